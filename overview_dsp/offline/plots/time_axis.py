"""The time axis of a picture: a calendar's dates, a match's minutes, or plain time in its unit."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import timedelta
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overview_dsp.data.analysis.crowd_excitement import FOOTBALL_KINDS
from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.match_minutes import Half, halves_of
from overview_dsp.offline.plots.style import BLACK
from overview_dsp.signal.surface.angle_map import AngleMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_TICK_MIN = 15


def time_unit(duration_s: float) -> tuple[float, str]:
    """The seconds and the name of the unit that suits a duration."""
    for longest_s, scale, name in ((600.0, 1.0, "s"), (18_000.0, 60.0, "min"), (3e5, 3600.0, "h")):
        if duration_s <= longest_s:
            return scale, name
    return 86_400.0, "days"


class TimeAxis:
    """Where the times of a timeline lie in a picture: in `time_unit`, or as on a surface.

    Parameters
    ----------
    timeline
        Timeline that is drawn.
    angle_map
        Map of the surface that is drawn with it; None draws equal times equally wide.
    """

    def __init__(self, timeline: Timeline, angle_map: AngleMap | None = None) -> None:
        self._timeline = timeline
        self._map = None if angle_map is None or angle_map.is_linear else angle_map
        self.scale, self.unit = time_unit(timeline.duration_s)
        self.width = timeline.duration_s / self.scale

    def x(self, time_s: ArrayLike) -> NDArray[np.float64]:
        """Return where times lie."""
        if self._map is None:
            return np.asarray(time_s, dtype=np.float64) / self.scale
        return self._map.position_of(time_s) * self.width

    def event_x(self) -> NDArray[np.float64]:
        """Return where each event of the timeline lies."""
        if self._map is None:
            return self.x([event.time_s for event in self._timeline.events])
        return self._map.events * self.width

    def even_times(self, count: int) -> NDArray[np.float64]:
        """Return the times at evenly drawn places, both ends included."""
        places = np.linspace(0.0, 1.0, count)
        return (
            places * self._timeline.duration_s if self._map is None else self._map.time_at(places)
        )

    def label(self, axes: Axes) -> None:
        """Label the axis; where time is stretched, a bar lies on it and the label says why."""
        axes.set_xlim(0.0, self.width)
        self._label(axes)
        if self._map is None:
            return
        along = axes.get_xaxis_transform()
        for first, last in self._map.stretched():
            ends = first * self.width, last * self.width
            axes.plot(ends, (0.0, 0.0), transform=along, color=BLACK, linewidth=3.0,
                      solid_capstyle="butt", clip_on=False, zorder=5)  # fmt: skip
        axes.set_xlabel(f"{axes.get_xlabel()}; bold: stretched, so that close events lie apart")

    def _label(self, axes: Axes) -> None:
        timeline = self._timeline
        if timeline.start is not None:
            _label_dates(axes, timeline, self)
            return
        halves = halves_of(timeline.events)
        if halves:
            _label_minutes(axes, halves, self)
            return
        football = not FOOTBALL_KINDS.isdisjoint(timeline.kinds())
        axes.set_xlabel(f"time of play, {self.unit}" if football else f"time, {self.unit}")
        if self._map is not None:
            ticker: Any = import_module("matplotlib.ticker")  # it has no types
            ticks = ticker.MaxNLocator(9, steps=[1, 1.5, 2, 2.5, 3, 5, 10]).tick_values(
                0.0, self.width
            )
            shown = ticks[(ticks >= 0.0) & (ticks <= self.width)]
            axes.set_xticks(self.x(shown * self.scale), [f"{tick:g}" for tick in shown])


def _label_minutes(axes: Axes, halves: Sequence[Half], axis: TimeAxis) -> None:
    """Minutes as on the board: 90+4 is the end of a half with four minutes added."""
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


def _label_dates(axes: Axes, timeline: Timeline, axis: TimeAxis) -> None:
    dates: Any = import_module("matplotlib.dates")  # it has no types
    assert timeline.start is not None
    # the clock on the wall: a zone would be turned into UTC
    first = timeline.start.replace(tzinfo=None)
    locator = dates.AutoDateLocator(minticks=4, maxticks=9)
    days = np.asarray(locator.tick_values(first, first + timedelta(seconds=timeline.duration_s)))
    at_s = (days - dates.date2num(first)) * 86_400.0
    shown = (at_s >= 0.0) & (at_s <= timeline.duration_s)
    words = dates.ConciseDateFormatter(locator).format_ticks(days[shown])
    axes.set_xticks(axis.x(at_s[shown]), words)
    axes.set_xlabel(f"from {timeline.start.isoformat(' ', 'seconds')}")
