"""Figures of a report, each with a descriptive title."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from overview_dsp.cli.extensions import plot_style as style
from overview_studies.analysis import Analysis, condition_text
from overview_studies.measures import (
    DISTANCES,
    JND_PER_WIDTH,
    LEVELS,
    condition_of,
    conditions_of,
    level_counts,
)
from overview_studies.scales import scale_of
from overview_studies.scripts import MAIN_MEASURES
from overview_studies.statistics import Psychometric

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MEASURE_TITLES = {
    "d_prime": "Sensitivity d'",
    "location_error": "Distance from the event",
    "hits": "Places found",
    "exact": "Exact counts",
    "accuracy": "Correct answers",
    "likeness": "Correlation of drawing and curve",
    "adjusted": "Adjusted level minus the standard",
    "threshold": "Threshold",
    "tlx": "Workload (raw TLX)",
    "rt": "Time to answer",
}
_COLOURS = (style.BLUE, style.VERMILION, style.GREEN, style.ORANGE, style.PURPLE, style.GREY)


def figures_of(analysis: Analysis) -> dict[str, Figure]:
    """Return all figures of an analysis by file stem."""
    task = analysis.answers.study["task"]
    found = {MAIN_MEASURES[task["name"]]: estimates_figure(analysis, MAIN_MEASURES[task["name"]])}
    if analysis.matrices:
        found["confusion"] = confusion_figure(analysis)
    if (
        task["name"] in ("compare", "staircase", "quest")
        and len(scale_of(analysis.answers.study).levels) > 2
    ):
        found["psychometric"] = psychometric_figure(analysis)
    measures = {line.measure for line in analysis.estimates}
    found |= {name: estimates_figure(analysis, name) for name in ("tlx", "rt") if name in measures}
    return found


def estimates_figure(analysis: Analysis, measure: str) -> Figure:
    """Plot a measure by condition: mean, 95 % interval and one dot per participant."""
    scale = scale_of(analysis.answers.study)
    own = [line for line in analysis.estimates if line.measure == measure]
    on_scale = measure in LEVELS | DISTANCES
    values = {
        condition: {who: scale.level(value) if on_scale else value for who, value in by.items()}
        for (name, condition), by in analysis.measures.values.items()
        if name == measure
    }
    lines = {line.condition: line.estimate for line in own}
    figure = style.new_figure(6.0, 1.4 + 0.5 * max(len(values), 1))
    axes = figure.subplots()
    for row, (condition, by) in enumerate(sorted(values.items(), key=str)):
        one, points = lines[condition], [v for v in by.values() if math.isfinite(v)]
        # vertical offsets keep equal values visible
        at = row + 0.22 * (np.arange(len(points)) / max(len(points) - 1, 1) - 0.5)
        axes.plot(points, at, "o", color=style.GREY, markersize=3, alpha=0.5)
        if math.isfinite(one.low):
            axes.plot([one.low, one.high], [row, row], color=style.BLUE, linewidth=3)
        axes.plot([one.mean], [row], "D", color=style.VERMILION, markersize=6)
    axes.set_yticks(range(len(values)), [condition_text(c) for c in sorted(values, key=str)])
    axes.set_ylim(len(values) - 0.5, -0.5)
    unit = own[0].unit if own else ""
    if on_scale and scale.kind == "log":
        axes.set_xscale("log")
    title = MEASURE_TITLES.get(measure, measure)
    axes.set_xlabel(f"{title} ({unit})" if unit else title)
    _set_title(figure, f"{title}: means with 95 % intervals, and participants")
    style.tidy(axes)
    figure.set_layout_engine("constrained")
    return figure


def confusion_figure(analysis: Analysis) -> Figure:
    """Plot the confusion matrix of each condition, in percent of each stimulus."""
    choices = analysis.answers.study["task"]["choices"]
    title = analysis.answers.study["task"]["words"]
    count = len(analysis.matrices)
    side = 1.4 + 0.45 * len(choices)
    figure = style.new_figure(count * side + 0.8, side + 0.6)
    grid = figure.subplots(1, count, squeeze=False)[0]
    named = [title.get(choice, choice) for choice in choices]
    for number, (axes, (condition, counts)) in enumerate(
        zip(grid, sorted(analysis.matrices.items(), key=str), strict=True)
    ):
        parts = 100.0 * counts / np.maximum(counts.sum(axis=1, keepdims=True), 1.0)
        axes.imshow(parts, cmap="cividis", vmin=0.0, vmax=100.0)
        for (i, j), part in np.ndenumerate(parts):
            colour = "white" if part < 60.0 else "black"
            axes.text(j, i, f"{part:.0f}", ha="center", va="center", color=colour, fontsize=8)
        axes.set_xticks(range(len(named)), named, rotation=45, ha="right", fontsize=8)
        axes.set_yticks(range(len(named)), named if number == 0 else [], fontsize=8)
        axes.set_title("\n".join(condition_text(condition).split(", ")), fontsize=9)
    grid[0].set_ylabel("presented")
    _set_title(figure, "Answers in percent of each presented stimulus")
    figure.set_layout_engine("constrained")
    return figure


def psychometric_figure(analysis: Analysis) -> Figure:
    """Plot answers by level, summed over participants, and the reported means."""
    study = analysis.answers.study
    names, scale = conditions_of(study), scale_of(study)
    compared = study["task"]["name"] == "compare"
    figure = style.new_figure(6.0, 3.6)
    axes = figure.subplots()
    rows = [row for row in analysis.answers.rows() if row["phase"] == "main"]
    means = {(line.measure, line.condition): line.estimate.mean for line in analysis.estimates}
    for number, condition in enumerate(sorted({condition_of(row, names) for row in rows}, key=str)):
        own = [row for row in rows if condition_of(row, names) == condition]
        colour, label = _COLOURS[number % 6], condition_text(condition)
        levels, chosen, trials = level_counts(study, own)
        sizes = 3.0 + 5.0 * np.sqrt(trials / trials.max())
        for level, part, size in zip(levels, chosen / trials, sizes, strict=True):
            axes.plot([level], [part], "o", color=colour, markersize=size, alpha=0.7)
        mean = means.get(("pse" if compared else "threshold", condition), math.nan)
        at = scale.axis_position(mean)
        name = "point of equality" if compared else "threshold"
        label += f": {name} {mean:.3g}" if math.isfinite(mean) else f": no {name}"
        jnd = means.get(("jnd", condition), math.nan)
        if math.isfinite(jnd):
            width = scale.axis_position(jnd) / JND_PER_WIDTH
            lapse = means["lapse", condition]
            x = np.linspace(levels[0], levels[-1], 200)
            fitted = Psychometric(at, width, lapse, lapse)
            axes.plot(x, fitted.at(x), color=colour, label=label)
        else:
            axes.axvline(at, color=colour, label=label)
    axes.set_xlabel(f"{study['task']['vary']}" + (" (log scale)" if scale.kind == "log" else ""))
    if scale.kind == "log":
        ticks = sorted(scale.levels)
        axes.set_xticks([scale.position(one) for one in ticks], [f"{one:g}" for one in ticks])
    axes.set_ylabel("judged stronger" if compared else "correct answers")
    axes.set_ylim(-0.03, 1.03)
    axes.legend(frameon=False, fontsize=8)
    _set_title(figure, "Answers by level of all participants, and means over participants")
    style.tidy(axes)
    figure.set_layout_engine("constrained")
    return figure


def _set_title(figure: Figure, title: str) -> None:
    figure.suptitle(title, x=0.02, ha="left", fontsize=10)
