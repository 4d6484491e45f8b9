"""Whatever is in a file: a Timeline or one line."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline, native
from overview_dsp.data.readers.data_file import parse_json
from tests.data.readers.outcome import timeline_or_one_line

TABLES = (
    b"date,open,high,low,close,volume,adj close\n"
    + b"".join(b"2020-01-%02d,1,2,0.5,%d.5,1000,%d\n" % (d, d, d) for d in range(1, 20)),
    "# made\ndatum;wert (°C)\n".encode()
    + b"".join(b"%02d.03.2020 10:00;%d,5\n" % (d, d % 4) for d in range(1, 20)),
    b"t\tv\n" + b"".join(b"%d\t%s\n" % (i, b"NA" if i == 4 else b"1e%d" % i) for i in range(12)),
    b"time,station,v\n" + b"".join(b"2020-01-01T%02d:00:00Z,A,%d\n" % (h, h) for h in range(20)),
)
DOCUMENTS = (
    b'[{"date": "2020-01-01", "v": 1.5}, {"date": "2020-01-02", "v": null},'
    b' {"date": "2020-01-03", "v": 3}]',
    b'{"hourly_units": {"v": "m"}, "hourly": {"time": [1577836800, 1577836801], "v": [1, 2]}}',
    b'{"2020-01-01": {"v": 1}, "2020-01-02": {"v": 2}}',
    b'{"date": "2020-01-01", "v": 1}\n{"date": "2020-01-02", "v": 2}\n{"date": "2020-01-04"}\n',
)
OPTIONS = st.fixed_dictionaries(
    {},
    optional={
        "value": st.sampled_from(["v", "close", "wert", "2", ""]),
        "time": st.sampled_from(["t", "date:mdy", ":epoch_ms", "datum:excel", "v:year", ":", "x"]),
        "map": st.sampled_from(["change", "activity:percent", "volatility:3d", "v", "volatility"]),
        "rate": st.floats(1e-300, 1e300),
        "match": st.sampled_from(["A", "station=B", "1", "=", ""]),
    },
)
PIECES = st.sampled_from(
    [",", ";", "\t", "\n", "\r", '"', "#", "-", ".", "e", "1", "9" * 30, "nan", "inf", " ", "x",
     "é", "\0", "/", ":", "0001-01-01", "9999-12-31", "13/13/13", "{", "}", "[", "]", "null",
     "true", "1e308", "-1e308", "5e-324", "\ud800", "Z", "+25:00", "$", "%"]
).map(lambda text: text.encode("utf-8", "surrogatepass")) | st.binary(max_size=4)  # fmt: skip


@st.composite
def changed(draw: st.DrawFn, files: tuple[bytes, ...]) -> bytes:
    """A valid file, cut off, or with some places overwritten."""
    data = draw(st.sampled_from(files))
    if draw(st.integers(0, 4)) == 0:
        return data[: draw(st.integers(1, len(data)))]
    for _ in range(draw(st.integers(0, 5))):
        at = draw(st.integers(0, len(data)))
        data = data[:at] + draw(PIECES) + data[at + draw(st.integers(0, 6)) :]
    return data


def check(path: Path, data: bytes, options: dict[str, Any]) -> None:
    path.write_bytes(data)
    timeline = timeline_or_one_line(lambda: load_timeline(path, **options))
    if timeline is None:
        return
    timeline.normalised_intensity_at([0.0, timeline.duration_s / 3.0, timeline.duration_s])
    text = native.encode(timeline).decode()
    assert native.decode(parse_json(text, ""), "") == timeline


relaxed = settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


@relaxed
@given(changed(TABLES), OPTIONS)
def test_any_change_of_a_table_gives_a_timeline_or_a_one_line_error(
    tmp_path: Path, data: bytes, options: dict[str, Any]
) -> None:
    check(tmp_path / "table.csv", data, options)


@relaxed
@given(changed(DOCUMENTS), OPTIONS)
def test_any_change_of_a_document_gives_a_timeline_or_a_one_line_error(
    tmp_path: Path, data: bytes, options: dict[str, Any]
) -> None:
    check(tmp_path / "document.json", data, options)


@relaxed
@given(st.binary(min_size=1, max_size=300), OPTIONS)
def test_any_bytes_give_a_timeline_or_a_one_line_error(
    tmp_path: Path, data: bytes, options: dict[str, Any]
) -> None:
    check(tmp_path / "bytes", data, options)


CELLS = st.sampled_from(
    ["", "NA", "1", "-1.5", "1,5", "1e300", "-1e300", "5e-324", "1e-310", "0", "2020-01-01",
     "0001-01-01", "9999-12-31T23:59:59.999999", "1/2/2020", "31/1/2020", "12:30", "1577836800",
     "253402300799.9999999", "1577836800000", "99999999999999999999", "-62135596800", "3%",
     "$4", "(5)", "x", "2020Q1"]
) | st.floats().map(repr) | st.integers(-(10**20), 10**20).map(str)  # fmt: skip


@relaxed
@given(
    st.lists(st.sampled_from(["date", "time", "year", "close", "open", "v", "t (ms)", ""]),
             min_size=1, max_size=4),
    st.data(),
    OPTIONS,
)  # fmt: skip
def test_any_cells_give_a_timeline_or_a_one_line_error(
    tmp_path: Path, header: list[str], data: st.DataObject, options: dict[str, Any]
) -> None:
    rows = data.draw(st.lists(st.tuples(*([CELLS] * len(header))), min_size=1, max_size=12))
    kinds = data.draw(st.sampled_from(["csv", "json"]))
    if kinds == "csv":
        text = "\n".join(";".join(row) for row in [tuple(header), *rows])
    else:
        text = json.dumps([dict(zip(header, row, strict=True)) for row in rows])
    check(tmp_path / "cells", text.encode(), options)


NUMBERS = st.one_of(
    st.floats(), st.floats(-1e3, 1e3), st.integers(-(2**62), 2**62), st.none(),
    st.sampled_from([1577836800.0, 1e300, -1e300, 5e-324]),
)  # fmt: skip


@relaxed
@given(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1, max_size=15), OPTIONS)
def test_any_pairs_of_numbers_give_a_timeline_or_a_one_line_error(
    tmp_path: Path, rows: list[tuple[Any, Any]], options: dict[str, Any]
) -> None:
    text = json.dumps([{"t": t, "v": v} for t, v in rows])
    check(tmp_path / "pairs.json", text.encode(), options)


@cache
def parquet() -> tuple[bytes, ...]:
    pa = pytest.importorskip("pyarrow", reason="needs pyarrow")
    pq = pytest.importorskip("pyarrow.parquet")
    files = []
    for times in (pa.array(range(40), pa.timestamp("s")), pa.array(map(str, range(40)))):
        stream = BytesIO()
        values = pa.array([None if i == 7 else i / 3 for i in range(40)])
        pq.write_table(pa.table({"t": times, "v": values}), stream, row_group_size=16)
        files.append(stream.getvalue())
    return tuple(files)


@relaxed
@given(st.data(), OPTIONS)
def test_any_change_of_parquet_gives_a_timeline_or_a_one_line_error(
    tmp_path: Path, data: st.DataObject, options: dict[str, Any]
) -> None:
    check(tmp_path / "table.parquet", data.draw(changed(parquet())), options)


@pytest.mark.parametrize(
    "make",
    [
        lambda: b"date,v\n" + b"," * 200_000,
        lambda: b"date," + b"v," * 20_000 + b"\n" + b"1," * 20_001,
        lambda: b"date,v\n" + b'"' * 100_001,
        lambda: b"date,v\n" + b"2020-01-01,1\n" * 100_000,
        lambda: b"date,v\n" + b"9" * 400_000 + b",1\n",
        lambda: b"[" * 60_000,
        lambda: b'{"a":' * 60_000,
        lambda: b'{"date": 1}\n' * 2 + b"[" * 60_000,
        lambda: b"[" + b"[1,2]," * 100_000 + b"[1,2]]",
    ],
)
def test_tables_of_extreme_shape_give_a_timeline_or_a_one_line_error(
    tmp_path: Path, make: Callable[[], bytes]
) -> None:
    check(tmp_path / "extreme", make(), {})


def test_a_sparse_file_of_10_gigabytes_is_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "sparse.csv"
    with open(path, "wb") as stream:
        stream.write(b"date,v\n2020-01-01,1\n2020-01-02,2\n")
        stream.truncate(10 * 2**30)
    assert timeline_or_one_line(lambda: load_timeline(path)) is None
    assert timeline_or_one_line(lambda: load_timeline(path, max_mb=20_000.0)) is None
