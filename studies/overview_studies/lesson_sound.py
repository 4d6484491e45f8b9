"""Playback of a lesson's examples by an output device, in real time."""

from __future__ import annotations

import time
from collections.abc import Callable
from types import TracebackType

import overview_dsp as ov
from overview_dsp.cli.extensions import resolve_output
from overview_studies.lesson import Example, Lesson

SILENT = "none"
RATE = 48_000
BLOCK, MAX_BLOCK = 256, 4096
POLL_S = 0.02


class Sound:
    """Output of a lesson, with the settings last used with the device.

    Parameters
    ----------
    lesson : Lesson
    device : str or None
        Name or number as in `overview devices`; None is the default, "none" has no sound.

    Raises
    ------
    OverviewError
        The device cannot be used.
    """

    def __init__(self, lesson: Lesson, device: str | None) -> None:
        self._preset = lesson.preset
        first = next(iter(lesson.references.values()))
        self._engine = ov.Engine(self._preset, first.timeline)
        self._stream: ov.live.NullStream | ov.live.OutputStream
        if device == SILENT:
            self._engine.prepare(RATE, MAX_BLOCK)
            self._stream = ov.live.NullStream(self._engine, BLOCK)
            return
        named = int(device) if device is not None and device.isdecimal() else device
        found = ov.live.find_device(named)
        settings = resolve_output(found.full_name, {}, {}, None, found.channels).settings
        self._engine.prepare(found.sample_rate, MAX_BLOCK)
        self._stream = ov.live.OutputStream(self._engine, named, BLOCK, settings)

    def __enter__(self) -> Sound:
        self._stream.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stream.close()

    def play(self, example: Example, stopped: Callable[[], bool]) -> list[str]:
        """Play an example to its end, or until `stopped`; return the kinds that were struck."""
        gesture = example.gesture
        times = (gesture.time_s * self._engine.sample_rate).round().astype("int64")

        def begin() -> None:
            self._engine.restart(self._preset, example.timeline)
            self._engine.control_all(gesture.theta2, gesture.touching, times, gesture.source)

        self._stream.restart(begin)
        end = round(example.duration_s * self._engine.sample_rate)
        while self._engine.sample_time < end and self._stream.active and not stopped():
            time.sleep(POLL_S)
        return [event.kind for event, _ in self._engine.pop_strike_events()]
