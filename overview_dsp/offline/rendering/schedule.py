"""Schedule of a gesture: events to feed, length of the steps, and end of the tail."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np

from overview_dsp.arrays import IntArray
from overview_dsp.design.gestures import Gesture
from overview_dsp.errors import InputError, quoted
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.engine.replay import apply_change
from overview_dsp.signal.surface.model import Surface

LONGEST_TAIL_S = 30.0
MAX_TAIL_S = 24 * 3600.0
FED_AHEAD = 4000  # highest number of pending control events; the engine's ring holds 4096
REST_S = 0.05  # time for which the disk must be at its rest position and both channels zero, s

Tail = Literal["rest", "none"] | float


def tail_of(text: str) -> Tail:
    """Return the tail that a user typed: rest, none, or seconds; InputError for anything else."""
    try:
        return checked_tail(float(text))
    except ValueError:
        return checked_tail(text)


def checked_tail(tail: Any) -> Tail:
    """Return a valid tail; raise InputError otherwise."""
    if isinstance(tail, str) and tail in ("rest", "none"):
        return "rest" if tail == "rest" else "none"
    is_number = isinstance(tail, int | float | np.integer | np.floating)
    # written so that NaN fails
    if isinstance(tail, bool) or not is_number or not 0.0 <= tail <= MAX_TAIL_S:
        raise InputError(
            f"tail is {quoted(tail)}; must be rest, none or seconds from 0 to {MAX_TAIL_S:g}"
        )
    return float(tail)


def unreached(surface: Surface, gesture: Gesture, reached: IntArray) -> tuple[int, ...]:
    """Return the timeline's events that the input passed but the disk never reached.

    `reached` are the events of all strikes. The input passes events up to
    its furthest touch. The result is empty for takes that change the surface.
    """
    if any("set" not in change.what for change in gesture.changes):
        return ()
    furthest = gesture.theta2[gesture.touching].max(initial=0.0) / math.pi
    crossed = surface.event[surface.edges[:, 0] <= furthest]
    return tuple(int(event) for event in np.setdiff1d(crossed, reached))


class GesturePlayer:
    """Plays a gesture through a prepared engine, step by step.

    A step is `feed`, a block of at most that many frames processed by the engine, and `count`.
    `least`: number of frames without the tail until rest.
    """

    def __init__(self, engine: Engine, gesture: Gesture, tail: Tail, block: int) -> None:
        """Start at the engine's present sample; steps have up to `block` frames."""
        tail = checked_tail(tail)
        rate = engine.sample_rate
        self._engine, self._gesture, self._block = engine, gesture, block
        self._stamps = stamps = gesture.stamps(rate)
        length = max(round(gesture.duration_s * rate), int(stamps[-1]) + 1 if len(stamps) else 0)
        self._to_rest = tail == "rest"
        self.least = length if isinstance(tail, str) else length + round(tail * rate)
        self._most = self.least + (round(LONGEST_TAIL_S * rate) if self._to_rest else 0)
        self._quiet = round(REST_S * rate)
        self._start = engine.sample_time
        self._whole = engine.timeline
        self._changes = [(round(change.time_s * rate), change.what) for change in gesture.changes]
        self._done = self._fed = self._changed = 0
        self._rested = False

    @property
    def over(self) -> bool:
        """True after the last frame."""
        return self._rested or self._done >= self._most

    @property
    def part(self) -> float:
        """Progress, 0 to 1, without the tail until rest."""
        return min(1.0, self._done / max(1, self.least))

    def feed(self) -> int:
        """Push the gesture's next events to the engine; return the number of frames to process."""
        stamps, done = self._stamps, self._done
        frames = min(self._block, self._most - done)
        ahead = int(np.searchsorted(stamps, done + frames))
        waiting = max(0, self._fed - int(np.searchsorted(stamps, done)))
        # a denser take is fed in shorter blocks
        if ahead - self._fed > FED_AHEAD - waiting:
            ahead = self._fed + FED_AHEAD - waiting
            frames = max(1, int(stamps[ahead]) - done)
        changes = self._changes
        while self._changed < len(changes) and changes[self._changed][0] <= done:
            what = changes[self._changed][1]
            self._whole = apply_change(self._engine, self._whole, what, self._start + done)
            self._changed += 1
        if self._changed < len(changes):
            # changes are applied when they are due, since only two surfaces can be pending
            frames = min(frames, changes[self._changed][0] - done)
            ahead = min(ahead, int(np.searchsorted(stamps, done + frames)))
        if ahead > self._fed:
            now = slice(self._fed, ahead)
            self._engine.control_all(
                self._gesture.theta2[now],
                self._gesture.touching[now],
                self._start + stamps[now],
                self._gesture.source[now],
            )
            self._fed = ahead
        return frames

    def count(self, frames: int, silent_samples: int | None = None) -> int:
        """Count processed frames; return how many of them belong to the gesture and its tail.

        `silent_samples` is the number of silent samples of a stage after the engine.
        """
        self._done += frames
        meters = self._engine.meters
        at_rest = min(meters.silent_samples, meters.still_samples, self._done - self.least)
        if silent_samples is not None:
            at_rest = min(at_rest, silent_samples)
        self._rested = self._to_rest and at_rest >= self._quiet
        # cut at rest, so that the end does not depend on the blocks
        return frames - (at_rest - self._quiet) if self._rested else frames
