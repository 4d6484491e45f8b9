"""Which surface a strike fell on: the kernel's log has the number of an event in that surface."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from overview_dsp.signal.engine.surface_slots import struck_event
from overview_dsp.signal.surface.model import Surface

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Timeline

MOST = 256
"""Surfaces that are remembered; strikes that nobody took for so many changes are the bare one's."""


@dataclass
class _Under:
    change: int  # the number of the change that brings it, for `ControlQueues.applied_at`
    sample: int | None  # from which it is under the disk; None while it waits
    events: NDArray[np.int64]  # the timeline's, by the kernel's numbers; the last: the bare surface
    timeline: Timeline

    @property
    def most(self) -> int:
        """The highest number of an event."""
        return len(self.events) - 1


def _events(surface: Surface) -> NDArray[np.int64]:
    count = len(surface.position) + len(surface.texture_strikes.position)
    return struck_event(surface, np.arange(count + 1))


class StruckSurfaces:
    """The surfaces that were under the disk since its strikes were taken last.

    Thread: one that changes surfaces, one that takes strikes.
    """

    def __init__(self) -> None:
        self._under: deque[_Under] = deque(maxlen=MOST)
        self._lock = threading.Lock()  # the audio thread takes it never

    def reset(self, surface: Surface, timeline: Timeline) -> None:
        """Begin anew with a surface."""
        with self._lock:
            self._under.clear()
            self._under.append(_Under(-1, 0, _events(surface), timeline))

    def add(
        self,
        change: int,
        surface: Surface,
        timeline: Timeline,
        applied_at: Callable[[int], int | None],
    ) -> None:
        """A change that was pushed brings a surface."""
        with self._lock:
            self._find(applied_at)  # while the queue still knows
            self._under.append(_Under(change, None, _events(surface), timeline))

    def _find(self, applied_at: Callable[[int], int | None]) -> None:
        for one in self._under:
            if one.sample is None:
                one.sample = applied_at(one.change)

    def find(
        self,
        numbers: NDArray[np.int64],
        times: NDArray[np.float64],
        now: int,
        applied_at: Callable[[int], int | None],
    ) -> tuple[NDArray[np.int64], list[Timeline | None]]:
        """The timelines' events of strikes by their numbers and times (samples), and the timelines.

        -1 is the bare surface. Later strikes are of sample `now` on.
        """
        with self._lock:
            self._find(applied_at)
            under = [one for one in self._under if one.sample is not None]
            starts = np.array([one.sample for one in under])
            which = np.searchsorted(starts, times, side="right") - 1
            events = np.full(len(numbers), -1, dtype=np.int64)
            timelines: list[Timeline | None] = [None] * len(numbers)
            for index in np.unique(which[which >= 0]):
                mine = np.flatnonzero(which == index)
                events[mine] = under[index].events[np.minimum(numbers[mine], under[index].most)]
                for i in mine:
                    timelines[i] = under[index].timeline
            while len(self._under) > 1:
                following = self._under[1].sample
                if following is None or following > now:
                    break
                self._under.popleft()
        return events, timelines
