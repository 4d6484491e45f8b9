from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline, save_timeline
from overview_dsp.data.readers.data_file import parse_json
from overview_dsp.data.readers.native import decode, encode
from overview_dsp.data.timeline import Event, Intensity, Timeline
from overview_dsp.errors import InputError
from tests.data.readers.outcome import timeline_or_one_line
from tests.data.timeline.strategies import timelines

SMALL: dict[str, Any] = {
    "overview_timeline": 1,
    "title": "Home 1-0 Away",
    "duration_s": 100,
    "intensity": {"time_s": [0, 50, 100], "value": [1, 2.5, -3], "unit": "dB"},
    "gaps": [[10, 20.5]],
    "events": [
        {"time_s": 10, "kind": "goal", "label": "1-0 Parris (pen)", "weight": 2},
        {"time_s": 5, "kind": "foul"},
    ],
    "provenance": "made up",
    "notes": ["first", "second"],
}


def changed(**changes: Any) -> dict[str, Any]:
    return SMALL | changes


def load(tmp_path: Path, text: str) -> Timeline:
    path = tmp_path / "match.json"
    path.write_text(text, encoding="utf-8")
    return load_timeline(path)


@given(timelines())
def test_what_is_written_is_read_back_equal(timeline: Timeline) -> None:
    assert decode(parse_json(encode(timeline).decode(), "x")) == timeline


def test_a_saved_file_is_loaded_equal(tmp_path: Path) -> None:
    timeline = decode(SMALL)
    save_timeline(timeline, tmp_path / "t.json")
    assert load_timeline(tmp_path / "t.json") == timeline
    assert [path.name for path in tmp_path.iterdir()] == ["t.json"]


def test_a_saved_file_can_be_read_by_a_person() -> None:
    timeline = Timeline("Żółw", 10.0, (Event(1.0, "a"), Event(2.0, "b", "Mandžukić")))
    assert encode(timeline).decode().splitlines() == [
        '{"overview_timeline": 1,',
        ' "title": "Żółw",',
        ' "duration_s": 10.0,',
        ' "events": [',
        '  {"time_s": 1.0, "kind": "a", "label": "", "weight": 1.0},',
        '  {"time_s": 2.0, "kind": "b", "label": "Mandžukić", "weight": 1.0}',
        " ]}",
    ]


def test_the_reason_of_a_gap_is_saved_and_loaded(tmp_path: Path) -> None:
    timeline = decode({**SMALL, "gap_reasons": ["the lead is off"]})
    assert timeline.gap_reasons == ("the lead is off",)
    save_timeline(timeline, tmp_path / "t.json")
    assert load_timeline(tmp_path / "t.json") == timeline


def test_saving_where_one_cannot_gives_a_one_line_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="can't be written"):
        save_timeline(decode(SMALL), tmp_path / "nowhere" / "t.json")


def test_every_key_of_the_native_format_is_read() -> None:
    timeline = decode(SMALL)
    assert timeline == Timeline(
        "Home 1-0 Away",
        100.0,
        (Event(5.0, "foul"), Event(10.0, "goal", "1-0 Parris (pen)", 2.0)),
        Intensity(np.array([0.0, 50.0, 100.0]), np.array([1.0, 2.5, -3.0]), "dB"),
        ((10.0, 20.5),),
        "made up",
        ("first", "second"),
    )


def test_only_the_version_a_duration_and_one_of_events_and_intensity_are_required(
    tmp_path: Path,
) -> None:
    least = {"overview_timeline": 1, "duration_s": 3.0, "events": [{"time_s": 1, "kind": "a"}]}
    timeline = load(tmp_path, json.dumps(least))
    assert timeline == Timeline("match", 3.0, (Event(1.0, "a"),))
    with pytest.raises(InputError, match="neither events nor an intensity"):
        load(tmp_path, json.dumps({"overview_timeline": 1, "duration_s": 3.0}))
    with pytest.raises(InputError, match="lacks the key 'duration_s'"):
        load(tmp_path, json.dumps({"overview_timeline": 1}))


@pytest.mark.parametrize(
    ("document", "words"),
    [
        (changed(colour="red"), r"unknown key 'colour'; known are overview_timeline, title"),
        (changed(events=[{"time_s": 1, "kind": "a", "tme": 2}]), r"events\[0\] has an unknown"),
        (changed(intensity={"time_s": [0], "value": [0], "units": ""}), "intensity has an unknown"),
        (changed(overview_timeline=2), "overview_timeline is 2; this program reads version 1"),
        (changed(overview_timeline=True), "overview_timeline is True"),
        (changed(overview_timeline="1"), "overview_timeline is '1'"),
        (changed(title=3), "title is 3, not text"),
        (changed(title=None), "title is None, not text"),
        (changed(duration_s="long"), "duration_s is 'long', not a number"),
        (changed(start="soon"), "start is 'soon', not a date and time"),
        (changed(start=3), "start is 3, not text"),
        (changed(start="9999-12-31T23:59:59"), "end after the year 9999"),
        (changed(duration_s=0), r"duration_s is 0\.0, not above 0"),
        (changed(events={}), r"events is \{\}, not a list"),
        (changed(events=[3]), r"events\[0\] is 3, not an object"),
        (changed(events=[{"kind": "a"}]), r"events\[0\] lacks the key 'time_s'"),
        (changed(events=[{"time_s": 1}]), r"events\[0\] lacks the key 'kind'"),
        (changed(events=[{"time_s": 1, "kind": "a b"}]), r"events\[0\].kind is 'a b'"),
        (changed(events=[{"time_s": True, "kind": "a"}]), r"events\[0\].time_s is True"),
        (changed(events=[{"time_s": "1", "kind": "a"}]), r"events\[0\].time_s is '1'"),
        (changed(events=[{"time_s": -1, "kind": "a"}]), r"events\[0\].time_s is -1\.0, outside"),
        (changed(events=[{"time_s": 101, "kind": "a"}]), r"events\[0\].time_s is 101\.0, outside"),
        (changed(events=[{"time_s": 1, "kind": "a", "label": 1}]), r"events\[0\].label is 1"),
        (changed(events=[{"time_s": 1, "kind": "a", "weight": 0}]), r"events\[0\].weight is 0"),
        (changed(intensity=[1, 2]), "intensity is .*, not an object"),
        (changed(intensity=None), "intensity is None, not an object"),
        (changed(intensity={"time_s": [0]}), "intensity lacks the key 'value'"),
        (changed(intensity={"time_s": 0, "value": [0]}), "intensity.time_s is 0, not a list"),
        (
            changed(intensity={"time_s": [0, 1], "value": [0, "a"]}),
            r"intensity.value\[1\] is 'a', not a number",
        ),
        (
            changed(intensity={"time_s": [0, 1, 1], "value": [0, 0, 0]}),
            r"intensity.time_s\[2\] is 1\.0, not after",
        ),
        (changed(intensity={"time_s": [0], "value": [0], "unit": 3}), "intensity.unit is 3"),
        (changed(gap_reasons=["why", "no gap"]), "2 gap_reasons for 1 gaps"),
        (changed(gap_reasons=[1]), r"gap_reasons\[0\] is 1"),
        (changed(gap_reasons="why"), r"gap_reasons is 'why', not a list"),
        (changed(gaps=[[1, 2, 3]]), r"gaps\[0\] has 3 numbers"),
        (changed(gaps=[5]), r"gaps\[0\] is 5, not a list"),
        (changed(gaps=[[1, None]]), r"gaps\[0\]\[1\] is None"),
        (changed(notes="note"), "notes is 'note', not a list"),
        (changed(notes=[1]), r"notes\[0\] is 1, not text"),
        (changed(provenance=[]), r"provenance is \[\], not text"),
    ],
)
def test_a_wrong_key_or_type_is_named_with_file_and_place(
    document: dict[str, Any], words: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=rf"match\.json: .*{words}") as caught:
        load(tmp_path, json.dumps(document))
    assert str(caught.value).count("match.json") == 1


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"time_s": 5', '"time_s": NaN', r"events\[1\].time_s is nan, not a finite"),
        ('"time_s": 5', '"time_s": -Infinity', r"events\[1\].time_s is -inf, not a finite"),
        ("2.5", "1e999", r"intensity.value\[1\] is inf"),
        ("2.5", "9" * 5000, r"intensity.value\[1\] is inf"),
        ("2.5", "9" * 390, r"intensity.value\[1\] is inf"),
        ('"weight": 2', '"weight": Infinity', r"events\[0\].weight is inf"),
        ("20.5", "NaN", r"gaps\[0\]\[1\] is nan"),
        ('"first"', '"\\ud800"', r"notes\[0\] has a lone surrogate"),
        ('"goal"', '"\\udc00"', r"events\[0\].kind is '\\udc00'"),
        ('"dB"', '"\\ud83d"', "intensity.unit has a lone surrogate"),
        ('"notes"', '"\\ud800"', r"unknown key '\\ud800'"),
        ('"notes"', '"title"', "the key 'title' is given twice"),
        ('["first", "second"]', "[" * 100_000, "nested too deep"),
        ('"Home 1-0 Away"', "{" + '"a":{' * 50_000, "nested too deep"),
    ],
)
def test_a_hostile_value_gives_a_printable_one_line_error(
    old: str, new: str, words: str, tmp_path: Path
) -> None:
    text = json.dumps(SMALL)
    assert old in text
    with pytest.raises(InputError, match=words) as caught:
        load(tmp_path, text.replace(old, new))
    assert len(str(caught.value).encode()) < 600


def test_cut_off_json_is_named_with_line_and_column(tmp_path: Path) -> None:
    text = json.dumps(SMALL, indent=1)
    cut = text[: text.index('"kind": "foul"')].rstrip()
    with pytest.raises(InputError, match=r"line 32, column \d+ .*cut off") as caught:
        load(tmp_path, cut)
    assert cut.count("\n") + 1 == 32, caught.value


def test_json_broken_in_the_middle_is_named_with_line_and_column(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"line 2, column 2 .*correct it there"):
        load(tmp_path, '{"overview_timeline": 1,\n ;"title": "a"}')


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_a_byte_order_mark_is_no_obstacle(encoding: str, tmp_path: Path) -> None:
    path = tmp_path / "t.json"
    path.write_text(json.dumps(SMALL | {"title": "Żółw"}, ensure_ascii=False), encoding=encoding)
    assert load_timeline(path).title == "Żółw"


JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(st.characters(), max_size=5)
    | st.just(10**400),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=6,
)


@given(
    st.sampled_from(
        [("title",), ("duration_s",), ("gaps",), ("gaps", 0), ("gaps", 0, 1), ("notes",)]
        + [("events",), ("events", 0), ("intensity",), ("overview_timeline",), ("provenance",)]
        + [("events", 0, key) for key in ("time_s", "kind", "label", "weight")]
        + [("intensity", key) for key in ("time_s", "value", "unit")]
        + [("intensity", "value", 1)]
    ),
    JSON,
)
def test_any_value_anywhere_gives_a_timeline_or_a_one_line_error(
    path: tuple[Any, ...], new: Any
) -> None:
    document = json.loads(json.dumps(SMALL))
    inside = document
    for step in path[:-1]:
        inside = inside[step]
    inside[path[-1]] = new
    timeline_or_one_line(lambda: decode(document))


def test_a_growing_timeline_with_the_old_key_until_s_still_loads() -> None:
    events = [{"time_s": 1.0, "kind": "goal"}]
    for key in ("until_s", "known_until_s"):
        document = {"overview_timeline": 1, "duration_s": 9.0, key: 4.0, "events": events}
        assert decode(document).known_until_s == 4.0
