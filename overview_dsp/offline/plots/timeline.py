"""Plot of a timeline: data in their unit, events and gaps (the paper's figure 4).

The time axis of a picture: a calendar's dates, a match's minutes, or plain time in its unit.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from datetime import datetime, timedelta
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from overview_dsp.arrays import FloatArray
from overview_dsp.data.analysis.crowd_excitement import FOOTBALL_KINDS
from overview_dsp.data.timeline import Intensity, Timeline
from overview_dsp.data.timeline.gaps import in_gap
from overview_dsp.data.timeline.ticks import Half, halves_of
from overview_dsp.offline.plots import style
from overview_dsp.signal.surface.angle_map import AngleMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_TICK_MIN = 15


def time_unit(duration_s: float) -> tuple[float, str]:
    """Return length (s) and name of the unit that suits a duration."""
    for longest_s, scale, name in ((600.0, 1.0, "s"), (18_000.0, 60.0, "min"), (3e5, 3600.0, "h")):
        if duration_s <= longest_s:
            return scale, name
    return 86_400.0, "days"


class TimeAxis:
    """Time axis of a plot: in `time_unit`, or with the angle map of a surface.

    `timeline` is drawn; without `angle_map` equal times are equally wide.
    """

    def __init__(self, timeline: Timeline, angle_map: AngleMap | None = None) -> None:
        self.timeline = timeline
        self._map = None if angle_map is None or angle_map.is_linear else angle_map
        self.scale, self.unit = time_unit(timeline.duration_s)
        self.width = timeline.duration_s / self.scale

    def x(self, time_s: ArrayLike) -> FloatArray:
        """Return the coordinates of times."""
        if self._map is None:
            return np.asarray(time_s, dtype=np.float64) / self.scale
        return self._map.position_of(time_s) * self.width

    def event_x(self) -> FloatArray:
        """Return the coordinates of the timeline's events."""
        if self._map is None:
            return self.x([event.time_s for event in self.timeline.events])
        return self._map.events * self.width

    def even_times(self, count: int) -> FloatArray:
        """Return the times at evenly spaced coordinates, including both ends."""
        places = np.linspace(0.0, 1.0, count)
        return places * self.timeline.duration_s if self._map is None else self._map.time_at(places)

    def label(self, axes: Axes) -> None:
        """Label the axis, and mark stretched parts with a bar and a note."""
        axes.set_xlim(0.0, self.width)
        self._label(axes)
        if self._map is None:
            return
        along = axes.get_xaxis_transform()
        for first, last in self._map.stretched():
            ends = first * self.width, last * self.width
            axes.plot(ends, (0.0, 0.0), transform=along, color=style.BLACK, linewidth=3.0,
                      solid_capstyle="butt", clip_on=False, zorder=5)  # fmt: skip
        axes.set_xlabel(f"{axes.get_xlabel()}; bold: stretched, so that close events lie apart")

    def _label(self, axes: Axes) -> None:
        if self.timeline.start is not None:
            _label_dates(axes, self.timeline.start, self)
            return
        halves = halves_of(self.timeline.events)
        if halves:
            _label_minutes(axes, halves, self)
            return
        football = not FOOTBALL_KINDS.isdisjoint(self.timeline.kinds())
        axes.set_xlabel(f"time of play, {self.unit}" if football else f"time, {self.unit}")
        if self._map is not None:
            ticker: Any = import_module("matplotlib.ticker")  # without types
            ticks = ticker.MaxNLocator(9, steps=[1, 1.5, 2, 2.5, 3, 5, 10]).tick_values(
                0.0, self.width
            )
            shown = ticks[(ticks >= 0.0) & (ticks <= self.width)]
            axes.set_xticks(self.x(shown * self.scale), [f"{tick:g}" for tick in shown])


def _label_minutes(axes: Axes, halves: Sequence[Half], axis: TimeAxis) -> None:
    """Return minutes of a match: 90+4 is the end of a half with four minutes added."""
    ticks: dict[float, str] = {}
    for half in halves:
        for minute in range(half.first, half.last, _TICK_MIN):
            ticks.setdefault(half.begin_s + 60.0 * (minute - half.first), str(minute))
        added = max(0, round((half.end_s - half.nominal_s) / 60.0))
        ticks[half.end_s] = half.minute_text(half.last - half.first + added)
        if half.end_s > half.nominal_s:
            begin, end = axis.x([half.nominal_s, half.end_s])
            axes.axvspan(begin, end, color="#f2ead2", linewidth=0.0, zorder=0)
    axes.set_xticks(axis.x(list(ticks)), list(ticks.values()))
    axes.set_xlabel("match minute (shaded: added time)")


def _label_dates(axes: Axes, start: datetime, axis: TimeAxis) -> None:
    dates: Any = import_module("matplotlib.dates")  # without types
    duration_s = axis.timeline.duration_s
    # local time without a zone, which matplotlib would convert to UTC
    first = start.replace(tzinfo=None)
    locator = dates.AutoDateLocator(minticks=4, maxticks=9)
    days = np.asarray(locator.tick_values(first, first + timedelta(seconds=duration_s)))
    at_s = (days - dates.date2num(first)) * 86_400.0
    shown = (at_s >= 0.0) & (at_s <= duration_s)
    words = dates.ConciseDateFormatter(locator).format_ticks(days[shown])
    axes.set_xticks(axis.x(at_s[shown]), words)
    axes.set_xlabel(f"from {start.isoformat(' ', 'seconds')}")


_STEPS = 600  # number of positions along a curve, about one per pixel
_CROWDED = 60  # number of events from which on a kind's markers are small
_TEAM_ROW = 0.13  # height of the row of a team relative to the height of the curve
_NAMED_GAP = 0.08  # width of a gap relative to the plot from which on its reason is written into it


def plot_timeline(timeline: Timeline, angle_map: AngleMap | None = None) -> Figure:
    """Plot the data with their events, as in the paper's figure 4; gaps are hatched.

    A recording that the curve was found in (an ECG) is drawn below it. With the map of a surface
    all lies where it is felt.
    """
    axis = TimeAxis(timeline, angle_map)
    signal = timeline.signal
    figure = style.new_figure(9.0, 3.6 if signal is None else 5.2)
    heights = (1,) if signal is None else (2, 1)
    grid: Any = figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights)
    axes = grid[0, 0]
    draw_timeline(axes, timeline, angle_map)
    if signal is not None:
        below = grid[1, 0]
        _draw_gaps(below, axis)
        _draw_curve(below, axis, signal, style.BLACK, band=0.8)
        below.set_ylabel(signal.unit or "signal")
        axis.label(below)
        axes.set_xlabel("")
        axes.tick_params(labelbottom=False)
        style.tidy(below)
    figure.subplots_adjust(
        left=0.085, right=0.7, top=0.92, bottom=0.14 if signal is None else 0.1, hspace=0.12
    )
    axes.set_title(timeline.title, loc="left", fontsize=10)
    if timeline.events or timeline.gaps:
        axes.legend(loc="upper left", bbox_to_anchor=(1.11, 1.04), frameon=False, fontsize=8)
    return figure


def draw_timeline(axes: Axes, timeline: Timeline, angle_map: AngleMap | None = None) -> None:
    """Plot the curve with its events and gaps into axes of a figure.

    The left axis has the data's own unit; on the right is the intensity that is felt of them.
    """
    axis = TimeAxis(timeline, angle_map)
    _draw_gaps(axes, axis)
    if timeline.intensity is not None:
        _draw_curve(axes, axis, timeline.intensity, style.GREY)
        _label_values(axes, timeline, timeline.intensity)
    _draw_events(axes, timeline, axis)
    axis.label(axes)
    style.tidy(axes)


def _draw_gaps(axes: Axes, axis: TimeAxis) -> None:
    """Hatch the gaps, with their reasons in the legend and in wide gaps."""
    timeline = axis.timeline
    reasons = timeline.gap_reasons or ("",) * len(timeline.gaps)
    named: set[str] = set()
    for gap, reason in zip(timeline.gaps, reasons, strict=True):
        start, end = axis.x(gap).tolist()
        words = f"no data: {reason}" if reason else "no data"
        label = None if reason in named else f"{words} ({reasons.count(reason)})"
        axes.axvspan(start, end, label=label, zorder=1, **style.GAP_STYLE)
        named.add(reason)
        if end - start >= _NAMED_GAP * axis.width:
            axes.text(
                (start + end) / 2.0,
                0.5,
                words.replace(": ", ":\n"),
                transform=axes.get_xaxis_transform(),
                ha="center",
                va="center",
                fontsize=7,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5},
                zorder=2,
            )


def _draw_curve(
    axes: Axes, axis: TimeAxis, curve: Intensity, colour: str, band: float = 0.3
) -> None:
    """Plot a line through few points, or the mean and range of many points."""
    if curve.is_constant:
        axes.axhline(float(curve.value[0]), color=colour, linewidth=1.2, zorder=2)
        return
    if curve.count <= 2 * _STEPS:
        times = np.asarray(curve.time_s)
        places, values = _broken(times, np.asarray(curve.value), axis)
        axes.plot(places, values, color=colour, linewidth=1.2, zorder=2)
        return
    times = axis.even_times(_STEPS)
    low, mean, high = curve.band(times, axis.timeline.gaps)
    axes.fill_between(
        axis.x(times), low, high, color=colour, alpha=band, linewidth=0.0, zorder=2, step="mid"
    )
    axes.plot(axis.x(times), mean, color=colour, linewidth=1.0, zorder=2)


def _broken(times: FloatArray, values: FloatArray, axis: TimeAxis) -> tuple[FloatArray, FloatArray]:
    """Return the points outside gaps, with the line interrupted at each gap."""
    gaps = axis.timeline.gaps
    known = ~in_gap(gaps, times)
    middles = np.array([(start + end) / 2.0 for start, end in gaps])
    every = np.concatenate((times[known], middles))
    order = np.argsort(every, kind="stable")
    levels = np.concatenate((values[known], np.full(len(middles), np.nan)))
    return axis.x(every[order]), levels[order]


def _label_values(axes: Axes, timeline: Timeline, curve: Intensity) -> None:
    """Label the data's unit on the left and the intensity, 0 to 1, on the right."""
    low, span = timeline.scale
    axes.set_ylabel(curve.unit or "value")
    if (low, span) == (0.0, 1.0):
        axes.set_ylim(0.0, 1.18)
        axes.set_ylabel("intensity")
        return
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.08 * (top - bottom))
    if span > 0.0:

        def intensity(value: Any) -> Any:
            return (np.asarray(value) - low) / span

        def in_unit(level: Any) -> Any:
            return low + np.asarray(level) * span

        felt = axes.secondary_yaxis("right", functions=(intensity, in_unit))
        felt.set_yticks([0.0, 0.5, 1.0])
        felt.set_ylabel("intensity")


def _draw_events(axes: Axes, timeline: Timeline, axis: TimeAxis) -> None:
    """Plot the events of each kind on the curve, or without a curve in one row per kind.

    Above the curve, the events of each of two teams have a row.
    """
    places = axis.event_x()
    bottom, _ = axes.get_ylim()
    styles = style.styles_of(timeline)
    rows = timeline.intensity is None
    teams = {} if rows else _team_rows(axes, timeline)
    for row, (kind, mark) in enumerate(styles.items()):
        events = [event for event in timeline.events if event.kind == kind]
        at = np.array([event.time_s for event in events])
        x = places[[event.kind == kind for event in timeline.events]]
        height = np.full(len(at), float(row)) if rows else _heights(timeline, at, bottom)
        height = np.array([teams.get(one.side, h) for one, h in zip(events, height, strict=True)])
        goal = kind in ("goal", "own_goal")
        options: dict[str, Any] = {"label": f"{mark[2]} ({len(at)})", "zorder": 4 if goal else 3}
        if style.has_face(mark[0]) and len(at) >= _CROWDED:
            options["linewidths"] = 0.3
        size = 90 if goal else 46 if len(at) < _CROWDED else 14
        style.mark_events(axes, x, height, mark, size, **options)
        if goal:
            for event, place, level in zip(events, x.tolist(), height.tolist(), strict=True):
                if score := event.label.split(" ")[0]:
                    axes.annotate(
                        score, (place, level), xytext=(0, 8), textcoords="offset points",
                        ha="center", fontsize=8,
                    )  # fmt: skip
    if rows and styles:
        axes.set_yticks(range(len(styles)), [words for _, _, words in styles.values()], fontsize=8)
        axes.set_ylim(-0.7, len(styles) - 0.3)


def _team_rows(axes: Axes, timeline: Timeline) -> dict[int, float]:
    """Make room for a row of each team above the curve; return the heights of both by side."""
    if not any(event.side for event in timeline.events):
        return {}
    bottom, top = axes.get_ylim()
    step = _TEAM_ROW * (top - bottom)
    axes.set_yticks([tick for tick in axes.get_yticks() if bottom <= tick <= top])
    axes.set_ylim(bottom, top + 2.3 * step)
    rows = {1: top + 1.4 * step, 2: top + 0.4 * step}
    for height, name in zip(rows.values(), timeline.sides or ("team 1", "team 2"), strict=True):
        axes.axhline(height, color=style.GREY, linewidth=0.5, zorder=1)
        axes.annotate(textwrap.fill(name, 14), (0.0, height), (-5, 0),
                      axes.get_yaxis_transform(), "offset points", ha="right", va="center",
                      fontsize=7)  # fmt: skip
    return rows


def _heights(timeline: Timeline, at: FloatArray, bottom: float) -> FloatArray:
    """Return the height of events on the curve; 0 without a curve."""
    curve = timeline.intensity
    assert curve is not None
    lost = in_gap(timeline.gaps, at)
    if not curve.is_constant:
        lost |= (at < curve.first_s) | (at > curve.last_s)
    return np.where(lost, bottom, curve.at(at))
