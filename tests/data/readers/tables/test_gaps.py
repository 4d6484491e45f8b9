"""Missing values and holes become gaps; weekends of a share don't."""

from __future__ import annotations

from datetime import date, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from overview_dsp.data.readers.series.sample_scan import find_holes
from overview_dsp.data.readers.tables.cells import TOKENS
from tests.data.readers.tables.made import load, noted, times, values

DAY = 86_400.0


def days(count: int, begin: date = date(2020, 1, 1)) -> list[date]:
    return [begin + timedelta(days=i) for i in range(count)]


def series(rows: list[tuple[object, object]]) -> str:
    return "date,level\n" + "".join(f"{moment},{value}\n" for moment, value in rows)


@pytest.mark.parametrize("word", [*sorted(TOKENS), " NA ", "NaN", "NULL", "N/A", '""'])
def test_a_word_for_missing_becomes_a_gap_from_value_to_value(tmp_path: Path, word: str) -> None:
    rows = [(day, f"{i}.5") for i, day in enumerate(days(9))]
    rows[3] = (rows[3][0], word)
    rows[4] = (rows[4][0], word)
    timeline = load(tmp_path, series(rows))
    assert timeline.gaps == ((2 * DAY, 5 * DAY),)
    assert values(timeline) == [0.5, 1.5, 2.5, 5.5, 6.5, 7.5, 8.5]
    assert timeline.intensity_at(3 * DAY) == 0.0  # not interpolated
    assert noted(timeline, "2 of 9 values are missing, which makes gaps")
    assert noted(timeline, "1 gap, the longest 3 days")


def test_missing_values_at_the_ends_are_gaps_and_the_duration_stays(tmp_path: Path) -> None:
    rows = [(day, "" if i in (0, 1, 8) else i) for i, day in enumerate(days(9))]
    timeline = load(tmp_path, series(rows))
    assert timeline.duration_s == 8 * DAY
    assert timeline.start == datetime(2020, 1, 1)
    assert timeline.gaps == ((0.0, 2 * DAY), (7 * DAY, 8 * DAY))


def test_a_lone_value_between_missing_ones_is_kept(tmp_path: Path) -> None:
    rows = [(day, "" if i in (2, 4) else i) for i, day in enumerate(days(7))]
    timeline = load(tmp_path, series(rows))
    assert timeline.gaps == ((DAY, 3 * DAY), (3 * DAY, 5 * DAY))
    assert timeline.intensity_at(3 * DAY) == 3.0


def test_missing_rows_of_a_daily_series_are_a_gap(tmp_path: Path) -> None:
    rows = [(day, i % 7) for i, day in enumerate(days(60)) if not 20 <= i < 24]
    timeline = load(tmp_path, series(rows))
    assert timeline.gaps == ((19 * DAY, 24 * DAY),)
    assert noted(timeline, "a step longer than 1.5 days is a gap")


def test_a_single_missing_day_is_a_gap(tmp_path: Path) -> None:
    rows = [(day, i % 7) for i, day in enumerate(days(60)) if i != 20]
    assert load(tmp_path, series(rows)).gaps == ((19 * DAY, 21 * DAY),)


def test_months_of_28_to_31_days_are_even(tmp_path: Path) -> None:
    rows = [(date(2015 + i // 12, i % 12 + 1, 1), i % 5) for i in range(60) if i != 30]
    timeline = load(tmp_path, series(rows))
    (gap,) = timeline.gaps
    assert timeline.start is not None
    assert timeline.start + timedelta(seconds=gap[0]) == datetime(2017, 6, 1)
    assert timeline.start + timedelta(seconds=gap[1]) == datetime(2017, 8, 1)


def business_days(count: int) -> list[date]:
    return [day for day in days(count) if day.weekday() < 5]


def test_weekends_and_holidays_of_a_share_are_no_gaps_and_a_suspension_is(tmp_path: Path) -> None:
    holidays = {date(2020, 4, 10), date(2020, 4, 13), date(2020, 12, 25)}
    traded = [day for day in business_days(366) if day not in holidays]
    timeline = load(tmp_path, series([(day, 100 + i % 9) for i, day in enumerate(traded)]))
    assert timeline.gaps == ()
    assert noted(timeline, "business days: weekends and holidays are not gaps")
    kept = [day for day in traded if not date(2020, 6, 1) <= day <= date(2020, 6, 26)]
    timeline = load(tmp_path, series([(day, 100 + i % 9) for i, day in enumerate(kept)]))
    assert timeline.start is not None
    (gap,) = timeline.gaps
    assert timeline.start + timedelta(seconds=gap[0]) == datetime(2020, 5, 29)
    assert timeline.start + timedelta(seconds=gap[1]) == datetime(2020, 6, 29)


def test_golden_weeks_that_return_every_year_are_no_gaps() -> None:
    traded = [
        day
        for day in days(5 * 365)
        if day.weekday() < 5 and not (day.month in (2, 10) and 1 <= day.day <= 8)
    ]
    seconds = np.array([(day - traded[0]).days * DAY for day in traded])
    assert find_holes(seconds, datetime.combine(traded[0], datetime.min.time())).after.size == 0


def test_nights_of_an_exchange_are_no_gaps_and_a_pause_within_a_day_is(tmp_path: Path) -> None:
    moments = [
        datetime.combine(day, datetime.min.time()) + timedelta(hours=9, minutes=30 + 5 * i)
        for day in business_days(30)
        for i in range(78)
    ]
    timeline = load(tmp_path, series([(m, i % 11) for i, m in enumerate(moments)]))
    assert timeline.gaps == ()
    assert noted(timeline, "sessions: nights, weekends and holidays are not gaps")
    halted = [m for m in moments if not datetime(2020, 1, 9, 12) < m < datetime(2020, 1, 9, 13)]
    timeline = load(tmp_path, series([(m, i % 11) for i, m in enumerate(halted)]))
    (gap,) = timeline.gaps
    assert timeline.start is not None
    assert timeline.start + timedelta(seconds=gap[0]) == datetime(2020, 1, 9, 12)
    assert timeline.start + timedelta(seconds=gap[1]) == datetime(2020, 1, 9, 13)


@pytest.mark.parametrize("count", [20, 99, 100, 400])  # few: the hole is 1 % of the steps or more
def test_uneven_samples_have_gaps_only_where_much_is_missing(tmp_path: Path, count: int) -> None:
    random = np.random.default_rng(0)
    steps = random.uniform(0.5, 4.0, count)
    hole = count // 2
    steps[hole] = 60.0
    at = np.concatenate([[0.0], np.cumsum(steps)])
    timeline = load(tmp_path, series([(f"{t:.3f}", i % 5) for i, t in enumerate(at)]))
    (gap,) = timeline.gaps
    assert gap == pytest.approx((at[hole], at[hole + 1]), abs=1e-3)
    assert noted(timeline, "samples are uneven")


def test_a_loggers_number_for_nothing_is_no_value(tmp_path: Path) -> None:
    rows = [(day, -9999 if i == 4 else i / 2) for i, day in enumerate(days(9))]
    timeline = load(tmp_path, series(rows))
    assert timeline.gaps == ((3 * DAY, 5 * DAY),)
    assert noted(timeline, "1 values of -9999 in column 'level' count as missing")
    # a depth of -99 among its likes is one
    rows = [(day, -99 if i == 4 else -80 - 2 * i) for i, day in enumerate(days(9))]
    assert load(tmp_path, series(rows)).gaps == ()


def test_a_row_without_time_and_value_is_ignored(tmp_path: Path) -> None:
    text = series([(day, i) for i, day in enumerate(days(5))]) + ",\n,\n"
    timeline = load(tmp_path, text)
    assert times(timeline) == [i * DAY for i in range(5)]


def test_a_value_of_99_below_zero_among_wide_ones_is_no_loggers_mark(tmp_path: Path) -> None:
    rows = [(day, -99 if i == 4 else 10 * i - 40) for i, day in enumerate(days(9))]
    timeline = load(tmp_path, series(rows))
    assert timeline.gaps == ()
    assert min(values(timeline)) == -99.0
