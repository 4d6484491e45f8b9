"""Marks of one's own: set, felt, named, undone and kept, while no other event moves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.cli.options.follow import _marks_path
from overview_dsp.data.feeds.timeline_diff import apply_diff, timeline_diff
from overview_dsp.data.timeline.model import with_marks
from overview_dsp.devices.controllers.control_map import parse_map
from overview_dsp.devices.controllers.control_messages import Command
from overview_dsp.devices.controllers.midi_messages import MidiReader
from overview_dsp.devices.controllers.osc_messages import OscReader, encode_message
from overview_dsp.errors import InputError
from overview_dsp.live.session.marks import MarksFile
from overview_dsp.signal.surface.angle_map import AngleMap
from tests.live.stepped_session import BLOCK, RATE, Session, event


@pytest.fixture
def timeline():
    """Events close together, so that the angle map is not linear."""
    times = (600, 610, 620, 4000, 5000)
    return ov.Timeline("Home - Away", 5700.0, tuple(event(at, "goal") for at in times))


@pytest.fixture
def open_session(timeline, tmp_path, monkeypatch):
    opened = []

    def opening(**keywords):
        keywords = {"timeline": timeline, "marks": MarksFile(tmp_path / "a.marks.json"), **keywords}
        opened.append(Session(ov.LiveTimeline(), monkeypatch, **keywords))
        return opened[-1]

    yield opening
    for one in opened:
        one.player.close()


def marks_of(session):
    return [one for one in session.window_timeline.events if one.kind == "mark"]


def set_mark(session, position, *name):
    """Return the disk's position at the command."""
    session.player.touch(position)
    session.run(1.0)
    cursor = session.player.engine.meters.cursor
    session.player.queue_command("mark", *name)
    session.run(0.5)
    return cursor


def test_a_mark_is_set_at_the_disk_and_felt_and_moves_no_other_event(open_session):
    session = open_session()
    before = session.player.engine.surface.position.copy()
    cursor = set_mark(session, 0.5, "what", "a", "pass")
    (mark,) = marks_of(session)
    assert mark.label == "what a pass"
    surface = session.player.engine.surface
    is_mark = np.array(
        [session.window_timeline.events[one].kind == "mark" for one in surface.event]
    )
    np.testing.assert_array_equal(surface.position[~is_mark], before)
    # the time is stored in ms
    assert float(surface.position[is_mark][0]) == pytest.approx(cursor, abs=1e-6)
    session.player.release()
    session.run(1.0)
    session.player.engine.pop_strike_events()
    session.player.touch(0.6)
    session.run(1.0)
    struck = [found.kind for found, _ in session.player.engine.pop_strike_events()]
    assert struck.count("mark") == 1


def test_marks_are_named_and_undone(open_session):
    session = open_session()
    set_mark(session, 0.5)
    set_mark(session, 0.6)
    session.player.queue_command("name-mark", "the", "turn")
    session.run(0.5)
    assert [one.label for one in marks_of(session)] == ["", "the turn"]
    session.player.queue_command("unmark")
    session.run(0.5)
    assert [one.label for one in marks_of(session)] == [""]
    for command in (["unmark"], ["unmark"], ["name-mark", "x"]):
        session.player.queue_command(*command)
    session.run(0.5)
    assert not marks_of(session)
    assert sum("there is no mark" in line for line in session.messages) == 2


def test_marks_are_kept_for_the_next_session(open_session, tmp_path, timeline):
    session = open_session()
    set_mark(session, 0.5, "a")
    set_mark(session, 0.7, "b")
    session.player.close()
    again = open_session()
    again.run(0.5)
    assert marks_of(again) == marks_of(session)
    # a session of a window has the marks inside it, at their places, and keeps the others
    first, second = (one.time_s for one in marks_of(again))
    part = open_session(
        timeline=timeline.window(first + 100.0, 5700.0),
        marks=MarksFile(tmp_path / "a.marks.json", first + 100.0),
    )
    part.run(0.5)
    assert [one.time_s for one in marks_of(part)] == pytest.approx([second - first - 100.0])
    set_mark(part, 0.9)
    loaded = ov.load_timeline(tmp_path / "a.marks.json")
    assert [one.label for one in loaded.events] == ["a", "b", ""]
    assert loaded.events[0].time_s == pytest.approx(first)


@pytest.mark.parametrize(
    "text",
    ["{", "[]", '{"events": 3}', '{"events": [3]}', '{"events": [{"time_s": 1, "kind": "goal"}]}',
     '{"events": [{"time_s": -1, "kind": "mark"}]}'],
)  # fmt: skip
def test_a_damaged_file_of_marks_is_one_line_and_stays_as_it_is(open_session, tmp_path, text):
    path = tmp_path / "a.marks.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"a\.marks\.json") as raised:
        open_session()
    assert "\n" not in str(raised.value)
    assert path.read_text() == text


def test_a_mark_that_cannot_be_stored_is_said_and_still_felt(open_session, tmp_path):
    session = open_session()
    (tmp_path / "a.marks.json").mkdir()
    set_mark(session, 0.5)
    assert len(marks_of(session)) == 1
    assert any("mark: " in line and "a.marks.json" in line for line in session.messages)


@pytest.mark.parametrize("start", ["first sample", "later", "at rest"])
def test_a_take_has_its_marks_and_renders_what_was_felt(
    open_session, timeline, tmp_path, monkeypatch, start
):
    take = tmp_path / "take.csv"
    session = open_session(record=take if start == "first sample" else None)
    monkeypatch.chdir(tmp_path)
    if start != "first sample":
        set_mark(session, 0.4, "earlier")
        session.player.takes.folder = tmp_path
        if start == "at rest":
            session.player.release()
            session.run(4.0)
        session.player.queue_command("record")
        session.run(0.1)
    set_mark(session, 0.5, "during")
    session.player.touch(0.8)
    session.run(1.0)
    session.player.release()
    session.run(2.0)
    session.player.queue_command("record", "0")
    session.run(0.1)
    path = session.player.takes.ended[-1]
    gesture = ov.load_gesture(path)
    made = ov.render(timeline, ov.load_preset("football"), gesture, RATE, tail="none")
    if start != "later":  # a take that starts during a touch renders from rest
        count = len(made.samples) // BLOCK * BLOCK
        np.testing.assert_array_equal(made.samples[:count], session.samples[:count])
    kept = {
        one["label"]
        for change in gesture.changes
        for one in change.what.get("timeline", {}).get("marks", ())
    }
    assert kept == ({"during"} if start == "first sample" else {"earlier", "during"})


def test_new_data_of_a_live_timeline_keep_the_marks(open_session, monkeypatch, tmp_path):
    live = ov.LiveTimeline("Home - Away", expected_duration_s=5700.0)
    live.append(events=[event(300, "goal")], clock_s=3000.0)
    session = Session(live, monkeypatch, announce="none", marks=MarksFile(tmp_path / "b.json"))
    set_mark(session, 0.2)
    session.player.release()
    session.run(3.0)
    (mark,) = marks_of(session)
    live.append(events=[event(2000, "foul")], clock_s=3100.0)
    session.run(3.0)
    assert marks_of(session) == [mark]
    assert "foul" in {one.kind for one in session.window_timeline.events}
    session.player.close()


def test_in_no_window_a_mark_takes_the_room_of_another_event_or_moves_it(match, football):
    rng = np.random.default_rng(0)
    curve = ov.Intensity(86_400.0 * np.arange(3000), 100.0 + np.cumsum(rng.normal(size=3000)))
    series = ov.Timeline("a share", 3000 * 86_400.0, (event(0, "period"),), curve)
    for whole in (match, series, match.window(1000.0, 3000.0)):
        marked = with_marks(whole, [event(whole.duration_s * part, "mark") for part in (0.5, 0.52)])
        assert apply_diff(whole, timeline_diff(whole, marked)) == marked
        for share in (1.0, 0.3, 0.1, 0.03):
            start, end = whole.duration_s * np.array([0.5 - share / 2.0, 0.5 + share / 2.0])
            plain, shown = whole.window(start, end), marked.window(start, end)
            others = [one.kind != "mark" for one in shown.events]
            assert tuple(np.compress(others, np.array(shown.events, object))) == plain.events
            assert not all(others)
            before, after = (AngleMap.of(one, football) for one in (plain, shown))
            np.testing.assert_array_equal(after.events[others], before.events)


def test_a_zoomed_session_of_a_window_with_a_mark_plays_what_its_take_renders(
    open_session, match, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    part = match.window(1000.0, 3000.0)
    session = open_session(timeline=part, record=tmp_path / "take.csv")
    set_mark(session, 0.5)
    session.player.show(500.0, 1500.0)
    session.run(1.0)
    session.player.touch(0.8)
    session.run(1.0)
    session.player.queue_command("record", "0")
    session.run(0.1)
    gesture = ov.load_gesture(session.player.takes.ended[-1])
    made = ov.render(part, ov.load_preset("football"), gesture, RATE, tail="none")
    count = len(made.samples) // BLOCK * BLOCK
    np.testing.assert_array_equal(made.samples[:count], session.samples[:count])


@pytest.mark.parametrize(
    ("source", "name"),
    [
        ("world-cup-final-2018", "world-cup-final-2018.marks.json"),
        ("https://example.org/v1/fixtures?id=7&key=secret", "fixtures.marks.json"),
        ("-", "live.marks.json"),
        ("https://example.org/", "live.marks.json"),
    ],
)
def test_marks_of_what_is_no_file_are_kept_in_the_current_folder(source, name):
    assert _marks_path(source) == Path(name)


def test_osc_and_midi_set_marks():
    asked = [
        (one.arguments if isinstance(one, Command) else one)
        for address, values in (("mark", []), ("mark", ["a", "b"]), ("unmark", []))
        for one in OscReader().read(encode_message(f"/overview/{address}", values), 0.0)
    ]
    assert asked == [("mark",), ("mark", "a", "b"), ("unmark",)]
    for control, press, release in (
        ("note 60", b"\x90\x3c\x40", b"\x80\x3c\x00"),
        ("cc 64", b"\xb0\x40\x7f", b"\xb0\x40\x00"),
    ):
        text = f'schema = 1\n[[control]]\ncontrol = "{control}"\nto = "mark"\n'
        reader = MidiReader(parse_map(text, "map"))
        found = [reader.read(data, 0.0) for data in (press, press, release, press)]
        again = [] if control.startswith("cc") else [Command(("mark",))]
        assert found[0] == found[3] == [Command(("mark",))]
        assert found[1] in ([], again)
        assert found[2] == []
    with pytest.raises(InputError, match="does not apply to a mark"):
        parse_map('schema = 1\n[[control]]\ncontrol = "cc 1"\nto = "mark"\nlow = 0.5\n', "map")


def test_a_mark_beyond_the_present_or_during_an_announcement_is_refused(monkeypatch, tmp_path):
    live = ov.LiveTimeline("Home - Away", expected_duration_s=5700.0)
    live.append(events=[event(300, "goal")], clock_s=2000.0)
    session = Session(live, monkeypatch, marks=MarksFile(tmp_path / "b.json"))
    session.player.touch(0.8)
    session.run(2.0)
    cursor = session.player.engine.meters.cursor
    session.player.queue_command("mark")
    session.run(0.5)
    assert cursor > 0.4
    session.player.release()
    session.run(3.0)
    assert not session.player.marks.events
    live.append(events=[event(2001, "goal")], clock_s=2002.0)
    session.run(0.1)
    session.player.queue_command("mark")
    session.run(0.1)
    assert any("being announced" in line for line in session.messages), session.messages
    assert not session.player.marks.events
    session.player.close()
