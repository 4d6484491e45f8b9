"""The time axis of a picture: a calendar's dates, a match's minutes, or plain time in its unit."""

from __future__ import annotations

import itertools
from datetime import timedelta
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from overview_dsp.readers.excitement import FOOTBALL_KINDS
from overview_dsp.timeline import Timeline

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HALVES = ((0, 45), (45, 90), (90, 105), (105, 120))
"""From and to which minute each half of a match goes, without added time."""

_TICK_MIN = 15
_SHORT_MIN = 2.0
"""A half as listed may be shorter than it should by so much."""


def time_unit(duration_s: float) -> tuple[float, str]:
    """The seconds and the name of the unit that suits a duration."""
    for longest_s, scale, name in ((600.0, 1.0, "s"), (18_000.0, 60.0, "min"), (3e5, 3600.0, "h")):
        if duration_s <= longest_s:
            return scale, name
    return 86_400.0, "days"


def label_time(axes: Axes, timeline: Timeline) -> None:
    """Label the time axis, whose numbers are in `time_unit`."""
    scale, unit = time_unit(timeline.duration_s)
    axes.set_xlim(0.0, timeline.duration_s / scale)
    if timeline.start is not None:
        _label_dates(axes, timeline, scale)
        return
    football = not FOOTBALL_KINDS.isdisjoint(timeline.kinds())
    halves = halves_of(timeline) if football else []
    if halves:
        _label_minutes(axes, halves, scale)
        return
    axes.set_xlabel(f"time of play, {unit}" if football else f"time, {unit}")


def halves_of(timeline: Timeline) -> list[tuple[float, float]]:
    """Where the halves of a whole match begin and end, s; none where its events don't say."""
    edges = sorted({event.time_s for event in timeline.events if event.kind == "period"})
    halves = list(itertools.pairwise(edges))
    if not 2 <= len(halves) <= len(HALVES) or edges[0] > 60.0:
        return []
    for (begin, end), (first, last) in zip(halves, HALVES, strict=False):
        if (end - begin) / 60.0 < last - first - _SHORT_MIN:
            return []
    return halves


def _label_minutes(axes: Axes, halves: list[tuple[float, float]], scale: float) -> None:
    """Minutes as on the board: 90+4 is the end of a half with four minutes added."""
    ticks: dict[float, str] = {}
    for (begin, end), (first, last) in zip(halves, HALVES, strict=False):
        for minute in range(first, last, _TICK_MIN):
            ticks.setdefault(begin + 60.0 * (minute - first), str(minute))
        nominal = begin + 60.0 * (last - first)
        added = round((end - nominal) / 60.0)
        ticks[end] = f"{last}+{added}" if added > 0 else str(last)
        if end > nominal:
            axes.axvspan(nominal / scale, end / scale, color="#f2ead2", linewidth=0.0, zorder=0)
    axes.set_xticks([at / scale for at in ticks], list(ticks.values()))
    axes.set_xlabel("match minute (shaded: added time)")


def _label_dates(axes: Axes, timeline: Timeline, scale: float) -> None:
    dates: Any = import_module("matplotlib.dates")  # it has no types
    assert timeline.start is not None
    # the clock on the wall: a zone would be turned into UTC
    first = timeline.start.replace(tzinfo=None)
    locator = dates.AutoDateLocator(minticks=4, maxticks=9)
    days = np.asarray(locator.tick_values(first, first + timedelta(seconds=timeline.duration_s)))
    at_s = (days - dates.date2num(first)) * 86_400.0
    shown = (at_s >= 0.0) & (at_s <= timeline.duration_s)
    words = dates.ConciseDateFormatter(locator).format_ticks(days[shown])
    axes.set_xticks(at_s[shown] / scale, words)
    axes.set_xlabel(f"from {timeline.start.isoformat(' ', 'seconds')}")
