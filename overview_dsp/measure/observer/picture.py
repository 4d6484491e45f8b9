"""What an observer took for what, as a picture: a confusion matrix a stroke and a modality."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from overview_dsp.measure.observer.scoring import NOTHING, ObserverScores
from overview_dsp.offline.plots.style import new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from overview_dsp.measure.observer.report import ObserverReport

CELL_IN = 0.3
LEFT_IN, TOP_IN, BOTTOM_IN, GAP_IN = 1.0, 0.75, 0.8, 0.35


def plot_observer(report: ObserverReport) -> Figure:
    """Of 100 events of each kind (rows), how many were taken for what (columns).

    Of the timelines that were given, or of random ones. Kinds that weren't met have no row. Each
    matrix has the mean recall of the kinds in its title.
    """
    shown = report.sets[-1]
    strokes = list(shown.strokes)
    modalities = list(shown.strokes[strokes[0]])
    first = shown.strokes[strokes[0]][modalities[0]].kinds
    met = [
        row
        for row in range(len(first.kinds))
        if any(by[m].kinds.events[row] for by in shown.strokes.values() for m in modalities)
    ]
    side = CELL_IN * (len(met) + 1)
    figure = new_figure(
        LEFT_IN + len(strokes) * (side + GAP_IN),
        TOP_IN + BOTTOM_IN + len(modalities) * (side + GAP_IN),
    )
    grid = figure.subplots(len(modalities), len(strokes), squeeze=False)
    names = [*(first.kinds[row] for row in met), NOTHING]
    for axes_row, modality in zip(grid, modalities, strict=True):
        for axes, stroke in zip(axes_row, strokes, strict=True):
            scores = shown.strokes[stroke][modality].kinds
            _matrix(axes, scores, met)
            axes.set_title(f"{stroke}, {modality}: {100.0 * scores.balanced:.0f} %", fontsize=8)
        axes_row[0].set_yticks(range(len(met)), names[:-1], fontsize=7)
    for axes in grid[-1]:
        axes.set_xticks(range(len(names)), names, rotation=60, ha="right", fontsize=7)
    width, height = figure.get_size_inches()
    figure.suptitle(
        f"{report.preset}, {shown.name}\nof 100 of each kind, taken for",
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


def _matrix(axes: Axes, scores: ObserverScores, met: list[int]) -> None:
    counts = scores.confusion[np.ix_(met, [*met, len(scores.kinds)])]
    total = scores.confusion[met].sum(axis=1, keepdims=True)
    parts: NDArray[np.float64] = 100.0 * counts / np.maximum(total, 1)
    axes.imshow(parts, cmap="cividis", vmin=0.0, vmax=100.0, aspect="equal")
    for (row, column), part in np.ndenumerate(parts):
        if part >= 0.5:
            color = "white" if part < 60.0 else "black"
            weight = "bold" if row == column else "normal"
            axes.text(
                column,
                row,
                f"{part:.0f}",
                ha="center",
                va="center",
                fontsize=6,
                color=color,
                fontweight=weight,
            )
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(visible=False)
