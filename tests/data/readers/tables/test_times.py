"""Times in every usual way of writing."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import pytest

from tests.data.readers.tables.made import load, noted, refusal, times, values

DAY = 86_400.0


def series(cells: list[str], header: str = "date") -> str:
    return f"{header},level\n" + "".join(f'"{cell}",{i * i}\n' for i, cell in enumerate(cells))


@pytest.mark.parametrize(
    ("cells", "start", "seconds"),
    [
        (["2012-09-19", "2012-09-20", "2012-09-21"], datetime(2012, 9, 19), [0, DAY, 2 * DAY]),
        (["2012/9/19", "2012/9/20", "2012/9/21"], datetime(2012, 9, 19), [0, DAY, 2 * DAY]),
        (["20120919", "20120920", "20120921"], datetime(2012, 9, 19), [0, DAY, 2 * DAY]),
        (["2012-09-19 09:30", "2012-09-19 09:31"], datetime(2012, 9, 19, 9, 30), [0, 60]),
        (["2012-09-19T09:30:00.25", "2012-09-19T09:30:01"],
         datetime(2012, 9, 19, 9, 30, 0, 250_000), [0, 0.75]),
        (["2012-09-19T09:30:00Z", "2012-09-19T09:30:05Z"],
         datetime(2012, 9, 19, 9, 30, tzinfo=UTC), [0, 5]),
        (["2012-09-19T23:00:00-04:00", "2012-09-20T09:00:00+05:30"],
         datetime(2012, 9, 19, 23, tzinfo=timezone(timedelta(hours=-4))), [0, 1800]),
        (["20120919T0930", "20120919T0945"], datetime(2012, 9, 19, 9, 30), [0, 900]),
        (["2012-01", "2012-02", "2012-03"], datetime(2012, 1, 1), [0, 31 * DAY, 60 * DAY]),
        (["2012Q1", "2012Q2", "2012Q3"], datetime(2012, 1, 1), [0, 91 * DAY, 182 * DAY]),
        (["Q1 2012", "Q2 2012", "Q3 2012"], datetime(2012, 1, 1), [0, 91 * DAY, 182 * DAY]),
        (["2020-W53", "2021-W01", "2021-W02"], datetime(2020, 12, 28), [0, 7 * DAY, 14 * DAY]),
        (["2012M01", "2012M02", "2012M03"], datetime(2012, 1, 1), [0, 31 * DAY, 60 * DAY]),
        (["2010", "2011", "2012"], datetime(2010, 1, 1), [0, 365 * DAY, 730 * DAY]),
        (["19.09.2012", "20.09.2012"], datetime(2012, 9, 19), [0, DAY]),
        (["01.09.2012", "02.09.2012"], datetime(2012, 9, 1), [0, DAY]),
        (["9/19/2012", "9/20/2012"], datetime(2012, 9, 19), [0, DAY]),
        (["19/9/2012", "20/9/2012"], datetime(2012, 9, 19), [0, DAY]),
        (["9/19/12 4:00 PM", "9/20/12 12:00 AM"], datetime(2012, 9, 19, 16), [0, 8 * 3600]),
        (["19-Sep-12", "20-Sep-12"], datetime(2012, 9, 19), [0, DAY]),
        (["Sep 19, 2012", "Sep 20, 2012"], datetime(2012, 9, 19), [0, DAY]),
        (["19 September 2012", "20 September 2012"], datetime(2012, 9, 19), [0, DAY]),
        (["Sep 2012", "Oct 2012"], datetime(2012, 9, 1), [0, 30 * DAY]),
        (["Wed, 19 Sep 2012 09:30:00 GMT", "Wed, 19 Sep 2012 09:30:01 GMT"],
         datetime(2012, 9, 19, 9, 30, tzinfo=UTC), [0, 1]),
        (["1348047000", "1348047001"], datetime(2012, 9, 19, 9, 30, tzinfo=UTC), [0, 1]),
        (["1348047000.5", "1348047001"],
         datetime(2012, 9, 19, 9, 30, 0, 500_000, tzinfo=UTC), [0, 0.5]),
        (["1348047000000", "1348047000250"], datetime(2012, 9, 19, 9, 30, tzinfo=UTC), [0, 0.25]),
        (["1348047000000000", "1348047000000125"],
         datetime(2012, 9, 19, 9, 30, tzinfo=UTC), [0, 0.000125]),
        (["1348047000000000000", "1348047000500000000"],
         datetime(2012, 9, 19, 9, 30, tzinfo=UTC), [0, 0.5]),
        (["0", "0.5", "1"], None, [0, 0.5, 1]),
        (["0:00:10", "0:01:10", "1:00:10"], None, [0, 60, 3600]),
    ],
)  # fmt: skip
def test_times_are_detected_by_how_they_are_written(
    tmp_path: Path, cells: list[str], start: datetime | None, seconds: list[float]
) -> None:
    timeline = load(tmp_path, series(cells, "time"))
    if "2010" in cells:
        timeline = load(tmp_path, series(cells, "year"))
    assert times(timeline) == seconds
    assert timeline.start == start
    if start is not None and timeline.start is not None:
        assert timeline.start.utcoffset() == start.utcoffset()


def test_the_day_of_dates_with_slashes_is_detected_by_a_part_above_12(tmp_path: Path) -> None:
    cells = [f"{day}/01/2020" for day in range(1, 32)]
    timeline = load(tmp_path, series(cells))
    assert timeline.start == datetime(2020, 1, 1)
    assert times(timeline)[-1] == 30 * DAY
    assert "over 'date' (dates d/m/y)" in timeline.provenance


def test_a_day_that_decides_may_come_after_thousands_of_rows(tmp_path: Path) -> None:
    begin = datetime(2020, 1, 1)
    moments = [begin + timedelta(minutes=5 * i) for i in range(12 * 24 * 14)]
    cells = [f"{m.day}/{m.month}/{m.year} {m:%H:%M}" for m in moments]
    timeline = load(tmp_path, series(cells))
    assert timeline.start == begin
    assert noted(timeline, f"read as dates d/m/y, detected from line {12 * 24 * 12 + 2}")
    assert timeline.duration_s == (moments[-1] - begin).total_seconds()


def test_the_order_of_rows_distinguishes_day_and_month_where_no_part_does(tmp_path: Path) -> None:
    cells = ["10/01/2020", "11/01/2020", "12/01/2020", "01/02/2020", "02/02/2020"]
    timeline = load(tmp_path, series(cells))
    assert timeline.start == datetime(2020, 1, 10)
    assert noted(
        timeline,
        "read as dates d/m/y, detected from the order of rows (only then are they ascending)",
    )
    # months and days of January both rise
    cells = [f"{month}/1/2020" for month in range(1, 13)]
    assert "may be day/month or month/day" in refusal(lambda: load(tmp_path, series(cells)))


@pytest.mark.parametrize(
    ("told", "start"), [("dmy", datetime(2020, 2, 1)), ("mdy", datetime(2020, 1, 2))]
)
def test_a_date_that_fits_both_is_asked_about_and_can_be_given(
    tmp_path: Path, told: str, start: datetime
) -> None:
    text = series(["01/02/2020", "02/02/2020", "03/03/2020"])
    words = refusal(lambda: load(tmp_path, text))
    assert "'01/02/2020' may be day/month or month/day" in words
    assert "choose with time (--time-column): 'date:dmy' or 'date:mdy'" in words
    for wish in (f"date:{told}", f":{told}"):
        assert load(tmp_path, text, time=wish).start == start


def test_plain_times_may_be_given_their_unit(tmp_path: Path) -> None:
    text = series(["0", "1", "2", "3"], "step")
    assert times(load(tmp_path, text, time="step")) == [0, 1, 2, 3]
    assert times(load(tmp_path, text, time="step:ms")) == [0, 0.001, 0.002, 0.003]
    assert times(load(tmp_path, text, time="step:h"))[-1] == 3 * 3600
    assert times(load(tmp_path, series(["0", "250"], "time (ms)"))) == [0, 0.25]
    assert times(load(tmp_path, series(["0", "250"], "time_ms"))) == [0, 0.25]
    assert times(load(tmp_path, series(["1", "3"], "minutes"))) == [0, 120]


def test_large_numbers_may_be_declared_seconds(tmp_path: Path) -> None:
    text = series(["1348047000", "1348047001"], "t")
    assert load(tmp_path, text).start is not None
    timeline = load(tmp_path, text, time="t:s")
    assert timeline.start is None
    assert noted(timeline, "times begin at 1.34805e+09 s; the timeline counts from there")


def test_spreadsheet_days_and_years_with_fractions(tmp_path: Path) -> None:
    timeline = load(tmp_path, series(["41171", "41171.5"]), time="date:excel")
    assert timeline.start == datetime(2012, 9, 19)
    assert timeline.duration_s == DAY / 2
    timeline = load(tmp_path, series(["2011", "2011.5", "2012"], "decimal date"))
    assert timeline.start == datetime(2011, 1, 1)
    assert times(timeline) == [0, 182.5 * DAY, 365 * DAY]


def test_columns_of_year_month_and_day_are_joined(tmp_path: Path) -> None:
    text = "year,month,day,rain\n2020,1,30,4\n2020,1,31,5\n2020,2,1,6\n"
    timeline = load(tmp_path, text)
    assert timeline.start == datetime(2020, 1, 30)
    assert times(timeline) == [0, DAY, 2 * DAY]
    assert values(timeline) == [4.0, 5.0, 6.0]
    assert noted(timeline, "times are made of columns 'year' and 'month' and 'day'")


def test_a_date_and_a_clock_beside_it_are_joined(tmp_path: Path) -> None:
    text = "date,time,load\n2020-01-01,09:30,4\n2020-01-01,10:00,5\n2020-01-02,09:30,6\n"
    timeline = load(tmp_path, text)
    assert timeline.start == datetime(2020, 1, 1, 9, 30)
    assert times(timeline) == [0, 1800, DAY]


def test_the_time_column_can_be_named(tmp_path: Path) -> None:
    text = "made,seen,level\n2020-01-01,2021-01-01,1\n2020-01-02,2021-01-03,2\n"
    assert load(tmp_path, text, time="seen").start == datetime(2021, 1, 1)
    words = refusal(lambda: load(tmp_path, text, time="level"[:3]))
    assert "no column 'lev' for the times; columns are 'made', 'seen', 'level'" in words
    words = refusal(lambda: load(tmp_path, text, time="seen:weekly"))
    assert "'weekly' is not a format of times; allowed: iso, dmy, mdy, epoch" in words


def test_times_with_and_without_a_zone_are_not_mixed(tmp_path: Path) -> None:
    words = refusal(lambda: load(tmp_path, series(["2020-01-01T00:00", "2020-01-01T01:00Z"])))
    assert "line 3, column 'date': '2020-01-01T01:00Z' has a time zone" in words


def test_a_clock_that_goes_back_is_refused(tmp_path: Path) -> None:
    words = refusal(lambda: load(tmp_path, series(["23:59:58", "23:59:59", "00:00:00"], "time")))
    assert "line 4: the clock goes back" in words


def test_rate_and_time_are_not_both_taken(tmp_path: Path) -> None:
    words = refusal(lambda: load(tmp_path, series(["1", "2"], "t"), time="t", rate=2.0))
    assert "rate and time are both given" in words


def test_a_moment_beyond_the_calendar_gives_a_one_line_error(tmp_path: Path) -> None:
    text = series(["0", "300000000000", "400000000000"], "t")
    words = refusal(lambda: load(tmp_path, text, time="t:epoch"))
    assert "line 3, column 't': '300000000000' is a time outside the years 1 to 9999" in words
    assert load(tmp_path, text).duration_s == 4e11


@pytest.mark.parametrize("cell", ["9999-12-31T23:59:59", "0001-01-01"])
def test_the_ends_of_the_calendar_are_no_traceback(tmp_path: Path, cell: str) -> None:
    timeline = load(tmp_path, series([cell, "2000-01-01"]))
    assert timeline.duration_s > 0
