"""What a feed has said, in bounded memory: its events, its samples and which times it covers.

Each event is there once; what was taken back stays away. Samples are in order.
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
from numpy.typing import NDArray

from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.gaps import Gaps

Key = tuple[float, str, str]
What = Literal["added", "retracted"]

MAX_EVENTS = 20_000
"""Most events (and most details) that are kept; more than a surface holds."""

MAX_TAKEN_BACK = 10_000
"""So many retractions are remembered, for events that come late or again."""


@dataclass(frozen=True)
class Change:
    """An event that came or was taken back."""

    revision: int
    what: What
    event: Event


class KeptEvents:
    """Events and details by time, kind and label, and by the names that a feed gives them.

    What a call changes is told as pairs of `"added"` or `"retracted"` and the event; of a detail
    there are none.
    """

    def __init__(self) -> None:
        self.events: dict[Key, Event] = {}
        self.details: dict[Key, Event] = {}
        self.left_out = 0
        self._ids: OrderedDict[str, Key] = OrderedDict()
        self._taken_back: OrderedDict[Key | str | tuple[str, Key], None] = OrderedDict()
        self._last_s: float | None = 0.0  # None is to be looked up

    @property
    def last_s(self) -> float:
        """The latest event's or detail's time, s; 0 of none."""
        if self._last_s is None:
            self._last_s = max((key[0] for key in (*self.events, *self.details)), default=0.0)
        return self._last_s

    def put(self, event: Event, name: str | None) -> list[tuple[What, Event]] | None:
        """Keep an event under the feed's name for it; what changes, None if it isn't new."""
        key = event_key(event)
        if not self._taken_back.keys().isdisjoint((key, name, (name, key))):
            return None
        corrected = self._named(name, key) if name is not None else None
        there = self.events.get(key)
        if there is not None and there.weight >= event.weight and corrected is None:
            return None
        self.events[key] = event
        self._reaches(event.time_s)
        changes: list[tuple[What, Event]] = []
        if corrected is not None:
            changes.append(("retracted", corrected))
        if there is None:
            changes.append(("added", event))
        self._keep_within(self.events)
        return changes

    def put_detail(self, event: Event) -> bool:
        """Keep a detail; whether it is new."""
        key = event_key(event)
        if key in self.details or key in self._taken_back:
            return False
        self.details[key] = event
        self._reaches(event.time_s)
        self._keep_within(self.details)
        return True

    def retract(self, event: Event | str) -> list[tuple[What, Event]] | None:
        """Take back an event or what a feed names so; what changes, None if it wasn't there."""
        key = self._ids.get(event) if isinstance(event, str) else event_key(event)
        self._take_back(event if isinstance(event, str) else event_key(event))
        if key is None:
            return None
        self._last_s = None
        if key in self.events:
            return [("retracted", self.events.pop(key))]
        return None if self.details.pop(key, None) is None else []

    def _named(self, name: str, key: Key) -> Event | None:
        """Give an event a name; the event that had it until now, which is gone."""
        earlier = self._ids.get(name)
        self._ids[name] = key
        if len(self._ids) > MAX_EVENTS:
            self._ids.popitem(last=False)
        if earlier is None or earlier == key:
            return None
        self._take_back((name, earlier))  # a feed that begins again doesn't bring it back
        self._last_s = None
        return self.events.pop(earlier, None)

    def _take_back(self, key: Key | str | tuple[str, Key]) -> None:
        self._taken_back[key] = None
        while len(self._taken_back) > MAX_TAKEN_BACK:
            self._taken_back.popitem(last=False)

    def _reaches(self, time_s: float) -> None:
        if self._last_s is not None:
            self._last_s = max(self._last_s, time_s)

    def _keep_within(self, events: dict[Key, Event]) -> None:
        if len(events) > MAX_EVENTS:
            self.left_out += _thin(events)
            self._last_s = None


def event_key(event: Event) -> Key:
    """What makes an event another one."""
    return event.time_s, event.kind, event.label


def _thin(events: dict[Key, Event]) -> int:
    """Leave out every second event of the commonest kind; how many."""
    counts = Counter(kind for _, kind, _ in events)
    common = max(counts, key=lambda kind: (counts[kind], kind))
    gone = sorted(key for key in events if key[1] == common)[1::2]
    for key in gone:
        del events[key]
    return len(gone)


MAX_SAMPLES = 65_536
"""Most samples that are kept: nine minutes' worth more than a match's at ten a second, and as many
as a surface looks at one by one. When there are more, each two become one."""


class KeptSamples:
    """A curve's points; one that comes again for a time takes the place of the first.

    Where they are too many, each two next to each other become the larger one: a cheer stays as
    high as it was.
    """

    def __init__(self) -> None:
        self._time_s = array("d")
        self._value = array("d")

    def __len__(self) -> int:
        return len(self._time_s)

    @property
    def last_s(self) -> float:
        """The latest sample's time, s."""
        return self._time_s[-1]

    def put(self, time_s: float, value: float) -> bool:
        """Keep a sample; whether it is new."""
        times, place = self._time_s, bisect_left(self._time_s, time_s)
        if place < len(times) and times[place] == time_s:
            is_new = self._value[place] != value
            self._value[place] = value
            return is_new
        times.insert(place, time_s)
        self._value.insert(place, value)
        if len(times) > MAX_SAMPLES:
            self._halve()
        return True

    def arrays(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Copies of the times (s) and the values."""
        return np.array(self._time_s, np.float64), np.array(self._value, np.float64)

    def _halve(self) -> None:
        times, values = self.arrays()
        count = len(times) // 2 * 2
        pair = values[:count].reshape(-1, 2)
        kept = np.arange(0, count, 2) + np.argmax(pair, axis=1)
        # the newest stays, so that the curve still reaches to where it did
        kept = np.unique(np.append(kept, len(times) - 1))
        self._time_s = array("d", times[kept])
        self._value = array("d", values[kept])


class Coverage:
    """Signs of life on a time axis, joined where they are no further apart than `reach_s`.

    The same signs give the same stretches in whatever order they come. Memory is that of the
    stretches, not of the signs.
    """

    def __init__(self, reach_s: float) -> None:
        self.reach_s = reach_s
        self._starts: list[float] = []
        self._ends: list[float] = []

    def add(self, time_s: float) -> bool:
        """Note a sign; whether that changes a stretch."""
        # stretches that end at or after the sign less the reach, and begin before it and the reach
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

    @property
    def first_s(self) -> float:
        """When the first sign was, s; without end where there is none."""
        return self._starts[0] if self._starts else math.inf

    def gaps(self, more: Iterable[float] = ()) -> tuple[tuple[float, float], ...]:
        """The stretches between those that were heard of.

        Parameters
        ----------
        more
            Further signs, which are not kept.
        """
        joined = Coverage(self.reach_s)
        joined._starts, joined._ends = self._starts.copy(), self._ends.copy()
        for time_s in more:
            joined.add(time_s)
        return tuple(zip(joined._ends[:-1], joined._starts[1:], strict=True))

    def __bool__(self) -> bool:
        return bool(self._starts)


def merged_gaps(found: Iterable[tuple[float, float, str]]) -> tuple[Gaps, tuple[str, ...]]:
    """Gaps (start_s, end_s, why) in order, those that overlap as one, and why each is there.

    Of those that overlap, the first one's reason stays. Empty ones are left out.
    """
    merged: list[tuple[float, float, str]] = []
    for start, end, why in sorted(one for one in found if one[0] < one[1]):
        if merged and start < merged[-1][1]:
            first, last, reason = merged[-1]
            merged[-1] = (first, max(last, end), reason)
        else:
            merged.append((start, end, why))
    return tuple((a, b) for a, b, _ in merged), tuple(why for *_, why in merged)
