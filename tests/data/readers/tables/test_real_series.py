"""The true extremes, moves, splits and dates of other people's series."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.timeline import Timeline
from tests.data.readers.tables.made import noted


def only(timeline: Timeline, kind: str) -> tuple[str, float]:
    """The day (and value) of the only event of a kind."""
    (event,) = [event for event in timeline.events if event.kind == kind]
    return day_of(timeline, event.time_s), float(timeline.intensity_at(event.time_s))


def day_of(timeline: Timeline, time_s: float) -> str:
    assert timeline.start is not None
    return str(np.datetime64(timeline.start) + np.timedelta64(round(time_s), "s"))[:10]


def moves(timeline: Timeline, kind: str) -> dict[str, str]:
    """Days and sizes of the largest moves."""
    return {
        day_of(timeline, event.time_s): event.label.partition(" to ")[0]
        for event in timeline.events
        if event.kind == kind
    }


@pytest.mark.parametrize("column", [None, "adjclose", "close"])
def test_the_sp500s_extremes_and_its_best_and_worst_day(
    data_folder: Path, column: str | None
) -> None:
    timeline = load_timeline(data_folder / "stocks" / "sp500-2000.csv", value=column)
    assert only(timeline, "highest") == ("2020-02-19", 3386.149902)
    assert only(timeline, "lowest") == ("2009-03-09", 676.530029)
    assert moves(timeline, "largest_fall")["2020-03-16"] == "-11.98 %"
    assert moves(timeline, "largest_rise")["2008-10-13"] == "+11.58 %"
    weights = {e.label: e.weight for e in timeline.events if e.kind == "largest_fall"}
    assert max(weights, key=weights.__getitem__).startswith("-11.98 %")
    assert timeline.start == datetime(2000, 1, 3)
    assert timeline.duration_s == 7410 * 86_400.0
    assert timeline.intensity is not None
    assert len(timeline.intensity.value) == 5105
    assert timeline.gaps == ()  # not even 2001-09-10 to 17
    assert "split" not in timeline.kinds()
    assert noted(timeline, "column 'adjclose'") is (column is None)


def test_a_closing_price_with_splits_is_pointed_out_and_its_crash_is_none(
    data_folder: Path,
) -> None:
    timeline = load_timeline(data_folder / "stocks" / "bokeh_AAPL.csv", value="Close")
    assert only(timeline, "highest") == ("2012-09-19", 702.10)
    assert only(timeline, "lowest") == ("2003-04-17", 13.12)
    splits = [e for e in timeline.events if e.kind == "split"]
    assert [day_of(timeline, e.time_s) for e in splits] == ["2000-06-21", "2005-02-28"]
    assert all(e.label.startswith("2:1 split") for e in splits)
    falls = moves(timeline, "largest_fall")
    assert falls["2000-09-29"] == "-51.87 %"
    assert not {"2000-06-21", "2005-02-28"} & set(falls)
    assert noted(timeline, "2:1 on 2000-06-21 (101.25 to 55.63)")
    assert noted(timeline, "2:1 on 2005-02-28 (88.99 to 44.86)")
    assert noted(timeline, "select the adjusted column 'Adj Close' with value (--value-column)")


@pytest.mark.parametrize("left", ["Date,Close", "Date,Open,Close", "Date,Open,Close,Volume"])
def test_splits_are_distinguished_from_the_crash_without_an_adjusted_column(
    data_folder: Path, tmp_path: Path, left: str
) -> None:
    rows = (data_folder / "stocks" / "bokeh_AAPL.csv").read_text().splitlines()
    header = rows[0].split(",")
    kept = [header.index(name) for name in left.split(",")]
    path = tmp_path / "aapl.csv"
    path.write_text("\n".join(",".join(row.split(",")[i] for i in kept) for row in rows))
    timeline = load_timeline(path, value="Close")
    splits = [day_of(timeline, e.time_s) for e in timeline.events if e.kind == "split"]
    assert "2000-09-29" not in splits
    assert "2005-02-28" in splits
    if "Open" in left:
        assert splits == ["2000-06-21", "2005-02-28"]
    assert moves(timeline, "largest_fall")["2000-09-29"] == "-51.87 %"
    assert noted(timeline, "the table has no adjusted column")


def test_the_adjusted_close_of_a_table_of_prices_is_taken_and_has_no_splits(
    data_folder: Path,
) -> None:
    timeline = load_timeline(data_folder / "stocks" / "bokeh_AAPL.csv")
    assert timeline.title == "bokeh_AAPL: Adj Close"
    assert "split" not in timeline.kinds()
    assert only(timeline, "highest")[0] == "2012-09-19"
    assert moves(timeline, "largest_fall")["2000-09-29"] == "-51.87 %"
    assert noted(timeline, "the close adjusted for splits and dividends")


def test_ibms_highest_close(data_folder: Path) -> None:
    timeline = load_timeline(data_folder / "stocks" / "bokeh_IBM.csv", value="Close")
    assert only(timeline, "highest") == ("2012-10-16", 211.00)
    assert "split" not in timeline.kinds()
    assert timeline.gaps == ()


@pytest.mark.parametrize(
    ("column", "kind", "day", "value"),
    [
        ("temp_max", "highest", "2014-08-11", 35.6),
        ("temp_min", "lowest", "2013-12-07", -7.1),
        ("precipitation", "highest", "2015-03-15", 55.9),
    ],
)
def test_the_hottest_coldest_and_wettest_day_of_seattle(
    data_folder: Path, column: str, kind: str, day: str, value: float
) -> None:
    timeline = load_timeline(data_folder / "weather" / "seattle-weather.csv", value=column)
    assert only(timeline, kind) == (day, value)
    assert timeline.intensity is not None
    assert len(timeline.intensity.value) == 1461
    assert timeline.duration_s == 1460 * 86_400.0
    assert timeline.gaps == ()


def test_the_warmest_hour_of_seattle(data_folder: Path) -> None:
    path = data_folder / "weather" / "seattle-weather-hourly-normals.csv"
    timeline = load_timeline(path, value="temperature")
    (event,) = [event for event in timeline.events if event.kind == "highest"]
    assert event.label == "highest 24.4, 2010-07-28 16:00"
    assert event.time_s == (datetime(2010, 7, 28, 16) - datetime(2010, 1, 1, 1)).total_seconds()


def test_seattle_asks_which_of_its_columns(data_folder: Path) -> None:
    with pytest.raises(ValueError, match="'precipitation', 'temp_max', 'temp_min', 'wind'; name"):
        load_timeline(data_folder / "weather" / "seattle-weather.csv")


@pytest.mark.parametrize(
    ("file", "value"),
    [
        ("stocks/sp500-2000.csv", None),
        ("stocks/bokeh_AAPL.csv", "Close"),
        ("weather/seattle-weather.csv", "wind"),
        ("weather/seattle-weather-hourly-normals.csv", "pressure"),
    ],
)
def test_a_series_has_events_for_a_hand_and_not_hundreds(
    data_folder: Path, file: str, value: str | None
) -> None:
    timeline = load_timeline(data_folder / file, value=value)
    assert 20 <= len(timeline.events) <= 90
