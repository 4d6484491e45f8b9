"""The side (team) of events: the score, every file format, and that it isn't felt."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.data.feeds.feed_lines import encode_line, event_object, event_of
from overview_dsp.data.feeds.timeline_diff import apply_diff, timeline_diff
from overview_dsp.data.readers import native
from overview_dsp.data.readers.events import event_table
from overview_dsp.data.readers.registry import list_matches
from overview_dsp.data.timeline.event import GOALS, score_of
from tests.data.feeds.feeds import apply_all, apply_line
from tests.data.readers import football_files, service_documents, statsbomb_match
from tests.data.timeline.strategies import timelines

TRUE = {
    "metrica/Sample_Game_1_RawEventsData.csv": (("Home", "Away"), (3, 1)),
    "statsbomb/15986.json": (("Barcelona", "Girona"), (2, 2)),
    "statsbomb/22936.json": (("England Women's", "Scotland Women's"), (2, 1)),
    "statsbomb/69321.json": (("United States Women's", "Netherlands Women's"), (2, 0)),
    "wyscout/wyscout_v2_match_2499773.json": (("Leicester City", "Liverpool"), (2, 3)),
}
"""Teams and final scores of the shared matches, from the README of the data."""


@pytest.mark.parametrize("name", TRUE)
def test_the_goals_of_the_sides_are_the_final_score(name, data_folder):
    match = ov.load_timeline(data_folder / "football" / name)
    assert (match.sides, score_of(match.events)) == TRUE[name]
    for event in match.events:
        assert event.side == 0 or event.kind != "period"
        team = match.sides[event.side - 1] if event.side else ""
        assert "(" not in event.label or event.kind in GOALS or f"({team})" in event.label


def test_all_64_matches_of_a_world_cup_have_their_score_by_sides(data_folder):
    path = data_folder / "football/openfootball/worldcup_2018.json"
    raw = json.loads(path.read_text())["matches"]
    assert len(raw) == len(list_matches(path)) == 64
    for number, one in enumerate(raw, 1):
        match = ov.load_timeline(path, match=str(number))
        assert match.sides == (one["team1"], one["team2"])
        final = one["score"].get("et") or one["score"]["ft"]
        assert list(score_of(match.events) or (0, 0)) == final, match.title


def test_matches_of_a_list_of_goals_have_the_score_of_their_title(data_folder):
    path = data_folder / "football/goalscorers_2010s.csv"
    for number in range(1, len(list_matches(path)), 200):
        match = ov.load_timeline(path, match=str(number))
        score = score_of(match.events)
        assert match.title.startswith("{} {}-{} {}".format(match.sides[0], *score, match.sides[1]))
    match = ov.load_timeline(path, match="2014-07-08 Brazil Germany")
    assert (match.sides, score_of(match.events)) == (("Brazil", "Germany"), (1, 7))


def api_goals():
    goals = [
        service_documents.api_event(10, "Goal", "Normal Goal"),
        service_documents.api_event(52, "Goal", "Own Goal", 1, "Tim Mann"),
        service_documents.api_event(60, "Goal", "Normal Goal", 2),
    ]
    return service_documents.api_football(goals, goals=(2, 1))


@pytest.mark.parametrize(
    "document",
    [
        football_files.MINUTES,
        football_files.WYSCOUT_TEXT,
        football_files.OPENFOOTBALL_TEXT,
        football_files.METRICA,
        json.dumps(statsbomb_match.full_match()),
        json.dumps(api_goals()),
        json.dumps(
            service_documents.football_data(
                [service_documents.data_goal(3), service_documents.data_goal(9, 1, "Lund")],
                score=(2, 0),
            )
        ),
        json.dumps(
            service_documents.open_liga(
                [
                    service_documents.liga_goal(0, 1, 20),
                    service_documents.liga_goal(0, 2, 50, "Lund", 2, isOwnGoal=True),
                ],
                finished=True,
            )
        ),
    ],
)
def test_each_football_reader_fills_the_sides_and_counts_own_goals_for_the_scorer(document):
    match = ov.load_timeline(document.encode())
    score, kinds = score_of(match.events), match.kinds()
    assert score is not None
    assert sum(score) == kinds.get("goal", 0) + kinds.get("own_goal", 0) > 0
    first, second = match.sides
    assert f"{first} {score[0]}-{score[1]} {second}" in match.title
    for event in match.events:  # the card of a team says which
        named = [side for side, name in enumerate(match.sides, 1) if f"({name})" in event.label]
        assert event.kind in GOALS or named in ([], [event.side])


def test_a_score_is_unknown_without_sides_or_with_a_goal_of_nobody():
    assert score_of([ov.Event(1.0, "goal")]) is None
    assert score_of([ov.Event(1.0, "goal", side=1), ov.Event(2.0, "goal")]) is None
    assert score_of([ov.Event(1.0, "foul", side=2)]) == (0, 0)


@pytest.mark.parametrize("side", [-1, 3, 1.5, "1", None])
def test_another_side_is_a_one_line_error(side):
    with pytest.raises(ov.InputError, match=r"^side is .*whole number[^\n]*$"):
        ov.Event(1.0, "goal", side=side)


@pytest.mark.parametrize("sides", ["AB", ("A",), ("A", ""), ("A", 3), ("A", "B", "C"), 5])
def test_other_names_of_sides_are_a_one_line_error(sides):
    with pytest.raises(ov.InputError, match=r"^sides is [^\n]*$"):
        ov.Timeline("x", 10.0, (ov.Event(1.0, "goal"),), sides=sides)
    with pytest.raises(ov.InputError, match=r"^sides is [^\n]*$"):
        ov.LiveTimeline().describe(sides=sides)


def test_files_without_sides_are_written_as_before():
    plain = ov.Timeline("x", 10.0, (ov.Event(1.0, "goal"),))
    assert b"side" not in native.encode(plain) + event_table.encode(plain)
    assert "side" not in event_object(plain.events[0])


@given(timelines())
@settings(max_examples=40)
def test_each_format_keeps_the_sides(timeline):
    assert native.decode(json.loads(native.encode(timeline))) == timeline
    bare = replace(timeline, sides=())
    assert apply_diff(bare, json.loads(json.dumps(timeline_diff(bare, timeline)))) == timeline
    for event in timeline.events:
        assert event_of(json.loads(json.dumps(event_object(event)))) == event
    if timeline.events:
        listed = event_table.decode(event_table.encode(timeline).decode())
        assert [one.side for one in listed.events] == [one.side for one in timeline.events]


def test_a_table_and_events_in_memory_keep_the_sides(match, tmp_path):
    sides = [event.side for event in match.events]
    assert {1, 2} < {*sides}
    for data in (list(match.events), match.to_dataframe()):
        assert [event.side for event in ov.load_timeline(data).events] == sides
    (tmp_path / "x.csv").write_text("time,what,side\n10,run,1\n20,walk,2\n30,run,left\n40,run,1\n")
    assert [one.side for one in ov.load_timeline(tmp_path / "x.csv").events] == [1, 2, 0, 1]
    (tmp_path / "x.csv").write_text("time_s,kind,side\n10,goal,3\n")
    with pytest.raises(ov.InputError, match="line 2, column 'side'"):
        ov.load_timeline(tmp_path / "x.csv")


def test_a_feed_gives_the_sides_and_corrects_one(match):
    live = ov.LiveTimeline()
    apply_all(live, match)
    assert live.snapshot().sides == match.sides
    assert score_of(live.snapshot().events) == (4, 2)
    goal = {"time_s": 5800.0, "kind": "goal"}
    for side, score in ((1, (5, 2)), (2, (4, 3))):
        apply_line(live, encode_line({"event": {**goal, "side": side}, "id": "late"}))
        assert score_of(live.snapshot().events) == score
    apply_line(live, encode_line({"retract": "late"}))
    assert score_of(live.snapshot().events) == (4, 2)


@given(st.floats(0.0, 0.98), st.floats(0.001, 0.02))
@settings(max_examples=20)
def test_a_window_keeps_the_sides(match, start, length):
    low, high = start * match.duration_s, (start + length) * match.duration_s
    part = match.window(low, high)
    kept = [one.side for one in match.events if low <= one.time_s <= high]
    assert part.sides == match.sides
    assert [one.side for one in part.events if one.side] == [side for side in kept if side]


def test_sides_change_no_bit_of_surface_sound_and_angle_map(match):
    plain = replace(match, sides=(), events=tuple(replace(one, side=0) for one in match.events))
    swapped = replace(
        match, events=tuple(replace(one, side=(3 - one.side) % 3) for one in match.events)
    )
    assert plain != match != swapped
    results = [
        ov.render(one, "football", "sweep:0.5", sample_rate=8_000)
        for one in (match, plain, swapped)
    ]
    for other in results[1:]:
        assert np.array_equal(results[0].samples, other.samples)
        for name in ("cursor", "friction", "torque"):
            assert np.array_equal(results[0].trace[name], other.trace[name])
    first, second = (ov.build_surface(one, ov.load_preset("football")) for one in (match, plain))
    assert np.array_equal(first.resistance, second.resistance)
    times = np.linspace(0.0, match.duration_s, 300)
    assert np.array_equal(first.position_of(times), second.position_of(times))
