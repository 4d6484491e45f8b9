"""Pictures of presets: kinds as rendered, contrasts, confusions; audition of all kinds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from overview_dsp.arrays import FloatArray
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.design.gestures import sweep
from overview_dsp.design.presets.model import Preset
from overview_dsp.measure.observer.scoring import NOTHING, ObserverScores
from overview_dsp.measure.perception import JND_DB
from overview_dsp.measure.report_base import cell
from overview_dsp.offline.plots.style import BLUE, GREY, VERMILION, extremes, new_figure, tidy
from overview_dsp.offline.rendering.offline import RenderResult, render

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from overview_dsp.measure.observer.report import ObserverReport
    from overview_dsp.measure.report import FeelReport

CELL_IN = 0.3
LEFT_IN, TOP_IN, BOTTOM_IN, GAP_IN = 1.0, 0.75, 0.8, 0.35
"""Sizes of an observer's confusion matrices, inches."""


def plot_preset(preset: Preset) -> Figure:
    """Render every kind of a preset and plot it with `plot_gallery`."""
    return plot_gallery(audition(preset), preset)


def plot_gallery(result: RenderResult, preset: Preset) -> Figure:
    """Plot click and vibration of each kind of event, in the order of the render."""
    figure = new_figure(11.0, 4.6)
    click, tactor = figure.subplots(2, 1, sharex=True)
    rate, trace = result.sample_rate, result.trace
    # only the outward stroke: the recoil repeats it backwards
    count = int(np.argmax(trace.engaged < 0.5)) or len(trace.time)
    time = trace.time[:count]
    click.plot(*extremes(time, result.samples[:count, 0].astype(float)), color=BLUE, linewidth=0.7)
    click.set_ylabel("click")
    level = 20.0 * np.log10(np.maximum(trace.envelope[:count], 1e-4))
    tactor.plot(*extremes(time, level), color=VERMILION, linewidth=1.0)
    tactor.set_ylabel("vibration, dB")
    tactor.set_ylim(-60.0, 3.0)
    tactor.set_xlabel("time, s")
    seen: set[str] = set()
    strikes = result.strikes.of_events()
    for at, event in zip(strikes.time_s, strikes.event, strict=True):
        if at * rate >= count:
            continue
        for axes in (click, tactor):
            axes.axvline(at, color=GREY, linewidth=0.5, zorder=0)
        kind = result.engine.timeline.events[event].kind
        if kind not in seen:
            seen.add(kind)
            click.annotate(
                kind, (at, 1.0), xycoords=click.get_xaxis_transform(), xytext=(0, 3),
                textcoords="offset points", rotation=35.0, fontsize=7, va="bottom",
            )  # fmt: skip
    for axes in (click, tactor):
        tidy(axes)
    figure.suptitle(f"{preset.title}: {preset.description}", x=0.01, ha="left", fontsize=10)
    figure.subplots_adjust(left=0.085, right=0.985, top=0.79, bottom=0.11, hspace=0.1)
    figure.align_ylabels((click, tactor))
    return figure


def plot_feel(report: FeelReport) -> Figure:
    """Plot the contrast of each kind in each stroke; contrasts below one JND are red."""
    kinds = list(dict.fromkeys(kind.kind for stroke in report.strokes for kind in stroke.kinds))
    figure = new_figure(9.0, 1.4 + 0.36 * len(kinds))
    axes = figure.subplots()
    table = np.full((len(kinds), len(report.strokes)), np.nan)
    for column, stroke in enumerate(report.strokes):
        for kind in stroke.kinds:
            table[kinds.index(kind.kind), column] = kind.contrast_db
    image = axes.imshow(table, aspect="auto", cmap="cividis", vmin=0.0, vmax=30.0)
    for (row, column), value in np.ndenumerate(table):
        colour = VERMILION if value < JND_DB else "white" if value < 18.0 else "black"
        _write(axes, row, column, value, 8, colour, value < JND_DB)
    axes.set_xticks(range(len(report.strokes)), [stroke.name for stroke in report.strokes])
    axes.tick_params(axis="x", rotation=25, labelsize=8)
    axes.set_yticks(range(len(kinds)), kinds)
    axes.grid(visible=False)
    figure.colorbar(image, ax=axes, label="contrast, dB (red: masked)", pad=0.02)
    axes.set_title(report.table().partition("\n")[0], loc="left", fontsize=10)
    figure.tight_layout()
    return figure


def plot_observer(report: ObserverReport) -> Figure:
    """Plot confusion matrices: true kinds in rows, answers in columns, in per cent of the row.

    The last set of timelines is plotted. Kinds without events have no row. The title of each matrix
    has the mean recall of the kinds.
    """
    scores_set = report.sets[-1]
    strokes = list(scores_set.strokes)
    modalities = list(scores_set.strokes[strokes[0]])
    first = scores_set.strokes[strokes[0]][modalities[0]].kinds
    rows = [
        row
        for row in range(len(first.kinds))
        if any(by[m].kinds.events[row] for by in scores_set.strokes.values() for m in modalities)
    ]
    side = CELL_IN * (len(rows) + 1)
    figure = new_figure(
        LEFT_IN + len(strokes) * (side + GAP_IN),
        TOP_IN + BOTTOM_IN + len(modalities) * (side + GAP_IN),
    )
    grid = figure.subplots(len(modalities), len(strokes), squeeze=False)
    names = [*(first.kinds[row] for row in rows), NOTHING]
    for axes_row, modality in zip(grid, modalities, strict=True):
        for axes, stroke in zip(axes_row, strokes, strict=True):
            scores = scores_set.strokes[stroke][modality].kinds
            _draw_matrix(axes, scores, rows)
            axes.set_title(f"{stroke}, {modality}: {100.0 * scores.balanced:.0f} %", fontsize=8)
        axes_row[0].set_yticks(range(len(rows)), names[:-1], fontsize=7)
    for axes in grid[-1]:
        axes.set_xticks(range(len(names)), names, rotation=60, ha="right", fontsize=7)
    width, height = figure.get_size_inches()
    figure.suptitle(
        f"{report.preset}, {scores_set.name}\nanswers to each kind, %",
        x=0.1 / width,
        y=1.0 - 0.1 / height,
        va="top",
        ha="left",
        fontsize=10,
    )
    figure.subplots_adjust(
        left=LEFT_IN / width,
        right=1.0 - 0.1 / width,
        top=1.0 - TOP_IN / height,
        bottom=BOTTOM_IN / height,
        wspace=GAP_IN / side,
        hspace=GAP_IN / side,
    )
    return figure


def _draw_matrix(axes: Axes, scores: ObserverScores, rows: list[int]) -> None:
    counts = scores.confusion[np.ix_(rows, [*rows, len(scores.kinds)])]
    total = scores.confusion[rows].sum(axis=1, keepdims=True)
    parts: FloatArray = 100.0 * counts / np.maximum(total, 1)
    axes.imshow(parts, cmap="cividis", vmin=0.0, vmax=100.0, aspect="equal")
    for (row, column), part in np.ndenumerate(parts):
        if part >= 0.5:
            _write(axes, row, column, part, 6, "white" if part < 60.0 else "black", row == column)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(visible=False)


def _write(
    axes: Axes, row: int, column: int, value: float, size: int, colour: str, bold: bool
) -> None:
    """Write a whole number into a cell of a matrix, or a dash for none, as in the table."""
    weight = "bold" if bold else "normal"
    axes.text(
        column, row, cell(value, 0, 0), ha="center", va="center", fontsize=size, color=colour,
        fontweight=weight,
    )  # fmt: skip


REPEATS = 2
MANY = 10
"""Number of kinds from which on each occurs once, so that a fast sweep still separates them."""

PAGE_KINDS = 5
SECONDS_EACH = 0.3  # time of the sweep between two events, long enough to distinguish them


def gallery(preset: Preset) -> Timeline:
    """Return a timeline with each kind of the preset, twice in a row if there are few."""
    repeats = REPEATS if len(preset.kinds) < MANY else 1
    return _gallery(preset, list(preset.kinds), repeats)


def pages(preset: Preset) -> tuple[Timeline, ...]:
    """Return the gallery in pages of up to `PAGE_KINDS` kinds, each kind twice."""
    names = list(preset.kinds)
    count = -(-len(names) // PAGE_KINDS)
    # distributed in turn, so that all pages are similarly long
    return tuple(_gallery(preset, names[i::count], REPEATS) for i in range(count))


def _gallery(preset: Preset, kinds: Sequence[str], repeats: int) -> Timeline:
    names = [name for name in kinds for _ in range(repeats)]
    length = SECONDS_EACH * (len(names) + 1)
    events = tuple(Event(SECONDS_EACH * (i + 1), name, name) for i, name in enumerate(names))
    return Timeline(f"{preset.title}: every kind", length, events)


def audition(preset: Preset, seed: int = 0) -> RenderResult:
    """Render a steady sweep over the gallery and its recoil."""
    timeline = gallery(preset)
    return render(timeline, preset, sweep(timeline.duration_s), seed=seed)
