"""The one Timeline every reader produces: events, an intensity curve, gaps, and where they're from.

All values are checked on construction, so that whoever holds a `Timeline` need not check again.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from datetime import timedelta
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.data.timeline.curve_lookup import CurveLookup
from overview_dsp.data.timeline.dataframe import dataframe, moments
from overview_dsp.data.timeline.event import Event, cut_events
from overview_dsp.data.timeline.fine_events import ranks, window_events
from overview_dsp.data.timeline.gaps import cut_gaps, cut_until
from overview_dsp.data.timeline.intensity import Intensity
from overview_dsp.data.timeline.match_minutes import Half, halves_of
from overview_dsp.data.timeline.page import timeline_page
from overview_dsp.data.timeline.ticks import part_ticks
from overview_dsp.errors import InputError, shown
from overview_dsp.public import counted, drawn, short
from overview_dsp.units import clock_text, span_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

__all__ = ["Event", "Intensity", "Timeline"]


@dataclass(frozen=True)
class Timeline(CurveLookup):
    """What happened, in order, and how intense it was. All values are checked on construction.

    Parameters
    ----------
    title : str
        Words for a person.
    duration_s : float
        Length in seconds, finite, > 0. Every time lies in [0, duration_s].
    events : tuple of Event
        In any order; kept sorted by time, those of equal time in the order given. Two events of
        the same time, kind and label are an error; a foul and its card at one time are not.
    intensity : Intensity or None
        The curve. Either events or an intensity must be there.
    gaps : tuple of (float, float)
        Spans (start_s, end_s) without data, start < end, not overlapping; kept sorted. Inside a
        gap the curve counts as missing, points that lie in it too.
    provenance : str
        Where the data are from and what was derived from what.
    notes : tuple of str
        What a person should know about them (warnings of the reader).
    start : datetime or None
        The calendar moment of time 0, with or without a time zone; None where there is none (a
        match clock).
    details : tuple of Event
        Smaller things (a match's passes); kept sorted. They are felt in a `window`, the weightiest
        first, as many as a hand can tell apart.
    gap_reasons : tuple of str
        Why there are no data, a text for each of the gaps, `""` where it isn't known; empty where
        none is.
    rules : object or None
        What finds the events of a part of a series (set by the readers of series).
    signal : Intensity or None
        The recording that the curve was found in (an ECG, where the curve is a heart's rate): drawn
        below it, not felt, and not in files.
    until_s : float or None
        Up to where it has happened, of one that is still growing; the rest is the future, which
        has a surface of its own. None where all has happened.

    Raises
    ------
    InputError
        A broken invariant, in one line that names it.

    See Also
    --------
    load_timeline : Reads one from a file.

    Examples
    --------
    >>> import numpy as np
    >>> import overview_dsp as ov
    >>> curve = ov.Intensity(np.array([0.0, 60.0]), np.array([0.2, 0.9]))
    >>> timeline = ov.Timeline("a minute", 60.0, (ov.Event(12.0, "goal"),), curve)
    >>> timeline.kinds()
    {'goal': 1}
    """

    def window(self, start_s: float, end_s: float) -> Timeline:
        """Cut out a part as a timeline of its own, which starts at 0.

        Events at the two ends belong to it. It carries ticks of the calendar or the clock, and is
        filled up with what rules find in it (a series' turning points, moves and crossings) and
        with details, the weightiest first, up to what a hand can tell apart: as one zooms about an
        event, the number of events doesn't fall until the data has no more. The curve is cut with
        interpolated end points, so it has the same value at the same moment; gaps are cut likewise.
        A part in
        which nothing is known (no event, no curve) becomes a flat curve of 0 with a note, since its
        emptiness is what a hand should feel. The title stays; a note names the part.

        Parameters
        ----------
        start_s, end_s : float
            Seconds, 0 <= start_s < end_s <= duration_s.

        Returns
        -------
        Timeline
            The part.

        Raises
        ------
        InputError
            A window that is empty or outside the timeline.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match = ov.load_timeline("world-cup-final-2018")
        >>> goal = match.event("goal", 1)
        >>> match.window(goal.time_s - 45.0, goal.time_s + 5.0).duration_s
        50.0
        """
        start, end = self.require_window(start_s, end_s)
        given = cut_events(self._given, start, end)
        details = cut_events(self.details, start, end)
        first = bisect_left(self.details, start, key=lambda event: event.time_s)
        rank = self._ranks[first : first + len(details)]
        rules = self.rules.cut(start, end) if self.rules is not None else None
        moment = self.start + timedelta(seconds=start) if self.start is not None else None
        from_s = self._from_s + start
        events = window_events(
            given,
            part_ticks(moment, from_s, end - start, self._halves),
            rules.found(end - start) if rules is not None else (),
            [details[i] for i in np.argsort(rank)],
            end - start,
        )
        intensity = self.intensity.cut(start, end) if self.intensity is not None else None
        notes = (*self.notes, f"the part from {self.moment_text(start)} to {self.moment_text(end)}")
        if not given and not details and intensity is None:
            unit = self.intensity.unit if self.intensity is not None else ""
            intensity = Intensity(np.zeros(1), np.zeros(1), unit)
            notes = (*notes, "nothing happens in this part: no event, no curve")
        gaps, gap_reasons = cut_gaps(self.gaps, self.gap_reasons, start, end)
        part = object.__new__(Timeline)  # a part of what was checked
        part.__dict__.update(
            title=self.title,
            duration_s=end - start,
            events=events,
            intensity=intensity,
            gaps=gaps,
            gap_reasons=gap_reasons,
            provenance=self.provenance,
            notes=notes,
            start=moment,
            details=details,
            rules=rules,
            signal=self.signal.cut(start, end) if self.signal is not None else None,
            until_s=cut_until(self.until_s, start, end),
            _given=given,
            _ranks=rank,
            _from_s=from_s,
            _halves=self._halves,
        )
        return part

    def moment_text(self, time_s: float) -> str:
        """Write a moment for a person: its date where there is a calendar, else a clock.

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
        >>> import overview_dsp as ov
        >>> match = ov.load_timeline("world-cup-final-2018")
        >>> match.moment_text(754.0)
        '12:34.0'
        """
        if self.start is None:
            return clock_text(time_s)
        moment = self.start + timedelta(seconds=time_s)
        return moment.isoformat(sep=" ", timespec="seconds")

    def require_window(self, start_s: float, end_s: float) -> tuple[float, float]:
        """Check a window's ends.

        Parameters
        ----------
        start_s, end_s : float
            Seconds.

        Returns
        -------
        (float, float)
            The same.

        Raises
        ------
        InputError
            Not 0 <= start_s < end_s <= duration_s.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match = ov.load_timeline("world-cup-final-2018")
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
        """Give the events, or the curve, as a pandas DataFrame, a row each.

        Parameters
        ----------
        part : {"events", "curve"}
            Which of the two.

        Returns
        -------
        pandas.DataFrame
            Columns `time_s`, `kind`, `label` and `weight`; or `time_s` and `value`. Where the
            timeline has a calendar, `moment` too.

        Raises
        ------
        InputError
            Another part, or pandas isn't installed.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match = ov.load_timeline("world-cup-final-2018")
        >>> list(match.to_dataframe())
        ['time_s', 'kind', 'label', 'weight']
        >>> len(match.to_dataframe("curve")) == match.intensity.count
        True
        """
        if part not in ("events", "curve"):
            raise InputError(f"part is {shown(part)}; give 'events' or 'curve'")
        columns: dict[str, Any]
        if part == "events":
            names = ("time_s", "kind", "label", "weight")
            columns = {name: [getattr(e, name) for e in self.events] for name in names}
        else:
            curve = self.intensity
            columns = {
                "time_s": np.asarray(curve.time_s) if curve is not None else np.empty(0),
                "value": np.asarray(curve.value) if curve is not None else np.empty(0),
            }
        frame = dataframe(columns)
        if self.start is not None:
            frame.insert(1, "moment", moments(self.start, columns["time_s"]))
        return frame

    def plot(self) -> Figure:
        """Draw the curve with its events and gaps.

        Returns
        -------
        matplotlib.figure.Figure
            As in the paper's figure 4; a notebook shows it.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> ov.load_timeline("world-cup-final-2018").plot().savefig("match.png")
        """
        return drawn("offline.plots.timeline", "plot_timeline", self)

    def _repr_html_(self) -> str:
        """What a notebook shows: a few words, and the curve."""
        begin = "" if self.start is None else self.moment_text(0.0)
        return timeline_page(self, begin)

    # --- what a part carries, in place of these, from the whole it was cut from

    @cached_property
    def _given(self) -> tuple[Event, ...]:
        """The events of the whole, without those that a window found."""
        return self.events

    @cached_property
    def _ranks(self) -> NDArray[np.int64]:
        """In which order the details are taken into a window."""
        return ranks(self.details)

    @cached_property
    def _from_s(self) -> float:
        """Where on the whole this begins, s."""
        return 0.0

    @cached_property
    def _halves(self) -> tuple[Half, ...]:
        """Those of the whole, where it is a match."""
        return halves_of(self.events)

    def __repr__(self) -> str:
        parts = [span_text(self.duration_s), counted(len(self.events), "event")]
        if self.intensity is not None:
            parts.append(f"a curve of {counted(self.intensity.count, 'point')}")
        if self.gaps:
            parts.append(counted(len(self.gaps), "gap"))
        return f"<Timeline {short(self.title)}: {', '.join(parts)}>"
