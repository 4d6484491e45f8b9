"""Objects of other libraries: each read right, or refused in one line with the remedy."""

from __future__ import annotations

import datetime as dt
import importlib.util
import io
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pytest

import overview_dsp as ov
from tests.data.readers.make_cardiac import beat_times, ecg
from tests.data.readers.statsbomb_match import full_match
from tests.data.readers.truths import Input, Refused, Series, check, parametrized

DAY = 86_400.0
DAYS = pd.date_range("2024-01-01", periods=4)
VALUES = [3.0, 1.0, 4.0, 1.5]
SECONDS = [0.0, 1.0, 2.0, 3.0]
BY_DAY = Series(VALUES, [0, DAY, 2 * DAY, 3 * DAY], "2024-01-01T00:00:00")
BY_SECOND = Series(VALUES, SECONDS)


def needs(library: str) -> Any:
    missing = importlib.util.find_spec(library) is None
    return pytest.mark.skipif(missing, reason=f"needs {library}")


# --- frames with whole numbers as headers, series without names, units and prices

HEADERS = [
    Input("a frame of an array", lambda: pd.DataFrame(np.c_[SECONDS, VALUES]), BY_SECOND),
    Input("dates under 0", lambda: pd.DataFrame({0: DAYS, 1: VALUES}), BY_DAY),
    Input("an index and a column 0", lambda: pd.DataFrame({0: VALUES}, index=DAYS), BY_DAY),
    Input("other whole numbers", lambda: pd.DataFrame({2019: DAYS, 2020: VALUES}), BY_DAY),
    Input("a rate", lambda: pd.DataFrame({0: VALUES}), BY_SECOND, {"rate": 1.0}),
    Input("a column by its number", lambda: pd.DataFrame({0: DAYS, 1: SECONDS, 2: VALUES}), BY_DAY,
          {"value": "2"}),
    Input("several columns", lambda: pd.DataFrame({0: DAYS, 1: SECONDS, 2: VALUES}),
          Refused(("which column is the value", "'1'", "'2'"))),
    Input("headers of two kinds", lambda: pd.DataFrame({"date": DAYS, 7: VALUES}), BY_DAY),
    Input("tuples of headers", lambda: pd.DataFrame({("a", 0): VALUES}, index=DAYS), BY_DAY),
    Input("the same header twice", lambda: pd.DataFrame([[1, 2], [3, 4]], columns=[1, 1]),
          Refused(("1",))),
]  # fmt: skip

BARE = [
    Input("pandas with dates", lambda: pd.Series(VALUES, index=DAYS), BY_DAY),
    Input("pandas at a rate", lambda: pd.Series(VALUES), BY_SECOND, {"rate": 1.0}),
    Input("pandas without times", lambda: pd.Series(VALUES), Refused(("rate",))),
    Input("pandas called 0", lambda: pd.DataFrame({0: VALUES}, index=DAYS)[0], BY_DAY),
    Input("pandas with times apart", lambda: pd.Series(VALUES), BY_DAY, {"time": DAYS}),
    Input("polars at a rate", lambda: pl.Series(VALUES), BY_SECOND, {"rate": 1.0}),
    Input("polars with times apart", lambda: pl.Series(VALUES), BY_DAY,
          {"time": pl.Series(DAYS.to_pydatetime())}),
    Input("seconds as an index", lambda: pd.Series(VALUES, index=[0.0, 1.0, 2.0, 3.0]), BY_SECOND),
    Input("spans as an index", lambda: pd.Series(VALUES, index=pd.to_timedelta(SECONDS, unit="s")),
          BY_SECOND),
    Input("whole numbers as an index", lambda: pd.Series(VALUES, index=[3, 5, 8, 9]),
          Refused(("rate", "time"))),
]  # fmt: skip


def priced(name: Any) -> pd.Series:
    return pd.Series([100.0, 50.0, 75.0, 60.0], index=DAYS, name=name)


def with_attrs(data: Any, **attrs: Any) -> Any:
    data.attrs.update(attrs)
    return data


def kept(unit: str) -> Series:
    return Series(VALUES, BY_DAY.seconds, BY_DAY.start, unit)


SHARES = {("Close", "AAPL"): [100.0, 50.0, 75.0, 60.0], ("Close", "IBM"): [1.0, 2.0, 3.0, 4.0]}
PRICES = Series([100.0, 50.0, 75.0, 60.0], BY_DAY.seconds, noted="steps are in per cent")
ROLES = [
    Input("a unit in a name", lambda: pd.Series(VALUES, index=DAYS, name="load (kW)"), kept("kW")),
    Input("units of a frame", lambda: with_attrs(
        pd.DataFrame({"load": VALUES}, index=DAYS), units={"load": "kW"}), kept("kW")),
    Input("the unit of a series", lambda: with_attrs(
        pd.Series(VALUES, index=DAYS, name="load"), units="kW"), kept("kW")),
    Input("the unit of a series without a name", lambda: with_attrs(
        pd.Series(VALUES, index=DAYS), unit="kW"), kept("kW")),
    Input("no unit", lambda: pd.Series(VALUES, index=DAYS, name="load"), kept("")),
    Input("a price", lambda: priced("Close"), PRICES),
    Input("a price of two headers", lambda: priced(("Close", "AAPL")), PRICES),
    Input("a price among shares", lambda: pd.DataFrame(SHARES, index=DAYS), PRICES,
          {"value": "Close AAPL"}),
    Input("times apart", lambda: priced("Close").reset_index(drop=True), PRICES, {"time": DAYS}),
    Input("a currency", lambda: with_attrs(priced("level"), units="USD"), PRICES),
    Input("a price in polars", lambda: pl.DataFrame(
        {"date": DAYS.to_pydatetime(), "close": PRICES.values}), PRICES),
]  # fmt: skip


@parametrized(HEADERS, BARE, ROLES)
def test_a_frame_or_series_is_read_right_or_refused(made: Input, tmp_path: Path) -> None:
    check(made, tmp_path)


# --- xarray and Arrow


def grid(name: str | None = "t2m", dims: tuple[str, ...] = ("time",), **attrs: Any) -> Any:
    import xarray

    shape = (4, *(2,) * (len(dims) - 1))
    data = np.broadcast_to(np.reshape(VALUES, (4, *(1,) * (len(dims) - 1))), shape)
    coords = {"time": DAYS, **{d: [10.0, 20.0] for d in dims[1:]}}
    made = xarray.DataArray(data, coords, dims, name, attrs)
    return made.assign_coords(height=2.0)


XARRAY = [
    Input("an array", grid, BY_DAY),
    Input("an array without a name", lambda: grid(None), BY_DAY),
    Input("its unit", lambda: grid(units="degC"), kept("degC")),
    Input("a data set", lambda: grid(units="K").to_dataset(), kept("K")),
    Input("a data set of two", lambda: grid().to_dataset().assign(u=grid("u")),
          Refused(("which column is the value", "t2m", "u"))),
    Input("one of two", lambda: grid().to_dataset().assign(u=2.0 * grid("u")), BY_DAY,
          {"value": "t2m"}),
    Input("two dimensions", lambda: grid(dims=("time", "lat")), Refused(("lat", "--select"))),
    Input("one place", lambda: grid(dims=("time", "lat")).sel(lat=10.0), BY_DAY),
    Input("three dimensions", lambda: grid(dims=("time", "lat", "lon")), Refused(("lat", "lon"))),
    Input("one place of two, chosen", lambda: grid(dims=("time", "lat")), BY_DAY,
          {"match": "lat=10"}),
    Input("without times", lambda: grid().drop_vars("time"), Refused(("rate",))),
]  # fmt: skip


@needs("xarray")
@parametrized(XARRAY)
def test_xarray_is_read_right_or_refused(made: Input, tmp_path: Path) -> None:
    check(made, tmp_path)


def arrow(**columns: Any) -> Any:
    import pyarrow

    return pyarrow.table({name: pyarrow.array(column) for name, column in columns.items()})


def arrow_unit(key: bytes) -> Any:
    import pyarrow

    fields = [pyarrow.field("date", "timestamp[us]"),
              pyarrow.field("load", "float64", metadata={key: b"kW"})]  # fmt: skip
    return arrow(date=DAYS, load=VALUES).cast(pyarrow.schema(fields))


def arrow_of(form: str) -> Any:
    import pyarrow

    text = pyarrow.array(["2024-01-01", "2024-01-02", "2024-01-03", "2024-01-04"])
    moments = pyarrow.array(DAYS)
    made = {
        "texts": text,
        "dictionary": text.dictionary_encode(),
        "days": moments.cast("date32"),
        "zoned": moments.cast("timestamp[ms]").cast(pyarrow.timestamp("ms", "UTC")),
    }[form]
    return pyarrow.table({"date": made, "load": pyarrow.array(VALUES)})


ARROW = [
    Input("a table", lambda: arrow(date=DAYS, load=VALUES), BY_DAY),
    Input("a batch", lambda: arrow(date=DAYS, load=VALUES).to_batches()[0], BY_DAY),
    Input("a reader", lambda: arrow(date=DAYS, load=VALUES).to_reader(), BY_DAY),
    Input("a column in parts", lambda: arrow(load=VALUES)["load"], BY_SECOND, {"rate": 1.0}),
    Input("an array", lambda: arrow(load=VALUES)["load"].combine_chunks(), BY_SECOND,
          {"rate": 1.0}),
    Input("a unit", lambda: arrow_unit(b"unit"), kept("kW")),
    Input("units", lambda: arrow_unit(b"units"), kept("kW")),
    Input("texts", lambda: arrow_of("texts"), BY_DAY),
    Input("a dictionary", lambda: arrow_of("dictionary"), BY_DAY),
    Input("days", lambda: arrow_of("days"), BY_DAY),
    Input("times in a zone", lambda: arrow_of("zoned"),
          Series(VALUES, BY_DAY.seconds, "2024-01-01T00:00:00+00:00")),
    Input("without times", lambda: arrow(load=VALUES), Refused(("rate",))),
]  # fmt: skip


@needs("pyarrow")
@parametrized(ARROW)
def test_arrow_is_read_right_or_refused(made: Input, tmp_path: Path) -> None:
    check(made, tmp_path)


# --- frames of football libraries


def statsbombpy() -> pd.DataFrame:
    """The frame that statsbombpy makes of a match: sorted by type, attributes flattened."""
    rows = []
    for index, event in enumerate(full_match(), 1):
        row: dict[str, Any] = {**event, "index": index, "possession": 1, "location": [60.0, 40.0]}
        section = event["type"]["name"].lower().replace(" ", "_")
        row |= {f"{section}_{key}": value for key, value in row.pop(section, {}).items()}
        names = {k: v["name"] for k, v in row.items() if isinstance(v, dict) and "name" in v}
        rows.append(row | names | {"team_id": 1})
    rows.sort(key=lambda row: row["type"])
    return pd.DataFrame(rows)[sorted({key for row in rows for key in row})]


def mplsoccer() -> pd.DataFrame:
    """The frame that mplsoccer makes of a match: names in columns of their own."""
    rows = []
    for index, event in enumerate(full_match(), 1):
        row = {
            "id": event["id"], "index": index, "period": event["period"], "minute": 0, "second": 0,
            "timestamp": dt.time.fromisoformat(event["timestamp"]),
            "type_name": event["type"]["name"], "team_name": event["team"]["name"],
            "player_name": event.get("player", {}).get("name"), "possession_team_name": "Northport",
        }  # fmt: skip
        shot = event.get("shot", {})
        row["outcome_name"] = shot.get("outcome", {}).get("name")
        row["sub_type_name"] = shot.get("type", {}).get("name")
        row["shot_statsbomb_xg"] = shot.get("statsbomb_xg")
        for section in ("foul_committed", "bad_behaviour"):
            row[f"{section}_card_name"] = event.get(section, {}).get("card", {}).get("name")
        row["block_save_block"] = event.get("block", {}).get("save_block")
        rows.append(row)
    return pd.DataFrame(rows)


def spans(frame: pd.DataFrame) -> pd.DataFrame:
    clocks = frame["timestamp"].astype(str)
    return frame.assign(timestamp=pd.to_timedelta(clocks))


def to_csv(frame: pd.DataFrame) -> io.BytesIO:
    return io.BytesIO(frame.to_csv(index=False).encode())


FRAMES = {
    "statsbombpy": statsbombpy,
    "statsbombpy as CSV": lambda: to_csv(statsbombpy()),
    "statsbombpy, mixed": lambda: statsbombpy().sample(frac=1.0, random_state=3),
    "statsbombpy in polars": lambda: pl.from_pandas(statsbombpy().drop(columns="location")),
    "statsbombpy, spans": lambda: spans(statsbombpy()),
    "statsbombpy, an index": lambda: statsbombpy().set_index("id"),
    "statsbombpy, few columns": lambda: statsbombpy().drop(columns=["location", "minute"]),
    "statsbombpy, broken indices": lambda: (
        statsbombpy().sort_values(["period", "timestamp"]).assign(index="1.2.3")
    ),
    "mplsoccer": mplsoccer,
    "mplsoccer as CSV": lambda: to_csv(mplsoccer()),
    "mplsoccer, spans": lambda: spans(mplsoccer()),
    "mplsoccer in polars": lambda: pl.from_pandas(mplsoccer()),
}


@pytest.mark.parametrize("made", FRAMES)
def test_a_frame_of_a_match_is_the_match_of_its_file(made: str) -> None:
    if "polars" in made:
        pytest.importorskip("pyarrow", reason="needs pyarrow")
    expected = ov.load_timeline(full_match())
    found = ov.load_timeline(FRAMES[made]())
    # the ids that relate a block to its shot are in a frame of their own
    apart = {"blocked on the line"} if "outcome_name" in mplsoccer_columns(FRAMES[made]) else set()
    assert found.duration_s == expected.duration_s
    listed = [event for event in expected.events if not any(a in event.label for a in apart)]
    assert list(found.events) == listed
    assert found.title == expected.title


def mplsoccer_columns(made: Any) -> set[str]:
    data = made()
    return set(pd.read_csv(data).columns) if isinstance(data, io.BytesIO) else set(data.columns)


BROKEN = [
    Input("a clock that is none", lambda: statsbombpy().assign(timestamp="later"),
          Refused(("timestamp", "later"))),
    Input("a card that is none", lambda: mplsoccer().assign(foul_committed_card_name="blue"),
          Refused(("card", "blue"))),
    Input("no periods", lambda: statsbombpy().assign(period=None), Refused(("period",))),
    Input("two matches", lambda: pd.concat([mplsoccer().assign(match_id=n) for n in (7, 8)]),
          Refused(("2 matches (match_id 7, 8", "keep the rows of one"))),
    Input("a clock that is a square", lambda: statsbombpy().assign(timestamp="²"),
          Refused(("timestamp", "²"))),
]  # fmt: skip


@parametrized(BROKEN)
def test_a_broken_frame_of_a_match_is_refused(made: Input, tmp_path: Path) -> None:
    check(made, tmp_path)


# --- arrays of sound, of hearts, and of neither

NOISE = np.random.default_rng(5)
SOUND = np.concatenate(
    (0.01 * NOISE.standard_normal(160_000), 0.3 * NOISE.standard_normal(160_000))
)


def heart(rate: float) -> Any:
    return ecg(beat_times(20.0), 20.0, rate)


ARRAYS: dict[str, tuple[Any, float, str]] = {
    "frames": (lambda: SOUND, 16_000, "LUFS"),
    "frames at 8 kHz": (lambda: SOUND, 8_000, "LUFS"),
    "frames x channels": (lambda: np.c_[SOUND, SOUND], 16_000, "LUFS"),
    "channels x frames": (lambda: np.stack((SOUND, SOUND)), 16_000, "LUFS"),
    "one channel": (lambda: SOUND[:, None], 16_000, "LUFS"),
    "16 bits": (lambda: (SOUND * 32_767).clip(-32_767, 32_767).astype(np.int16), 16_000, "LUFS"),
    "32 bits of float": (lambda: SOUND.astype(np.float32), 16_000, "LUFS"),
    "a list": (lambda: SOUND.tolist(), 16_000, "LUFS"),
    "a heart": (lambda: heart(250.0), 250.0, "bpm"),
    "a heart at 1 kHz": (lambda: heart(1000.0), 1000.0, "bpm"),
}


@pytest.mark.parametrize("name", ARRAYS)
def test_samples_are_a_sound_a_heart_or_a_series(name: str) -> None:
    make, rate, unit = ARRAYS[name]
    data = make()
    timeline = ov.load_timeline(data, rate=rate)
    assert timeline.intensity is not None
    assert timeline.intensity.unit == unit
    frames = max(np.shape(data))
    assert timeline.duration_s == pytest.approx(frames / rate, abs=2.0 / rate)
    told = " ".join((timeline.provenance, *timeline.notes))
    if unit == "LUFS":
        assert "sound" in told
        level = timeline.intensity.value
        assert (
            np.median(level[len(level) // 2 + 30 :]) - np.median(level[: len(level) // 2 - 30]) > 25
        )
    else:
        assert "beats found" in told


@pytest.mark.parametrize(
    ("data", "rate"),
    [(np.cumsum(NOISE.standard_normal(20_000)), 100.0), (np.sin(np.arange(40_000) / 3.0), 2000.0)],
    ids=["a walk", "a tone"],
)
def test_samples_below_8_khz_without_beats_are_refused_or_a_series(data: Any, rate: float) -> None:
    with pytest.raises(ov.InputError, match="--map level"):
        ov.load_timeline(data, rate=rate)
    timeline = ov.load_timeline(data, rate=rate, map="level")
    assert timeline.intensity is not None
    assert timeline.intensity.count == len(data)


def test_samples_above_8_khz_are_a_series_by_request() -> None:
    timeline = ov.load_timeline(SOUND, rate=16_000, map="level")
    assert timeline.intensity is not None
    assert timeline.intensity.count == len(SOUND)
    assert ov.load_timeline(SOUND, rate=16_000, map="momentary").intensity is not None
    silent = np.full(16_000, np.nan)
    with pytest.raises(ov.InputError, match="no sample is a number"):
        ov.load_timeline(silent, rate=16_000)


def test_loudness_of_an_array_is_that_of_its_file(tmp_path: Path) -> None:
    soundfile = pytest.importorskip("soundfile")
    samples = np.c_[SOUND, 0.5 * SOUND].clip(-0.99, 0.99)
    soundfile.write(tmp_path / "a.wav", samples, 16_000, subtype="DOUBLE")
    one, other = ov.load_timeline(tmp_path / "a.wav"), ov.load_timeline(samples, rate=16_000)
    assert one.intensity == other.intensity
    assert one.events == other.events
