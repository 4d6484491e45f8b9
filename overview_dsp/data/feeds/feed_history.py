"""Events, samples and covered times of a feed, in bounded memory.

Each event is stored once, and a retracted event stays retracted. Samples are sorted by time.
"""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left, bisect_right
from collections import Counter, OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from overview_dsp.arrays import FloatArray
from overview_dsp.data.timeline.event import GOALS, Event
from overview_dsp.data.timeline.gaps import Gaps

Key = tuple[float, str, str]
Action = Literal["added", "retracted"]

MAX_EVENTS = 20_000  # maximum number of stored events, and of stored details. A surface holds fewer
MAX_RETRACTIONS = 10_000
"""Maximum number of stored retractions, which apply to events that arrive late or again."""


@dataclass(frozen=True)
class Change:
    """An event that was added or retracted."""

    revision: int
    action: Action
    event: Event


class EventBuffer:
    """Events and details by time, kind and label, and by their ids in the feed.

    Methods return their changes as pairs of `"added"` or `"retracted"` and the event. Changes of
    details are not listed.
    """

    def __init__(self) -> None:
        self.events: dict[Key, Event] = {}
        self.details: dict[Key, Event] = {}
        self.withdrawn: dict[Key, Event] = {}
        """Retracted goals."""
        self.omitted = 0
        self._ids: OrderedDict[str, Key] = OrderedDict()
        self._retracted: OrderedDict[Key | str | tuple[str, Key], None] = OrderedDict()
        self._last_s: float | None = 0.0  # None: has to be computed

    @property
    def last_s(self) -> float:
        """Time of the latest event or detail, s; 0 without any."""
        if self._last_s is None:
            self._last_s = max((key[0] for key in (*self.events, *self.details)), default=0.0)
        return self._last_s

    def put(self, event: Event, id_: str | None) -> list[tuple[Action, Event]] | None:
        """Store an event under its id; return the changes, None if it is not new."""
        key = identity_of(event)
        if not self._retracted.keys().isdisjoint((key, id_)):
            return [] if self.withdraw(event) else None
        if (id_, key) in self._retracted:
            return None
        corrected = self._assign_id(id_, key) if id_ is not None else None
        present = self.events.get(key)
        if present is not None and corrected is None:
            other_side = id_ is not None and present.side != event.side
            if (present.weight, present.side) >= (event.weight, event.side) and not other_side:
                return None
        self._store(self.events, key, event)
        changes: list[tuple[Action, Event]] = []
        if corrected is not None:
            changes.append(("retracted", corrected))
        if present is None:
            changes.append(("added", event))
        return changes

    def put_detail(self, event: Event) -> bool:
        """Store a detail; return whether it is new."""
        key = identity_of(event)
        if key in self.details or key in self._retracted:
            return False
        self._store(self.details, key, event)
        return True

    def retract(self, event: Event | str) -> list[tuple[Action, Event]] | None:
        """Retract an event or an id; return the changes, None if the event was not stored."""
        key = self._ids.get(event) if isinstance(event, str) else identity_of(event)
        self._remember_retraction(event if isinstance(event, str) else identity_of(event))
        if key is None:
            return None
        self._last_s = None
        if key in self.events:
            self.withdraw(self.events[key])
            return [("retracted", self.events.pop(key))]
        return None if self.details.pop(key, None) is None else []

    def withdraw(self, event: Event) -> bool:
        """Remember a goal that does not count; return whether it is one, and new."""
        key = identity_of(event)
        if event.kind not in GOALS or key in self.withdrawn:
            return False
        self.withdrawn[key] = event
        if len(self.withdrawn) > MAX_RETRACTIONS:
            del self.withdrawn[next(iter(self.withdrawn))]
        return True

    def _assign_id(self, id_: str, key: Key) -> Event | None:
        """Assign an id to an event; remove and return the event that had it before."""
        earlier = self._ids.get(id_)
        self._ids[id_] = key
        if len(self._ids) > MAX_EVENTS:
            self._ids.popitem(last=False)
        if earlier is None or earlier == key:
            return None
        self._remember_retraction((id_, earlier))  # a feed that restarts does not add it again
        self._last_s = None
        return self.events.pop(earlier, None)

    def _remember_retraction(self, key: Key | str | tuple[str, Key]) -> None:
        self._retracted[key] = None
        while len(self._retracted) > MAX_RETRACTIONS:
            self._retracted.popitem(last=False)

    def _store(self, events: dict[Key, Event], key: Key, event: Event) -> None:
        events[key] = event
        if self._last_s is not None:
            self._last_s = max(self._last_s, event.time_s)
        if len(events) > MAX_EVENTS:
            self.omitted += _thin(events)
            self._last_s = None


def identity_of(event: Event) -> Key:
    """Return the fields that identify an event: time, kind and label."""
    return event.time_s, event.kind, event.label


def _thin(events: dict[Key, Event]) -> int:
    """Remove every second event of the most frequent kind; return the number removed."""
    counts = Counter(kind for _, kind, _ in events)
    common = max(counts, key=lambda kind: (counts[kind], kind))
    removed = sorted(key for key in events if key[1] == common)[1::2]
    for key in removed:
        del events[key]
    return len(removed)


MAX_SAMPLES = 65_536
"""Maximum number of stored samples, enough for 109 minutes at 10 Hz.

A surface evaluates up to this number one by one. Above the maximum, pairs of samples are merged.
"""


class SampleBuffer:
    """Samples of a curve; a sample replaces an earlier one of the same time.

    Above `MAX_SAMPLES`, each pair of neighbouring samples is merged into the larger one. So the
    peaks keep their height.
    """

    def __init__(self) -> None:
        self._time_s = array("d")
        self._value = array("d")

    def __len__(self) -> int:
        return len(self._time_s)

    @property
    def last_s(self) -> float:
        """Time of the latest sample, s."""
        return self._time_s[-1]

    def put(self, time_s: float, value: float) -> bool:
        """Store a sample; return whether it changes the curve."""
        index = bisect_left(self._time_s, time_s)
        if index < len(self) and self._time_s[index] == time_s:
            is_new = self._value[index] != value
            self._value[index] = value
            return is_new
        self._time_s.insert(index, time_s)
        self._value.insert(index, value)
        if len(self) > MAX_SAMPLES:
            self._halve()
        return True

    def arrays(self) -> tuple[FloatArray, FloatArray]:
        """Return copies of the times (s) and the values."""
        return np.array(self._time_s, np.float64), np.array(self._value, np.float64)

    def _halve(self) -> None:
        times, values = self.arrays()
        count = len(times) // 2 * 2
        pair = values[:count].reshape(-1, 2)
        larger = np.arange(0, count, 2) + np.argmax(pair, axis=1)
        # the latest sample stays, so that the end of the curve does not move
        selected = np.unique(np.append(larger, len(times) - 1))
        self._time_s = array("d", times[selected])
        self._value = array("d", values[selected])


class Coverage:
    """Time ranges in which a feed was active: times that are at most `reach_s` apart are joined.

    The order in which times are added has no effect. Only the ranges are stored.
    """

    def __init__(self, reach_s: float) -> None:
        self.reach_s = reach_s
        self._starts: list[float] = []
        self._ends: list[float] = []

    def add(self, time_s: float) -> bool:
        """Add a time at which the feed was active; return whether a range changes."""
        # the ranges within `reach_s` of the time
        first = bisect_left(self._ends, time_s - self.reach_s)
        stop = bisect_right(self._starts, time_s + self.reach_s)
        if first >= stop:
            self._starts.insert(first, time_s)
            self._ends.insert(first, time_s)
            return True
        start, end = self._starts[first], self._ends[stop - 1]
        if stop - first == 1 and start <= time_s <= end:
            return False
        self._starts[first:stop] = [min(start, time_s)]
        self._ends[first:stop] = [max(end, time_s)]
        return True

    def cut(self, end_s: float) -> None:
        """Remove the times after `end_s`."""
        count = bisect_right(self._starts, end_s)
        self._starts, self._ends = self._starts[:count], self._ends[:count]
        if count:
            self._ends[-1] = min(self._ends[-1], end_s)

    @property
    def first_s(self) -> float:
        """Earliest time that was added, s; infinite without any."""
        return self._starts[0] if self._starts else math.inf

    def gaps(self, more: Iterable[float] = ()) -> tuple[tuple[float, float], ...]:
        """Return the gaps between the ranges; `more` has further times, which are not stored."""
        joined = Coverage(self.reach_s)
        joined._starts, joined._ends = self._starts.copy(), self._ends.copy()
        for time_s in more:
            joined.add(time_s)
        return tuple(zip(joined._ends[:-1], joined._starts[1:], strict=True))

    def __bool__(self) -> bool:
        return bool(self._starts)


def merged_gaps(found: Iterable[tuple[float, float, str]]) -> tuple[Gaps, tuple[str, ...]]:
    """Return gaps and their reasons, from (start_s, end_s, reason) in any order.

    Overlapping gaps become one, with the reason of the first. Empty gaps are omitted.
    """
    merged: list[tuple[float, float, str]] = []
    for start, end, reason in sorted(one for one in found if one[0] < one[1]):
        if merged and start < merged[-1][1]:
            first, last, first_reason = merged[-1]
            merged[-1] = (first, max(last, end), first_reason)
        else:
            merged.append((start, end, reason))
    return tuple((a, b) for a, b, _ in merged), tuple(reason for *_, reason in merged)
