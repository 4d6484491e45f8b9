"""Plain blocks of text are read to the same cells as by Python's csv module."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.tables import delimited, dialect
from overview_dsp.data.readers.tables.table import as_list
from overview_dsp.errors import InputError

FIELDS = st.text("ab01.-# \t,;'é", max_size=6) | st.sampled_from(
    ["", "3.5", '"q"', '"a,b"', '" \n"']
)
ROWS = st.lists(st.lists(FIELDS, min_size=3, max_size=3) | st.just([]), max_size=24)


def read(path: Path, columns: list[int]) -> list[Any]:
    """Each row's number and cells, or the line with which it is refused."""
    held = dialect.Dialect("utf-8", ",", ("x", "y", "z"), ("", "", ""), 2, ("#",))
    table = delimited.DelimitedTable(DataFile.open(path), held)
    rows: list[Any] = []
    try:
        for chunk in table.chunks(columns):
            cells = zip(*map(as_list, chunk.cells), strict=True)
            rows += [(chunk.number(i), *row) for i, row in enumerate(cells)]
    except InputError as error:
        return [str(error)]  # how many rows were given before depends on the blocks
    return rows


@settings(
    max_examples=200,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(rows=ROWS, end=st.sampled_from(["\n", "\r\n"]), last=st.booleans(), size=st.integers(5, 90))
def test_a_table_is_the_same_by_blocks_and_by_rows(
    tmp_path: Path, rows: list[list[str]], end: str, last: bool, size: int
) -> None:
    # a row of nothing may be left out, or be one without a value
    rows = [row for row in rows if not row or any(cell.strip(' "\n\t') for cell in row)]
    text = end.join(["x,y,z", *map(",".join, rows)]) + (end if last else "")
    path = tmp_path / "table.csv"
    path.write_bytes(text.encode())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(delimited, "BLOCK_BYTES", size)
        for columns in ([0, 1, 2], [2], [1, 0]):
            fast = read(path, columns)
            with patch.context() as slow:
                slow.setattr(delimited, "field_ends", lambda *arguments: None)
                assert fast == read(path, columns)


def test_a_wide_table_gives_the_columns_that_are_asked_for(tmp_path: Path) -> None:
    width, rows = 60, 50
    header = tuple(f"c{i}" for i in range(width))
    path = tmp_path / "wide.csv"
    lines = [",".join(f"{row}.{i}" for i in range(width)) for row in range(rows)]
    path.write_text("\n".join([",".join(header), *lines, ""]))
    table = delimited.DelimitedTable(
        DataFile.open(path), dialect.Dialect("utf-8", ",", header, ("",) * 60, 2, ("#",))
    )
    for columns in ([0], [59], [7, 30, 0]):
        (chunk,) = table.chunks(columns)
        assert [as_list(cells) for cells in chunk.cells] == [
            [f"{row}.{i}" for row in range(rows)] for i in columns
        ]
