"""Selection of the events of a window, up to the number that touch can distinguish.

Every window is filled up with events found by rules (`Rules`), then with details, by falling
weight. Among equal weights, those that are distant from all shown events come first, then the
others. So the number of events never falls from a window to one within it, unless all events are
shown.

Details of equal weight are ordered by how evenly they divide the timeline (the middle, the
quarters, the eighths and so on). So a window shows some from all of its parts, and a detail that is
shown in a window is shown in windows within it.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Protocol

import numpy as np

from overview_dsp.arrays import IntArray
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.ticks import KINDS

APART = 0.0018
"""Minimum distance of distinct events, as a fraction of the surface: a third of a degree, or 30 ms
at a slow ten degrees per second."""

MOST_DETAILS = 200
"""Number of events up to which details are added, about one per degree. In a sweep of twelve
degrees per second, nine of ten are perceived separately (`measure.count_resolved_events`)."""

MOST_BY_RULE = 90
"""Number of events up to which events found by rules are added, one per two degrees. A whole series
has 20 to 90."""

MOST_OF_A_KIND = 100
"""Maximum number of single events of a kind in a window. More of them (heartbeats) form a
background, which presets leave out (`spacing_percent`), and do not replace other events."""


HEAVY = 10
"""Total weight of events found by rules; with more of them, each gets lighter, so that the trend of
the curve stays perceptible."""


class Rules(Protocol):
    """Finder of the events of a series in any window."""

    def cut(self, start_s: float, end_s: float) -> Rules:
        """Return the rules for a window, on a time axis that begins with it."""

    def found(self, duration_s: float) -> Iterable[Event]:
        """Yield the events, most important first, at different samples."""


def ranks(details: Sequence[Event]) -> IntArray:
    """Return the rank of each detail (sorted by time) for selection into windows, from 0."""
    count = len(details)
    bits = max(1, (count - 1).bit_length())
    index = np.arange(count)
    reversed_bits = np.zeros(count, dtype=np.int64)
    for bit in range(bits):  # the bits of the index in reverse order
        reversed_bits |= ((index >> bit) & 1) << (bits - 1 - bit)
    order = np.lexsort((reversed_bits, np.array([-detail.weight for detail in details])))
    rank = np.empty(count, dtype=np.int64)
    rank[order] = index
    return rank


def window_events(
    events_in_window: Sequence[Event],
    marks: Iterable[Event],
    ruled: Iterable[Event],
    details: Sequence[Event],
    duration_s: float,
) -> tuple[Event, ...]:
    """Return the events of a window, by time.

    `events_in_window`: events of the timeline in the window; all are kept.
    `marks`: ticks of the window.
    `ruled`, `details`: events that may be added, most important first.
    """
    counts = Counter(event.kind for event in events_in_window)
    background = [event for event in events_in_window if counts[event.kind] > MOST_OF_A_KIND]
    single = [event for event in events_in_window if counts[event.kind] <= MOST_OF_A_KIND]
    taken = [*single, *_clear(_other(marks, single), single, duration_s)]
    sampled = {event.time_s for event in single if event.kind not in KINDS}
    found = (event for event in ruled if event.time_s not in sampled)
    kept = len(taken)
    _fill(taken, found, MOST_BY_RULE, duration_s)
    # more than `HEAVY` events found by rules all have less weight
    share = min(1.0, HEAVY / max(1, len(taken) - kept))
    taken[kept:] = [replace(event, weight=event.weight * share) for event in taken[kept:]]
    taken += background
    for _, alike in groupby(_other(details, taken), key=lambda event: event.weight):
        _fill(taken, [*alike], MOST_DETAILS, duration_s)
    return tuple(sorted(taken, key=lambda event: event.time_s))


def _clear(
    marks: Sequence[Event], events_in_window: Sequence[Event], duration_s: float
) -> list[Event]:
    """Return the ticks that are not close to an event, or all ticks if all are."""
    times = np.array([event.time_s for event in events_in_window])
    if not len(times):
        return list(marks)
    far = [mark for mark in marks if np.abs(times - mark.time_s).min() >= APART * duration_s]
    return far or list(marks)


def _other(events: Iterable[Event], known_events: Iterable[Event]) -> list[Event]:
    """Return the events whose time and kind are not among known events, without repetitions."""
    known = {(event.time_s, event.kind) for event in known_events}
    other = []
    for event in events:
        key = event.time_s, event.kind
        if key not in known:
            known.add(key)
            other.append(event)
    return other


def _fill(taken: list[Event], ranked: Iterable[Event], most: int, duration_s: float) -> None:
    """Add distant events, then others, up to `most` events in all."""
    if len(taken) >= most:
        return
    apart = APART * duration_s
    times = sorted(event.time_s for event in taken)
    near: list[Event] = []
    for event in ranked:
        at = bisect_left(times, event.time_s)
        if any(abs(other - event.time_s) < apart for other in times[max(0, at - 1) : at + 1]):
            near.append(event)
        else:
            insort(times, event.time_s)
            taken.append(event)
            if len(taken) == most:
                return
    taken += near[: most - len(taken)]
