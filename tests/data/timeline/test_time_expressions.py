"""Moments as a person writes them, and windows between two of them."""

from __future__ import annotations

import warnings
from datetime import UTC, datetime, timedelta, timezone

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.data.timeline.time_expressions import (
    parse_time_expression,
    window_of,
    zoom_window,
)
from overview_dsp.data.timeline.time_parsing import length_s
from overview_dsp.errors import InputError, OverviewWarning

DAY = 86_400.0
EVENTS = (
    Event(10.0, "period"),
    Event(1050.0, "own_goal"),
    Event(1650.0, "goal", "a"),
    Event(3600.0, "foul"),
    Event(4685.0, "goal", "b"),
)
MATCH = Timeline("match", 5400.0, EVENTS)
YEAR = Timeline("year", 366 * DAY, (Event(DAY, "peak"),), start=datetime(2012, 1, 1))


@pytest.mark.parametrize(
    ("text", "time_s"),
    [
        ("90", 90.0),
        (" 90.5 ", 90.5),
        ("1e3", 1000.0),
        ("90s", 90.0),
        ("15min", 900.0),
        ("1.5 h", 5400.0),
        ("1:30", 90.0),
        ("78:05", 4685.0),
        ("1:18:05", 4685.0),
        ("1:02:03.25", 3723.25),
        ("goal:1", 1650.0),
        ("goal:2", 4685.0),
        ("own_goal:1", 1050.0),
        ("event:3", 1650.0),
        ("event:1", 10.0),
        ("goal:1-60", 1590.0),
        ("goal:1+1:30", 1740.0),
        ("goal:2-15min", 3785.0),
        ("start", 0.0),
        ("start+5", 5.0),
        ("end", 5400.0),
        ("end-1:00", 5340.0),
    ],
)
def test_a_written_moment_is_so_long_after_the_start(text: str, time_s: float) -> None:
    assert parse_time_expression(text, MATCH) == time_s


@pytest.mark.parametrize(
    ("text", "day"),
    [
        ("2012-01-01", 0.0),
        ("2012-09-19", 262.0),
        ("2012/9/19", 262.0),
        ("2012-09-19T12:00", 262.5),
        ("2012-09-19 06:00:00", 262.25),
        ("20120919T1200", 262.5),
        ("Sep 19, 2012", 262.0),
        ("19-Sep-12", 262.0),
        ("2012-03", 60.0),
        ("2012Q2", 91.0),
        ("3d", 3.0),
        ("2w", 14.0),
        ("end-6w", 324.0),
        ("peak:1+2d", 3.0),
    ],
)
def test_a_date_is_found_by_the_timelines_calendar(text: str, day: float) -> None:
    assert parse_time_expression(text, YEAR) == pytest.approx(day * DAY, abs=1e-6)


def test_time_zones_are_distinguished_and_the_timelines_own_is_taken_where_none_is_named() -> None:
    zone = timezone(timedelta(hours=-4))
    events = (Event(1.0, "a"),)
    timeline = Timeline("day", DAY, events, start=datetime(2012, 9, 19, 9, 30, tzinfo=zone))
    assert parse_time_expression("2012-09-19T10:30", timeline) == 3600.0
    assert parse_time_expression("2012-09-19T14:30Z", timeline) == 3600.0
    assert parse_time_expression("2012-09-19T16:30+02:00", timeline) == 3600.0
    naive = Timeline("day", DAY, events, start=datetime(2012, 9, 19))
    with pytest.raises(InputError, match="names a time zone"):
        parse_time_expression("2012-09-19T14:30Z", naive)


def test_a_clock_change_within_a_zone_is_counted() -> None:
    zoneinfo = pytest.importorskip("zoneinfo")
    try:
        zone = zoneinfo.ZoneInfo("Europe/Paris")
    except zoneinfo.ZoneInfoNotFoundError:
        pytest.skip("needs the zone database")
    events = (Event(1.0, "a"),)
    timeline = Timeline("spring", 5 * DAY, events, start=datetime(2012, 3, 24, tzinfo=zone))
    assert parse_time_expression("2012-03-26", timeline) == 2 * DAY - 3600.0
    assert parse_time_expression("2012-03-25T22:00Z", timeline) == 2 * DAY - 3600.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "not a moment; give seconds"),
        ("a", "'a' is not a moment"),
        ("1:60", "not a moment"),
        ("1:60:00", "not a moment"),
        ("1.2.3", "not a moment"),
        ("goal", "not a moment"),
        ("goal:", "not a moment"),
        ("goal:x", "not a moment"),
        ("Goal:1", "not a moment"),
        ("goal:3", "there is no goal number 3; the timeline has 2"),
        ("goal:0", "give 1 to 2"),
        ("dog:1", "no event of kind 'dog'; it has period"),
        ("event:6", "there is no event number 6; the timeline has 5: give 1 to 5"),
        ("goal:1-x", "'x' is not a length"),
        ("2012-09-19", "the timeline has no calendar"),
        ("19/9/2012", "not a moment"),
        ("5401", "outside the timeline; it reaches from 0:00.0 to 1:30:00.0"),
        ("-1", "outside the timeline"),
        ("nan", "outside the timeline"),
        ("inf", "outside the timeline"),
        ("1:30:01", "outside the timeline"),
    ],
)
def test_what_is_no_moment_of_the_timeline_is_one_line(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        parse_time_expression(text, MATCH)
    assert "\n" not in str(caught.value)


def test_an_offset_or_a_date_stops_at_the_ends_with_a_warning() -> None:
    with pytest.warns(OverviewWarning, match=r"goal:2\+20min lies beyond.*end.*1:30:00"):
        assert parse_time_expression("goal:2+20min", MATCH) == 5400.0
    with pytest.warns(OverviewWarning, match="2011-12-01 lies beyond.*start.*2012-01-01"):
        assert window_of(YEAR, "2011-12-01", "2012-02-01") == (0.0, 31 * DAY)


def test_a_window_is_between_two_moments() -> None:
    assert window_of(MATCH, "goal:1-60", "goal:1+5") == (1590.0, 1655.0)
    assert window_of(MATCH, "start", "end") == (0.0, 5400.0)
    assert window_of(YEAR, "2012-09-01", "2012-10-01") == (244 * DAY, 274 * DAY)


@pytest.mark.parametrize(
    ("start", "end", "words"),
    [
        ("5", "5", r"from 5\.0 to 5\.0 s is empty"),
        ("goal:2", "goal:1", "empty or outside"),
        ("0", "1e9", r"give 0 <= start < end <= 5400\.0"),
        ("nan", "5", "window start is nan"),
        ("0", "inf", "window end is inf"),
    ],
)
def test_an_empty_window_is_refused(start: str, end: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        window_of(MATCH, start, end)


def test_a_window_of_dates_beyond_the_timeline_is_refused_and_says_how_far_it_reaches() -> None:
    words = "from 2012-01-01 00:00:00 to 2013-01-01 00:00:00"
    with pytest.warns(OverviewWarning), pytest.raises(InputError, match=words):
        window_of(YEAR, "2014-01-01", "2015-01-01")


def test_a_zoom_has_the_event_three_quarters_into_a_window_of_the_length_asked_for() -> None:
    assert zoom_window(MATCH, "goal:1:100") == (1575.0, 1675.0)
    assert zoom_window(MATCH, "event:3:1:40") == (1575.0, 1675.0)
    assert zoom_window(MATCH, "goal:2:2min") == (4595.0, 4715.0)
    start, end = zoom_window(MATCH, "goal:1")
    assert end - start == pytest.approx(540.0)
    assert start < 1650.0 < end


def test_a_zoom_stays_within_the_timeline() -> None:
    assert zoom_window(MATCH, "period:1:100") == (0.0, 100.0)
    late = Timeline("late", 100.0, (Event(99.0, "goal"),))
    assert zoom_window(late, "goal:1:40") == (60.0, 100.0)
    assert zoom_window(late, "goal:1:1d") == (0.0, 100.0)


@pytest.mark.parametrize("text", ["", "goal", "goal:x", "goal:1:0", "goal:1:x", "goal:1:-5", "1:2"])
def test_a_zoom_to_nothing_is_one_line(text: str) -> None:
    with pytest.raises(InputError, match=r"is not an event; give kind:number \(goal:1"):
        zoom_window(MATCH, text)


def test_lengths() -> None:
    assert [length_s(text) for text in ("90", "1:30", "1.5h", "2 W", "x", "-1", "..")] == [
        *(90.0, 90.0, 5400.0, 1_209_600.0),
        *(None, None, None),
    ]


def one_line_or_seconds(text: str, timeline: Timeline) -> float | None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return parse_time_expression(text, timeline)
        except InputError as error:
            line = str(error)
    assert "\n" not in line
    return None


@given(st.text(max_size=30))
def test_any_text_is_a_moment_within_the_timeline_or_one_line(text: str) -> None:
    zoned = Timeline("z", 1e9, EVENTS, start=datetime(2012, 1, 1, tzinfo=UTC))
    for timeline in (MATCH, YEAR, zoned):
        at = one_line_or_seconds(text, timeline)
        assert at is None or 0.0 <= at <= timeline.duration_s


@given(
    st.integers(1, 9999),
    st.integers(1, 12),
    st.integers(1, 28),
    st.sampled_from(("", "T23:59Z", "T00:00+23:59", "T24:00-23:59")),
)
def test_any_date_is_within_the_calendar_or_one_line(y: int, m: int, d: int, rest: str) -> None:
    for zone in (UTC, timezone(timedelta(hours=14)), timezone(timedelta(hours=-12))):
        start = datetime(2012, 1, 1, tzinfo=zone)
        timeline = Timeline("z", 1e9, EVENTS, start=start)
        one_line_or_seconds(f"{y:04}-{m:02}-{d:02}{rest}", timeline)
