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


ENCODINGS = ("utf-8", "utf-8-sig", "cp1252", "utf-16-le")


@settings(
    max_examples=200,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    text=st.text("a1,é€\n\r\u2028\ufeff🙂", max_size=60),
    wrong=st.binary(max_size=3),
    encoding=st.sampled_from(ENCODINGS),
    size=st.integers(1, 40),
)
def test_blocks_hold_the_whole_lines_of_a_file(
    tmp_path: Path, text: str, wrong: bytes, encoding: str, size: int
) -> None:
    data = text.encode(encoding, "replace")
    data = data[: len(data) // 2] + wrong + data[len(data) // 2 :]
    path = tmp_path / "table.csv"
    path.write_bytes(data or b"x")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(delimited, "BLOCK_BYTES", size)
        lines = delimited.Lines(DataFile.open(path), encoding)
        blocks = [delimited.as_text(block) for block in lines.blocks()]
        texts = list(lines)
    errors = "surrogateescape" if encoding.startswith("utf-8") else "replace"
    with open(path, encoding=encoding, errors=errors) as stream:
        assert "".join(blocks) == "".join(texts) == stream.read()
    assert all(block[-1:] in ("", "\n") for block in blocks[:-1])


@given(text=st.text(st.characters(codec=None) | st.sampled_from("\r\n\ud800\udc80\udfff")))
def test_the_lines_of_a_text_keep_all_characters(text: str) -> None:
    assert ascii("".join(delimited.Lines(text))) == ascii(text)


@pytest.mark.parametrize("letter", ["x", "é"])
@pytest.mark.parametrize("size", [3, 10, 64])
def test_the_line_that_is_too_long_is_named_by_its_number(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, letter: str, size: int
) -> None:
    monkeypatch.setattr(delimited, "BLOCK_BYTES", size)
    monkeypatch.setattr(delimited, "MAX_LINE", 30)
    path = tmp_path / "table.csv"

    def lines_of(length: int) -> list[str]:
        path.write_text("a\n\nbc\r\n" + letter * length + "\nd\n" * 40, "utf-8", newline="")
        return list(delimited.Lines(DataFile.open(path)))

    assert lines_of(28)[3] == letter * 28 + "\n"  # in characters, of one or two bytes
    with pytest.raises(InputError, match="line 4 is longer than 30 characters"):
        lines_of(200)
