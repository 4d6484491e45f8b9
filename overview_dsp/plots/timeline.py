"""The timeline as a picture: its curve, events and gaps (the paper's figure 4)."""

from __future__ import annotations

from datetime import timedelta
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from overview_dsp.plots.style import (
    BLACK,
    GAP_HATCH,
    GREY,
    LINES,
    new_figure,
    styles_of,
    tidy,
)
from overview_dsp.readers.excitement import FOOTBALL_KINDS
from overview_dsp.timeline import Timeline
from overview_dsp.timeline.gaps import in_gap

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def plot_timeline(timeline: Timeline) -> Figure:
    """The intensity curve with its events, as in the paper's figure 4; gaps are hatched."""
    figure = new_figure(9.0, 3.6)
    axes = figure.subplots()
    draw_timeline(axes, timeline)
    figure.subplots_adjust(left=0.07, right=0.785, top=0.92, bottom=0.14)
    axes.set_title(timeline.title, loc="left", fontsize=10)
    if timeline.events or timeline.gaps:
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=8)
    return figure


def draw_timeline(axes: Axes, timeline: Timeline, like: Timeline | None = None) -> None:
    """The intensity curve with its events and gaps into axes of any figure.

    Kinds have the markers they have in a picture of `like`, which must have them all.
    """
    scale, unit = _time_unit(timeline.duration_s)
    times = np.linspace(0.0, timeline.duration_s, 4001)
    curve = timeline.normalised_levels(4000)
    curve[in_gap(timeline.gaps, times)] = np.nan  # no line over a gap
    for i, (start, end) in enumerate(timeline.gaps):
        axes.axvspan(
            start / scale,
            end / scale,
            facecolor="none",
            edgecolor="#b0b0b0",
            hatch=GAP_HATCH,
            linewidth=0.0,
            label=f"no data ({len(timeline.gaps)})" if i == 0 else None,
            zorder=1,
        )
    axes.fill_between(times / scale, curve, color="#e8eef4", zorder=1)
    axes.plot(times / scale, curve, color=GREY, linewidth=1.2, zorder=2)
    for kind, (marker, colour, words) in styles_of(like or timeline).items():
        at = np.array([event.time_s for event in timeline.events if event.kind == kind])
        if not len(at):
            continue
        height = timeline.normalised_intensity_at(at)
        goal = kind in ("goal", "own_goal")
        axes.scatter(
            at / scale,
            height,
            s=90 if goal else 46,
            marker=marker,
            color=colour,
            edgecolors=None if marker in LINES else BLACK,
            linewidths=1.6 if marker in LINES else 0.7,
            label=f"{words} ({len(at)})",
            zorder=4 if goal else 3,
        )
    for event in timeline.events:
        if event.kind in ("goal", "own_goal") and event.label:
            axes.annotate(
                event.label.split(" ")[0],
                (
                    event.time_s / scale,
                    float(timeline.normalised_intensity_at(np.array([event.time_s]))[0]),
                ),
                xytext=(0, 8),
                textcoords="offset points",
                ha="center",
                fontsize=8,
            )
    axes.set_xlim(0.0, timeline.duration_s / scale)
    axes.set_ylim(0.0, 1.18)
    _label_time(axes, timeline, scale, unit)
    axes.set_ylabel("intensity")
    tidy(axes)


def _time_unit(duration_s: float) -> tuple[float, str]:
    """The seconds and the name of the unit that suits a duration."""
    for longest_s, scale, name in ((600.0, 1.0, "s"), (18_000.0, 60.0, "min"), (3e5, 3600.0, "h")):
        if duration_s <= longest_s:
            return scale, name
    return 86_400.0, "days"


def _label_time(axes: Axes, timeline: Timeline, scale: float, unit: str) -> None:
    """Label the time axis: dates where the timeline has a calendar, else its unit."""
    start = timeline.start
    if start is None:
        football = not FOOTBALL_KINDS.isdisjoint(timeline.kinds())
        axes.set_xlabel(f"time of play, {unit}" if football else f"time, {unit}")
        return
    dates: Any = import_module("matplotlib.dates")  # it has no types
    # the clock on the wall: a zone would be turned into UTC
    first = start.replace(tzinfo=None)
    locator = dates.AutoDateLocator(minticks=4, maxticks=9)
    days = np.asarray(locator.tick_values(first, first + timedelta(seconds=timeline.duration_s)))
    at_s = (days - dates.date2num(first)) * 86_400.0
    shown = (at_s >= 0.0) & (at_s <= timeline.duration_s)
    words = dates.ConciseDateFormatter(locator).format_ticks(days[shown])
    axes.set_xticks(at_s[shown] / scale, words)
    axes.set_xlabel(f"from {start.isoformat(' ', 'seconds')}")
