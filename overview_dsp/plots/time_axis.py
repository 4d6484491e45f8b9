"""The time axis of a picture: a calendar's dates, a match's minutes, or plain time in its unit."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import timedelta
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from overview_dsp.analysis.crowd_excitement import FOOTBALL_KINDS
from overview_dsp.timeline import Timeline
from overview_dsp.timeline.match_minutes import Half, halves_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_TICK_MIN = 15


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
    halves = halves_of(timeline.events)
    if halves:
        _label_minutes(axes, halves, scale)
        return
    football = not FOOTBALL_KINDS.isdisjoint(timeline.kinds())
    axes.set_xlabel(f"time of play, {unit}" if football else f"time, {unit}")


def _label_minutes(axes: Axes, halves: Sequence[Half], scale: float) -> None:
    """Minutes as on the board: 90+4 is the end of a half with four minutes added."""
    ticks: dict[float, str] = {}
    for half in halves:
        for minute in range(half.first, half.last, _TICK_MIN):
            ticks.setdefault(half.begin_s + 60.0 * (minute - half.first), str(minute))
        added = max(0, round((half.end_s - half.nominal_s) / 60.0))
        ticks[half.end_s] = half.minute_text(half.last - half.first + added)
        if half.end_s > half.nominal_s:
            begin, end = half.nominal_s / scale, half.end_s / scale
            axes.axvspan(begin, end, color="#f2ead2", linewidth=0.0, zorder=0)
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
