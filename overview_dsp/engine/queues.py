"""What the control thread hands to the audio thread: hands' events, changes, free surface slots.

Each ring has one writer and one reader. An event is written first and published last, so that the
audio thread sees all of it or nothing; what doesn't fit is counted, never waited for.

Thread: control.
"""

from __future__ import annotations

import math
import warnings

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError, OverviewError, OverviewWarning
from overview_dsp.gestures import SOURCES
from overview_dsp.kernels import layout

_AS_SOON_AS_POSSIBLE = -1


class ControlQueues:
    """The writing ends of a memory block's rings."""

    def __init__(self, memory: NDArray[np.float64]) -> None:
        """`memory` is the block of `kernels.layout`."""
        self._f64 = memory
        self._i64 = memory.view(np.int64)
        self.dropped = 0

    def control(self, theta2: float, touching: bool, stamp: int, source: str) -> None:
        """Push a hand's event; a full ring drops it, counts it and warns the first time."""
        if source not in SOURCES:
            raise InputError(f"no source is called {source!r}; known: {', '.join(SOURCES)}")
        ring = SOURCES.index(source)
        written = int(self._i64[layout.RING_WRITTEN + ring])
        if written - int(self._i64[layout.RING_READ + ring]) >= layout.RING:
            if self.dropped == 0:
                warnings.warn(
                    f"control event dropped: {layout.RING} of source {source!r} wait already; "
                    "process a block first",
                    OverviewWarning,
                    stacklevel=3,
                )
            self.dropped += 1
            return
        at = ring * layout.RING + written % layout.RING
        self._i64[layout.RING_TIME + at] = stamp
        self._f64[layout.RING_THETA2 + at] = theta2
        self._i64[layout.RING_TOUCHING + at] = 1 if touching else 0
        self._i64[layout.RING_WRITTEN + ring] = written + 1

    def control_all(
        self,
        theta2: NDArray[np.float64],
        touching: NDArray[np.bool_],
        stamps: NDArray[np.int64],
        sources: NDArray[np.int8],
    ) -> None:
        """Push events of hands, in order: all, or none with OverviewError if a ring has no room."""
        if len(sources) and not 0 <= sources.min() <= sources.max() < len(SOURCES):
            raise InputError(
                f"a source is an index of {', '.join(SOURCES)}: 0 to {len(SOURCES) - 1}"
            )
        of_ring = [(ring, np.flatnonzero(sources == ring)) for ring in set(sources.tolist())]
        for ring, events in of_ring:
            waiting = int(self._i64[layout.RING_WRITTEN + ring]) - int(
                self._i64[layout.RING_READ + ring]
            )
            if waiting + len(events) > layout.RING:
                raise OverviewError(
                    f"{len(events)} control events of {SOURCES[ring]!r}, {waiting} wait already; "
                    f"there is room for {layout.RING}: process a block first"
                )
        for ring, events in of_ring:
            written = int(self._i64[layout.RING_WRITTEN + ring])
            at = ring * layout.RING + (written + np.arange(len(events))) % layout.RING
            self._i64[layout.RING_TIME + at] = stamps[events]
            self._f64[layout.RING_THETA2 + at] = theta2[events]
            self._i64[layout.RING_TOUCHING + at] = touching[events]
            self._i64[layout.RING_WRITTEN + ring] = written + len(events)

    def require_room(self, changes: int) -> None:
        """Raise OverviewError unless so many parameter or surface changes can be pushed."""
        waiting = int(self._i64[layout.HOST_WRITTEN]) - int(self._i64[layout.HOST_READ])
        if waiting + changes > layout.HOST_RING:
            raise OverviewError(
                f"{waiting} parameter changes wait already; process a block, then set more"
            )

    def push(self, changes: list[tuple[int, float]], stamp: int) -> int:
        """Push changes that belong together; their number, for `applied_at`."""
        self.require_room(len(changes))
        written = int(self._i64[layout.HOST_WRITTEN])
        for index, (what, value) in enumerate(changes, written):
            at = index % layout.HOST_RING
            self._i64[layout.HOST_TIME + at] = stamp
            self._i64[layout.HOST_WHAT + at] = what
            self._f64[layout.HOST_VALUE + at] = value
        self._i64[layout.HOST_WRITTEN] = written + len(changes)
        return written

    def applied_at(self, number: int) -> int | None:
        """The sample at which a pushed change was applied; None while it waits.

        OverviewError if so many came after it that its place was used again.
        """
        if int(self._i64[layout.HOST_WRITTEN]) - number > layout.HOST_RING:
            raise OverviewError("parameters change faster than they are recorded; change fewer")
        if int(self._i64[layout.HOST_READ]) <= number:
            return None
        return int(self._i64[layout.HOST_TIME + number % layout.HOST_RING])

    def free_slot(self) -> int:
        """A surface slot that neither sounds, fades nor waits; OverviewError if there is none."""
        # an audio thread may begin a waiting crossfade while we look: the active slot is read
        # before and after, and what waits before what fades, so that none is overlooked
        taken = {int(self._i64[layout.ACTIVE_SLOT])}
        for index in range(int(self._i64[layout.HOST_READ]), int(self._i64[layout.HOST_WRITTEN])):
            at = index % layout.HOST_RING
            if self._i64[layout.HOST_WHAT + at] == layout.COMMAND_SURFACE:
                taken.add(int(self._f64[layout.HOST_VALUE + at]))
        if self._i64[layout.FADE_LEFT] > 0:
            taken.add(int(self._i64[layout.FADING_SLOT]))
        taken.add(int(self._i64[layout.ACTIVE_SLOT]))
        free = [slot for slot in range(layout.SLOTS) if slot not in taken]
        if not free:
            raise OverviewError("two surfaces wait or fade already; process a block, then set it")
        return free[0]


def stamp_of(sample_time: int | None) -> int:
    """The stamp of a sample time; None is as soon as possible. InputError if it is no sample."""
    if sample_time is None:
        return _AS_SOON_AS_POSSIBLE
    if not math.isfinite(sample_time) or sample_time < 0:
        raise InputError(f"sample_time = {sample_time}; it counts samples since reset, from 0")
    return int(sample_time)
