"""Figures 4, 5 and 6 of the paper, and plots of any sweeps and taps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture, sweep, tap
from overview_dsp.design.presets.model import Preset
from overview_dsp.files.atomic import make_folder
from overview_dsp.offline.plots import style
from overview_dsp.offline.plots.timeline import plot_timeline
from overview_dsp.offline.rendering.offline import RenderResult, render
from overview_dsp.units import HALF_TURN

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FAST_S, SLOW_S = 1.0, 4.0
TAP_AT, HOLD_S = 1.0, 3.0
GESTURES = {"fast sweep": sweep(FAST_S), "slow sweep": sweep(SLOW_S), "tap": tap(TAP_AT, HOLD_S)}


def renders(timeline: Timeline, preset: Preset) -> dict[str, RenderResult]:
    """Render the three gestures of the paper: a fast sweep, a slow sweep and a tap."""
    return {name: render(timeline, preset, gesture) for name, gesture in GESTURES.items()}


def draw(timeline: Timeline, results: dict[str, RenderResult], folder: str | Path) -> list[Path]:
    """Write figures 4, 5 and 6 to a folder as PNG and SVG; return the files."""
    out = make_folder(folder)
    fast, slow = results["fast sweep"], results["slow sweep"]
    sweeps = plot_strokes(
        [(f"fast sweep, {FAST_S:g} s", fast), (f"slow sweep, {SLOW_S:g} s", slow)],
        timeline,
        f"{timeline.title}: sweeps and recoil",
        [GESTURES["fast sweep"], GESTURES["slow sweep"]],
    )
    taps = plot_strokes(
        [(f"tap at {TAP_AT:g}, held {HOLD_S:g} s", results["tap"])],
        timeline,
        f"{timeline.title}: a tap",
        [GESTURES["tap"]],
    )
    data = plot_timeline(timeline, fast.engine.surface.angle_map)
    figures = {"figure-4": data, "figure-5": sweeps, "figure-6": taps}
    return [path for name, one in figures.items() for path in style.save_figure(one, out / name)]


def plot_strokes(
    results: list[tuple[str, RenderResult]],
    timeline: Timeline,
    title: str,
    gestures: Sequence[Gesture] = (),
) -> Figure:
    """Plot torque, friction, disk 1 and disk 2 over time, one column per gesture.

    Gaps in the data are hatched. With a slip clutch, the curve of disk 2 is the rest position of
    the clutch, not the input angle. With `gestures`, the input angle is plotted, too.
    """
    figure = style.new_figure(5.2 * len(results) + 0.6, 9.0)
    grid: Any = figure.subplots(5, len(results), sharex="col", sharey="row", squeeze=False)
    for column, (name, result) in enumerate(results):
        trace = result.trace
        # the last part of the recoil is uniform
        away = np.flatnonzero(trace.cursor > 0.01)
        shown = trace.time <= (trace.time[away[-1]] + 0.3 if len(away) else trace.time[-1])
        time, touching = trace.time[shown], trace.touching[shown] > 0.5
        axes: list[Axes] = list(grid[:, column])
        rows = (
            (trace.torque[shown] * 1e3, "(a) torque\nmN·m, logarithmic", style.BLUE),
            (trace.torque[shown] * 1e3, "torque\nmN·m, linear", style.BLUE),
            (trace.friction[shown] * 1e3, "(b) friction B\nmN·m·s/rad", style.VERMILION),
            (trace.cursor[shown] * HALF_TURN, "(c) disk 1\nrad on the surface", style.BLACK),
            (trace.theta2[shown] * trace.engaged[shown], "(d) disk 2\nrad", style.GREEN),
        )
        for ax, (values, label, colour) in zip(axes, rows, strict=True):
            ax.plot(*style.extremes(time, values), color=colour, linewidth=1.0)
            if column == 0:
                ax.set_ylabel(label)
            style.tidy(ax)
            if touching.any() and not touching.all():
                release = float(time[np.flatnonzero(touching)[-1]])
                ax.axvline(release, color=style.GREY, linestyle="--", linewidth=0.9)
        if gestures:
            gesture = gestures[column]
            latest = np.searchsorted(gesture.time_s, time, side="right") - 1
            inside = touching & (latest >= 0)
            angle = np.where(inside, gesture.theta2[np.maximum(latest, 0)], 0.0)
            input_angle = style.extremes(time, angle)
            axes[4].plot(
                *input_angle, color=style.GREY, linewidth=0.9, label="input angle", zorder=1.5
            )
        _mark_strikes(axes[0], result, timeline, float(time[-1]))
        for gap in timeline.gaps:
            start, end = result.engine.surface.position_of(gap) * HALF_TURN
            axes[3].axhspan(start, end, **style.GAP_STYLE)
        axes[0].set_title(name, fontsize=10, pad=14)
        # logarithmic beyond 1 mN·m to show the base surface and goals together; the linear
        # panel shows their distance
        axes[0].set_yscale("symlog", linthresh=1.0)
        # plain numbers, since powers of ten need slow typesetting of formulas
        axes[0].yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes[-1].set_xlabel("time, s (dashed: release)")
    # fixed margins, since automatic layout takes longer than drawing
    inch = 1.0 / (5.2 * len(results) + 0.6)
    figure.subplots_adjust(
        left=0.95 * inch, right=1.0 - 0.15 * inch, top=0.89, bottom=0.1, wspace=0.06, hspace=0.12
    )
    figure.align_ylabels(grid[:, 0])
    figure.suptitle(title, x=0.1 * inch, ha="left", fontsize=11)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    if gestures:
        inputs, names = grid[4, 0].get_legend_handles_labels()
        handles, labels = handles + inputs, labels + names
    if handles:
        figure.legend(handles, labels, loc="lower center", ncols=6, frameon=False, fontsize=8)
    return figure


def _mark_strikes(axes: Axes, result: RenderResult, timeline: Timeline, end: float) -> None:
    # a row of marks just above the axes
    above = axes.get_xaxis_transform()
    strikes = result.strikes.of_events()
    for kind, mark in style.styles_of(timeline).items():
        at = [
            time
            for time, event in zip(strikes.time_s, strikes.event, strict=True)
            if timeline.events[event].kind == kind and time <= end
        ]
        if not at or kind in ("foul", "period", "touch", "shot"):
            continue
        width = 0.5 if style.has_face(mark[0]) else 1.2
        options = {"transform": above, "clip_on": False, "zorder": 4, "linewidths": width}
        style.mark_events(axes, at, np.full(len(at), 1.03), mark, 26, **options)
