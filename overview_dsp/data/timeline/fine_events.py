"""Which of the small things a window shows: the weightiest, up to what a hand can tell apart.

A window is filled up, at every width: with what rules find in it (`Rules`), then with details, each
the weightiest first. Of one weight those that lie apart from everything shown already come first,
then the others while there is room; so the number of events never falls from a window to one
within it unless all that is there is shown.

Details of one weight take turns by how evenly they divide the timeline (the middle, the quarters,
the eighths ...), so that a window shows some from all of it, and one that is shown in a window is
shown in those within it.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.ticks import KINDS

APART = 0.0018
"""Part of the surface between two events that can be felt apart, a third of a degree: it takes a
slow look, of ten degrees a second, 30 ms."""

MOST_DETAILS = 200
"""A window is filled up with details to so many events, about one a degree: in a sweep of twelve
degrees a second nine of ten are felt one by one (`measure.count_resolved_events`)."""

MOST_BY_RULE = 90
"""A window is filled up to so many events with those found by rule, one in two degrees: peaks and
crossings are wider than a touch, and a whole series has 20 to 90."""

MOST_OF_A_KIND = 100
"""More of a kind in a window (a heart's beats) are no single events but a ground, which presets
leave out (`spacing_percent`): they keep none of those found by rule away."""


HEAVY = 10
"""Of events found by rule so many together weigh as much as any more do: between crowded ones the
curve's trend would not be felt."""


class Rules(Protocol):
    """What finds the events of a series, in any part of it."""

    def cut(self, start_s: float, end_s: float) -> Rules:
        """Return the same for a part, on an axis that begins with it."""

    def found(self, duration_s: float) -> Iterable[Event]:
        """Give what is found, what matters most first; each of another sample."""


def ranks(details: Sequence[Event]) -> NDArray[np.int64]:
    """Return in which order details (sorted by time) are taken into a window, from 0."""
    count = len(details)
    bits = max(1, (count - 1).bit_length())
    index = np.arange(count)
    turn = np.zeros(count, dtype=np.int64)
    for bit in range(bits):  # the index, read backwards
        turn |= ((index >> bit) & 1) << (bits - 1 - bit)
    order = np.lexsort((turn, np.array([-detail.weight for detail in details])))
    rank = np.empty(count, dtype=np.int64)
    rank[order] = index
    return rank


def window_events(
    given: Sequence[Event],
    marks: Iterable[Event],
    ruled: Iterable[Event],
    details: Sequence[Event],
    duration_s: float,
) -> tuple[Event, ...]:
    """Return the events of a window, by time.

    Parameters
    ----------
    given
        The whole's events in it: all are kept.
    marks
        Its ticks: all that aren't among them.
    ruled, details
        What it may be filled up with, what matters most first; no more of it is asked for.
    duration_s
        Its length.
    """
    counts = Counter(event.kind for event in given)
    ground = [event for event in given if counts[event.kind] > MOST_OF_A_KIND]
    single = [event for event in given if counts[event.kind] <= MOST_OF_A_KIND]
    taken = [*single, *_clear(_other(marks, single), single, duration_s)]
    sampled = {event.time_s for event in single if event.kind not in KINDS}
    found = (event for event in ruled if event.time_s not in sampled)
    kept = len(taken)
    _fill(taken, found, MOST_BY_RULE, duration_s)
    taken[kept:] = _lighter(taken[kept:])
    taken += ground
    for _, alike in groupby(_other(details, taken), key=lambda event: event.weight):
        _fill(taken, [*alike], MOST_DETAILS, duration_s)
    return tuple(sorted(taken, key=lambda event: event.time_s))


def _lighter(found: list[Event]) -> list[Event]:
    """Return events found by rule, the lighter the more there are."""
    share = min(1.0, HEAVY / max(1, len(found)))
    if share == 1.0:
        return found
    return [replace(event, weight=event.weight * share) for event in found]


def _clear(marks: Sequence[Event], given: Sequence[Event], duration_s: float) -> list[Event]:
    """The ticks that don't blunt an event: none close to one, unless all are."""
    times = np.array([event.time_s for event in given])
    if not len(times):
        return list(marks)
    far = [mark for mark in marks if np.abs(times - mark.time_s).min() >= APART * duration_s]
    return far or list(marks)


def _other(events: Iterable[Event], there: Iterable[Event]) -> list[Event]:
    """Those of a moment and a kind that aren't there; two of a kind at one moment feel as one."""
    known = {(event.time_s, event.kind) for event in there}
    other = []
    for event in events:
        key = event.time_s, event.kind
        if key not in known:
            known.add(key)
            other.append(event)
    return other


def _fill(taken: list[Event], ranked: Iterable[Event], most: int, duration_s: float) -> None:
    """Add the first of those that are apart, then the first of the others, up to `most` in all."""
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
