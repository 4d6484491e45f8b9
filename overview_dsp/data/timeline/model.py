"""Timeline, the result of every reader: events, intensity curve, gaps and provenance.

All values are validated on construction, so that no other code has to validate them.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from datetime import datetime, timedelta
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from overview_dsp import validation
from overview_dsp.arrays import BoolArray, FloatArray, IntArray
from overview_dsp.data.timeline.event import (
    FIELDS,
    MARK,
    Event,
    checked_sides,
    cut_events,
    sorted_events,
)
from overview_dsp.data.timeline.gaps import cut_gaps, in_gap, sorted_gaps, sorted_reasons
from overview_dsp.data.timeline.intensity import EXTREMES, LONG, Intensity
from overview_dsp.data.timeline.notebook import timeline_page
from overview_dsp.data.timeline.ticks import Half, halves_of, window_ticks
from overview_dsp.data.timeline.window_events import Rules, ranks, window_events
from overview_dsp.errors import InputError, quoted
from overview_dsp.public import counted, dataframe, plot_with, short
from overview_dsp.units import clock_text, span_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


__all__ = ["Event", "Intensity", "Timeline"]


@dataclass(frozen=True)
class Timeline:
    """Events in order of time, and an intensity curve. All values are validated on construction.

    Parameters
    ----------
    title : str
        Title for display.
    duration_s : float
        Length in seconds, finite, > 0. Every time lies in [0, duration_s].
    events : tuple of Event
        Events in any order; they are sorted by time, and keep their order at equal times. Two
        events with equal time, kind and label are an error.
    intensity : Intensity or None
        Intensity curve. Events or an intensity are required.
    gaps : tuple of (float, float)
        Spans (start_s, end_s) without data, start < end, not overlapping; they are sorted. Points
        of the curve inside a gap do not count.
    provenance : str
        Origin of the data, and of derived values.
    notes : tuple of str
        Messages about the data for the user.
    start : datetime or None
        Calendar moment of time 0, with or without a time zone; None for a clock (of a match).
    details : tuple of Event
        Minor events (passes of a match); they are sorted. A `window` shows as many of them as can
        be distinguished, by falling weight.
    gap_reasons : tuple of str
        Reasons of the gaps, one text per gap, `""` if unknown; empty if none is known.
    rules : object or None
        Rules for the events of windows of a series (set by readers of series).
    signal : Intensity or None
        Recording from which the curve was derived (an ECG for a heart rate). It is drawn below the
        curve, but is not on the surface and not in files.
    known_until_s : float or None
        End of the known part of a growing timeline, s. The rest is the future, which has its own
        surface. None if all of it is known.
    sides : tuple of str
        Names of the two teams, as in the title, for the `side` of events; empty if unknown.

    Raises
    ------
    InputError
        A wrong value, with a message of one line.

    See Also
    --------
    load_timeline : Reads one from a file.

    Examples
    --------
    >>> curve = ov.Intensity(np.array([0.0, 60.0]), np.array([0.2, 0.9]))
    >>> timeline = ov.Timeline("a minute", 60.0, (ov.Event(12.0, "goal"),), curve)
    >>> timeline.kinds()
    {'goal': 1}
    """

    title: str
    duration_s: float
    events: tuple[Event, ...] = ()
    intensity: Intensity | None = None
    gaps: tuple[tuple[float, float], ...] = ()
    provenance: str = ""
    notes: tuple[str, ...] = ()
    start: datetime | None = None
    details: tuple[Event, ...] = ()
    gap_reasons: tuple[str, ...] = ()
    rules: Rules | None = field(default=None, compare=False, repr=False)
    signal: Intensity | None = field(default=None, compare=False, repr=False)
    known_until_s: float | None = None
    sides: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        validation.text(self.title, "title")
        validation.text(self.provenance, "provenance")
        duration_s = validation.positive(
            self.duration_s, "duration_s", "a duration is a finite number of seconds above 0"
        )
        object.__setattr__(self, "duration_s", duration_s)
        notes = tuple(validation.text(note, f"notes[{i}]") for i, note in enumerate(self.notes))
        object.__setattr__(self, "notes", notes)
        object.__setattr__(self, "sides", checked_sides(self.sides))
        validation.moment(self.start, duration_s)
        object.__setattr__(self, "known_until_s", validation.until(self.known_until_s, duration_s))
        object.__setattr__(self, "events", sorted_events(self.events, duration_s))
        with validation.prefix_errors("details: "):
            object.__setattr__(self, "details", sorted_events(self.details, duration_s))
        gaps = sorted_gaps(self.gaps, duration_s)
        object.__setattr__(self, "gap_reasons", sorted_reasons(self.gap_reasons, self.gaps))
        object.__setattr__(self, "gaps", gaps)
        if self.intensity is not None:
            hint = "give times and values: ov.Intensity(time_s, value, unit)"
            validation.instance(self.intensity, Intensity, "intensity", hint)
        if self.intensity is not None and self.intensity.last_s > duration_s:
            last = self.intensity.count - 1
            raise InputError(
                f"intensity.time_s[{last}] is {self.intensity.last_s!r}, after the "
                f"end of the timeline (duration_s {duration_s!r}); {validation.TIME_HINT}"
            )
        if not self.events and self.intensity is None:
            raise InputError(
                "the timeline has neither events nor an intensity; give one of them or both"
            )

    def kinds(self) -> dict[str, int]:
        """Count the events of each kind.

        Returns
        -------
        dict of str to int
            In order of first appearance.

        Examples
        --------
        >>> match.kinds()["goal"]
        5
        """
        return dict(Counter(event.kind for event in self.events))

    def event(self, kind: str, number: int) -> Event:
        """Return the n-th event of a kind.

        Parameters
        ----------
        kind : str
            Event kind.
        number : int
            Number from 1, in order of time.

        Returns
        -------
        Event
            The event.

        Raises
        ------
        InputError
            There are no or too few events of that kind; the message has the number.

        Examples
        --------
        >>> match.event("goal", 2).time_s > match.event("goal", 1).time_s
        True
        """
        validation.instance(kind, str, "kind", "'goal' is one")
        found = [event for event in self.events if event.kind == kind]
        if not found:
            there = ", ".join(self.kinds()) or "no events at all"
            raise InputError(f"the timeline has no event of kind {quoted(kind)}; it has {there}")
        number = validation.whole(number, "number")
        if not 1 <= number <= len(found):
            raise InputError(
                f"there is no {kind} number {quoted(number)}; the timeline has {len(found)}: "
                f"give 1 to {len(found)}"
            )
        return found[number - 1]

    @cached_property
    def scale(self) -> tuple[float, float]:
        """Value of the curve that becomes 0, and its distance to the value that becomes 1."""
        if self.intensity is None:
            return 0.0, 0.0
        curve = self.intensity
        if curve.count > LONG:
            low, high = curve.scale_outside(self.gaps)
        else:
            times = np.asarray(curve.time_s)
            known = np.ones(1, np.bool_) if curve.is_constant else self.has_data(times)
            low, high = curve.scale(known)
        as_is = curve.percentiles == EXTREMES and low >= 0.0 and high <= 1.0
        return (0.0, 1.0) if as_is else (low, high - low)

    def intensity_at(self, times: ArrayLike) -> FloatArray:
        """Evaluate the curve, linear between its points.

        Parameters
        ----------
        times : array_like
            Seconds, any shape.

        Returns
        -------
        float64
            Values of that shape; 0 before the first point and after the last one, inside a gap
            (without its ends), for a timeline without intensity, and for NaN. A curve of one point
            has its value over the whole timeline.

        Examples
        --------
        >>> match.intensity_at([-1.0, 1e9])
        array([0., 0.])
        """
        at = validation.numbers(times, "times")
        flat = at.reshape(-1)  # a scalar too: boolean indexing needs an axis
        return np.where(self.has_data(flat), self._curve_at(flat), 0.0).reshape(at.shape)

    def normalised_intensity_at(self, times: ArrayLike) -> FloatArray:
        """Evaluate the curve, scaled to 0 to 1.

        If all points outside of gaps are within [0, 1], values are not scaled. Otherwise the
        minimum becomes 0 and the maximum 1; a constant becomes 0. A curve with its own percentiles
        is always scaled by them, and clipped.

        Parameters
        ----------
        times : array_like
            Seconds, any shape.

        Returns
        -------
        float64
            Values of that shape, 0 to 1; 0 without a curve, as in `intensity_at`.

        Examples
        --------
        >>> curve = ov.Intensity(np.array([0.0, 10.0]), np.array([-5.0, 5.0]))
        >>> ov.Timeline("rising", 10.0, (), curve).normalised_intensity_at([5.0, 10.0])
        array([0.5, 1. ])
        """
        at = np.asarray(times, dtype=np.float64)
        flat = at.reshape(-1)
        low, span = self.scale
        if span == 0.0:
            return np.zeros(at.shape, dtype=np.float64)
        # clipped first, since division by a very small span could overflow
        scaled = np.clip(self._curve_at(flat) - low, 0.0, span) / span
        return np.where(self.has_data(flat), scaled, 0.0).reshape(at.shape)

    def normalised_levels(self, steps: int) -> FloatArray:
        """Evaluate the curve, scaled to 0 to 1, at evenly spaced times from start to end.

        This is for a surface: each time represents the points nearest to it. For few points, it is
        `normalised_intensity_at`; for many points, see `Intensity.along`.

        Parameters
        ----------
        steps : int
            Number of equal parts of the timeline.

        Returns
        -------
        float64 (steps + 1,)
            Values, 0 to 1; arbitrary inside a gap.

        Examples
        --------
        >>> match.normalised_levels(100).shape
        (101,)
        """
        at = np.arange(steps + 1, dtype=np.float64) * (self.duration_s / steps)
        low, span = self.scale
        curve = self.intensity
        if curve is None or span == 0.0:
            return np.zeros(steps + 1)
        levels = curve.along(at) - low
        np.clip(levels, 0.0, span, out=levels)
        levels /= span
        if not curve.is_constant:
            levels[: np.searchsorted(at, curve.first_s)] = 0.0
            levels[np.searchsorted(at, curve.last_s, side="right") :] = 0.0
        return levels

    def _curve_at(self, at: FloatArray) -> FloatArray:
        return np.zeros(at.shape) if self.intensity is None else self.intensity.at(at)

    def has_data(self, at: FloatArray) -> BoolArray:
        """Return whether the curve has data at each time.

        Parameters
        ----------
        at : float64 (n,)
            Seconds.

        Returns
        -------
        bool (n,)
            False before the first point, after the last one and inside gaps.

        Examples
        --------
        >>> match.has_data(np.array([-1.0, 60.0]))
        array([False,  True])
        """
        if self.intensity is None:
            return np.zeros(at.shape, dtype=np.bool_)
        first, last = self.intensity.first_s, self.intensity.last_s
        if self.intensity.is_constant:
            first, last = 0.0, self.duration_s
        covered = (at >= first) & (at <= last) & ~in_gap(self.gaps, at)
        return np.asarray(covered, dtype=np.bool_)

    def window(self, start_s: float, end_s: float) -> Timeline:
        """Return a window as a new timeline, which starts at 0.

        It includes events at both ends. It is filled up with ticks of calendar or clock, with
        events found by rules (for a series) and with details, by falling weight, up to the number
        that can be distinguished. So zooming in never reduces the number of events, unless all are
        shown. The curve has interpolated ends. A window without events and curve gets a constant
        curve of 0 and a note. The title is kept, and a note names the window.

        Parameters
        ----------
        start_s, end_s : float
            Seconds, 0 <= start_s < end_s <= duration_s.

        Returns
        -------
        Timeline
            The window.

        Raises
        ------
        InputError
            The window is empty or outside of the timeline.

        Examples
        --------
        >>> goal = match.event("goal", 1)
        >>> match.window(goal.time_s - 45.0, goal.time_s + 5.0).duration_s
        50.0
        """
        start, end = self.require_window(start_s, end_s)
        marks = tuple(event for event in self.events if event.kind == MARK)
        if marks and (len(marks) < len(self.events) or self.intensity is not None):
            # they take no room from other events
            window = with_marks(self, ()).window(start, end)
            return with_marks(window, cut_events(marks, start, end))
        own_events = cut_events(self._own_events, start, end)
        details = cut_events(self.details, start, end)
        first = bisect_left(self.details, start, key=lambda event: event.time_s)
        rank = self._ranks[first : first + len(details)]
        rules = self.rules.cut(start, end) if self.rules is not None else None
        moment = self.start + timedelta(seconds=start) if self.start is not None else None
        from_s = self._from_s + start
        events = window_events(
            own_events,
            window_ticks(moment, from_s, end - start, self._halves),
            rules.found(end - start) if rules is not None else (),
            [details[i] for i in np.argsort(rank)],
            end - start,
        )
        intensity = self.intensity.cut(start, end) if self.intensity is not None else None
        span = f"the window from {self.moment_text(start)} to {self.moment_text(end)}"
        notes = (*self.notes, span)
        if not own_events and not details and intensity is None:
            unit = self.intensity.unit if self.intensity is not None else ""
            intensity = Intensity(np.zeros(1), np.zeros(1), unit)
            notes = (*notes, "this window has no event and no curve")
        gaps, gap_reasons = cut_gaps(self.gaps, self.gap_reasons, start, end)
        until_s = self.known_until_s
        return _changed(
            self,
            duration_s=end - start,
            events=events,
            intensity=intensity,
            gaps=gaps,
            gap_reasons=gap_reasons,
            notes=notes,
            start=moment,
            details=details,
            rules=rules,
            signal=self.signal.cut(start, end) if self.signal is not None else None,
            known_until_s=None if until_s is None or until_s >= end else max(until_s - start, 0.0),
            _own_events=own_events,
            _ranks=rank,
            _from_s=from_s,
        )

    def moment_text(self, time_s: float) -> str:
        """Return a moment as text for display: a date with a calendar, else a clock.

        Parameters
        ----------
        time_s : float
            Seconds from the start.

        Returns
        -------
        str
            A date and time, or a clock.

        Examples
        --------
        >>> match.moment_text(754.0)
        '12:34.0'
        """
        if self.start is None:
            return clock_text(time_s)
        moment = self.start + timedelta(seconds=time_s)
        return moment.isoformat(sep=" ", timespec="seconds")

    def require_window(self, start_s: float, end_s: float) -> tuple[float, float]:
        """Validate the ends of a window.

        Parameters
        ----------
        start_s, end_s : float
            Seconds.

        Returns
        -------
        (float, float)
            Start and end.

        Raises
        ------
        InputError
            Not 0 <= start_s < end_s <= duration_s.

        Examples
        --------
        >>> match.require_window(0, 600)
        (0.0, 600.0)
        """
        hint = f"give 0 <= start < end <= {self.duration_s!r} seconds"
        start = validation.number(start_s, "window start", hint)
        end = validation.number(end_s, "window end", hint)
        if not 0.0 <= start < end <= self.duration_s:
            raise InputError(
                f"the window from {start!r} to {end!r} s is empty or outside the timeline; {hint}"
            )
        return start, end

    def to_dataframe(self, part: Literal["events", "curve"] = "events") -> DataFrame:
        """Return the events, or the curve, as a pandas DataFrame, one per row.

        Parameters
        ----------
        part : {"events", "curve"}
            Content of the table.

        Returns
        -------
        pandas.DataFrame
            Columns `time_s`, `kind`, `label`, `weight` and `side`; or `time_s` and `value`. With
            a calendar, also `moment`.

        Raises
        ------
        InputError
            Another `part`, or pandas isn't installed.

        Examples
        --------
        >>> list(match.to_dataframe())
        ['time_s', 'kind', 'label', 'weight', 'side']
        >>> len(match.to_dataframe("curve")) == match.intensity.count
        True
        """
        if part not in ("events", "curve"):
            raise InputError(f"part is {quoted(part)}; give 'events' or 'curve'")
        columns: dict[str, Any]
        if part == "events":
            columns = {name: [getattr(e, name) for e in self.events] for name in FIELDS}
        else:
            curve = self.intensity
            columns = {
                "time_s": np.asarray(curve.time_s) if curve is not None else np.empty(0),
                "value": np.asarray(curve.value) if curve is not None else np.empty(0),
            }
        frame = dataframe(columns)
        if self.start is not None:
            from pandas import Timestamp, to_timedelta

            moments = Timestamp(self.start) + to_timedelta(columns["time_s"], unit="s")
            frame.insert(1, "moment", moments)
        return frame

    def plot(self) -> Figure:
        """Draw the curve with its events and gaps.

        Returns
        -------
        matplotlib.figure.Figure
            Figure like the paper's figure 4.

        Examples
        --------
        >>> ov.load_timeline("world-cup-final-2018").plot().savefig("match.png")
        """
        return plot_with("offline.plots.timeline", "plot_timeline", self)

    def _repr_html_(self) -> str:
        """Return the display in a notebook: a summary and the curve."""
        return timeline_page(self, "" if self.start is None else self.moment_text(0.0))

    # --- values that a window takes from its whole timeline instead

    @cached_property
    def _own_events(self) -> tuple[Event, ...]:
        """Events of the whole timeline, without those added to a window."""
        return self.events

    @cached_property
    def _ranks(self) -> IntArray:
        """Ranks of the details for selection into windows."""
        return ranks(self.details)

    @cached_property
    def _from_s(self) -> float:
        """Beginning on the whole timeline, s."""
        return 0.0

    @cached_property
    def _halves(self) -> tuple[Half, ...]:
        """Halves of the whole timeline, if it is a match."""
        return halves_of(self.events)

    def __repr__(self) -> str:
        parts = [span_text(self.duration_s), counted(len(self.events), "event")]
        if self.intensity is not None:
            parts.append(f"a curve of {counted(self.intensity.count, 'point')}")
        if self.gaps:
            parts.append(counted(len(self.gaps), "gap"))
        return f"<Timeline {short(self.title)}: {', '.join(parts)}>"


def with_marks(timeline: Timeline, marks: Iterable[Event]) -> Timeline:
    """Return a timeline with other marks; a window keeps what it knows of its timeline.

    InputError for a mark after the end.
    """
    marks = tuple(marks)

    def marked(events: tuple[Event, ...]) -> tuple[Event, ...]:
        others = (event for event in events if event.kind != MARK)
        return sorted_events((*others, *marks), timeline.duration_s)

    own_events = marked(timeline._own_events)
    return _changed(timeline, events=marked(timeline.events), _own_events=own_events)


def _changed(timeline: Timeline, **changes: Any) -> Timeline:
    """Return a timeline with changes, without validating again; a window keeps its origin."""
    names = [*(one.name for one in fields(timeline)), "_ranks", "_from_s", "_halves"]
    changed = object.__new__(Timeline)
    changed.__dict__.update({name: getattr(timeline, name) for name in names} | changes)
    return changed
