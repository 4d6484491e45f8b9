"""Written times against the calendar, and each column's quick way against the slow one."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from overview_dsp.data.readers.tables.table import CellLocation
from overview_dsp.data.readers.tables.time_column import Format, TimeColumn
from overview_dsp.data.timeline.time_parsing import (
    clock_s,
    day_clock_s,
    in_line,
    length_s,
    match_minute,
    moment,
)
from overview_dsp.errors import InputError

moments = st.datetimes(datetime(1000, 1, 1), datetime(9998, 12, 31))


@given(moments, st.sampled_from((None, 0, 330, -60)))
def test_an_iso_moment_is_the_calendars(at, offset_min):
    zone = None if offset_min is None else timezone(timedelta(minutes=offset_min))
    written = at.replace(tzinfo=zone)
    read = moment(written.isoformat(), "iso")
    assert read is not None
    assert read.to_datetime() == written
    assert read.offset_min == offset_min
    utc = written.replace(tzinfo=UTC) if zone is None else written.astimezone(UTC)
    assert read.ns == (utc - datetime(1970, 1, 1, tzinfo=UTC)) // timedelta(microseconds=1) * 1000


@given(moments)
def test_forms_of_one_day_are_one_moment(at):
    forms = {
        "iso": f"{at:%Y/%m/%d %H:%M}",
        "dmy": f"{at:%d.%m.%Y %I:%M %p}",
        "mdy": f"{at:%m/%d/%Y, %H:%M}",
        "month names": f"{at:%a, %d %b %Y %H:%M}",
    }
    read = {moment(text.replace("AM", "a.m."), form) for form, text in forms.items()}
    assert len(read) == 1
    assert None not in read


@pytest.mark.parametrize(
    ("line", "form", "utc"),
    [
        ("x 2024-05-03T18:20:01,5 y", "iso", "2024-05-03T18:20:01.500000"),
        ('- [10/Oct/2000:13:55:36 -0700] "GET', "web", "2000-10-10T20:55:36"),
        ("[Fri May 3 18:20:00.1 2024] error", "long", "2024-05-03T18:20:00"),
        ("Fri May  3 18:20:00 CEST 2024", "long", "2024-05-03T16:20:00"),
        ("Fri May  3 18:20:00 XYZ 2024", "long", "2024-05-03T18:20:00"),
    ],
)
def test_a_time_in_a_line_is_read_again_with_its_zone(line, form, utc):
    read = moment(in_line(line, form) or "", "iso")
    assert read is not None
    at = read.to_datetime()
    assert (at.astimezone(UTC) if at.tzinfo else at).replace(tzinfo=None).isoformat() == utc


def test_clocks_lengths_and_minutes_have_their_ranges():
    assert [clock_s(t) for t in ("1:02:03.5", "62:03", "120:30", "1:60", "1:60:00", "5")] == [
        3723.5, 3723.0, 7230.0, None, None, None
    ]  # fmt: skip
    assert [day_clock_s(t) for t in ("8:00 PM", "24:00", "24:01", "13:00 PM")] == [
        72_000.0, 86_400.0, None, None
    ]  # fmt: skip
    assert [length_s(t) for t in ("90", "1.5 H", "1y", "1.2.3")] == [
        90.0, 5400.0, 31_557_600.0, None
    ]  # fmt: skip
    assert [match_minute(t) for t in ("38.0", "90'+3'", "45+2:30", "90+3.0", "3.5", "9" * 25)] == [
        (38, None, None), (90, 3, None), (45, 2, 30.0), None, None, None
    ]  # fmt: skip


TEXTS = st.lists(moments, min_size=1, max_size=5).flatmap(
    lambda many: st.sampled_from(
        [
            [f"{at:%Y-%m-%d}" for at in many],
            [f"{at:%Y-%m-%d %H:%M}" for at in many],
            [f"{at:%Y-%m-%dT%H:%M:%S}Z" for at in many],
            [f"{at:%Y-%m-%dT%H:%M:%S.%f}" for at in many],
            [f"{at:%Y-%m-%dT%H:%M:%S.%f}789" for at in many],
        ]
    )
)


@given(TEXTS)
@example(["2262-04-12T00:00:00.000000001", "2300-01-01T00:00:00.000000001"])
@example(["1600-01-01T00:00:00.000000001"])
@example(["2000-01-01T00:00:00.000000789", "2147-01-01T00:00:00.000000789"])
@example(["2012-02-28", "2012-02-30"])
@example(["2012-09-19T23:00", "2012-09-19T24:00"])
@example(["2012-09-19T09:30:00.0000", "2012-09-19T09:30:00-0200"])
@example(["2012-09-19", "0000-01-01"])
@example(["2012-09-19", "-012-09-19"])
@example(["2012-09-19", "0x12-09-19"])
def test_a_column_of_iso_texts_is_read_as_each_of_its_cells(texts):
    def read(column, cells):
        try:
            return column.seconds(cells, CellLocation).tolist()
        except InputError:
            return None

    whole, single = TimeColumn(Format("iso")), TimeColumn(Format("iso"))
    # a blank beside them takes the slow way
    one_by_one = read(single, [*texts, " "])
    quick = read(whole, texts)
    assert (quick is None) == (one_by_one is None)
    # to the last bit of a float: microseconds of 300 years are more than it holds
    assert one_by_one is None or quick == pytest.approx(one_by_one[:-1], rel=3e-16, abs=0.0)
    assert (whole.anchor_ns, whole.offset_min) == (single.anchor_ns, single.offset_min)
