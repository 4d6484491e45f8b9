"""The observer's picture, of scores made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from overview_dsp.measure.observer.report import ObserverReport, SetScores, StrokeScores
from overview_dsp.measure.observer.scoring import ObserverScores
from overview_dsp.measure.pictures import plot_observer


def report(strokes=("1 s", "recoil", "tap"), modalities=("touch", "sound")):
    table = np.array([[8, 0, 2, 0], [0, 0, 0, 0], [1, 0, 3, 16], [0, 0, 0, 0]])
    one = ObserverScores(
        ("goal", "comet", "foul"), table, np.array([9, 0, 5]), np.array([8, 0, 3]), 1
    )
    scores = {modality: StrokeScores(one, one) for modality in modalities}
    found = dict.fromkeys(strokes, scores)
    return ObserverReport("football", "steady", 120, (SetScores("random timelines", 40, found),))


def test_each_stroke_and_modality_has_a_matrix_in_per_cent_of_the_passed_kinds():
    figure = plot_observer(report())
    assert [axes.get_title().partition(":")[0] for axes in figure.axes] == [
        f"{stroke}, {modality}"
        for modality in ("touch", "sound")
        for stroke in ("1 s", "recoil", "tap")
    ]
    for axes in figure.axes:
        shown = axes.images[0].get_array()
        assert shown.tolist() == [[80.0, 20.0, 0.0], [5.0, 15.0, 80.0]]
        assert sorted(text.get_text() for text in axes.texts) == ["15", "20", "5", "80", "80"]
    rows = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    columns = [label.get_text() for label in figure.axes[-1].get_xticklabels()]
    assert rows == ["goal", "foul"]
    assert columns == ["goal", "foul", "nothing"]


@pytest.mark.parametrize(
    "what", [{}, {"strokes": ("mixed",), "modalities": ("touch",)}], ids=["many", "one"]
)
def test_the_labels_of_the_picture_do_not_overlap(what):
    figure = plot_observer(report(**what))
    figure.canvas.draw()
    width, height = figure.canvas.get_width_height()
    boxes = [axes.get_tightbbox() for axes in figure.axes]
    title = figure.texts[0].get_window_extent()
    for box in (*boxes, title):
        assert box.x0 >= 0.0
        assert box.y0 >= 0.0
        assert box.x1 <= width
        assert box.y1 <= height
    assert title.y0 >= max(box.y1 for box in boxes)
