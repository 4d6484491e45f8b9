"""A timeline that is still growing: what came so far, in whatever order, as one Timeline at a time.

What comes may be late, doubled, out of order and taken back: the same things give the same
timeline in any order (events of one time stay in the order they came), except that the last of two
values for one sample or one id stands.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Iterable
from dataclasses import replace
from datetime import datetime
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from overview_dsp import validation
from overview_dsp.data.analysis.crowd_excitement import derive_intensity
from overview_dsp.data.feeds.feed_history import (
    Change,
    Coverage,
    KeptEvents,
    KeptSamples,
    What,
    event_key,
    merged_gaps,
)
from overview_dsp.data.timeline.curve_points import MAX_VALUE
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.gaps import Gaps
from overview_dsp.data.timeline.intensity import EXTREMES, Intensity
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown
from overview_dsp.public import counted, short
from overview_dsp.units import clock_text

Map = Literal["whole", "so far"]

MAPS: tuple[Map, ...] = ("whole", "so far")
"""How a timeline that grows may be laid out."""

LONGEST_S = 100 * 366 * 86_400.0
"""A time beyond this is no moment of a feed but a broken clock."""

MAX_CHANGES = 1_000
"""So many of the latest changes are remembered for `changes_since`."""

EXTRA_TIME = 0.05
"""By which part of the expected length it is extended, again and again, when play goes on: half an
hour for a day, five minutes for a match, so that the map changes rarely."""

ROOM = 0.03
"""How much of the future lies behind what has just happened, at least, as a part of what has."""

SHORTEST_S = 1.0
"""What has only just begun is at least so long."""

SILENCE_S = 120.0
"""A feed that tells its clock (or samples) and is silent for longer leaves a gap."""


class LiveTimeline:
    """A timeline that grows: events and samples are appended, and events retracted, as they happen.

    `snapshot` gives the timeline as it is at that moment. It is mapped in one of two ways: `"so
    far"` ends now, `"whole"` is as long as what is expected, and what lies behind now is the
    future, which feels like nothing else. Without samples, football events get the curve of
    excitement that a file of them gets.

    Thread: any.

    Parameters
    ----------
    title : str
        Words for a person.
    expect_s : float or None
        How long it is expected to last, s; play that goes on extends it by 5 % at a time.
    map : {"whole", "so far"} or None
        How it is laid under the hand; None is whole where a length is expected, else so far.
    unit : str
        Of the samples.
    start : datetime or None
        The calendar moment of time 0.
    percentiles : (float, float)
        Which percentiles of the samples become 0 and 1.
    silence_s : float
        A feed that tells its clock, or samples, and is silent for longer leaves a gap, s.

    Raises
    ------
    InputError
        A value that isn't allowed.

    Examples
    --------
    >>> live = ov.LiveTimeline("Home - Away", expect_s=5700.0)
    >>> live.append(events=[ov.Event(786.2, "goal", "1-0 Parris")])
    >>> live.snapshot().known_until_s
    786.2
    >>> live.map = "so far"
    >>> live.snapshot().duration_s
    786.2
    """

    def __init__(
        self,
        title: str = "",
        *,
        expect_s: float | None = None,
        map: Map | None = None,
        unit: str = "",
        start: datetime | None = None,
        percentiles: tuple[float, float] = EXTREMES,
        silence_s: float = SILENCE_S,
    ) -> None:
        self._lock = threading.RLock()
        self._title = validation.text(title, "title")
        self._unit = validation.text(unit, "unit")
        validation.moment(start, LONGEST_S)
        self._start = start
        self._percentiles = percentiles
        self._provenance = "a feed"
        self._notes: tuple[str, ...] = ()
        self._kept = KeptEvents()
        self._samples = KeptSamples()
        self._heard = Coverage(validation.positive(silence_s, "silence_s"))
        self._given_gaps: dict[tuple[float, float], str] = {}
        self._clock_s = 0.0
        self._document: Timeline | None = None
        self._revision = 0
        self._changes: deque[Change] = deque(maxlen=MAX_CHANGES)
        self._expect_s = _checked_expectation(expect_s)
        wanted: Map = "whole" if expect_s else "so far"
        self._map: Map = wanted if map is None else _checked_map(map)
        self._is_map_chosen = map is not None
        self._end_s: float | None = None
        self._made: tuple[int, Timeline] | None = None
        self._felt: tuple[Timeline, Timeline] | None = None

    def append(
        self,
        events: Iterable[Event] = (),
        intensity: Intensity | Iterable[ArrayLike] = (),
        *,
        details: Iterable[Event] = (),
        clock_s: float | None = None,
        ids: Iterable[str | None] = (),
    ) -> None:
        """Take what has happened: all of it, or none.

        What is there already stays as it is; what was retracted stays away.

        Parameters
        ----------
        events : iterable of Event
            In any order.
        intensity : Intensity or iterable of (float, float)
            Samples: seconds and value; one for a time that is there already replaces that.
        details : iterable of Event
            Smaller things, felt in windows.
        clock_s : float or None
            What time it is, s: nothing else has happened up to then.
        ids : iterable of (str or None)
            The feed's name of each of the events: an event of the same name replaces the earlier
            one, and is retracted by it.

        Raises
        ------
        InputError
            A time, value or type that isn't allowed; nothing is taken.

        Examples
        --------
        >>> live = ov.LiveTimeline()
        >>> live.append(events=[ov.Event(10.0, "foul")], intensity=[(0.0, 0.2), (12.0, 0.7)])
        >>> live.snapshot().duration_s
        12.0
        """
        happened = tuple(_checked_event(one, "events") for one in events)
        smaller = tuple(_checked_event(one, "details") for one in details)
        unit = ""
        if isinstance(intensity, Intensity):
            unit = intensity.unit
            intensity = np.column_stack([intensity.time_s[:], intensity.value])
        samples = [_checked_sample(one) for one in intensity]
        named: tuple[str | None, ...] = tuple(ids)
        if named and len(named) != len(happened):
            raise InputError(f"{len(named)} ids for {len(happened)} events; give one for each")
        clock = None if clock_s is None else _checked_time(clock_s, "clock_s")
        with self._lock:
            before = self._sight()
            changed = False
            if unit and unit != self._unit:
                self._unit, changed = unit, True
            effects: list[tuple[What, Event]] = []
            for event, name in zip(happened, named or (None,) * len(happened), strict=True):
                effect = self._kept.put(event, name)
                changed |= effect is not None
                effects += effect or ()
            for detail in smaller:
                changed |= self._kept.put_detail(detail)
            for time_s, value in samples:
                changed |= self._samples.put(time_s, value)
                changed |= self._heard.add(time_s)
            if clock is not None:
                changed |= self._heard.add(clock)
                self._clock_s = max(self._clock_s, clock)
            if changed or self._sight() != before:
                self._revised(effects)

    def retract(self, event: Event | str) -> bool:
        """Take an event back: a goal that was annulled.

        It stays away, also if the feed gives it again or only gives it later.

        Parameters
        ----------
        event : Event or str
            An event of that time, kind and label, or the feed's id of it.

        Returns
        -------
        bool
            Whether it was there.

        Raises
        ------
        InputError
            Neither of both.

        Examples
        --------
        >>> live = ov.LiveTimeline()
        >>> goal = ov.Event(786.2, "goal", "1-0 Parris")
        >>> live.append(events=[goal, ov.Event(800.0, "foul")])
        >>> live.retract(goal)
        True
        >>> live.snapshot().kinds()
        {'foul': 1}
        """
        if not isinstance(event, Event | str):
            raise InputError(f"{shown(event)} is neither an Event nor an id")
        with self._lock:
            effect = self._kept.retract(event)
            if effect is None:
                return False
            self._revised(effect)
            return True

    def gap(self, start_s: float, end_s: float, reason: str = "") -> None:
        """Say that nothing is known of a stretch.

        Parameters
        ----------
        start_s, end_s : float
            Seconds.
        reason : str
            Why.

        Raises
        ------
        InputError
            Not 0 <= start_s < end_s.

        Examples
        --------
        >>> live = ov.LiveTimeline()
        >>> live.append(events=[ov.Event(10.0, "foul")], clock_s=40.0)
        >>> live.gap(20.0, 30.0, "no camera")
        >>> live.snapshot().gaps
        ((20.0, 30.0),)
        """
        start, end = _checked_time(start_s, "start_s"), _checked_time(end_s, "end_s")
        if start >= end:
            raise InputError(f"a gap from {start!r} to {end!r} s; it begins before it ends")
        validation.text(reason, "reason")
        with self._lock:
            if self._given_gaps.get((start, end)) != reason and len(self._given_gaps) < MAX_CHANGES:
                self._given_gaps[start, end] = reason
                self._clock_s = max(self._clock_s, end)
                self._revised()

    def describe(
        self,
        *,
        title: str | None = None,
        unit: str | None = None,
        start: datetime | None = None,
        provenance: str | None = None,
        notes: Iterable[str] | None = None,
        percentiles: tuple[float, float] | None = None,
        silence_s: float | None = None,
    ) -> None:
        """Say what it is; what is left out stays as it was.

        Parameters
        ----------
        title : str or None
            Words for a person.
        unit : str or None
            Of the samples.
        start : datetime or None
            The calendar moment of time 0.
        provenance : str or None
            Where it is from.
        notes : iterable of str or None
            What a person should know.
        percentiles : (float, float) or None
            As an Intensity's.
        silence_s : float or None
            As in the constructor; nothing once the clock was told.

        Raises
        ------
        InputError
            A value that isn't allowed; nothing is changed.

        Examples
        --------
        >>> live = ov.LiveTimeline()
        >>> live.describe(title="Home - Away")
        >>> live.snapshot().title
        'Home - Away'
        """
        words = {"title": title, "unit": unit, "provenance": provenance}
        said: dict[str, object] = {
            f"_{name}": validation.text(text, name)
            for name, text in words.items()
            if text is not None
        }
        if notes is not None:
            said["_notes"] = tuple(validation.text(note, "notes") for note in notes)
        validation.moment(start, LONGEST_S)
        if start is not None:
            said["_start"] = start
        if percentiles is not None:
            Intensity(np.zeros(1), np.zeros(1), percentiles=percentiles)  # checked there
            said["_percentiles"] = percentiles
        reach = None if silence_s is None else validation.positive(silence_s, "silence_s")
        with self._lock:
            if reach is not None and not self._heard:
                self._heard.reach_s = reach
            if any(getattr(self, key) != value for key, value in said.items()):
                self.__dict__.update(said)
                self._revised()

    def replace(self, timeline: Timeline) -> None:
        """Take over a timeline that was read anew, in place of all that came.

        Parameters
        ----------
        timeline : Timeline
            All that has happened so far.

        Examples
        --------
        >>> live = ov.LiveTimeline(expect_s=5880.0)
        >>> live.replace(match.window(0.0, 2400.0))
        >>> live.snapshot().known_until_s
        2400.0
        """
        with self._lock:
            if self._document == timeline:
                return
            before = {event_key(event): event for event in self._all_events()}
            after = {event_key(event): event for event in timeline.events}
            changes: list[tuple[What, Event]] = []
            changes += [("retracted", event) for key, event in before.items() if key not in after]
            changes += [("added", event) for key, event in after.items() if key not in before]
            self._document = timeline
            self._revised(changes)

    @property
    def now_s(self) -> float:
        """Up to when it has happened, s: the latest of the clock, the events and the samples."""
        with self._lock:
            if self._document is not None:
                document = self._document
                return (
                    document.duration_s
                    if document.known_until_s is None
                    else document.known_until_s
                )
            last_s = self._samples.last_s if len(self._samples) else 0.0
            return max(self._clock_s, self._kept.last_s, last_s)

    @property
    def revision(self) -> int:
        """Counts up with every change."""
        return self._revision

    @property
    def left_out(self) -> int:
        """How many events were too many to be kept."""
        return self._kept.left_out

    def changes_since(self, revision: int) -> tuple[Change, ...]:
        """Look up which events came and which were taken back.

        Parameters
        ----------
        revision : int
            After which.

        Returns
        -------
        tuple of Change
            In order; each has `revision`, `what` (`"added"` or `"retracted"`) and `event`. The
            latest 1000 are remembered.

        Examples
        --------
        >>> live = ov.LiveTimeline()
        >>> live.append(events=[ov.Event(10.0, "foul")])
        >>> [change.what for change in live.changes_since(0)]
        ['added']
        """
        with self._lock:
            return tuple(change for change in self._changes if change.revision > revision)

    def _sight(self) -> tuple[float, bool]:
        return self.now_s, bool(self._heard)

    def _revised(self, changes: Iterable[tuple[What, Event]] = ()) -> None:
        self._revision += 1
        self._changes.extend(Change(self._revision, what, event) for what, event in changes)

    def _all_events(self) -> Iterable[Event]:
        return self._kept.events.values() if self._document is None else self._document.events

    def end(self, duration_s: float | None = None) -> None:
        """Say that it is over: no map has a future any more.

        Corrections may still come.

        Parameters
        ----------
        duration_s : float or None
            How long it was, s; None is up to now.

        Raises
        ------
        InputError
            Not a number above 0.

        Examples
        --------
        >>> live = ov.LiveTimeline(expect_s=5700.0)
        >>> live.append(events=[ov.Event(10.0, "foul")])
        >>> live.end(5790.0)
        >>> live.snapshot().duration_s, live.ended
        (5790.0, True)
        """
        rule = "a duration is a finite number of seconds"
        given = None if duration_s is None else _checked_length(duration_s, "duration_s", rule)
        with self._lock:
            over = max(self.now_s, SHORTEST_S) if given is None else given
            if self._end_s != over:
                self._end_s = over
                self._revised()

    @property
    def ended(self) -> bool:
        """Whether it is over."""
        return self._end_s is not None

    @property
    def map(self) -> Map:
        """How it is laid under the hand, `"whole"` or `"so far"`; may be set at any time."""
        return self._map

    @map.setter
    def map(self, map: Map) -> None:
        with self._lock:
            self._is_map_chosen = True
            if _checked_map(map) != self._map:
                self._map = map
                self._revised()

    @property
    def expect_s(self) -> float | None:
        """How long it is expected to last, s; may be set at any time."""
        return self._expect_s

    @expect_s.setter
    def expect_s(self, expect_s: float | None) -> None:
        with self._lock:
            if _checked_expectation(expect_s) != self._expect_s:
                self._expect_s = expect_s
                self._revised()

    def suggest(self, expect_s: float | None = None, map: Map | None = None) -> None:
        """Use a length and a map where none was chosen: what a feed says of itself.

        Parameters
        ----------
        expect_s : float or None
            How long it is expected to last, s.
        map : {"whole", "so far"} or None
            How it is laid under the hand; None is whole where a length is expected.

        Raises
        ------
        InputError
            A value that isn't allowed; nothing is changed.

        Examples
        --------
        >>> live = ov.LiveTimeline(map="so far")
        >>> live.suggest(expect_s=5700.0)
        >>> live.map, live.expect_s
        ('so far', 5700.0)
        """
        length = _checked_expectation(expect_s)
        laid: Map = "whole" if length is not None else self._map
        wanted = laid if map is None else _checked_map(map)
        with self._lock:
            before = self._map, self._expect_s
            if self._expect_s is None:
                self._expect_s = length
            if not self._is_map_chosen:
                self._map = wanted
            if before != (self._map, self._expect_s):
                self._revised()

    @property
    def duration_s(self) -> float:
        """How long `snapshot` is, s."""
        with self._lock:
            now = self.now_s
            if self._end_s is not None:
                return max(self._end_s, now)
            if self._map == "so far" or self._expect_s is None:
                return now if now > 0.0 else SHORTEST_S
            over = math.ceil(max(now / self._expect_s - 1.0, 0.0) / EXTRA_TIME)
            return self._expect_s * (1.0 + over * EXTRA_TIME)

    def snapshot(self) -> Timeline:
        """Give the timeline as it is now.

        Returns
        -------
        Timeline
            In the map that is chosen; the same object until something changes. Of a feed that has
            given nothing yet, a flat curve with a note.

        Examples
        --------
        >>> live = ov.LiveTimeline(expect_s=5700.0)
        >>> live.snapshot().notes
        ('nothing has happened yet',)
        """
        with self._lock:
            if self._made is None or self._made[0] != self._revision:
                self._made = (self._revision, self._build())
            return self._made[1]

    def felt(self) -> Timeline:
        """Give the timeline as it is laid under a hand: as `snapshot`, with room behind now.

        What has just happened lies at the very end of `snapshot` where that is so far, and a disk
        only meets what it can pass. So 3 % of future lie behind it, until it is over.

        Returns
        -------
        Timeline
            The same object until something changes.

        Examples
        --------
        >>> live = ov.LiveTimeline(map="so far")
        >>> live.append(events=[ov.Event(1000.0, "goal")])
        >>> live.felt().duration_s, live.felt().known_until_s
        (1030.0, 1000.0)
        """
        with self._lock:
            shown = self.snapshot()
            now = self.now_s
            if self.ended or now == 0.0 or shown.duration_s >= now * (1.0 + ROOM):
                return shown
            if self._felt is None or self._felt[0] is not shown:
                room = replace(shown, duration_s=now * (1.0 + ROOM), known_until_s=now)
                self._felt = (shown, room)
            return self._felt[1]

    def _build(self) -> Timeline:
        duration_s, now = self.duration_s, self.now_s
        growing = self._end_s is None and self._map == "whole" and self._expect_s is not None
        known_until_s = now if growing and now < duration_s else None
        if self._document is not None:
            document = self._document
            if document.duration_s == duration_s and document.known_until_s == known_until_s:
                return document
            return replace(document, duration_s=duration_s, known_until_s=known_until_s)
        reach = duration_s if known_until_s is None else now
        # periods first, as the readers of matches list them: the same products to the bit
        events = sorted(
            self._kept.events.values(), key=lambda one: (one.kind != "period", one.time_s)
        )
        provenance, notes = self._provenance, self._notes
        intensity: Intensity | None = None
        if len(self._samples):
            times, values = self._samples.arrays()
            intensity = Intensity(times, values, self._unit, self._percentiles)
        elif events and reach > 0.0:
            intensity, derived, said = derive_intensity(events, reach)
            provenance = "; ".join(part for part in (provenance, derived) if part)
            notes = (*notes, *said)
        if not events and intensity is None:
            intensity = Intensity(np.zeros(1), np.zeros(1), self._unit)
            if now == 0.0:
                notes = (*notes, "nothing has happened yet")
        if self._kept.left_out:
            notes = (*notes, f"{self._kept.left_out} events were too many to be kept")
        gaps, reasons = self._gaps(events, reach)
        return Timeline(
            title=self._title,
            duration_s=duration_s,
            events=tuple(events),
            intensity=intensity,
            gaps=gaps,
            gap_reasons=reasons,
            provenance=provenance,
            notes=notes,
            start=self._start,
            details=tuple(self._kept.details.values()),
            known_until_s=known_until_s,
        )

    def _gaps(self, events: Iterable[Event], reach: float) -> tuple[Gaps, tuple[str, ...]]:
        """The stretches that were silent, and those that the feed names; joined where they meet."""
        # a feed that tells no clock may be silent, and what was before the first is not known
        signs = (event.time_s for event in events if event.time_s > self._heard.first_s)
        found = [(*gap, "the feed was silent") for gap in self._heard.gaps(signs)]
        found += [(start, min(end, reach), why) for (start, end), why in self._given_gaps.items()]
        return merged_gaps(found)

    def __repr__(self) -> str:
        over = "ended" if self.ended else f"{self._map}, now {clock_text(self.now_s)}"
        count = counted(sum(1 for _ in self._all_events()), "event")
        return f"<LiveTimeline {short(self._title)}: {over}, {count}>"


def _within(value: object, what: str, hint: str, low: float, high: float) -> float:
    """Return a number in a range; InputError ends with the hint."""
    number = validation.number(value, what, hint)
    if not low <= number <= high:
        raise InputError(f"{what} is {number!r}; {hint}")
    return number


def _checked_event(value: object, where: str) -> Event:
    """Return an event at a time that is allowed; `where` is what holds it."""
    if not isinstance(value, Event):
        raise InputError(f"{where} holds {shown(value)}; give Event")
    _checked_time(value.time_s, "time_s")
    return value


def _checked_time(value: object, what: str) -> float:
    """Return seconds from the start."""
    hint = f"times are seconds from the start, 0 to {LONGEST_S:g}"
    return _within(value, what, hint, 0.0, LONGEST_S)


def _checked_sample(value: object) -> tuple[float, float]:
    """Return a sample's time, s, and its value."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if not isinstance(value, tuple | list) or len(value) != 2:
        raise InputError(f"a sample is {shown(value)}; give a time in s and a value")
    hint = f"it is finite, up to {MAX_VALUE:g}"
    level = _within(value[1], "a sample's value", hint, -MAX_VALUE, MAX_VALUE)
    return _checked_time(value[0], "a sample's time"), level


def _checked_length(value: object, name: str, rule: str) -> float:
    """Return seconds that a feed may last; `name` is the parameter's, `rule` what it has to be."""
    hint = f"{rule} above 0, up to {LONGEST_S:g}"
    return _within(validation.positive(value, name, hint), name, hint, 0.0, LONGEST_S)


def _checked_expectation(value: object) -> float | None:
    """Return how long a feed is expected to last, s, or None."""
    rule = "the expected length is seconds,"
    return None if value is None else _checked_length(value, "expect_s", rule)


def _checked_map(value: Map) -> Map:
    """Return how a timeline that grows is laid out."""
    if value not in MAPS:
        raise InputError(f"map is {shown(value)}; it is one of {', '.join(MAPS)}")
    return value
