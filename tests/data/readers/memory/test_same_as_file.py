"""The same data as a file, a frame, an array, a list, bytes or an open file: the same Timeline."""

from __future__ import annotations

import dataclasses
import datetime as dt
import importlib.util
import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pytest

import overview_dsp as ov
from tests.data.readers.statsbomb_match import full_match

HOURLY = "time,temp (°C),place\n" + "".join(
    f"2021-03-0{1 + i // 24} {i % 24:02d}:00,{value},town\n"
    for i, value in enumerate(np.round(20.0 + 8.0 * np.sin(np.arange(72) / 3.7), 2))
)
GAPPY = "date,load\n2020-01-01,3.5\n2020-01-02,\n2020-01-03,4\n2020-01-04,6\n2020-01-09,1\n"
ZONED = "t,x\n" + "".join(f"2021-06-01T{h:02d}:30:00+02:00,{h * h % 7}\n" for h in range(9))
SECONDS = "t_s,x\n" + "".join(f"{i / 8},{i * 37 % 11}\n" for i in range(40))
EVENTS = 'time_s,kind,label,weight\n1.5,goal,"1-0, pen",1\n4,foul,,0.5\n9,period,"a ""half""",1\n'
MINUTES = "minute,type,player,team\n18,own goal,Mandžukić,Croatia\n28,goal,Perišić,Croatia\n"
DATED = "date,event,note\n2021-03-01 09:30,launch,first try\n2021-03-01 10:00,landing,\n"
NUMBERED = "time_s,kind,label\n1,a,3\n2,b,\n4,c,12\n"
SERIES = {"hourly": HOURLY, "gaps": GAPPY, "zoned": ZONED, "seconds": SECONDS}


def bare(timeline: ov.Timeline) -> ov.Timeline:
    """Without where it is from: a file has a name, and lines in place of rows."""
    return dataclasses.replace(timeline, title="", provenance="")


def in_its_zone(frame: pl.DataFrame) -> pl.DataFrame:
    """Polars makes UTC of times with an offset: back to two hours before it, as ZONED has them."""
    first = frame.columns[0]
    if getattr(frame[first].dtype, "time_zone", None) is None:
        return frame
    return frame.with_columns(pl.col(first).dt.convert_time_zone("Etc/GMT-2"))


def other_ways(text: str) -> Iterator[tuple[str, Any]]:
    """The table of a text as everything it may be in memory."""
    yield "bytes", text.encode()
    yield "a text in memory", io.StringIO(text)
    yield "an open file", io.BytesIO(text.encode())
    for name, frame in {
        "pandas": pd.read_csv(io.StringIO(text)),
        "pandas, dates": pd.read_csv(io.StringIO(text), parse_dates=[0] if "2021-" in text else []),
        "polars": pl.read_csv(text.encode()),
        "polars, dates": in_its_zone(pl.read_csv(text.encode(), try_parse_dates=True)),
        "pandas, an index": pd.read_csv(io.StringIO(text), index_col=0),
    }.items():
        yield name, frame
    frame = pd.read_csv(io.StringIO(text))
    if importlib.util.find_spec("pyarrow") is not None:
        yield "Arrow", pl.read_csv(text.encode()).to_arrow()
    yield "a dict", frame.to_dict("list")
    yield "records", frame.to_dict("records")
    yield "rows with names", [list(frame.columns), *frame.itertuples(index=False, name=None)]
    yield "named fields", frame.to_records(index=False)


def as_file(folder: Path, text: str, **options: Any) -> ov.Timeline:
    path = folder / "table.csv"
    path.write_text(text, encoding="utf-8")
    return bare(ov.load_timeline(path, **options))


@pytest.mark.parametrize("name", SERIES)
def test_a_series_is_the_same_whatever_holds_it(name: str, tmp_path: Path) -> None:
    text = SERIES[name]
    expected = as_file(tmp_path, text)
    assert expected.intensity is not None
    for way, data in other_ways(text):
        assert bare(ov.load_timeline(data)) == expected, way


@pytest.mark.parametrize("text", [EVENTS, MINUTES, DATED, NUMBERED])
def test_events_are_the_same_whatever_holds_them(text: str, tmp_path: Path) -> None:
    expected = as_file(tmp_path, text)
    assert expected.events
    for way, data in other_ways(text):
        if way != "pandas, an index" and way != "Arrow":
            assert bare(ov.load_timeline(data)) == expected, way


def test_events_as_tuples_and_as_events_are_those_of_their_list(tmp_path: Path) -> None:
    expected = as_file(tmp_path, EVENTS)
    rows = [(1.5, "goal", "1-0, pen", 1), (4, "foul", "", 0.5), (9, "period", 'a "half"', 1.0)]
    assert bare(ov.load_timeline(rows)) == expected
    assert bare(ov.load_timeline(expected.events)) == expected
    short = ov.load_timeline([(2.0, "goal", "1-0"), (8.0, "foul")], duration_s=10.0)
    assert short.events == (ov.Event(2.0, "goal", "1-0"), ov.Event(8.0, "foul"))


@pytest.mark.parametrize("column", [np.arange(5.0) ** 2 % 7, np.array([1, 5, 2, 8, 3])])
def test_samples_are_those_of_a_file_of_one_column(
    column: np.ndarray[Any, Any], tmp_path: Path
) -> None:
    text = "value\n" + "\n".join(map(str, column.tolist())) + "\n"
    expected = as_file(tmp_path, text, rate=4.0)
    for data in (column, column.tolist(), pd.Series(column), pl.Series(column), column[:, None]):
        assert bare(ov.load_timeline(data, rate=4.0)) == expected


def test_times_of_their_own_are_a_column_of_times(tmp_path: Path) -> None:
    days = pd.date_range("2020-01-01", periods=4)
    value = [3.0, 1.0, 4.0, 1.5]
    text = "time,value\n" + "".join(f"{d:%Y-%m-%d},{v}\n" for d, v in zip(days, value, strict=True))
    expected = as_file(tmp_path, text)
    for times in (days, days.to_numpy(), list(days.date), pl.Series(days.to_pydatetime())):
        assert bare(ov.load_timeline(value, time=times)) == expected
    assert bare(ov.load_timeline(pd.Series(value, index=days))) == expected
    pairs = list(zip(days.to_pydatetime(), value, strict=True))
    assert ov.load_timeline(pairs).intensity == expected.intensity
    by_time = dict(zip(days.date, value, strict=True))
    assert bare(ov.load_timeline(by_time)) == expected


def test_the_columns_of_events_may_be_named(tmp_path: Path) -> None:
    text = "when,what,type,note\n1,goal,x,a\n2.5,foul,y,b\n"
    named = {"time": "when", "kind": "what", "label": "note"}
    expected = as_file(tmp_path, text, **named)
    assert expected.events == (ov.Event(1.0, "goal", "a"), ov.Event(2.5, "foul", "b"))
    assert bare(ov.load_timeline(pd.read_csv(io.StringIO(text)), **named)) == expected
    assert bare(ov.load_timeline(pl.read_csv(text.encode()), **named)) == expected


def test_events_with_dates_begin_with_the_first(tmp_path: Path) -> None:
    moments = [dt.datetime(2021, 3, 1, 9, 30), dt.datetime(2021, 3, 1, 10)]
    expected = as_file(tmp_path, DATED)
    rows = [(moments[0], "launch", "first try"), (moments[1], "landing")]
    assert bare(ov.load_timeline(rows)) == expected
    assert expected.start == moments[0]
    assert expected.events == (ov.Event(0.0, "launch", "first try"), ov.Event(1800.0, "landing"))
    zoned = pd.DataFrame({"when": pd.DatetimeIndex(moments).tz_localize("Europe/Paris")})
    zoned["what"] = ["launch", "landing"]
    start = ov.load_timeline(zoned).start
    assert start is not None
    assert start.utcoffset() == dt.timedelta(hours=1)


@pytest.mark.parametrize("way", ["count", "count:6h"])
def test_rows_and_moments_are_counted_as_those_of_a_file(way: str, tmp_path: Path) -> None:
    expected = as_file(tmp_path, HOURLY, map=way)
    assert expected.intensity is not None
    for name, data in other_ways(HOURLY):
        assert bare(ov.load_timeline(data, map=way)) == expected, name
    moments = list(pd.read_csv(io.StringIO(HOURLY), parse_dates=[0])["time"])
    counted = ov.load_timeline(moments, map=way)
    assert counted.intensity == expected.intensity
    assert ov.load_timeline([(m, "quake") for m in moments], map=way).intensity == counted.intensity


def test_a_document_is_that_of_its_json_file(tmp_path: Path) -> None:
    document = full_match()
    path = tmp_path / "match.json"
    path.write_text(json.dumps(document))
    assert bare(ov.load_timeline(document)) == bare(ov.load_timeline(path))
    native = {"overview_timeline": 1, "duration_s": 9, "events": [{"time_s": 1, "kind": "a"}]}
    assert ov.load_timeline(native).events == (ov.Event(1.0, "a"),)


def test_types_of_times_keep_their_moments() -> None:
    hours = [dt.datetime(2021, 10, 31, h, tzinfo=dt.UTC) for h in range(5)]
    value = [1.0, 4.0, 2.0, 8.0, 5.0]
    paris = pd.Series(value, index=pd.DatetimeIndex(hours).tz_convert("Europe/Paris"))
    polars = pl.DataFrame({"t": hours, "x": value}).with_columns(
        pl.col("t").dt.convert_time_zone("Europe/Paris")
    )
    for data in (paris, polars):
        timeline = ov.load_timeline(data)
        assert timeline.start == hours[0]
        assert timeline.start.utcoffset() == dt.timedelta(hours=2)
        assert timeline.duration_s == 4 * 3600.0
    spans = pd.Series(value, index=pd.to_timedelta([0, 1, 2, 3, 5], unit="min"))
    assert ov.load_timeline(spans).duration_s == 300.0
    months = pd.Series(value, index=pd.period_range("2021-01", periods=5, freq="M"))
    assert ov.load_timeline(months).start == dt.datetime(2021, 1, 1)
    assert ov.load_timeline(np.ma.masked_equal(value, 2.0), rate=1.0).gaps == ((1.0, 3.0),)


def test_clocks_are_times_of_day() -> None:
    clocks = [dt.time(8 + i // 4, 15 * (i % 4)) for i in range(12)]
    frames = ({"clock": clocks, "load": range(12)}, {"at": clocks, "what": list("abcabcabcabc")})
    for columns in frames:
        for data in (pl.DataFrame(columns), pd.DataFrame(columns), columns):
            assert ov.load_timeline(data).duration_s == 2.75 * 3600.0


def test_headers_of_two_levels_are_joined() -> None:
    days = pd.date_range("2024-01-01", periods=9)
    headers = [("Close", "AAPL"), ("Volume", "AAPL")]
    values = np.arange(18.0).reshape(9, 2) + 1.0
    frame = pd.DataFrame(values, days, pd.MultiIndex.from_tuples(headers))
    assert ov.load_timeline(frame, value="Volume").title == "Volume"
    headers.append(("Close", "IBM"))
    frame = pd.DataFrame(np.c_[values, values[:, 0]], days, pd.MultiIndex.from_tuples(headers))
    assert ov.load_timeline(frame, value="Close IBM").intensity is not None


def test_row_numbers_are_no_times() -> None:
    series = pd.Series([1.0, 3.0, 2.0, 5.0])
    for data in (series, series[series != 3.0]):
        with pytest.raises(ov.InputError, match=r"no column looks like times.*rate"):
            ov.load_timeline(data)


def test_real_files_are_the_same_in_memory(data_folder: Path) -> None:
    for name, options in {
        "stocks/bokeh_AAPL.csv": {},
        "weather/seattle-weather.csv": {"value": "temp_max"},
        "football/metrica/Sample_Game_1_RawEventsData.csv": {},
        "football/goalscorers_2010s.csv": {"match": "2014-07-08 Brazil Germany"},
    }.items():
        path = data_folder / name
        expected = bare(ov.load_timeline(path, **options))
        for data in (pd.read_csv(path), pl.read_csv(path, try_parse_dates=True)):
            assert bare(ov.load_timeline(data, **options)) == expected, name
    ecg = np.loadtxt(data_folder / "ecg" / "118e24.csv")
    heart = bare(ov.load_timeline(ecg.tolist(), rate=360.0))
    assert heart == bare(ov.load_timeline(data_folder / "ecg" / "118e24.csv", rate=360.0))
