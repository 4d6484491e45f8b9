"""The pictures: the timeline (the paper's figure 4), sweeps (figure 5) and a tap (figure 6).

Colours are Okabe and Ito's, which colour-blind eyes tell apart; event kinds differ in shape too.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.files import whole_file
from overview_dsp.rendering import Result
from overview_dsp.timeline import Timeline
from overview_dsp.timeline.gaps import in_gap
from overview_dsp.units import HALF_TURN

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
GREY = "#767676"

# kind: (marker, face colour, words); the paper's goals are blue, its cards yellow and red
KIND_STYLE: dict[str, tuple[str, str, str]] = {
    "goal": ("o", BLUE, "goal"),
    "own_goal": ("h", SKY, "own goal"),
    "near_miss": ("^", GREEN, "near miss"),
    "yellow_card": ("s", YELLOW, "yellow card"),
    "red_card": ("D", VERMILION, "red card"),
    "foul": ("x", GREY, "foul"),
    "period": ("|", BLACK, "start or end of a half"),
    "shot": ("<", GREEN, "shot"),
    "touch": ("+", GREY, "touch"),
}
# of kinds that have no style of their own, one after the other
_OTHER_MARKERS = "Pv*X>pd8"
_LINES = "x|+"  # markers without a face
GAP_HATCH = "////"
_POINTS = 1500  # a curve keeps its extremes in this many steps, so that an SVG stays small


def styles_of(timeline: Timeline) -> dict[str, tuple[str, str, str]]:
    """The style of each kind of a timeline: the known ones first, the others by name."""
    kinds = timeline.kinds()
    known = {kind: style for kind, style in KIND_STYLE.items() if kind in kinds}
    others = sorted(set(kinds) - set(known))
    return known | {
        kind: (_OTHER_MARKERS[index % len(_OTHER_MARKERS)], PURPLE, kind.replace("_", " "))
        for index, kind in enumerate(others)
    }


def _figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height))


def _tidy(axes: Axes) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)


def extremes(
    x: NDArray[np.float64], y: NDArray[np.float64], points: int = _POINTS
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A curve with fewer points and the same extremes: the lowest and highest of each step."""
    if len(x) <= 2 * points:
        return x, y
    edges = np.linspace(0, len(x), points + 1).astype(int)[:-1]
    low, high = np.minimum.reduceat(y, edges), np.maximum.reduceat(y, edges)
    return np.repeat(x[edges], 2), np.column_stack([low, high]).ravel()


def _axis(axes: Axes, timeline: Timeline) -> tuple[float, float, str]:
    """Seconds in a unit of the time axis, where it begins, and its label; dates for a calendar."""
    if timeline.start is not None:
        import matplotlib.dates

        dates: Any = matplotlib.dates  # its functions are untyped
        locator = dates.AutoDateLocator()
        axes.xaxis.set_major_locator(locator)
        axes.xaxis.set_major_formatter(dates.ConciseDateFormatter(locator))
        # its own clock: a zone would be turned into UTC
        return 86_400.0, float(dates.date2num(timeline.start.replace(tzinfo=None))), ""
    for unit, scale in (("days", 86_400.0), ("h", 3600.0), ("min", 60.0)):
        if timeline.duration_s > 10.0 * scale:
            return scale, 0.0, f"time, {unit}"
    return 1.0, 0.0, "time, s"


def plot_timeline(timeline: Timeline) -> Figure:
    """The intensity curve with its events, as in the paper's figure 4; gaps are hatched."""
    figure = _figure(9.0, 3.6)
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
    scale, shift, label = _axis(axes, timeline)
    times = np.linspace(0.0, timeline.duration_s, 4001)
    curve = timeline.normalised_levels(4000)
    curve[in_gap(timeline.gaps, times)] = np.nan  # no line over a gap
    for i, (start, end) in enumerate(timeline.gaps):
        axes.axvspan(
            start / scale + shift,
            end / scale + shift,
            facecolor="none",
            edgecolor="#b0b0b0",
            hatch=GAP_HATCH,
            linewidth=0.0,
            label=f"no data ({len(timeline.gaps)})" if i == 0 else None,
            zorder=1,
        )
    axes.fill_between(times / scale + shift, curve, color="#e8eef4", zorder=1)
    axes.plot(times / scale + shift, curve, color=GREY, linewidth=1.2, zorder=2)
    for kind, (marker, colour, words) in styles_of(like or timeline).items():
        at = np.array([event.time_s for event in timeline.events if event.kind == kind])
        if not len(at):
            continue
        height = timeline.normalised_intensity_at(at)
        goal = kind in ("goal", "own_goal")
        axes.scatter(
            at / scale + shift,
            height,
            s=90 if goal else 46,
            marker=marker,
            color=colour,
            edgecolors=None if marker in _LINES else BLACK,
            linewidths=1.6 if marker in _LINES else 0.7,
            label=f"{words} ({len(at)})",
            zorder=4 if goal else 3,
        )
    for event in timeline.events:
        if event.kind in ("goal", "own_goal") and event.label:
            axes.annotate(
                event.label.split(" ")[0],
                (
                    event.time_s / scale + shift,
                    float(timeline.normalised_intensity_at(np.array([event.time_s]))[0]),
                ),
                xytext=(0, 8),
                textcoords="offset points",
                ha="center",
                fontsize=8,
            )
    axes.set_xlim(shift, timeline.duration_s / scale + shift)
    axes.set_ylim(0.0, 1.18)
    axes.set_xlabel(label)
    axes.set_ylabel("intensity")
    _tidy(axes)


def plot_strokes(results: list[tuple[str, Result]], timeline: Timeline, title: str) -> Figure:
    """Torque, friction, disk 1 and disk 2 over time, a column a gesture (figures 5 and 6).

    Where data is missing, the surface under disk 1 is hatched.
    """
    figure = _figure(5.2 * len(results) + 0.6, 7.6)
    grid: Any = figure.subplots(4, len(results), sharex="col", sharey="row", squeeze=False)
    for column, (name, result) in enumerate(results):
        trace = result.trace
        assert trace is not None
        # the last part of the recoil is all alike
        shown = trace.time <= _end_of_interest(trace.time, trace.cursor)
        time, held = trace.time[shown], trace.touching[shown] > 0.5
        axes: list[Axes] = list(grid[:, column])
        rows = (
            (trace.torque[shown] * 1e3, "(a) torque\nmN·m", BLUE),
            (trace.friction[shown] * 1e3, "(b) friction B\nmN·m·s/rad", VERMILION),
            (trace.cursor[shown] * HALF_TURN, "(c) disk 1\nrad on the surface", BLACK),
            (np.where(held, trace.theta2[shown], 0.0), "(d) disk 2, the hand\nrad", GREEN),
        )
        for ax, (values, label, colour) in zip(axes, rows, strict=True):
            ax.plot(*extremes(time, values), color=colour, linewidth=1.0)
            if column == 0:
                ax.set_ylabel(label)
            _tidy(ax)
            if held.any() and not held.all():
                release = float(time[np.flatnonzero(held)[-1]])
                ax.axvline(release, color=GREY, linestyle="--", linewidth=0.9)
        _mark_strikes(axes[0], result, timeline, float(time[-1]))
        for start, end in timeline.gaps:
            axes[2].axhspan(
                start / timeline.duration_s * HALF_TURN,
                end / timeline.duration_s * HALF_TURN,
                facecolor="none",
                edgecolor="#b0b0b0",
                hatch=GAP_HATCH,
                linewidth=0.0,
            )
        axes[0].set_title(name, fontsize=10, pad=14)
        # linear within 1 mN·m, logarithmic beyond: the surface and its goals in one view
        axes[0].set_yscale("symlog", linthresh=1.0)
        # plain numbers: powers of ten would go through the slow setting of formulas
        axes[0].yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes[-1].set_xlabel("time, s (dashed: the finger lets go)")
    # margins by hand: finding them takes longer than drawing
    inch = 1.0 / (5.2 * len(results) + 0.6)
    figure.subplots_adjust(
        left=0.95 * inch, right=1.0 - 0.15 * inch, top=0.89, bottom=0.1, wspace=0.06, hspace=0.12
    )
    figure.align_ylabels(grid[:, 0])
    figure.suptitle(title, x=0.1 * inch, ha="left", fontsize=11)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="lower center", ncols=6, frameon=False, fontsize=8)
    return figure


def _end_of_interest(time: NDArray[np.float64], cursor: NDArray[np.float64]) -> float:
    away = np.flatnonzero(cursor > 0.01)
    return float(time[away[-1]]) + 0.3 if len(away) else float(time[-1])


def _mark_strikes(axes: Axes, result: Result, timeline: Timeline, end: float) -> None:
    # a row of marks just above the axes
    above = axes.get_xaxis_transform()
    for kind, (marker, colour, words) in styles_of(timeline).items():
        at = [
            time
            for time, event in zip(result.strikes.time_s, result.strikes.event, strict=True)
            if timeline.events[event].kind == kind and time <= end
        ]
        if not at or kind in ("foul", "period", "touch", "shot"):
            continue
        axes.scatter(
            at,
            np.full(len(at), 1.03),
            transform=above,
            s=26,
            marker=marker,
            color=colour,
            edgecolors=BLACK,
            linewidths=0.5,
            label=words,
            clip_on=False,
            zorder=4,
        )


def save_figure(figure: Figure, stem: str | os.PathLike[str]) -> list[Path]:
    """Write a figure as PNG and as SVG; the files, whole or absent."""
    import matplotlib

    written = []
    # no date and fixed ids: the same figure gives the same bytes
    with matplotlib.rc_context({"svg.hashsalt": "overview", "svg.fonttype": "none"}):
        for suffix, metadata in ((".png", {"Software": None}), (".svg", {"Date": None})):
            path = Path(f"{os.fspath(stem)}{suffix}")
            with whole_file(path) as temporary:
                figure.savefig(temporary, dpi=150, metadata=metadata)
            written.append(path)
    return written
