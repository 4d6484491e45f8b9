"""A series read as a stream is the same as in one piece."""

from __future__ import annotations

import resource
import sys
import time
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import signal

from overview_dsp.data.analysis.extrema import Thinner, lows_and_highs, peaks
from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.series import sample_scan as streamed
from overview_dsp.data.readers.tables import delimited
from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.curve_points import RegularTimes
from tests.data.readers.tables.made import load, noted, refusal

COUNT = 5000


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Streams series of more than 1000 rows, in blocks of 700."""
    monkeypatch.setattr(delimited, "CHUNK_ROWS", 250)
    monkeypatch.setattr(streamed, "LONG_ROWS", 1000)
    monkeypatch.setattr(streamed, "BLOCK_ROWS", 700)
    monkeypatch.setattr(streamed, "CONTEXT_ROWS", 300)


def made(even: bool, kind: str = "level") -> str:
    random = np.random.default_rng(7)
    level = 450.0 + np.cumsum(random.normal(0.0, 1.0, COUNT))
    assert level.min() > 200.0
    level[1234] = 900.0
    step = np.full(COUNT, 60) if even else random.integers(20, 90, COUNT)
    step[3000] = 60 if even else 4000
    at = np.cumsum(step)
    cells = [f"{value:.3f}" for value in level]
    # at a block's edge, over several blocks, at the ends
    for begin, end in ((0, 3), (695, 705), (1500, 3000), (4200, 4201), (4998, COUNT)):
        cells[begin:end] = ["NA"] * (end - begin)
    begin_at = datetime(2020, 1, 1, 9)
    rows = (
        f"{begin_at + timedelta(seconds=int(s))},{cell},{i % 97}\n"
        for i, (s, cell) in enumerate(zip(at, cells, strict=True))
    )
    return f"time,{kind} (m),other\n" + "".join(rows)


def both(folder: Path, text: str, patch: pytest.MonkeyPatch, **options: Any) -> list[Timeline]:
    streams = load(folder, text, **options)
    with patch.context() as context:
        context.setattr(streamed, "LONG_ROWS", 10**9)
        pieces = load(folder, text, **options)
    assert noted(streams, f"of {COUNT} samples, events are found among")
    assert not noted(pieces, "events are found among")
    return [streams, pieces]


@pytest.mark.usefixtures("short")
@pytest.mark.parametrize("even", [True, False])
@pytest.mark.parametrize(
    "wish",
    ["level", "change", "activity", "change:percent", "volatility:40", "volatility:2h", "other"],
)
def test_a_stream_gives_the_same_timeline(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, even: bool, wish: str
) -> None:
    text = made(even)
    stream, piece = both(tmp_path, text, monkeypatch, value="level", map=wish)
    assert stream.duration_s == piece.duration_s
    assert stream.start == piece.start
    assert stream.gaps == piece.gaps
    assert stream.intensity is not None
    assert piece.intensity is not None
    assert stream.intensity.unit == piece.intensity.unit
    assert isinstance(stream.intensity.time_s, RegularTimes) is even
    at = np.linspace(1.0, stream.duration_s - 1.0, 3001)
    mine, theirs = stream.intensity_at(at), piece.intensity_at(at)
    near = np.isclose(mine, theirs, rtol=1e-6, atol=1e-6)
    # the first changes after a gap may come from another block
    assert near.mean() >= (1.0 if wish in ("level", "other") else 0.98)


@pytest.mark.usefixtures("short")
def test_a_stream_finds_the_same_extremes_moves_and_ticks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stream, piece = both(tmp_path, made(even=False), monkeypatch, value="level")
    for kind in ("highest", "lowest", "largest_rise", "largest_fall", "day", "hour"):
        assert [event for event in stream.events if event.kind == kind] == [
            event for event in piece.events if event.kind == kind
        ]
    turns = [
        {e.time_s for e in t.events if e.kind in ("peak", "trough", "record_high", "record_low")}
        for t in (stream, piece)
    ]
    assert turns[0] == turns[1]


@pytest.mark.usefixtures("short")
def test_a_long_series_out_of_order_is_refused_with_its_line(tmp_path: Path) -> None:
    lines = made(even=True).splitlines(keepends=True)
    lines[2500], lines[2501] = lines[2501], lines[2500]
    words = refusal(lambda: load(tmp_path, "".join(lines), value="level"))
    assert "line 2502: earlier than the row before it" in words
    assert "sort it by time" in words


@pytest.mark.usefixtures("short")
def test_rows_of_one_time_count_once_at_the_edge_of_blocks_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    header, *lines = made(even=True).splitlines(keepends=True)
    for i in range(600, 4000, 50):
        moment, _, other = lines[i].split(",")
        lines[i] += f"{moment},{i / 10},{other}"
    stream, piece = both(tmp_path, header + "".join(lines), monkeypatch, value="level")
    assert stream.gaps == piece.gaps
    at = np.linspace(1.0, stream.duration_s - 1.0, 3001)
    assert np.allclose(stream.intensity_at(at), piece.intensity_at(at), rtol=1e-9)


@pytest.mark.usefixtures("short")
def test_a_wrong_cell_late_in_a_long_series_is_named(tmp_path: Path) -> None:
    lines = made(even=True).splitlines(keepends=True)
    lines[4321] = lines[4321].rpartition(",")[0].rpartition(",")[0] + ",x,1\n"
    words = refusal(lambda: load(tmp_path, "".join(lines), value="level"))
    assert "line 4322, column 'level (m)': 'x' isn't a number" in words


def test_thinning_keeps_what_is_prominent() -> None:
    random = np.random.default_rng(0)
    value = np.cumsum(random.normal(0.0, 1.0, 300_000))
    step = np.diff(value, prepend=np.nan)
    thinner = Thinner()
    at = np.arange(len(value), dtype=np.float64)
    for begin in range(0, len(value), 70_001):
        part = slice(begin, begin + 70_001)
        thinner.add(at[part], value[part], step[part])
    kept_at, kept, kept_step = thinner.finish()
    assert len(kept) < len(value) / 10
    assert np.array_equal(kept, value[kept_at.astype(int)])
    assert {value.argmax(), value.argmin(), np.nanargmax(step), np.nanargmin(step)} <= set(kept_at)
    found, prominence = peaks(kept)
    theirs, about = signal.find_peaks(value, prominence=50.0)
    assert set(theirs) == set(kept_at[found[prominence >= 50.0]].astype(int))
    assert np.allclose(sorted(about["prominences"]), sorted(prominence[prominence >= 50.0]))
    assert np.nanmax(kept_step) == np.nanmax(step)


def test_the_lowest_and_highest_value_of_each_run_are_kept() -> None:
    value = np.array([3.0, 1.0, 1.0, 5.0, 2.0, 2.0, 9.0])
    assert lows_and_highs(value, 3).tolist() == [0, 1, 3, 4, 6]


@pytest.mark.soak
def test_a_hundred_million_rows_are_read_in_bounded_memory(tmp_path: Path) -> None:
    pa = pytest.importorskip("pyarrow", reason="needs pyarrow")
    pq = pytest.importorskip("pyarrow.parquet")
    path, count, part = tmp_path / "long.parquet", 100_000_000, 1_000_000
    random = np.random.default_rng(0)
    schema = pa.schema([("time", pa.timestamp("ms")), ("level", pa.float64())])
    with pq.ParquetWriter(path, schema) as writer:
        for first in range(0, count, part):
            at = np.arange(first, first + part)
            level = np.sin(at / 3e6) + random.normal(0.0, 0.01, part)
            if first == 70 * part:
                level[1234] = 9.0
            times = np.datetime64("2020-01-01", "ms") + at * np.timedelta64(10, "ms")
            writer.write_table(pa.table({"time": times, "level": level}, schema=schema))
    parts: list[float] = []
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    began = time.monotonic()
    timeline = load_timeline(path, progress=parts.append)
    took = time.monotonic() - began
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(
        f"\n{count} rows, {path.stat().st_size / 2**20:.0f} MB of Parquet: read in {took:.0f} s, "
        f"peak memory {peak:.0f} MB ({before:.0f} MB before)",
        file=sys.stderr,
    )
    assert timeline.intensity is not None
    assert timeline.intensity.count == count
    assert timeline.duration_s == (count - 1) / 100.0
    (highest,) = [e for e in timeline.events if e.kind == "highest"]
    assert highest.time_s == (70 * part + 1234) / 100.0
    assert timeline.intensity_at(highest.time_s) == 9.0
    assert parts == sorted(parts)
    assert parts[-1] == 1.0
    assert peak < 1024.0
