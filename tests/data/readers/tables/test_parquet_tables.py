"""Parquet, where pyarrow is installed."""

from __future__ import annotations

import sys
from datetime import UTC, date, datetime
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.tables.arrays import ParquetTable
from overview_dsp.data.readers.tables.table import as_list
from overview_dsp.data.readers.tables.text_cells import TextCells
from overview_dsp.installation import install_command
from tests.data.readers.tables.made import load, refusal, times, values

pa = pytest.importorskip("pyarrow", reason="needs pyarrow: pip install '.[parquet]'")
pq = pytest.importorskip("pyarrow.parquet")

DAY = 86_400.0


def write(folder: Path, columns: dict[str, Any], **options: Any) -> bytes:
    path = folder / "written.parquet"
    pq.write_table(pa.table(columns), path, **options)
    return path.read_bytes()


@pytest.mark.parametrize(
    ("cells", "start", "seconds"),
    [
        (pa.array([date(2020, 1, 1), date(2020, 1, 2)]), datetime(2020, 1, 1), [0, DAY]),
        (pa.array([datetime(2020, 1, 1), datetime(2020, 1, 2)], pa.timestamp("us")),
         datetime(2020, 1, 1), [0, DAY]),
        (pa.array([0, 1_500_000_000], pa.timestamp("ns", "UTC")),
         datetime(1970, 1, 1, tzinfo=UTC), [0, 1.5]),
        (pa.array([0, 1_500], pa.timestamp("ms")), datetime(1970, 1, 1), [0, 1.5]),
        (pa.array(["2020-01-01", "2020-01-02"]), datetime(2020, 1, 1), [0, DAY]),
        (pa.array(["2020-01-01", "2020-01-02"]).dictionary_encode(),
         datetime(2020, 1, 1), [0, DAY]),
        (pa.array([1577836800, 1577836801]), datetime(2020, 1, 1, tzinfo=UTC), [0, 1]),
        (pa.array([0.5, 1.0]), None, [0, 0.5]),
    ],
)  # fmt: skip
def test_times_of_any_type(
    tmp_path: Path, cells: Any, start: datetime | None, seconds: list[float]
) -> None:
    data = write(tmp_path, {"time": cells, "level": pa.array([3, 5])})
    timeline = load(tmp_path, data, "made.parquet")
    assert timeline.start == start
    assert times(timeline) == seconds
    assert values(timeline) == [3.0, 5.0]
    assert "a Parquet table" in timeline.provenance


@pytest.mark.parametrize(
    "cells",
    [
        pa.array([1.5, None, 3.0]),
        pa.array([1.5, float("nan"), 3.0]),
        pa.array([1.5, None, 3.0], pa.float32()),
        pa.array(["1.5", "NA", "3"]),
        pa.array([Decimal("1.5"), None, Decimal("3.0")]),
    ],
)
def test_missing_values_of_any_type_are_gaps(tmp_path: Path, cells: Any) -> None:
    data = write(tmp_path, {"time": pa.array([0.0, 1.0, 2.0]), "level": cells})
    timeline = load(tmp_path, data)
    assert timeline.gaps == ((0.0, 2.0),)
    assert len(values(timeline)) == 2


def test_many_row_groups_are_one_series(tmp_path: Path) -> None:
    count = 200_000
    level = np.sin(np.arange(count) / 1000.0)
    data = write(
        tmp_path,
        {"t": np.arange(count) / 10.0, "level": level, "note": ["x"] * count},
        row_group_size=30_000,
    )
    timeline = load(tmp_path, data)
    assert np.array_equal(values(timeline), level)
    assert timeline.duration_s == (count - 1) / 10.0


@pytest.mark.parametrize("kind", [pa.string(), pa.large_string()])
@pytest.mark.parametrize("odd", ["", "é", None])
def test_texts_are_read_from_the_buffers_of_any_part(
    tmp_path: Path, kind: Any, odd: str | None
) -> None:
    texts: list[str | None] = [f"{i}{'x' * (i % 7)}" for i in range(150_000)]
    texts[70_000] = odd
    path = tmp_path / "texts.parquet"
    pq.write_table(pa.table({"text": pa.array(texts, kind)}), path, row_group_size=100_000)
    chunks = list(ParquetTable(DataFile.open(path)).chunks([0]))
    assert [cell for chunk in chunks for cell in as_list(chunk.cells[0])] == texts
    assert sum(isinstance(chunk.cells[0], TextCells) for chunk in chunks) >= 1


def test_a_wrong_cell_is_named_with_row_and_column(tmp_path: Path) -> None:
    data = write(tmp_path, {"t": [0.0, 1.0, 2.0, 3.0], "level": ["1", "2", "x", "4"]})
    assert "row 3, column 'level': 'x' isn't a number" in refusal(lambda: load(tmp_path, data))
    data = write(tmp_path, {"t": [0.0, 1.0], "level": [1.0, float("inf")]})
    assert "row 2, column 'level': inf isn't" in refusal(lambda: load(tmp_path, data))
    data = write(tmp_path, {"t": [0.0, 1.0], "level": [[1.0], [2.0]]})
    assert "no column of numbers" in refusal(lambda: load(tmp_path, data))
    data = write(tmp_path, {"t": pa.array([], pa.float64()), "level": pa.array([], pa.float64())})
    assert "no rows" in refusal(lambda: load(tmp_path, data))


def test_a_damaged_file_gives_a_one_line_error(tmp_path: Path) -> None:
    data = write(tmp_path, {"t": np.arange(1000.0), "level": np.arange(1000.0)})
    assert "broken or unknown Parquet" in refusal(lambda: load(tmp_path, data[:-100]))
    assert "broken or unknown Parquet" in refusal(lambda: load(tmp_path, b"PAR1"))


def test_how_to_install_what_is_missing_is_noted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = write(tmp_path, {"t": [0.0, 1.0], "level": [1.0, 2.0]})
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    words = refusal(lambda: load(tmp_path, data))
    assert install_command("parquet") in words
    assert "or save the table as CSV" in words
