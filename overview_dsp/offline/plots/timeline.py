"""The timeline as a picture: its data in their unit, events and gaps (the paper's figure 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline import Intensity, Timeline
from overview_dsp.data.timeline.gaps import in_gap
from overview_dsp.offline.plots.style import (
    BLACK,
    GAP_HATCH,
    GREY,
    has_face,
    new_figure,
    styles_of,
    tidy,
)
from overview_dsp.offline.plots.time_axis import TimeAxis
from overview_dsp.signal.surface.angle_map import AngleMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STEPS = 600
"""Positions along a picture, one for each pixel of its curve."""

_CROWDED = 60
"""From so many events on, a kind's marks are small."""

_NAMED_GAP = 0.08
"""A gap of this part of the picture's width has its reason written in it."""


def plot_timeline(timeline: Timeline, angle_map: AngleMap | None = None) -> Figure:
    """The data with their events, as in the paper's figure 4; gaps are hatched.

    A recording that the curve was found in (an ECG) is drawn below it. With the map of a surface
    all lies where it is felt.
    """
    axis = TimeAxis(timeline, angle_map)
    signal = timeline.signal
    figure = new_figure(9.0, 3.6 if signal is None else 5.2)
    heights = (1,) if signal is None else (2, 1)
    grid: Any = figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights)
    axes = grid[0, 0]
    draw_timeline(axes, timeline, angle_map)
    if signal is not None:
        below = grid[1, 0]
        _draw_gaps(below, timeline, axis)
        _draw_curve(below, timeline, signal, axis, BLACK, band=0.8)
        below.set_ylabel(signal.unit or "signal")
        axis.label(below)
        axes.set_xlabel("")
        axes.tick_params(labelbottom=False)
        tidy(below)
    figure.subplots_adjust(
        left=0.085, right=0.7, top=0.92, bottom=0.14 if signal is None else 0.1, hspace=0.12
    )
    axes.set_title(timeline.title, loc="left", fontsize=10)
    if timeline.events or timeline.gaps:
        axes.legend(loc="upper left", bbox_to_anchor=(1.11, 1.04), frameon=False, fontsize=8)
    return figure


def draw_timeline(axes: Axes, timeline: Timeline, angle_map: AngleMap | None = None) -> None:
    """The curve with its events and gaps into axes of any figure.

    The left axis has the data's own unit; on the right is the intensity that is felt of them.
    """
    axis = TimeAxis(timeline, angle_map)
    _draw_gaps(axes, timeline, axis)
    if timeline.intensity is not None:
        _draw_curve(axes, timeline, timeline.intensity, axis, GREY)
        _label_values(axes, timeline, timeline.intensity)
    _draw_events(axes, timeline, axis)
    axis.label(axes)
    tidy(axes)


def _draw_gaps(axes: Axes, timeline: Timeline, axis: TimeAxis) -> None:
    """Gaps hatched, each reason once in the legend; in a wide gap it is written too."""
    reasons: tuple[str, ...] = getattr(timeline, "gap_reasons", ())
    reasons = reasons or ("",) * len(timeline.gaps)
    named: set[str] = set()
    for gap, reason in zip(timeline.gaps, reasons, strict=True):
        start, end = axis.x(gap).tolist()
        words = f"no data: {reason}" if reason else "no data"
        axes.axvspan(
            start,
            end,
            facecolor="none",
            edgecolor="#b0b0b0",
            hatch=GAP_HATCH,
            linewidth=0.0,
            label=None if reason in named else f"{words} ({reasons.count(reason)})",
            zorder=1,
        )
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
    axes: Axes,
    timeline: Timeline,
    curve: Intensity,
    axis: TimeAxis,
    colour: str,
    band: float = 0.3,
) -> None:
    """A line where there are few points, else their mean in the band from lowest to highest."""
    if curve.is_constant:
        axes.axhline(float(curve.value[0]), color=colour, linewidth=1.2, zorder=2)
        return
    if curve.count <= 2 * _STEPS:
        times = np.asarray(curve.time_s)
        axes.plot(*_broken(times, np.asarray(curve.value), timeline, axis), color=colour,
                  linewidth=1.2, zorder=2)  # fmt: skip
        return
    times = axis.even_times(_STEPS)
    low, mean, high = curve.band(times)
    gone = in_gap(timeline.gaps, times)
    for row in (low, mean, high):
        row[gone] = np.nan  # no line over a gap
    axes.fill_between(
        axis.x(times), low, high, color=colour, alpha=band, linewidth=0.0, zorder=2, step="mid"
    )
    axes.plot(axis.x(times), mean, color=colour, linewidth=1.0, zorder=2)


def _broken(
    times: NDArray[np.float64], values: NDArray[np.float64], timeline: Timeline, axis: TimeAxis
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The points without those in gaps, the line broken at each gap."""
    known = ~in_gap(timeline.gaps, times)
    middles = np.array([(start + end) / 2.0 for start, end in timeline.gaps])
    every = np.concatenate((times[known], middles))
    order = np.argsort(every, kind="stable")
    levels = np.concatenate((values[known], np.full(len(middles), np.nan)))
    return axis.x(every[order]), levels[order]


def _label_values(axes: Axes, timeline: Timeline, curve: Intensity) -> None:
    """The data's unit on the left; what is felt of it, 0 to 1, on the right."""
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
    """One symbol a kind: on the curve, or without one a row a kind."""
    places = axis.event_x()
    bottom, _ = axes.get_ylim()
    styles = styles_of(timeline)
    rows = timeline.intensity is None
    for row, (kind, (marker, colour, words)) in enumerate(styles.items()):
        events = [event for event in timeline.events if event.kind == kind]
        at = np.array([event.time_s for event in events])
        x = places[[event.kind == kind for event in timeline.events]]
        height = np.full(len(at), float(row)) if rows else _heights(timeline, at, bottom)
        goal = kind in ("goal", "own_goal")
        face = has_face(marker)
        axes.scatter(
            x,
            height,
            s=90 if goal else 46 if len(at) < _CROWDED else 14,
            marker=marker,
            color=colour,
            edgecolors=BLACK if face else None,
            linewidths=1.6 if not face else 0.7 if len(at) < _CROWDED else 0.3,
            label=f"{words} ({len(at)})",
            zorder=4 if goal else 3,
        )
        if goal:
            for event, place, level in zip(events, x.tolist(), height.tolist(), strict=True):
                _name_goal(axes, event.label.split(" ")[0], place, level)
    if rows and styles:
        axes.set_yticks(range(len(styles)), [words for _, _, words in styles.values()], fontsize=8)
        axes.set_ylim(-0.7, len(styles) - 0.3)


def _heights(timeline: Timeline, at: NDArray[np.float64], bottom: float) -> NDArray[np.float64]:
    """Where on the curve events lie; at the bottom where there is none."""
    curve = timeline.intensity
    assert curve is not None
    lost = in_gap(timeline.gaps, at)
    if not curve.is_constant:
        lost |= (at < curve.first_s) | (at > curve.last_s)
    return np.where(lost, bottom, curve.at(at))


def _name_goal(axes: Axes, score: str, x: float, y: float) -> None:
    if score:
        axes.annotate(
            score, (x, y), xytext=(0, 8), textcoords="offset points", ha="center", fontsize=8
        )
