"""Live timeline: events and samples received so far, provided as one Timeline at a time.

Events may arrive late, twice or out of order, and may be retracted. The result does not depend on
the order of arrival, with two exceptions: events with equal times keep their order of arrival, and
the later of two values for one sample or one id is used.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Iterable
from dataclasses import replace
from datetime import datetime
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from overview_dsp import validation
from overview_dsp.data.analysis.crowd_excitement import derive_intensity
from overview_dsp.data.feeds.feed_history import (
    Action,
    Change,
    Coverage,
    EventBuffer,
    SampleBuffer,
    identity_of,
    merged_gaps,
)
from overview_dsp.data.readers.football.match_timeline import label_without_counts
from overview_dsp.data.timeline.curve_points import MAX_VALUE
from overview_dsp.data.timeline.event import GOALS, WITHDRAWN_GOAL, Event, checked_sides
from overview_dsp.data.timeline.gaps import Gaps
from overview_dsp.data.timeline.intensity import EXTREMES, Intensity
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, quoted
from overview_dsp.public import counted, short
from overview_dsp.units import clock_text

Layout = Literal["whole", "so far"]

LAYOUTS: tuple[Layout, ...] = ("whole", "so far")
"""Allowed values of `layout`."""

LONGEST_S = 100 * 366 * 86_400.0
"""Maximum time of an event or sample, s. Later times indicate a broken clock."""

MAX_CHANGES = 1_000  # number of latest changes stored for `changes_since`
EXTRA_TIME = 0.05
"""Share of the expected duration that is added each time the clock passes the end.

The share is five minutes for a match and over an hour for a day, so the layout changes rarely."""

FUTURE_MARGIN = 0.03  # minimum length of the future after now, as a share of the time until now
SHORTEST_S = 1.0  # minimum duration, s
MAX_CORRECTION_S = 180.0  # maximum change of an event's time that is a correction, s
SILENCE_S = 120.0  # silence, s, after which a feed that sends clock lines or samples gets a gap


class LiveTimeline:
    """Timeline of an event in progress: events and samples are appended, events can be retracted.

    `snapshot` returns the current timeline. Its `layout` is one of two: `"so far"` ends now,
    `"whole"` has the expected duration and marks the time after now as the future. The future has
    its own friction. Football events without samples get the same excitement curve as a file of
    these events.

    Thread: any.

    Parameters
    ----------
    title : str
        Title for display.
    expected_duration_s : float or None
        Expected duration, s. It is extended by 5 % each time the clock passes it.
    layout : {"whole", "so far"} or None
        Part of the duration that the disk covers. None: "whole" with an expected duration, else
        "so far".
    unit : str
        Unit of the samples.
    start : datetime or None
        Calendar date and time of time 0.
    percentiles : (float, float)
        Percentiles of the samples that become intensity 0 and 1.
    silence_s : float
        Silence, s, after which a feed that sends clock lines or samples gets a gap.

    Raises
    ------
    InputError
        A value is not allowed.

    Examples
    --------
    >>> live = ov.LiveTimeline("Home - Away", expected_duration_s=5700.0)
    >>> live.append(events=[ov.Event(786.2, "goal", "1-0 Parris")])
    >>> live.snapshot().known_until_s
    786.2
    >>> live.layout = "so far"
    >>> live.snapshot().duration_s
    786.2
    """

    def __init__(
        self,
        title: str = "",
        *,
        expected_duration_s: float | None = None,
        layout: Layout | None = None,
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
        self._sides: tuple[str, ...] = ()
        self._buffer = EventBuffer()
        self._samples = SampleBuffer()
        self._coverage = Coverage(validation.positive(silence_s, "silence_s"))
        self._reported_gaps: dict[tuple[float, float], str] = {}
        self._withdrawn: list[Event] = []  # goals that do not count, as recorded
        self._clock_s = 0.0
        self._document: Timeline | None = None
        self._revision = 0
        self._changes: deque[Change] = deque(maxlen=MAX_CHANGES)
        self._expected_duration_s = _checked_expectation(expected_duration_s)
        default: Layout = "whole" if expected_duration_s else "so far"
        self._layout: Layout = default if layout is None else _checked_layout(layout)
        self._is_layout_set = layout is not None
        self._end_s: float | None = None
        self._snapshot: tuple[int, Timeline] | None = None
        self._padded: tuple[Timeline, Timeline] | None = None

    def append(
        self,
        events: Iterable[Event] = (),
        intensity: Intensity | Iterable[ArrayLike] = (),
        *,
        details: Iterable[Event] = (),
        clock_s: float | None = None,
        ids: Iterable[str | None] = (),
    ) -> None:
        """Add events, samples and the clock; if one is invalid, nothing is added.

        Events that are present already are ignored, as are retracted events.

        Parameters
        ----------
        events : iterable of Event
            Events in any order.
        intensity : Intensity or iterable of (float, float)
            Samples as time (s) and value. A sample replaces an earlier one of the same time.
        details : iterable of Event
            Detail events, which are shown in windows only.
        clock_s : float or None
            Current time, s. All events until this time have been reported.
        ids : iterable of (str or None)
            Id in the feed of each event. An event replaces an earlier one with the same id, and
            the id can be used to retract it.

        Raises
        ------
        InputError
            A time, value or type is not allowed; nothing is added.

        Examples
        --------
        >>> live = ov.LiveTimeline()
        >>> live.append(events=[ov.Event(10.0, "foul")], intensity=[(0.0, 0.2), (12.0, 0.7)])
        >>> live.snapshot().duration_s
        12.0
        """
        checked = tuple(_checked_event(one, "events") for one in events)
        checked_details = tuple(_checked_event(one, "details") for one in details)
        unit = ""
        if isinstance(intensity, Intensity):
            unit = intensity.unit
            intensity = np.column_stack([intensity.time_s[:], intensity.value])
        samples = [_checked_sample(one) for one in intensity]
        event_ids: tuple[str | None, ...] = tuple(ids)
        if event_ids and len(event_ids) != len(checked):
            raise InputError(
                f"{len(event_ids)} ids for {len(checked)} events; must be one id per event"
            )
        clock = None if clock_s is None else _checked_time(clock_s, "clock_s")
        with self._lock:
            before = self.now_s, bool(self._coverage)
            changed = False
            if unit and unit != self._unit:
                self._unit, changed = unit, True
            effects: list[tuple[Action, Event]] = []
            for event, id_ in zip(checked, event_ids or (None,) * len(checked), strict=True):
                effect = self._buffer.put(event, id_)
                changed |= effect is not None
                effects += effect or ()
            for detail in checked_details:
                changed |= self._buffer.put_detail(detail)
            for time_s, value in samples:
                changed |= self._samples.put(time_s, value)
                changed |= self._coverage.add(time_s)
            if clock is not None:
                changed |= self._coverage.add(clock)
                self._clock_s = max(self._clock_s, clock)
            if changed or (self.now_s, bool(self._coverage)) != before:
                self._record_revision(effects)

    def retract(self, event: Event | str) -> bool:
        """Retract an event.

        It stays retracted, even if the feed sends it again or sends it only later. A goal leaves
        an event of the kind `withdrawn_goal`, unless another one corrects it.

        Parameters
        ----------
        event : Event or str
            Event with the same time, kind and label, or its id in the feed.

        Returns
        -------
        bool
            True if the event was present.

        Raises
        ------
        InputError
            `event` is neither an Event nor an id.

        Examples
        --------
        >>> live = ov.LiveTimeline()
        >>> goal = ov.Event(786.2, "goal", "1-0 Parris")
        >>> live.append(events=[goal, ov.Event(800.0, "foul")])
        >>> live.retract(goal)
        True
        >>> live.snapshot().kinds()
        {'withdrawn_goal': 1, 'foul': 1}
        """
        if not isinstance(event, Event | str):
            raise InputError(f"event is {quoted(event)}; must be an Event or an id")
        with self._lock:
            effect = self._buffer.retract(event)
            if effect is None:
                return False
            self._record_revision(effect)
            return True

    def gap(self, start_s: float, end_s: float, reason: str = "") -> None:
        """Add a gap: a time range without data.

        Parameters
        ----------
        start_s, end_s : float
            Start and end of the gap, s.
        reason : str
            Reason for the gap.

        Raises
        ------
        InputError
            `0 <= start_s < end_s` does not hold.

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
            raise InputError(
                f"gap is from {start!r} to {end!r} s; its start must be before its end"
            )
        validation.text(reason, "reason")
        with self._lock:
            is_new = self._reported_gaps.get((start, end)) != reason
            if is_new and len(self._reported_gaps) < MAX_CHANGES:
                self._reported_gaps[start, end] = reason
                self._clock_s = max(self._clock_s, end)
                self._record_revision()

    def describe(
        self,
        *,
        title: str | None = None,
        unit: str | None = None,
        start: datetime | None = None,
        provenance: str | None = None,
        notes: Iterable[str] | None = None,
        sides: Iterable[str] | None = None,
        percentiles: tuple[float, float] | None = None,
        silence_s: float | None = None,
    ) -> None:
        """Set the description; parameters that are None stay unchanged.

        Parameters
        ----------
        title : str or None
            Title for display.
        unit : str or None
            Unit of the samples.
        start : datetime or None
            Calendar date and time of time 0.
        provenance : str or None
            Origin of the data.
        notes : iterable of str or None
            Notes for display.
        sides : iterable of str or None
            Names of the two teams.
        percentiles : (float, float) or None
            Percentiles of the samples that become intensity 0 and 1.
        silence_s : float or None
            As in the constructor. It has no effect after the first clock line or sample.

        Raises
        ------
        InputError
            A value is not allowed; nothing is changed.

        Examples
        --------
        >>> live = ov.LiveTimeline()
        >>> live.describe(title="Home - Away")
        >>> live.snapshot().title
        'Home - Away'
        """
        texts = {"title": title, "unit": unit, "provenance": provenance}
        fields: dict[str, object] = {
            f"_{name}": validation.text(text, name)
            for name, text in texts.items()
            if text is not None
        }
        if notes is not None:
            fields["_notes"] = tuple(validation.text(note, "notes") for note in notes)
        if sides is not None:
            fields["_sides"] = checked_sides(sides)
        validation.moment(start, LONGEST_S)
        if start is not None:
            fields["_start"] = start
        if percentiles is not None:
            Intensity(np.zeros(1), np.zeros(1), percentiles=percentiles)  # validates them
            fields["_percentiles"] = percentiles
        reach = None if silence_s is None else validation.positive(silence_s, "silence_s")
        with self._lock:
            if reach is not None and not self._coverage:
                self._coverage.reach_s = reach
            if any(getattr(self, key) != value for key, value in fields.items()):
                self.__dict__.update(fields)
                self._record_revision()

    def replace(self, timeline: Timeline) -> None:
        """Replace all data by a timeline that was read again.

        An event whose label alone has changed is neither retracted nor added, nor is one that is
        corrected by at most three minutes, or a goal that turns out to be an own goal. A timeline
        that is known in part only sets the expected duration.

        Parameters
        ----------
        timeline : Timeline
            All data until now.

        Examples
        --------
        >>> live = ov.LiveTimeline(expected_duration_s=5880.0)
        >>> live.replace(match.window(0.0, 2400.0))
        >>> live.snapshot().known_until_s
        2400.0
        """
        with self._lock:
            if self._document == timeline:
                return
            before = {identity_of(event): event for event in self._all_events()}
            after = {identity_of(event): event for event in timeline.events}
            removed = [event for key, event in before.items() if key not in after]
            changes: list[tuple[Action, Event]] = []
            for key, event in after.items():
                if key in before:
                    continue
                same = [one for one in removed if _is_correction(one, event)]
                if same:
                    removed.remove(min(same, key=lambda one: abs(one.time_s - event.time_s)))
                else:
                    changes.append(("added", event))
            self._document = timeline
            for event in removed:
                self._buffer.withdraw(event)
            changes = [*(("retracted", event) for event in removed), *changes]
            if timeline.known_until_s is not None:
                self.suggest(timeline.duration_s)
            self._record_revision(changes)

    @property
    def now_s(self) -> float:
        """Latest time of the clock, the events and the samples, s."""
        with self._lock:
            if self._document is not None:
                until_s = self._document.known_until_s
                return self._document.duration_s if until_s is None else until_s
            last_s = self._samples.last_s if len(self._samples) else 0.0
            return max(self._clock_s, self._buffer.last_s, last_s)

    @property
    def revision(self) -> int:
        """Number of changes so far."""
        return self._revision

    @property
    def omitted_events(self) -> int:
        """Number of events that exceeded the capacity and were omitted."""
        return self._buffer.omitted

    def changes_since(self, revision: int) -> tuple[Change, ...]:
        """Return the events that were added and retracted after a revision.

        Parameters
        ----------
        revision : int
            Value of `revision` after which changes are returned.

        Returns
        -------
        tuple of Change
            Changes in order; each has `revision`, `action` (`"added"` or `"retracted"`) and
            `event`. The latest 1000 changes are stored.

        Examples
        --------
        >>> live = ov.LiveTimeline()
        >>> live.append(events=[ov.Event(10.0, "foul")])
        >>> [change.action for change in live.changes_since(0)]
        ['added']
        """
        with self._lock:
            return tuple(change for change in self._changes if change.revision > revision)

    def _record_revision(self, changes: Iterable[tuple[Action, Event]] = ()) -> None:
        before, self._withdrawn = self._withdrawn, self._withdrawn_goals()
        self._revision += 1
        self._changes.extend(Change(self._revision, action, event) for action, event in changes)
        added = (event for event in self._withdrawn if event not in before)
        self._changes.extend(Change(self._revision, "added", event) for event in added)

    def _withdrawn_goals(self) -> list[Event]:
        """Return the goals that do not count, without those that another event corrects."""
        if not self._buffer.withdrawn:
            return []
        present = list(self._all_events())
        marks = [replace(one, kind="goal") for one in present if one.kind == WITHDRAWN_GOAL]
        known = [*(one for one in present if one.kind in GOALS), *marks]
        return [
            replace(goal, kind=WITHDRAWN_GOAL, label=label_without_counts(goal.label))
            for _, goal in sorted(self._buffer.withdrawn.items())
            if goal.time_s <= self.duration_s
            and not any(_is_correction(goal, one) for one in known)
        ]

    def _all_events(self) -> Iterable[Event]:
        return self._buffer.events.values() if self._document is None else self._document.events

    def end(self, duration_s: float | None = None) -> None:
        """Mark the timeline as ended: no layout has a future any longer.

        Corrections may still arrive.

        Parameters
        ----------
        duration_s : float or None
            Final duration, s. None: until now. A clock beyond it is set back to it.

        Raises
        ------
        InputError
            `duration_s` is not a number above 0.

        Examples
        --------
        >>> live = ov.LiveTimeline(expected_duration_s=5700.0)
        >>> live.append(events=[ov.Event(10.0, "foul")])
        >>> live.end(5790.0)
        >>> live.snapshot().duration_s, live.ended
        (5790.0, True)
        """
        length = None if duration_s is None else checked_duration(duration_s, "duration_s")
        with self._lock:
            end_s = max(self.now_s, SHORTEST_S) if length is None else length
            if self._end_s != end_s:
                self._clock_s = min(self._clock_s, end_s)  # the end overrules a wrong clock
                self._coverage.cut(end_s)
                self._end_s = end_s
                self._record_revision()

    @property
    def ended(self) -> bool:
        """True after `end`."""
        return self._end_s is not None

    @property
    def layout(self) -> Layout:
        """Part of the duration that the disk covers, `"whole"` or `"so far"`. It can be set."""
        return self._layout

    @layout.setter
    def layout(self, layout: Layout) -> None:
        with self._lock:
            self._is_layout_set = True
            if _checked_layout(layout) != self._layout:
                self._layout = layout
                self._record_revision()

    @property
    def expected_duration_s(self) -> float | None:
        """Expected duration, s. It can be set."""
        return self._expected_duration_s

    @expected_duration_s.setter
    def expected_duration_s(self, expected_duration_s: float | None) -> None:
        with self._lock:
            if _checked_expectation(expected_duration_s) != self._expected_duration_s:
                self._expected_duration_s = expected_duration_s
                self._record_revision()

    def suggest(
        self, expected_duration_s: float | None = None, layout: Layout | None = None
    ) -> None:
        """Set the expected duration and layout of the feed, unless they have been set already.

        Parameters
        ----------
        expected_duration_s : float or None
            Expected duration, s.
        layout : {"whole", "so far"} or None
            Layout. None: "whole" with an expected duration.

        Raises
        ------
        InputError
            A value is not allowed; nothing is changed.

        Examples
        --------
        >>> live = ov.LiveTimeline(layout="so far")
        >>> live.suggest(expected_duration_s=5700.0)
        >>> live.layout, live.expected_duration_s
        ('so far', 5700.0)
        """
        length = _checked_expectation(expected_duration_s)
        default: Layout = "whole" if length is not None else self._layout
        suggested = default if layout is None else _checked_layout(layout)
        with self._lock:
            before = self._layout, self._expected_duration_s
            if self._expected_duration_s is None:
                self._expected_duration_s = length
            if not self._is_layout_set:
                self._layout = suggested
            if before != (self._layout, self._expected_duration_s):
                self._record_revision()

    @property
    def duration_s(self) -> float:
        """Duration of `snapshot`, s."""
        with self._lock:
            now = self.now_s
            if self._end_s is not None:
                return max(self._end_s, now)
            if self._layout == "so far" or self._expected_duration_s is None:
                return now if now > 0.0 else SHORTEST_S
            expected = self._expected_duration_s
            extensions = math.ceil(max(now / expected - 1.0, 0.0) / EXTRA_TIME)
            return expected * (1.0 + extensions * EXTRA_TIME)

    def snapshot(self) -> Timeline:
        """Return the current timeline.

        Returns
        -------
        Timeline
            Timeline in the current layout; the same object until the data change. Before any
            data arrive it has a flat curve and a note.

        Examples
        --------
        >>> live = ov.LiveTimeline(expected_duration_s=5700.0)
        >>> live.snapshot().notes
        ('nothing has happened yet',)
        """
        with self._lock:
            if self._snapshot is None or self._snapshot[0] != self._revision:
                self._snapshot = (self._revision, self._build())
            return self._snapshot[1]

    def padded_snapshot(self) -> Timeline:
        """Return `snapshot` with at least 3 % of future after now, until the timeline has ended.

        The disk strikes an event only when it passes it. In the layout `"so far"` the latest event
        is at the end of `snapshot`, where the disk cannot pass it.

        Returns
        -------
        Timeline
            The same object until the data change.

        Examples
        --------
        >>> live = ov.LiveTimeline(layout="so far")
        >>> live.append(events=[ov.Event(1000.0, "goal")])
        >>> live.padded_snapshot().duration_s, live.padded_snapshot().known_until_s
        (1030.0, 1000.0)
        """
        with self._lock:
            snapshot = self.snapshot()
            now = self.now_s
            if self.ended or now == 0.0 or snapshot.duration_s >= now * (1.0 + FUTURE_MARGIN):
                return snapshot
            if self._padded is None or self._padded[0] is not snapshot:
                padded = replace(
                    snapshot, duration_s=now * (1.0 + FUTURE_MARGIN), known_until_s=now
                )
                self._padded = (snapshot, padded)
            return self._padded[1]

    def _build(self) -> Timeline:
        duration_s, now = self.duration_s, self.now_s
        growing = (
            self._end_s is None
            and self._layout == "whole"
            and self._expected_duration_s is not None
        )
        known_until_s = now if growing and now < duration_s else None
        if self._document is not None:
            document = self._document
            if document.duration_s == duration_s and document.known_until_s == known_until_s:
                changes: dict[str, Any] = {}
            else:
                changes = {"duration_s": duration_s, "known_until_s": known_until_s}
            if withdrawn := self._withdrawn_goals():
                changes["events"] = (*document.events, *withdrawn)
            return replace(document, **changes) if changes else document
        reach = duration_s if known_until_s is None else now
        # periods first, as the match readers sort them, so that the curve is bit-identical
        events = sorted(
            (*self._buffer.events.values(), *self._withdrawn_goals()),
            key=lambda one: (one.kind != "period", one.time_s),
        )
        provenance, notes = self._provenance, self._notes
        intensity: Intensity | None = None
        if len(self._samples):
            times, values = self._samples.arrays()
            intensity = Intensity(times, values, self._unit, self._percentiles)
        elif events and reach > 0.0:
            intensity, derived, derived_notes = derive_intensity(events, reach)
            provenance = "; ".join(part for part in (provenance, derived) if part)
            notes = (*notes, *derived_notes)
        if not events and intensity is None:
            intensity = Intensity(np.zeros(1), np.zeros(1), self._unit)
            if now == 0.0:
                notes = (*notes, "nothing has happened yet")
        if self.omitted_events:
            notes = (*notes, f"{self.omitted_events} events were omitted: too many to store")
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
            details=tuple(self._buffer.details.values()),
            known_until_s=known_until_s,
            sides=self._sides,
        )

    def _gaps(self, events: Iterable[Event], reach: float) -> tuple[Gaps, tuple[str, ...]]:
        """Return the silent time ranges and the gaps in the feed, merged, with their reasons."""
        # silence counts only from the first clock line or sample on
        times = (event.time_s for event in events if event.time_s > self._coverage.first_s)
        found = [(*gap, "the feed was silent") for gap in self._coverage.gaps(times)]
        found += [
            (start, min(end, reach), why) for (start, end), why in self._reported_gaps.items()
        ]
        return merged_gaps(found)

    def __repr__(self) -> str:
        status = "ended" if self.ended else f"{self._layout}, now {clock_text(self.now_s)}"
        count = counted(len([*self._all_events(), *self._withdrawn_goals()]), "event")
        return f"<LiveTimeline {short(self._title)}: {status}, {count}>"


def _is_correction(before: Event, after: Event) -> bool:
    """Return whether an event is another one with its label, minute or kind of goal corrected."""
    if before.time_s == after.time_s:
        return before.kind == after.kind or {before.kind, after.kind} <= GOALS
    texts = [label_without_counts(one.label) for one in (before, after)]
    near = abs(before.time_s - after.time_s) <= MAX_CORRECTION_S
    return near and before.kind == after.kind and texts[0] == texts[1] != ""


def _in_range(value: object, name: str, hint: str, low: float, high: float) -> float:
    """Return a number from `low` to `high`; the InputError ends with `hint`."""
    number = validation.number(value, name, hint)
    if not low <= number <= high:
        raise InputError(f"{name} is {number!r}; {hint}")
    return number


def _checked_event(value: object, parameter: str) -> Event:
    if not isinstance(value, Event):
        raise InputError(f"{parameter} contains {quoted(value)}; each item must be an Event")
    _checked_time(value.time_s, "time_s")
    return value


def _checked_time(value: object, name: str) -> float:
    hint = f"times must be 0 to {LONGEST_S:g} s from the start"
    return _in_range(value, name, hint, 0.0, LONGEST_S)


def _checked_sample(value: object) -> tuple[float, float]:
    """Return the time, s, and the value of a sample."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if not isinstance(value, tuple | list) or len(value) != 2:
        raise InputError(f"a sample is {quoted(value)}; must be a time in s and a value")
    hint = f"must be finite, -{MAX_VALUE:g} to {MAX_VALUE:g}"
    level = _in_range(value[1], "a sample's value", hint, -MAX_VALUE, MAX_VALUE)
    return _checked_time(value[0], "a sample's time"), level


def checked_duration(value: object, name: str) -> float:
    """Return a duration, s, of a live timeline, or raise InputError if it is out of range."""
    hint = f"must be above 0, up to {LONGEST_S:g} s"
    return _in_range(validation.positive(value, name, hint), name, hint, 0.0, LONGEST_S)


def _checked_expectation(value: object) -> float | None:
    return None if value is None else checked_duration(value, "expected_duration_s")


def _checked_layout(value: Layout) -> Layout:
    if value not in LAYOUTS:
        raise InputError(f"layout is {quoted(value)}; must be one of {', '.join(LAYOUTS)}")
    return value
