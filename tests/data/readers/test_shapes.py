"""A hundred shapes of tables and event lists: read right, or error with a hint."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest

from overview_dsp.data.readers import load_timeline
from overview_dsp.design.presets.library import fitting_preset
from overview_dsp.errors import InputError
from tests.data.readers.shapes import Shape, all_shapes

SHAPES = all_shapes()

FORMATS_PAGE = Path(__file__).parents[3] / "docs" / "explanation" / "formats.md"


def outcome(shape: Shape) -> str:
    if shape.fix:
        return "error with a hint"
    return "series" if shape.points else "events"


def test_at_least_a_hundred_shapes_are_tested_and_the_documentation_counts_them() -> None:
    counts = Counter(map(outcome, SHAPES))
    assert len(SHAPES) >= 100
    assert len({shape.name for shape in SHAPES}) == len(SHAPES)
    assert len({shape.data for shape in SHAPES}) >= len(SHAPES) - 2
    page = FORMATS_PAGE.read_text(encoding="utf-8")
    for what, count in (*counts.items(), ("all", len(SHAPES))):
        assert re.search(rf"\| {what} \| {count} \|", page), (what, count)


@pytest.mark.parametrize("shape", SHAPES, ids=[shape.name for shape in SHAPES])
def test_a_shape_is_read_right_or_refused_with_the_fix(shape: Shape, tmp_path: Path) -> None:
    path = tmp_path / "made"
    path.write_bytes(shape.data)
    if shape.fix:
        with pytest.raises(InputError) as caught:
            load_timeline(path, **shape.options)
        lines = str(caught.value).split("\n")
        assert len(lines) <= 2
        assert shape.fix in lines[-1]
        assert lines[0].startswith(str(path))
        return
    timeline = load_timeline(path, **shape.options)
    if shape.points:
        assert timeline.intensity is not None
        assert timeline.intensity.count == shape.points
        assert not any("per cent" in note for note in timeline.notes)
        if shape.duration_s is not None:
            assert timeline.duration_s == pytest.approx(shape.duration_s)
        else:  # months and years
            assert timeline.duration_s > 365.0 * 86_400.0 * 3
        return
    assert [event.time_s for event in timeline.events] == pytest.approx(shape.seconds)
    assert tuple(event.kind for event in timeline.events) == shape.kinds
    assert timeline.duration_s == pytest.approx(shape.duration_s or shape.seconds[-1])
    assert timeline.intensity is None  # no crowd without football
    assert fitting_preset(timeline.kinds()).preset == "plain"
    if shape.note:
        assert any(shape.note in note for note in timeline.notes)
