"""A crowd that is heard as it cheers: loudness and cheers, as the reader of recordings finds them.

All that is kept of the sound is ten numbers a second, so what is found is what the reader finds in
a file of as much: the background reaches a minute ahead, so a cheer of the last minute may still
change a little.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.analysis.loudness import MIN_RATE, StepMeter
from overview_dsp.data.readers.audio.channels import layout_of, weights_of
from overview_dsp.data.readers.audio.reader import timeline_of
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError

LOOK_EVERY_S = 0.5
"""Cheers are looked for so often ..."""

BUSY_PART = 0.1
"""... or less, so that it takes no more than this part of the time."""

LONGEST_S = 27 * 3600.0
"""What comes later isn't listened to: as much as is read of a file."""


class Crowd:
    """Listens; tells a timeline whenever there is enough that is new.

    Parameters
    ----------
    sample_rate
        Hz, 4000 or more.
    channels
        How many.
    tell
        Receives a timeline of all that was heard.
    now
        A clock, s.

    Raises
    ------
    InputError
        A rate or number of channels that can't be measured.
    """

    def __init__(
        self,
        sample_rate: int,
        channels: int,
        tell: Callable[[Timeline], None],
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        if sample_rate < MIN_RATE or sample_rate > 768_000 or not 1 <= channels <= 64:
            raise InputError(
                f"{channels} channels at {sample_rate} Hz; loudness is measured of 1 to 64, from "
                f"{MIN_RATE} Hz up"
            )
        self._rate, self._channels = sample_rate, channels
        layout = layout_of(channels)
        self._meter = StepMeter(sample_rate, weights_of(layout) if layout else (1.0,) * channels)
        self._waiting: list[NDArray[np.floating[Any]]] = []
        self._frames = self._heard = 0
        self._tell, self._now = tell, now
        self._look_at = 0.0

    def feed(self, block: NDArray[np.floating[Any]]) -> None:
        """Listen to the next (frames, channels), of any length; NaN is missing."""
        if self._heard >= LONGEST_S * self._rate:
            return
        self._waiting.append(block)
        self._frames += len(block)
        whole = self._frames // self._rate * self._rate
        if not whole:
            return
        sound = np.concatenate(self._waiting)
        self._waiting = [sound[whole:].copy()]
        self._frames -= whole
        self._heard += whole
        for start in range(0, whole, self._rate):  # the meter takes whole seconds
            self._meter.feed(sound[start : start + self._rate])
        begun = self._now()
        if begun >= self._look_at:
            self._tell(self._timeline(self._meter))
            took = self._now() - begun
            self._look_at = begun + max(LOOK_EVERY_S, took / BUSY_PART)

    def end(self) -> None:
        """Tell the whole: it is over."""
        if self._frames:
            self._meter.feed(np.concatenate(self._waiting))
            self._heard += self._frames
        if self._heard:
            self._tell(self._timeline(self._meter))

    def _timeline(self, meter: StepMeter) -> Timeline:
        kind = f"sound as it is heard, {self._channels} channels at {self._rate} Hz"
        return timeline_of(meter.so_far(), "loudness", "", kind, ())
