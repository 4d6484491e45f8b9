from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.events.event_table import decode, encode
from overview_dsp.data.timeline import Event, Intensity, Timeline
from overview_dsp.errors import InputError
from tests.data.readers.outcome import timeline_or_one_line
from tests.data.timeline.strategies import timelines

SMALL = "time_s,kind,label,weight\n10,beat,one,2\n20.5,beat,,\n"


def load(tmp_path: Path, text: str, duration_s: float | None = None) -> Timeline:
    path = tmp_path / "list.csv"
    path.write_bytes(text.encode())
    return load_timeline(path, duration_s)


def test_an_event_list_is_read_and_ends_with_its_last_event(tmp_path: Path) -> None:
    timeline = load(tmp_path, SMALL)
    assert timeline.title == "list"
    assert timeline.duration_s == 20.5
    assert timeline.events == (Event(10.0, "beat", "one", 2.0), Event(20.5, "beat"))
    assert timeline.intensity is None


@pytest.mark.parametrize(
    "text",
    [
        "\ufeff" + SMALL,
        SMALL.replace("\n", "\r\n"),
        SMALL.replace("\n", "\r"),
        SMALL.replace(",", ";"),
        SMALL.replace(",", "\t"),
        SMALL.replace("\n", "\n\n"),
        SMALL.rstrip("\n"),
        "label,weight,kind,time_s\none,2,beat,10\n,,beat,20.5",
        " Time_S , KIND,label,weight\n 10 , beat ,one, 2\n20.5,beat,,,\n".replace(",,,", ",,"),
        '"time_s","kind","label","weight"\n"10","beat","one","2"\n20.5,"beat","",""\n',
        SMALL.replace(",,\n", "\n"),
        "# a remark\n\n" + SMALL.replace("20.5", "# another\n20.5"),
        SMALL.replace("10", "1e1").replace("20.5", "+2.05E1"),
    ],
)
def test_the_same_list_written_otherwise_is_the_same(text: str, tmp_path: Path) -> None:
    assert load(tmp_path, text) == load(tmp_path, SMALL)


def test_only_time_and_kind_are_required(tmp_path: Path) -> None:
    assert load(tmp_path, "kind,time_s\nbeat,3\n").events == (Event(3.0, "beat"),)


def test_quoted_labels_may_hold_separators_quotes_and_line_breaks(tmp_path: Path) -> None:
    timeline = load(tmp_path, 'time_s,kind,label\n1,a,"x, ""y""\n# z"\n2,b,"#1"\n')
    assert [event.label for event in timeline.events] == ['x, "y"\n# z', "#1"]


def test_comments_give_title_and_duration(tmp_path: Path) -> None:
    timeline = load(tmp_path, "# title: Home: 1-0, Away\n#duration_s: 90\n" + SMALL)
    assert timeline.title == "Home: 1-0, Away"
    assert timeline.duration_s == 90.0


def test_a_given_duration_outranks_the_files(tmp_path: Path) -> None:
    assert load(tmp_path, "# duration_s: 90\n" + SMALL, 95.0).duration_s == 95.0


def test_an_unquoted_label_that_begins_with_a_hash_is_not_lost(tmp_path: Path) -> None:
    timeline = load(tmp_path, "label,time_s,kind\n#1 beat,3,beat\n")
    assert timeline.events == (Event(3.0, "beat", "#1 beat"),)


def test_a_list_with_football_kinds_gets_a_crowd_curve(tmp_path: Path) -> None:
    timeline = load(tmp_path, "time_s,kind\n100,goal\n600,period\n700,whatever\n")
    assert timeline.intensity is not None
    assert float(timeline.intensity_at(100.0)) > 0.8
    assert "applied to the events, not a recording" in timeline.provenance


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time_s,kind\nten,a\n", "line 2, column 'time_s': 'ten' isn't a number"),
        ("time_s,kind\n1_0,a\n", "line 2, column 'time_s': '1_0' isn't a number"),
        ("time_s,kind\n١,a\n", "line 2, column 'time_s': '١' isn't a number"),
        ("time_s;kind\n1,5;a\n", "line 2, column 'time_s': '1,5' .* with a decimal point"),
        ("time_s,kind\n1,a\n\nNaN,a\n", "line 4, column 'time_s': 'NaN' isn't a finite"),
        ("time_s,kind\n-inf,a\n", "line 2, column 'time_s': '-inf' isn't a finite"),
        ("time_s,kind\n1e999,a\n", "line 2, column 'time_s': '1e999' isn't a finite number"),
        ("time_s,kind\n-1,a\n", r"line 2, column 'time_s': -1\.0 is before the start"),
        ("time_s,kind\n,a\n", "line 2, column 'time_s': is missing"),
        ("time_s,kind\n1,\n", "line 2, column 'kind': is missing"),
        ("time_s,kind\n1\n", "line 2, column 'kind': is missing"),
        ("time_s,kind\n1,Near Miss\n", "line 2, column 'kind': .*try 'near_miss'"),
        ("time_s,kind,weight\n1,a,0\n", r"line 2, column 'weight' is 0\.0, not above 0"),
        ("time_s,kind,weight\n1,a,big\n", "line 2, column 'weight': 'big' isn't a number"),
        ("time_s,kind,colour\n1,a,red\n", "line 1, column 3: unknown column 'colour'"),
        ("time_s,kind,kind\n1,a,b\n", "line 1, column 3: 'kind' is repeated"),
        ("moment_s,kind\n1,a\n", "line 1, column 1: unknown column 'moment_s'; columns: time_s"),
        ("# x\nkind\na\n", "line 2: the header has no column 'time_s'"),
        ("time_s,kind,label\n1,a,b\n1,a,b\n", "line 3 repeats line 2"),
        ("time_s,kind\n1,a,b,c\n", "line 2: 4 fields for 2 columns"),
        ('time_s,kind,label\n1,a,b\n2,a,"b\n', "line 3: .*check the quotes"),
        ('time_s,kind,label\n1,a,"b\nb"\n2,a,"c\nc"\nx,a,\n', "line 6, column 'time_s': 'x'"),
        ('time_s,kind,label\n1,a,b\nx,a,"c\nc"\n', "line 3, column 'time_s': 'x'"),
        ("time_s,kind\n", "the file has no events"),
        ("time_s,kind\n0,a\n", "duration is unknown; set duration_s"),
        ("# duration_s: long\ntime_s,kind\n0,a\n", "line 1: 'long' isn't a number; the duration"),
        ("# duration_s: 0\ntime_s,kind\n0,a\n", r"line 1, duration_s is 0\.0, not above 0"),
        ("# title: a\n# title: b\ntime_s,kind\n0,a\n", "line 2: '# title:' is repeated"),
        ("# duration_s: 5\ntime_s,kind\n2,a\n6,a\n", r"line 4, .* 6 s is after the end"),
    ],
)
def test_a_wrong_row_is_named_with_file_line_and_column(
    text: str, words: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=rf"list\.csv: .*{words}") as caught:
        load(tmp_path, text)
    assert str(caught.value).count("list.csv") == 1


def test_a_single_event_at_0_needs_a_duration_and_takes_one(tmp_path: Path) -> None:
    assert load(tmp_path, "time_s,kind\n0,a\n", 30.0).duration_s == 30.0


def test_a_field_beyond_the_csv_modules_limit_gives_a_one_line_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="line 2: field larger"):
        load(tmp_path, f"time_s,kind,label\n1,a,{'x' * 200_000}\n")


def test_what_is_written_is_read_back(tmp_path: Path) -> None:
    timeline = load(tmp_path, "# title: A, B\n# duration_s: 90\n" + SMALL)
    assert decode(encode(timeline).decode()) == timeline
    with pytest.raises(InputError, match="no events, and an event list contains nothing else"):
        encode(Timeline("x", 9.0, (), Intensity(np.zeros(1), np.zeros(1))))


@given(timelines())
def test_the_events_of_any_timeline_are_written_and_read_back(timeline: Timeline) -> None:
    if not timeline.events:
        return
    again = decode(encode(timeline).decode())
    assert [(e.time_s, e.kind, e.weight) for e in again.events] == [
        (e.time_s, e.kind, e.weight) for e in timeline.events
    ]
    assert [e.label for e in again.events] == [e.label.strip() for e in timeline.events]
    assert again.duration_s == timeline.duration_s


LABELS = st.text(st.characters(exclude_categories=("Cs", "Cc")), max_size=8).map(str.strip)


@given(
    st.lists(
        st.builds(
            Event, st.floats(0.0, 1e6), st.sampled_from(("a", "goal")), LABELS, st.floats(0.1, 9.0)
        ),
        min_size=1,
        max_size=8,
        unique_by=lambda event: (event.time_s, event.kind, event.label),
    ),
    st.sampled_from(",;\t"),
    st.permutations(("time_s", "kind", "label", "weight")),
)
def test_any_list_written_as_csv_is_read_back(
    events: list[Event], delimiter: str, columns: list[str]
) -> None:
    text = io.StringIO()
    writer = csv.writer(text, delimiter=delimiter, quoting=csv.QUOTE_ALL)
    writer.writerow(columns)
    writer.writerows([getattr(event, column) for column in columns] for event in events)
    read = decode(text.getvalue(), duration_s=1e6)
    assert read.events == Timeline("", 1e6, tuple(events)).events


@given(st.data())
def test_any_change_of_a_list_gives_a_timeline_or_a_one_line_error(data: st.DataObject) -> None:
    text = '# title: x\n# duration_s: 99\ntime_s,kind,label,weight\n1,goal,"a, b",2\n3,foul,,\n'
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text)))
        cut = data.draw(st.integers(0, 6))
        new = data.draw(st.text(st.sampled_from('",;\t\r\n#-.e1naif_ x\0é\ud800'), max_size=4))
        text = text[:at] + new + text[at + cut :]
    timeline_or_one_line(lambda: decode(text))
