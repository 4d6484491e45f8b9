"""What a feed has given so far: late, doubled, out of order, taken back."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterable
from datetime import datetime

import numpy as np
from numpy.typing import ArrayLike

from overview_dsp import validation
from overview_dsp.data.feeds.coverage import Coverage
from overview_dsp.data.feeds.feed_checks import (
    LONGEST_S,
    checked_event,
    checked_sample,
    checked_time,
)
from overview_dsp.data.feeds.kept_events import Change, KeptEvents, What, event_key
from overview_dsp.data.feeds.kept_samples import KeptSamples
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.intensity import Intensity
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown

MAX_CHANGES = 1_000
"""So many of the latest changes are remembered for `changes_since`."""


class Gathered:
    """What has come of a timeline that is still growing, and what is known of it.

    The same things give the same in any order (events of one time stay in the order they came),
    except that the last of two values for one sample or one id stands.

    Thread: any.
    """

    def __init__(
        self,
        title: str,
        unit: str,
        start: datetime | None,
        percentiles: tuple[float, float],
        silence_s: float,
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
        >>> import overview_dsp as ov
        >>> live = ov.LiveTimeline()
        >>> live.append(events=[ov.Event(10.0, "foul")], intensity=[(0.0, 0.2), (12.0, 0.7)])
        >>> live.snapshot().duration_s
        12.0
        """
        happened = tuple(checked_event(one, "events") for one in events)
        smaller = tuple(checked_event(one, "details") for one in details)
        unit = ""
        if isinstance(intensity, Intensity):
            unit = intensity.unit
            intensity = np.column_stack([intensity.time_s[:], intensity.value])
        samples = [checked_sample(one) for one in intensity]
        named: tuple[str | None, ...] = tuple(ids)
        if named and len(named) != len(happened):
            raise InputError(f"{len(named)} ids for {len(happened)} events; give one for each")
        clock = None if clock_s is None else checked_time(clock_s, "clock_s")
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
        >>> import overview_dsp as ov
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
        >>> import overview_dsp as ov
        >>> live = ov.LiveTimeline()
        >>> live.append(events=[ov.Event(10.0, "foul")], clock_s=40.0)
        >>> live.gap(20.0, 30.0, "no camera")
        >>> live.snapshot().gaps
        ((20.0, 30.0),)
        """
        start, end = checked_time(start_s, "start_s"), checked_time(end_s, "end_s")
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
        >>> import overview_dsp as ov
        >>> live = ov.LiveTimeline()
        >>> live.describe(title="Home - Away")
        >>> live.snapshot().title
        'Home - Away'
        """
        told = {
            "_title": None if title is None else validation.text(title, "title"),
            "_unit": None if unit is None else validation.text(unit, "unit"),
            "_provenance": None
            if provenance is None
            else validation.text(provenance, "provenance"),
            "_notes": None if notes is None else tuple(validation.text(n, "notes") for n in notes),
            "_start": start,
            "_percentiles": percentiles,
        }
        validation.moment(start, LONGEST_S)
        if percentiles is not None:
            Intensity(np.zeros(1), np.zeros(1), percentiles=percentiles)  # checked there
        reach = None if silence_s is None else validation.positive(silence_s, "silence_s")
        with self._lock:
            if reach is not None and not self._heard:
                self._heard.reach_s = reach
            said = {key: value for key, value in told.items() if value is not None}
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
        >>> import overview_dsp as ov
        >>> live = ov.LiveTimeline(expect_s=5880.0)
        >>> match = ov.load_timeline("world-cup-final-2018")
        >>> live.replace(match.window(0.0, 2400.0))
        >>> live.snapshot().until_s
        2400.0
        """
        with self._lock:
            if self._document == timeline:
                return
            before = {event_key(event): event for event in self._all_events()}
            after = {event_key(event): event for event in timeline.events}
            gone = [event for key, event in before.items() if key not in after]
            new = [event for key, event in after.items() if key not in before]
            self._document = timeline
            self._revised(
                [
                    *(("retracted", event) for event in gone),
                    *(("added", event) for event in new),
                ]
            )

    @property
    def now_s(self) -> float:
        """Up to when it has happened, s: the latest of the clock, the events and the samples."""
        with self._lock:
            if self._document is not None:
                document = self._document
                return document.duration_s if document.until_s is None else document.until_s
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
        >>> import overview_dsp as ov
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
