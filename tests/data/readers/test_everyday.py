"""Everyday event lists: labels, cues, calendars, lines of a time and words; broken ones too."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.events.timeline_builder import ListEntry, kind_of, with_kinds
from overview_dsp.data.readers.tables.column_names import NAMES
from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import InputError
from tests.data.readers.shapes import all_shapes
from tests.data.readers.tables.test_robustness import changed, check, relaxed

EVENT_ROLES = ("event_times", "event_kinds", "event_labels", "event_extras")
EVENT_WORDS = (*(word for role in EVENT_ROLES for word in NAMES[role]), "x")
LISTS = tuple(shape.data for shape in all_shapes() if shape.kinds)


def load(tmp_path: Path, text: str, **options: Any) -> Timeline:
    path = tmp_path / "made"
    path.write_text(text, encoding="utf-8")
    return load_timeline(path, **options)


def told(timeline: Timeline) -> list[tuple[float, str, str]]:
    return [(event.time_s, event.kind, event.label) for event in timeline.events]


@pytest.mark.parametrize(
    ("words", "kind"),
    [
        ("Own goal", "own_goal"),
        ("Début", "debut"),
        ("Fußball!", "fussball"),
        ("a sentence of many words in all", ""),
        ("...", ""),
        ("x" * 41, ""),
    ],
)
def test_words_become_a_kind_unless_they_are_a_sentence(words: str, kind: str) -> None:
    assert kind_of(words) == kind


def test_names_that_come_again_are_kinds_and_others_are_not() -> None:
    def kinds(*texts: str) -> list[str]:
        listed = [ListEntry(0.0, text, "", "line 1", None) for text in texts]
        return [one.kind_text for one in with_kinds(listed, "label")]

    assert kinds("laugh", "cough", "laugh", "laugh") == ["laugh", "cough", "laugh", "laugh"]
    assert kinds("Ann", "Bob", "Cy") == ["label"] * 3
    assert kinds("laugh", "laugh", "laugh and then a long, long story") == ["label"] * 3


def test_labels_of_one_thing_each_keep_their_words(tmp_path: Path) -> None:
    timeline = load(tmp_path, "start,name\n0:10,Intro\n0:50,The first verse\n")
    assert told(timeline) == [(10.0, "event", "Intro"), (50.0, "event", "The first verse")]
    both = load(tmp_path, "start,type,name\n0:10,verse,One\n0:50,verse,Two\n")
    assert told(both) == [(10.0, "verse", "One"), (50.0, "verse", "Two")]


def test_cues_have_text_without_style_and_sounds_in_brackets_are_kinds(tmp_path: Path) -> None:
    cues = (
        "WEBVTT\n\nNOTE made up\n\nintro\n00:01.000 --> 00:04.500 align:start\n<v Ann>Hello "
        "<i>you</i> &amp; me\nhow are you?\n\n1:00:05.000 --> 1:00:06.000\n[Laughter]\n"
    )
    timeline = load(tmp_path, cues)
    assert told(timeline) == [
        (1.0, "cue", "Hello you & me how are you?"),
        (3605.0, "laughter", ""),
    ]
    assert timeline.duration_s == 3606.0
    with pytest.raises(InputError, match=r"line 3: 'soon --> later' is not the time of a cue"):
        load(tmp_path, "1\n\nsoon --> later\nx\n\n00:01:00,000 --> 00:01:02,000\ny\n")


CALENDAR = """BEGIN:VCALENDAR
BEGIN:VEVENT
UID:1
DTSTART;tzid=Europe/Berlin:20241027T023000
SUMMARY:Before\\, perhaps
BEGIN:VALARM
DTSTART:19990101
END:VALARM
RRULE:FREQ=DAILY
END:VEVENT
BEGIN:VEVENT
UID:2
DTSTART:20241027T013000Z
DTEND:20241027T023000Z
CATEGORIES:Clock change,Other
SUMMARY:After a long
  line
END:VEVENT
END:VCALENDAR
"""


def test_a_calendars_entries_lie_where_they_happened(tmp_path: Path) -> None:
    timeline = load(tmp_path, CALENDAR)
    # half past two is there twice; UTC tells which
    assert told(timeline) == [
        (0.0, "event", "Before, perhaps"),
        (3600.0, "clock_change", "After a long line"),
    ]
    assert timeline.duration_s == 7200.0
    assert timeline.start is not None
    assert timeline.start.isoformat() == "2024-10-27T00:30:00+00:00"
    assert any("1 entries recur" in note for note in timeline.notes)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("20241027T013000Z", "soon", r"line 13, DTSTART: 'soon' isn't a time"),
        ("DTSTART:20241027T013000Z\n", "", "the VEVENT has no DTSTART"),
        ("VEVENT", "VTODO", "the calendar has no events; must contain a VEVENT"),
        ("20241027T013000Z", "20241399", "line 13, DTSTART"),
    ],
)
def test_a_broken_calendar_gives_a_one_line_error(
    tmp_path: Path, old: str, new: str, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        load(tmp_path, CALENDAR.replace(old, new))


@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_subtitles_are_named_by_their_format_with_and_without_a_mark(
    tmp_path: Path, mark: str
) -> None:
    cue = "00:00:10.000 --> 00:00:12.000\nHello\n"
    assert "WebVTT" in load(tmp_path, f"{mark}WEBVTT\n\n{cue}").provenance
    assert "SubRip" in load(tmp_path, f"{mark}1\n{cue.replace('.', ',')}").provenance


def test_weights_are_read_and_a_wrong_one_is_named(tmp_path: Path) -> None:
    rows = "clock,event,weight\n0:10,laugh,2.5\n0:50,laugh,\n1:00,laugh,NA\n"
    assert [event.weight for event in load(tmp_path, rows).events] == [2.5, 1.0, 1.0]
    for wrong, words in (("x", "isn't a number; weights must be above 0"), ("-1", "above 0")):
        with pytest.raises(InputError, match=f"line 2, column 'weight'.*{words}"):
            load(tmp_path, rows.replace("2.5", wrong))


def test_a_label_track_takes_a_length(tmp_path: Path) -> None:
    track = "10.0\t10.0\tlaugh\n50.0\t50.0\tcough\n"
    assert load(tmp_path, track, duration_s=80.0).duration_s == 80.0
    assert load(tmp_path, track).duration_s == 50.0


def test_the_largest_list_of_a_document_is_read(tmp_path: Path) -> None:
    few = [{"time": "0:10", "event": "laugh"}] * 2
    many = [{"time": f"0:{second}", "event": "cough"} for second in range(10, 50)]
    for document in ({"a": few, "b": many}, {"a": many, "b": few}):
        assert load(tmp_path, json.dumps(document)).kinds() == {"cough": 40}


def test_a_list_that_is_half_football_has_a_curve(tmp_path: Path) -> None:
    rows = "clock,event\n0:10,goal\n0:50,laugh\n"
    assert load(tmp_path, rows).intensity is not None
    assert load(tmp_path, rows + "0:55,cough\n").intensity is None


def test_a_length_is_taken_and_has_to_reach_to_the_last_event(tmp_path: Path) -> None:
    rows = "start,what\n0:10,a\n0:50,b\n"
    assert load(tmp_path, rows, duration_s=100.0).duration_s == 100.0
    with pytest.raises(InputError, match=r"line 3: 50 s is after the end .*duration_s 20\.0"):
        load(tmp_path, rows, duration_s=20.0)
    with pytest.raises(InputError, match="all events have the same time"):
        load(tmp_path, "start,what\n0:00,a\n0:00,b\n")


def test_markers_by_measures_and_beats_are_refused_with_the_fix(tmp_path: Path) -> None:
    path = tmp_path / "markers.csv"
    path.write_text("#,Name,Start\nM1,intro,1.1.00\nM2,verse,5.1.00\n")
    with pytest.raises(InputError) as refused:
        load_timeline(path)
    first, second = str(refused.value).splitlines()
    assert "measures and beats ('1.1.00')" in first
    assert "ruler" in second


def test_rows_without_a_time_and_repeated_rows_are_noted(tmp_path: Path) -> None:
    timeline = load(tmp_path, "start,what\n0:10,a\n,b\n0:10,a\n0:50,c\n")
    assert len(timeline.events) == 2
    assert any("1 rows without a time" in note for note in timeline.notes)
    assert any("1 rows repeat another row" in note for note in timeline.notes)


def test_a_wrong_cell_is_named_with_line_and_column(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"line 4, column 'start': 'soon' isn't a time"):
        load(tmp_path, "start,what\n0:10,a\n0:20,b\nsoon,c\n0:50,d\n0:55,e\n")
    with pytest.raises(InputError, match=r"line 3, column 'weight': 'big' isn't a number"):
        load(tmp_path, "start,what,weight\n0:10,a,2\n0:20,b,big\n")


def test_a_table_with_a_quantity_is_a_series_with_words_beside_it(tmp_path: Path) -> None:
    rows = "".join(f"2024-06-{day:02d},calm,{day}.5\n" for day in range(1, 20))
    timeline = load(tmp_path, f"date,event,wind speed\n{rows}")
    assert timeline.intensity is not None
    assert timeline.intensity.count == 19


WISHES = {
    "time": st.sampled_from(["time", "start:hhmm", ":min", "x"]),
    "duration_s": st.floats(1e-9, 1e9),
}


@relaxed
@given(changed(LISTS), st.fixed_dictionaries({}, optional=WISHES))
def test_a_changed_list_gives_a_timeline_or_a_short_error(
    tmp_path: Path, data: bytes, options: dict[str, Any]
) -> None:
    check(tmp_path / "x", data, options)


@relaxed
@given(
    names=st.lists(st.sampled_from(EVENT_WORDS), max_size=6),
    cells=st.lists(
        st.sampled_from(("0:45", "goal", "x", "", "1", "08:30", '"', "2014-01-01", "9e9", "-3")),
        max_size=18,
    ),
)
def test_any_header_of_known_columns_gives_a_timeline_or_a_short_error(
    names: list[str], cells: list[str], tmp_path: Path
) -> None:
    width = max(len(names), 1)
    lines = [",".join(cells[i : i + width]) for i in range(0, len(cells), width)]
    check(tmp_path / "x", ("\n".join([",".join(names), *lines]) + "\n").encode(), {})


def test_an_end_is_a_moment_and_a_length_counts_from_the_begin(tmp_path: Path) -> None:
    ends = "start,end,name\n0:10,0:20,Intro\n0:50,1:10,The first verse\n"
    assert load(tmp_path, ends).duration_s == 70.0
    lengths = "start,duration,name\n0:10,0:10,Intro\n0:50,0:20,The first verse\n"
    assert load(tmp_path, lengths).duration_s == 70.0
