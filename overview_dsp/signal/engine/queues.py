"""Queues from the control thread to the audio thread: control events, changes, surface slots.

An event is written before it is published (`kernels.atomics`), so that the audio thread never sees
a part of it. Events that do not fit are dropped and counted. One thread at a time writes a ring:
each source has a lock for its writers, which the audio thread never takes.
"""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from functools import cache

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.arrays import BoolArray, FloatArray, IntArray
from overview_dsp.design.gestures import SOURCES
from overview_dsp.errors import InputError, OverviewError, quoted, warn
from overview_dsp.kernels import layout
from overview_dsp.kernels.atomics import acquired, publish
from overview_dsp.kernels.control_events import push_control

_RING_OF = {source: ring for ring, source in enumerate(SOURCES)}
_AS_SOON_AS_POSSIBLE = -1


class ControlQueues:
    """Writing ends of a memory block's rings.

    Thread: any for `control`, `control_all` and `dropped`; one control thread for the rest.
    """

    def __init__(self, memory: FloatArray) -> None:
        """Write to the rings of `memory`, a block of `kernels.layout`."""
        self._f64 = memory
        self._i64 = memory.view(np.int64)
        # between writers in Python; the audio thread takes none of them
        self._writing = [threading.Lock() for _ in SOURCES]
        self._dropped = [0 for _ in SOURCES]
        self._touches = [False for _ in SOURCES]  # of the latest event of each source
        _compile()

    @property
    def dropped(self) -> int:
        """Number of control events dropped because their ring was full."""
        return sum(self._dropped)

    def clear(self) -> None:
        """Reset the number of dropped events and the latest touches, after the rings."""
        for ring, writing in enumerate(self._writing):
            with writing:
                self._dropped[ring] = 0
                self._touches[ring] = False

    @property
    def touched(self) -> bool:
        """True while a source controls the disk, or will after the events that are pending."""
        return any(self._touches) or int(self._i64[layout.HOLDER]) >= 0

    @contextlib.contextmanager
    def no_new_events(self) -> Iterator[None]:
        """Hold back control events of all sources."""
        with contextlib.ExitStack() as writing:  # in the order of rings, to avoid deadlocks
            for lock in self._writing:
                writing.enter_context(lock)
            yield

    def control(self, theta2: float, touching: bool, stamp: int, source: str) -> None:
        """Push a control event; a full ring drops and counts it, with one warning."""
        ring = _RING_OF.get(source) if isinstance(source, str) else None
        if ring is None:
            raise InputError(f"source is {quoted(source)}; must be one of {', '.join(SOURCES)}")
        # exact types: others would be compiled again
        event = ring, stamp, validation.real(theta2, "theta2"), bool(touching)
        with self._writing[ring]:
            if push_control(self._f64, self._i64, *event):
                self._touches[ring] = event[3]
                return
            self._dropped[ring] += 1
            first = self._dropped[ring] == 1
        if first:
            warn(
                f"control event dropped: {layout.RING} of source {source!r} are pending; "
                "process a block first",
                2,
            )

    def control_all(
        self, theta2: FloatArray, touching: BoolArray, stamps: IntArray, sources: NDArray[np.int8]
    ) -> None:
        """Push control events in order; if a ring is full raise OverviewError and push none."""
        rows = {"theta2": theta2, "touching": touching, "sample_times": stamps, "sources": sources}
        for what, row in rows.items():
            validation.floats(row, what)
        validation.equally_long(", ".join(rows), *rows.values())
        if len(sources) and not 0 <= sources.min() <= sources.max() < len(SOURCES):
            raise InputError(
                f"sources must be indices of {', '.join(SOURCES)}: 0 to {len(SOURCES) - 1}"
            )
        i64 = self._i64
        of_ring = [
            (ring, np.flatnonzero(sources == ring)) for ring in sorted(set(sources.tolist()))
        ]
        with contextlib.ExitStack() as writing:  # in the order of rings, to avoid deadlocks
            for ring, _ in of_ring:
                writing.enter_context(self._writing[ring])
            for ring, events in of_ring:
                waiting = int(i64[layout.RING_WRITTEN + ring]) - acquired(
                    i64, layout.RING_READ + ring
                )
                if waiting + len(events) > layout.RING:
                    raise OverviewError(
                        f"{len(events)} control events of {SOURCES[ring]!r} do not fit: {waiting} "
                        f"are pending, and the queue holds {layout.RING}; process a block first"
                    )
            for ring, events in of_ring:
                written = int(i64[layout.RING_WRITTEN + ring])
                at = ring * layout.RING + (written + np.arange(len(events))) % layout.RING
                i64[layout.RING_TIME + at] = stamps[events]
                self._f64[layout.RING_THETA2 + at] = theta2[events]
                i64[layout.RING_TOUCHING + at] = touching[events]
                publish(i64, layout.RING_WRITTEN + ring, written + len(events))
                self._touches[ring] = bool(touching[events[-1]])

    def require_capacity(self, changes: int) -> None:
        """Raise OverviewError if this number of changes does not fit into the ring."""
        waiting = int(self._i64[layout.HOST_WRITTEN]) - acquired(self._i64, layout.HOST_READ)
        if waiting + changes > layout.HOST_RING:
            raise OverviewError(
                f"{waiting} parameter changes are pending; process a block, then set more"
            )

    def push(self, changes: list[tuple[int, float]], stamp: int) -> int:
        """Push changes that belong together; return their number for `applied_at`."""
        self.require_capacity(len(changes))
        written = int(self._i64[layout.HOST_WRITTEN])
        for index, (what, value) in enumerate(changes, written):
            at = index % layout.HOST_RING
            self._i64[layout.HOST_TIME + at] = stamp
            self._i64[layout.HOST_WHAT + at] = what
            self._f64[layout.HOST_VALUE + at] = value
        publish(self._i64, layout.HOST_WRITTEN, written + len(changes))
        return written

    def applied_at(self, number: int) -> int | None:
        """Return the sample at which a pushed change was applied; None while it is pending.

        Raise OverviewError if later changes have overwritten its entry.
        """
        if int(self._i64[layout.HOST_WRITTEN]) - number > layout.HOST_RING:
            raise OverviewError("parameters change faster than they are recorded; change fewer")
        if acquired(self._i64, layout.HOST_READ) <= number:
            return None
        return int(self._i64[layout.HOST_TIME + number % layout.HOST_RING])

    def free_slot(self) -> int:
        """Return a free surface slot; raise OverviewError if all are in use."""
        # the audio thread may start a pending crossfade meanwhile; reading in the reverse of its
        # order finds all slots that are pending, active or fading
        i64 = self._i64
        waiting = range(acquired(i64, layout.HOST_READ), int(i64[layout.HOST_WRITTEN]))
        taken = {acquired(i64, layout.ACTIVE_SLOT)}
        taken.add(acquired(i64, layout.FADING_SLOT))
        for index in waiting:
            at = index % layout.HOST_RING
            if i64[layout.HOST_WHAT + at] == layout.COMMAND_SURFACE:
                taken.add(int(self._f64[layout.HOST_VALUE + at]))
        free = [slot for slot in range(layout.SLOTS) if slot not in taken]
        if not free:
            raise OverviewError("two surfaces are pending or fading; process a block first")
        return free[0]


@cache
def _compile() -> None:
    """Compile the functions that push events, so that the first event is not late."""
    scratch = np.zeros(layout.HOST_TIME)
    push_control(scratch, scratch.view(np.int64), 0, 0, 0.0, False)
    publish(scratch.view(np.int64), 0, acquired(scratch.view(np.int64), 0))


def stamp_of(sample_time: int | None) -> int:
    """Return the stamp of a sample time; None is as soon as possible; InputError."""
    if sample_time is None:
        return _AS_SOON_AS_POSSIBLE
    if not 0.0 <= validation.real(sample_time, "sample_time") < 2.0**63:
        raise InputError(
            f"sample_time is {quoted(sample_time)}; must be a number of samples since reset, from 0"
        )
    return int(sample_time)
