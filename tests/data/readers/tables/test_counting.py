"""`--map count`: how many rows there are in each window, none left out."""

from __future__ import annotations

import json
from collections import Counter
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.series import counting
from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import InputError

START = datetime(2024, 5, 1, 9, 40, tzinfo=UTC)
MOMENTS = [START + timedelta(minutes=m) for m in (0, 5, 19, 20, 21, 200, 200, 1500)]


def write(folder: Path, text: str, name: str = "rows.csv") -> Path:
    (folder / name).write_text(text)
    return folder / name


def numbers(timeline: Timeline) -> list[float]:
    """The count of each window."""
    assert timeline.intensity is not None
    return [float(n) for n in timeline.intensity.value[1:-1]]


def rows_of(moments: list[datetime]) -> list[str]:
    return [f"{moment.isoformat()},Ann" for moment in moments]


def test_rows_are_counted_in_windows_of_the_calendar(tmp_path: Path) -> None:
    path = write(tmp_path, "\n".join(["when,who", *rows_of(MOMENTS)]))
    timeline = load_timeline(path, map="count:1h")
    assert timeline.start == START.replace(minute=0)
    assert timeline.duration_s == 26 * 3600.0
    expected = [0.0] * 26
    expected[0], expected[1], expected[4], expected[25] = 3.0, 2.0, 2.0, 1.0
    assert numbers(timeline) == expected
    assert timeline.intensity is not None
    assert timeline.intensity.unit == "per h"
    assert timeline.gaps == ()
    assert any(note.startswith("8 rows, counted in 26 windows of 1h") for note in timeline.notes)


def test_days_begin_at_midnight_where_the_rows_were_written_and_weeks_with_monday(
    tmp_path: Path,
) -> None:
    text = "when,who\n2024-05-01T23:30:00-04:00,a\n2024-05-02T00:30:00-04:00,a\n"
    days = load_timeline(write(tmp_path, text), map="count:1d")
    assert numbers(days) == [1.0, 1.0]
    assert days.start is not None
    assert days.start.isoformat() == "2024-05-01T00:00:00-04:00"
    weeks = load_timeline(write(tmp_path, text), map="count:1w")
    assert weeks.start is not None
    assert weeks.start.isoformat() == "2024-04-29T00:00:00-04:00"


@pytest.mark.parametrize("order", ["falling", "shuffled"])
def test_the_order_of_rows_does_not_matter(order: str, tmp_path: Path) -> None:
    moments = (
        MOMENTS[::-1] if order == "falling" else [MOMENTS[i] for i in (3, 0, 7, 1, 6, 2, 5, 4)]
    )
    there = load_timeline(write(tmp_path, "\n".join(["t,who", *rows_of(moments)])), map="count:1h")
    here = load_timeline(write(tmp_path, "\n".join(["t,who", *rows_of(MOMENTS)])), map="count:1h")
    assert numbers(there) == numbers(here)


def git_entry(moment: datetime) -> str:
    return (
        f"commit {'0af4' * 10}\nAuthor: A <a@b>\nDate:   {moment:%a %b} {moment.day} "
        f"{moment:%H:%M:%S %Y} +0000\n\n    as of 2020-01-01 10:00\n\n"
    )


def test_every_shape_of_table_is_counted_alike(tmp_path: Path) -> None:
    expected = [3.0, 2.0, 0.0, 0.0, 2.0, *[0.0] * 20, 1.0]
    records = [{"when": m.isoformat(), "text": "x"} for m in MOMENTS]
    log = [f"{m.isoformat(' ')} INFO it, said\n  and more" for m in MOMENTS]
    web = [f'1.2.3.4 - - [{m:%d/%b/%Y:%H:%M:%S} +0000] "GET / HTTP/1.1" 200 2' for m in MOMENTS]
    for name, text in (
        ("a.csv", "\n".join(["when", *(m.isoformat() for m in MOMENTS)])),
        ("b.csv", "\n".join(rows_of(MOMENTS))),
        ("c.csv", "\n".join(["time,place,mag", *(f"{m.isoformat()},b,1.5" for m in MOMENTS)])),
        ("d.jsonl", "\n".join(map(json.dumps, records))),
        ("f.log", "\n".join(log)),
        ("g.log", "\n".join(web)),
        ("h.log", "\n".join(f"[{m:%Y-%m-%d %H:%M:%S}] INFO it" for m in MOMENTS)),
        ("i.log", "\n".join(f"{m:%Y/%m/%d %H:%M:%S} [error] it" for m in MOMENTS)),
        ("j.log", "\n".join(f"[{m:%a %b %d %H:%M:%S}.123 {m:%Y}] [core] it" for m in MOMENTS)),
        ("k.txt", "\n".join(f"[{m:%d.%m.%y, %H:%M:%S}] Ann: it,\nand more" for m in MOMENTS)),
        ("m.log", "\n".join(f"{m:%b %d %H:%M:%S} host program[7]: it" for m in MOMENTS)),
        ("n.txt", "".join(git_entry(m) for m in MOMENTS[::-1])),
    ):
        assert numbers(load_timeline(write(tmp_path, text, name), map="count:1h")) == expected, name


def test_the_order_of_day_and_month_in_a_chat_is_found_or_given(tmp_path: Path) -> None:
    def chat(month: int, day: int) -> Path:
        lines = [f"{month}/{day}/24, {h}:05 PM - Ann: 1/2/2020 it" for h in (12, 1, 3)]
        return write(tmp_path, "\n".join(lines), "chat.txt")

    assert numbers(load_timeline(chat(5, 13), map="count:1h")) == [1.0, 1.0, 0.0, 1.0]
    with pytest.raises(InputError, match="may be day/month or month/day"):
        load_timeline(chat(5, 3), map="count:1h")
    for order, month in (("dmy", 3), ("mdy", 5)):
        start = load_timeline(chat(5, 3), map="count:1h", time=f"time:{order}").start
        assert start is not None
        assert start.month == month


def test_times_without_a_year_go_on_after_december(tmp_path: Path) -> None:
    path = write(tmp_path, "Dec 31 23:10:00 h: a\nDec 31 23:50:00 h: b\nJan  1 01:20:00 h: c\n")
    timeline = load_timeline(path, map="count:1h")
    assert numbers(timeline) == [2.0, 0.0, 1.0]
    assert "its lines have no year; the first year is called 2000" in timeline.notes


def test_a_log_that_is_not_counted_is_refused_with_the_option(tmp_path: Path) -> None:
    path = write(tmp_path, "\n".join(f"{m:%Y-%m-%d %H:%M:%S} it" for m in MOMENTS), "a.log")
    with pytest.raises(InputError, match=r"nearest: a log; .*--map count"):
        load_timeline(path)


def test_an_event_list_is_counted_too(tmp_path: Path) -> None:
    path = write(tmp_path, "time_s,kind,label\n1,foul,\n2,goal,1-0\n61,foul,\n")
    assert numbers(load_timeline(path, map="count:1min")) == [2.0, 1.0]


def test_what_is_not_counted_is_noted(tmp_path: Path) -> None:
    text = "\n".join([f"{m.isoformat(' ')} x\n  rest" for m in MOMENTS])
    notes = load_timeline(write(tmp_path, text), map="count:1h").notes
    assert "8 rows without a time aren't counted" in notes


def test_a_column_called_count_is_still_that_column(tmp_path: Path) -> None:
    path = write(tmp_path, "date,count\n2024-01-01,5\n2024-01-02,9\n2024-01-03,7\n")
    timeline = load_timeline(path, map="count")
    assert timeline.intensity is not None
    assert list(timeline.intensity.value) == [5.0, 9.0, 7.0]
    assert numbers(load_timeline(path, map="count:1d")) == [1.0, 1.0, 1.0]


def test_a_window_that_is_not_given_is_a_round_one(tmp_path: Path) -> None:
    for days, words in ((0.001, "1s"), (1.0, "5min"), (300.0, "1d"), (20_000.0, "1y")):
        times = [START + timedelta(days=days * i / 50.0) for i in range(51)]
        path = write(tmp_path, "\n".join(["t,who", *rows_of(times)]))
        timeline = load_timeline(path, map="count")
        assert any(f"windows of {words} (map count:{words})" in note for note in timeline.notes)
        assert len(numbers(timeline)) <= counting.USUAL_WINDOWS + 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"map": "count:5"}, "count:'5': give a window as a time"),
        ({"map": "count:soon"}, "give a window as a time"),
        ({"map": "count:0h"}, "give a window as a time"),
        ({"map": "count:0.001s"}, r"makes 9\d{7} windows .* at most 2000000"),
        ({"map": "count", "value": "who"}, "leave value out"),
        ({"map": "count", "rate": 5.0}, "leave rate out"),
    ],
)
def test_a_count_option_that_does_not_apply_gives_a_one_line_error(
    options: dict[str, Any], words: str, tmp_path: Path
) -> None:
    path = write(tmp_path, "\n".join(["when,who", *rows_of(MOMENTS)]))
    with pytest.raises(InputError, match=words):
        load_timeline(path, **options)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(
    st.lists(st.integers(0, 400_000), min_size=1, max_size=60),
    st.sampled_from(["1s", "7s", "1min", "1h", "6h", "1d", "2d", "1w"]),
)
def test_every_row_is_in_its_window(tmp_path: Path, seconds: list[int], window: str) -> None:
    moments = [START + timedelta(seconds=s) for s in seconds]
    path = write(tmp_path, "\n".join(["when,who", *rows_of(moments)]))
    timeline = load_timeline(path, map=f"count:{window}", time="when")
    assert timeline.start is not None
    found = np.array(numbers(timeline))
    span = timeline.duration_s / len(found)
    expected = Counter(int((m - timeline.start).total_seconds() // span) for m in moments)
    assert {i: int(n) for i, n in enumerate(found) if n} == dict(expected)


def test_memory_stays_bounded_and_nothing_is_thinned(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from overview_dsp.data.timeline import growable_array

    monkeypatch.setattr(growable_array, "SPILL_BYTES", 1 << 16)  # times go to disk early
    times = np.arange(200_000)
    path = write(tmp_path, "seconds,what\n" + "".join(f"{t},x\n" for t in times))
    timeline = load_timeline(path, map="count:1000s")
    assert numbers(timeline) == [1000.0] * 200
