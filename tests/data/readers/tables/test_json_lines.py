"""JSON Lines whose values are converted as columns give what parsing each line gives."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.tables import json_lines
from overview_dsp.data.readers.tables.json_lines import JsonLinesTable, cells_of
from overview_dsp.data.readers.tables.table import as_list


@pytest.fixture(autouse=True)
def short_sample(monkeypatch):
    """The names of the columns are found in the first line, so that others are read as columns."""
    monkeypatch.setattr(json_lines, "_SAMPLE", 1)


MANY = settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
plain = st.text("ab01:,{}[] -.", max_size=8)
texts = st.integers(0, 9).flatmap(lambda n: plain if n else st.text(max_size=8))
whole = st.integers(-(10**17), 10**17) | st.integers(-300, 300)
kinds = {
    "whole": whole,
    "floats": st.floats(allow_nan=False, allow_infinity=False) | st.floats(-1e4, 1e4),
    "short": st.decimals(-(10**6), 10**6, places=3).map(float),
    "text": texts,
    "missing": st.none() | st.floats(-1e4, 1e4),
    "other": st.none() | st.booleans() | whole | texts | st.floats() | st.lists(st.integers()),
}
shapes = st.dictionaries(
    plain.filter(bool),
    st.sampled_from([*sorted(kinds), "whole", "short", "text"]),
    min_size=1,
    max_size=4,
)


def values(path: Path) -> list[list[Any]] | str:
    """Return all cells of the columns, None if missing, or the error."""
    try:
        table = JsonLinesTable(DataFile.open(path))
        found: list[list[Any]] = [[] for _ in table.columns]
        for chunk in table.chunks(range(len(table.columns))):
            for column, cells in zip(found, chunk.cells, strict=True):
                column += as_list(cells)
    except ov.InputError as error:
        return str(error)
    return [[None if one != one else one for one in column] for column in found]


def line_by_line(path: Path) -> list[list[Any]] | str:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(json_lines, "cells_of", lambda block, names: None)
        return values(path)


@MANY
@given(st.data())
def test_columns_are_the_values_of_each_line(tmp_path, data):
    shape = data.draw(shapes)
    row = st.fixed_dictionaries({name: kinds[kind] for name, kind in shape.items()})
    rows = data.draw(st.lists(row, min_size=2, max_size=30))
    marks = data.draw(st.sampled_from([(", ", ": "), (",", ":"), (" , ", " :  ")]))
    escaped = data.draw(st.booleans())
    lines = [json.dumps(one, separators=marks, ensure_ascii=escaped) for one in rows]
    if data.draw(st.booleans()):
        at = data.draw(st.integers(0, len(lines) - 1))
        cut = data.draw(st.integers(0, len(lines[at])))
        other = data.draw(st.sampled_from(["", " ", "0", '"', "}", "-", ".", "null", "e5", "\t"]))
        lines[at] = lines[at][:cut] + other + lines[at][cut + data.draw(st.integers(0, 1)) :]
    path = tmp_path / "a.jsonl"
    path.write_text("\n".join(lines) + data.draw(st.sampled_from(["", "\n", "\n\n"])))
    assert values(path) == line_by_line(path)


@pytest.mark.parametrize(
    "line",
    [
        '{"t": 01, "v": 1}',
        '{"t": 1., "v": 1}',
        '{"t": +1, "v": 1}',
        '{"t": .5, "v": 1}',
        '{"t": 1, "v": nul}',
        '{"t": 1, "v": 1',
        '{"t": 1 "v": 1}',
        '{"t": 1, "v": 1}}',
        '{"t"; 1, "v": 1}',
        '{"t": 1, "v"  1}',
        '{"t": 1; "v": 1}',
    ],
)
def test_a_broken_line_is_named(tmp_path, line):
    path = tmp_path / "a.jsonl"
    path.write_text('{"t": 0, "v": 2}\n' * 3 + line + "\n")
    found = values(path)
    assert isinstance(found, str)
    assert "line 4: broken JSON" in found


def test_lines_with_the_same_keys_are_read_as_columns():
    block = b'{"time": "2024-01-01", "level": -1.25, "n": 3}\n'
    block += b'{"time": "2024-01-02", "level": null, "n": -12}\n'
    time, level, n = cells_of(block, ["time", "level", "n"])
    assert time.tolist() == ["2024-01-01", "2024-01-02"]
    assert level[0] == -1.25
    assert math.isnan(level[1])
    assert n.dtype == np.int64
    assert n.tolist() == [3, -12]


def test_lines_with_other_keys_or_broken_texts_are_parsed_one_by_one(tmp_path):
    path = tmp_path / "a.jsonl"
    path.write_text('{"a": 1, "b": 2}\n' * 3 + '{"b": 3, "a": 4}\n{"a": 5, "c": 6}\n')
    assert values(path) == [[1, 1, 1, 4, 5], [2, 2, 2, 3, None]]
    for broken in ('{"a": 5""}', '{"a": "\t"}'):
        path.write_text('{"a": "1"}\n' * 3 + broken + "\n")
        assert "line 4: broken JSON" in values(path)


@pytest.mark.parametrize("mark", ["\u2028", "\u0085", "\x7f", "é"])
def test_only_line_ends_separate_records(tmp_path, mark):
    path = tmp_path / "a.jsonl"
    path.write_text(f'{{"a": "x{mark}y"}}\n\n{{"a": "z"}}\n', encoding="utf-8")
    assert values(path) == [[f"x{mark}y", "z"]]


def test_blank_lines_before_the_first_record_are_skipped(tmp_path):
    path = tmp_path / "a.jsonl"
    path.write_text("\n" * 200 + '{"a": 1}\n{"a": 2}\n')
    assert values(path) == [[1, 2]]
