"""The layout of a text table is detected once for all formats, from the first lines only."""

from __future__ import annotations

from pathlib import Path

import pytest

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.tables import dialect

ROWS = [f"2020-01-{day:02},{day}.5" for day in range(1, 9)]


def written(path: Path, header: str, separator: str = ",", encoding: str = "utf-8") -> DataFile:
    lines = "\n".join([header, *ROWS, ""]).replace(",", separator)
    path.write_text(lines, encoding=encoding)
    return DataFile.open(path)


def test_the_layout_is_detected_once_for_all_formats(tmp_path: Path) -> None:
    source = written(tmp_path / "once.csv", "date,once")
    dialect._layout.cache_clear()
    load_timeline(source.path)
    assert dialect._layout.cache_info().misses == 1
    assert dialect._layout.cache_info().hits > 1


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ({"header": "date,level"}, {"header": "date,depth"}),
        ({"header": "date,level"}, {"header": "date,level", "separator": ";"}),
        ({"header": "date,höhe"}, {"header": "date,höhe", "encoding": "cp1252"}),
        ({"header": "date,level"}, {"header": "date,level", "encoding": "utf-16"}),
    ],
)
def test_the_layout_of_another_file_is_its_own(
    tmp_path: Path, first: dict[str, str], second: dict[str, str]
) -> None:
    sources = [written(tmp_path / f"{i}.csv", **way) for i, way in enumerate((first, second))]
    alone = []
    for source in sources:
        dialect._layout.cache_clear()
        alone.append(dialect.detect(source))
    assert None not in alone
    assert alone[0] != alone[1]
    assert [dialect.detect(source) for source in (*sources, *sources)] == [*alone, *alone]


def test_a_file_that_is_written_again_has_another_layout(tmp_path: Path) -> None:
    for header, separator in (("date,level", ","), ("date,level", ";"), ("day,level", ";")):
        found = dialect.detect(written(tmp_path / "a.csv", header, separator))
        assert found is not None
        assert (",".join(found.header), found.separator) == (header, separator)


def test_each_format_decides_by_its_own_rows(tmp_path: Path) -> None:
    source = written(tmp_path / "a.csv", "date,level")
    assert dialect.detect(source) is not None
    assert dialect.detect(source, lambda header, below: False) is None
    seen: list[object] = []
    assert dialect.detect(source, lambda header, below: bool(seen.extend((header, below)) or 1))
    assert seen == [("date", "level"), [row.split(",") for row in ROWS]]
