from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.football.statsbomb import GOOD_CHANCE_XG, decode
from overview_dsp.errors import InputError
from tests.data.readers.outcome import timeline_or_one_line
from tests.data.readers.statsbomb_match import (
    AWAY,
    HOME,
    foul,
    full_match,
    halves,
    match,
    record,
    shot,
)
from tests.data.timeline.strategies import without_ticks

FIRST_S = 46 * 60 + 0.5
"""Length of the made-up first half."""


def found(document: list[dict[str, Any]], *kinds: str) -> list[tuple[float, str]]:
    """(time, label) of the events of some kinds."""
    return [(e.time_s, e.label) for e in decode(document).events if e.kind in kinds]


def test_the_second_half_follows_the_first() -> None:
    timeline = decode(match(shot(1, "00:45:30.250", "Goal"), shot(2, "00:00:30.250", "Goal")))
    assert [e.time_s for e in timeline.events if e.kind == "goal"] == [2730.25, FIRST_S + 30.25]
    assert timeline.duration_s == FIRST_S + 47 * 60 + 0.25
    assert timeline.notes == ()


def test_a_match_has_a_kick_off_each_boundary_once_and_an_end() -> None:
    assert found(match(), "period") == [
        (0.0, "kick-off"),
        (FIRST_S, "half-time"),
        (FIRST_S + 2820.25, "full time"),
    ]
    labels = [label for _, label in found(full_match(), "period")]
    assert labels == ["kick-off", "half-time", "extra time", "extra-time half-time", "full time"]


def test_a_period_lasts_until_its_latest_half_end() -> None:
    document = [
        record(1, "00:00:00.000", "Half Start"),
        record(1, "00:45:00.000", "Half End", HOME),
        record(1, "00:45:01.000", "Half End", AWAY),
        record(2, "00:00:10.000", "Pass"),
    ]
    timeline = decode(document)
    assert found(document, "period")[1] == (2701.0, "half-time")
    assert timeline.duration_s == 2711.0
    assert timeline.notes == ("period 2 has no 'Half End': it ends with its last event",)


def test_what_is_listed_after_the_half_end_is_put_at_it_with_a_note() -> None:
    timeline = decode(match(foul(1, "00:46:09.000", "Red Card", player="Ada Berg")))
    card = timeline.event("red_card", 1)
    assert card.time_s == FIRST_S
    assert len(timeline.notes) == 1
    assert "after the end of period 1" in timeline.notes[0]


def test_records_in_any_order_give_the_same_timeline() -> None:
    document = full_match()
    assert decode([*document[:2], *reversed(document[2:])]).events == decode(document).events


def test_goals_carry_the_running_score_home_team_first() -> None:
    document = match(
        shot(1, "00:10:00.000", "Goal", AWAY, player="Eva Friis", shot_type="Penalty"),
        shot(1, "00:20:00.000", "Goal", HOME, player="Ada van Berg"),
        shot(2, "00:10:00.000", "Goal", HOME),
    )
    labels = [label for _, label in found(document, "goal")]
    assert labels == ["0-1 Friis (pen)", "1-1 van Berg", "2-1"]
    assert decode(document).title == "Northport 2-1 Sudbury"


def test_the_home_team_is_that_of_the_first_eleven() -> None:
    document = match(shot(1, "00:10:00.000", "Goal", AWAY))
    document[0], document[1] = document[1], document[0]
    assert decode(document).title == "Sudbury 1-0 Northport"
    stray = record(1, "00:00:00.000", "Camera On", HOME)
    assert decode([stray, *document]).title == "Sudbury 1-0 Northport"


@pytest.mark.parametrize(
    ("for_more", "against_more"),
    [
        ({"related_events": ["against"]}, {}),
        ({}, {"related_events": ["for"]}),
        ({}, {}),
    ],
)
def test_an_own_goal_is_one_event_and_the_score_of_the_team_it_is_for(
    for_more: dict[str, Any], against_more: dict[str, Any]
) -> None:
    document = match(
        record(1, "00:18:00.000", "Own Goal Against", HOME, id="against", player="Mario Mann")
        | against_more,
        record(1, "00:18:00.040", "Own Goal For", AWAY, id="for") | for_more,
    )
    timeline = decode(document)
    assert found(document, "own_goal", "goal") == [(1080.04, "0-1 own goal, Mann")]
    assert timeline.title == "Northport 0-1 Sudbury"
    assert timeline.notes == ()


def test_two_own_goals_keep_their_own_scorers() -> None:
    document = match(
        record(1, "00:18:00.000", "Own Goal Against", HOME, player="A One"),
        record(1, "00:18:00.000", "Own Goal For", AWAY),
        record(1, "00:18:05.000", "Own Goal Against", AWAY, player="B Two"),
        record(1, "00:18:05.000", "Own Goal For", HOME),
    )
    labels = [label for _, label in found(document, "own_goal")]
    assert labels == ["0-1 own goal, One", "1-1 own goal, Two"]


@pytest.mark.parametrize("naming", ["Own Goal For", "Own Goal Against"])
def test_own_goal_records_that_name_each_other_belong_together_however_near_others_are(
    naming: str,
) -> None:
    pairs = {"for 1": "against 1", "for 2": "against 2"}
    document = match(
        record(1, "00:18:00.000", "Own Goal For", AWAY, id="for 1"),
        record(1, "00:18:00.000", "Own Goal Against", HOME, id="against 2", player="B Two"),
        record(1, "00:18:05.000", "Own Goal For", AWAY, id="for 2"),
        record(1, "00:18:05.000", "Own Goal Against", HOME, id="against 1", player="A One"),
    )
    for entry in document:
        if entry["type"]["name"] == naming:
            names = pairs | {value: key for key, value in pairs.items()}
            entry["related_events"] = [names[entry["id"]]]
    labels = [label for _, label in found(document, "own_goal")]
    assert labels == ["0-1 own goal, One", "0-2 own goal, Two"]


@pytest.mark.parametrize(("clock", "pair"), [("00:18:10.000", True), ("00:18:10.001", False)])
def test_own_goal_records_up_to_ten_seconds_apart_are_one_goal(clock: str, pair: bool) -> None:
    document = match(
        record(1, "00:18:00.000", "Own Goal Against", HOME, player="A One"),
        record(1, clock, "Own Goal For", AWAY),
    )
    labels = [label for _, label in found(document, "own_goal")]
    assert labels == (["0-1 own goal, One"] if pair else ["0-1 own goal, One", "0-2 own goal"])


def test_half_an_own_goal_counts_too() -> None:
    alone = match(record(1, "00:18:00.000", "Own Goal For", AWAY))
    assert found(alone, "own_goal") == [(1080.0, "0-1 own goal")]
    alone = match(record(1, "00:18:00.000", "Own Goal Against", HOME, player="A One"))
    assert found(alone, "own_goal") == [(1080.0, "0-1 own goal, One")]
    assert "without an 'Own Goal For'" in decode(alone).notes[0]


@pytest.mark.parametrize(
    ("outcome", "xg", "label"),
    [
        ("Saved", 0.01, "Berg (Northport), saved"),
        ("Saved to Post", 0.01, "Berg (Northport), saved"),
        ("Saved Off Target", 0.01, "Berg (Northport), saved"),
        ("Post", 0.01, "Berg (Northport), on the post"),
        ("Off T", GOOD_CHANCE_XG, "Berg (Northport), missed"),
        ("Wayward", GOOD_CHANCE_XG, "Berg (Northport), missed"),
        ("Off T", 0.0999, None),
        ("Wayward", 0.0999, None),
        ("Off T", None, None),
        ("Blocked", 0.9, None),
        ("Goal", 0.9, None),
    ],
)
def test_a_near_miss_is_a_save_a_post_or_a_good_chance_missed(
    outcome: str, xg: float | None, label: str | None
) -> None:
    document = match(shot(1, "00:10:00.000", outcome, player="Ada Berg", xg=xg))
    assert found(document, "near_miss") == ([(600.0, label)] if label else [])


@pytest.mark.parametrize(
    ("shot_related", "block_related", "save_block", "near"),
    [
        (["b"], [], True, True),
        ([], ["s"], True, True),
        (["b"], ["s"], True, True),
        (["b"], ["s"], False, False),
        (["b"], ["s"], "true", False),
        (["x"], ["x"], True, False),
        ([], [], True, False),
    ],
)
def test_a_shot_blocked_on_the_line_is_a_near_miss(
    shot_related: list[str], block_related: list[str], save_block: object, near: bool
) -> None:
    document = match(
        shot(1, "00:10:00.000", "Blocked", id="s", related_events=shot_related),
        record(
            1,
            "00:10:00.100",
            "Block",
            AWAY,
            id="b",
            related_events=block_related,
            block={"save_block": save_block},
        ),
    )
    expected = [(600.0, "Northport, blocked on the line")] if near else []
    assert found(document, "near_miss") == expected


def test_a_penalty_saved_or_missed_is_a_near_miss_that_says_so() -> None:
    document = match(
        shot(1, "00:10:00.000", "Saved", player="Ada Berg", shot_type="Penalty", xg=0.76),
        shot(1, "00:20:00.000", "Off T", player="Ada Berg", shot_type="Penalty", xg=0.76),
    )
    assert [label for _, label in found(document, "near_miss")] == [
        "Berg (Northport), penalty saved",
        "Berg (Northport), penalty missed",
    ]


def test_a_foul_and_its_card_are_two_events_at_one_time() -> None:
    document = match(
        foul(1, "00:10:00.000", player="Ada Berg"),
        foul(1, "00:20:00.000", "Yellow Card", player="Ada Berg"),
        foul(1, "00:30:00.000", "Second Yellow", player="Ada Berg"),
        foul(1, "00:40:00.000", "Red Card", player="Carla Dahl"),
    )
    assert decode(document).kinds() == {"period": 3, "foul": 4, "yellow_card": 1, "red_card": 2}
    assert [time for time, _ in found(document, "foul")] == [600.0, 1200.0, 1800.0, 2400.0]
    assert found(document, "yellow_card") == [(1200.0, "Berg (Northport)")]
    assert found(document, "red_card") == [
        (1800.0, "Berg (Northport), second yellow"),
        (2400.0, "Dahl (Northport)"),
    ]


def test_cards_of_bad_behaviour_are_cards_without_a_foul() -> None:
    card = {"card": {"id": 7, "name": "Yellow Card"}}
    document = match(record(1, "00:10:00.000", "Bad Behaviour", bad_behaviour=card))
    assert found(document, "yellow_card") == [(600.0, "Northport")]
    assert found(document, "foul") == []


def test_a_shoot_out_is_left_out_but_noted() -> None:
    timeline = decode(full_match())
    assert timeline.title == "Northport 1-1 Sudbury"
    assert timeline.kinds()["goal"] == 1
    assert timeline.notes == (
        "the shoot-out (period 5) is omitted: 2 kicks; scored: Northport 1, Sudbury 0",
    )
    expected_s = FIRST_S + 47 * 60 + 0.25 + 15.5 * 60 + 16 * 60
    assert timeline.duration_s == expected_s
    assert timeline.kinds() == {
        "period": 5,
        "goal": 1,
        "foul": 3,
        "yellow_card": 2,
        "near_miss": 4,
        "own_goal": 1,
        "red_card": 1,
    }


def test_the_intensity_is_derived_from_the_events_and_says_so() -> None:
    timeline = decode(full_match())
    assert float(timeline.intensity_at(600.123)) > 0.85
    assert "StatsBomb" in timeline.provenance
    assert "applied to the events, not a recording" in timeline.provenance


def test_an_event_listed_twice_is_taken_once_with_a_note() -> None:
    twice = foul(1, "00:10:00.000", player="Ada Berg")
    timeline = decode(match(twice, twice | {"id": "again"}))
    assert timeline.kinds()["foul"] == 1
    assert "repeats" in timeline.notes[0]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"period": 6}, "period is 6; must be 1 to 5"),
        ({"period": "1"}, "period is '1'"),
        ({"period": True}, "period is True"),
        ({"period": None}, "period is None"),
        ({"timestamp": "10:00"}, "timestamp is '10:00'"),
        ({"timestamp": 600}, "timestamp is 600"),
        ({"timestamp": "00:61:00.000"}, "timestamp is"),
        ({"timestamp": "00:00:٣٣.000"}, "timestamp is"),
        ({"type": None}, "type.name is missing"),
        ({"type": {"id": 3}}, "type.name is missing"),
        ({"shot": None}, "shot.outcome.name is None"),
        ({"shot": [1]}, r"shot is \[1\]; must be an object"),
        ({"shot": {"outcome": {"name": "Lost"}}}, "shot.outcome.name is 'Lost'; must be one of"),
        ({"shot": {"outcome": 5}}, "shot.outcome is 5; must have a name"),
        ({"shot": {"outcome": {"name": "Off T"}, "statsbomb_xg": "x"}}, "statsbomb_xg is 'x'"),
        ({"team": {"name": "Thirdtown"}}, "the goal's team is 'Thirdtown'; .* 'Northport' and"),
        ({"team": None}, "the goal's team is ''"),
        ({"player": {"name": "a \ud800"}}, "label has a lone surrogate"),
        (
            {"type": {"name": "Foul Committed"}, "foul_committed": {"card": {"name": "Blue"}}},
            "foul_committed.card.name is 'Blue'; must be one of Yellow Card",
        ),
        (
            {"type": {"name": "Bad Behaviour"}, "bad_behaviour": {"card": "Red Card"}},
            "bad_behaviour.card is 'Red Card'; must have a name",
        ),
    ],
)
def test_a_broken_record_is_named(changes: dict[str, Any], words: str, tmp_path: Path) -> None:
    document = match(shot(1, "00:10:00.000", "Goal", id="abc"))
    position = next(i for i, entry in enumerate(document) if entry["id"] == "abc")
    document[position] |= changes
    path = tmp_path / "m.json"
    path.write_text(json.dumps(document))
    place = rf"m\.json: event {position + 1} \(id abc\): "
    with pytest.raises(InputError, match=f"{place}.*{words}") as caught:
        load_timeline(path)
    str(caught.value).encode()


@pytest.mark.parametrize("entry", [None, 3, "x", []])
def test_a_record_that_is_no_object_is_named_by_its_place(entry: Any) -> None:
    document: list[Any] = match()
    document.insert(4, entry)
    with pytest.raises(InputError, match=r"^event 5: is .*; must be an object"):
        decode(document)


@pytest.mark.parametrize(
    "changes",
    [
        {"player": None},
        {"player": "x"},
        {"team": 3},
        {"related_events": "x"},
        {"related_events": [1, None]},
        {"id": None},
        {"id": 7},
        {"minute": "x", "second": None, "location": "nowhere"},
    ],
)
def test_what_is_not_needed_may_be_broken(changes: dict[str, Any]) -> None:
    document = match(foul(1, "00:10:00.000"), shot(1, "00:11:00.000", "Blocked"))
    for entry in document:
        if entry["type"]["name"] in ("Foul Committed", "Shot"):
            entry |= changes
    assert decode(document).kinds()["foul"] == 1


def test_a_file_without_play_is_refused() -> None:
    for document in ([], [shot(5, "00:01:00.000", "Goal")], [record(1, "00:00:00.000", "Pass")]):
        with pytest.raises(InputError, match="no duration"):
            decode(document)


def test_a_match_of_one_team_has_the_files_name_as_title() -> None:
    assert decode([*halves((1, "00:45:00.000"))][::2], "afternoon").title == "afternoon"


FULL = full_match()
VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-2, 7),
    st.floats(),
    st.just(10**400),
    st.text(st.characters(), max_size=6),
    st.sampled_from(["Goal", "Blocked", "Half End", "Shot", "Own Goal For", "99:59:59.999", AWAY]),
    st.just([]),
    st.just({}),
    st.just({"name": "Red Card"}),
    st.just([None, "shot", 3]),
)


@given(st.data())
def test_any_change_of_a_match_gives_a_timeline_or_a_one_line_error(data: st.DataObject) -> None:
    document: Any = copy.deepcopy(FULL)
    for _ in range(data.draw(st.integers(1, 4))):
        inside: Any = document
        while True:
            keys = list(inside) if isinstance(inside, dict) else list(range(len(inside)))
            if not keys:
                break
            key = data.draw(st.sampled_from(keys))
            deeper = isinstance(inside[key], dict | list) and inside[key]
            if deeper and data.draw(st.integers(0, 9)):
                inside = inside[key]
                continue
            if data.draw(st.booleans()):
                inside[key] = copy.deepcopy(data.draw(VALUES))  # it may be changed next
            else:
                del inside[key]
            break
    timeline = timeline_or_one_line(lambda: decode(document))
    assert timeline is None or timeline.kinds()["period"] >= 2


# --- real matches -------------------------------------------------------------------------------


def clock(period: int, minutes: int, seconds: float, first_half_s: float) -> float:
    """Time of StatsBomb's minute and second (45:00 is the start of period 2) in the timeline."""
    return minutes * 60 + seconds + (first_half_s - 45 * 60 if period == 2 else 0.0)


REAL: dict[str, dict[str, Any]] = {
    "22936": {
        "title": "England Women's 2-1 Scotland Women's",
        "halves": (47 * 60 + 30.321, 49 * 60 + 8.044),
        "goals": [
            (1, 13, 6.245, "1-0 Parris (pen)"),
            (1, 39, 24.818, "2-0 White"),
            (2, 78, 5.933, "2-1 Emslie"),
        ],
        "yellows": [(1, 42, 51.565), (2, 46, 12.956)],
        "reds": [],
        "fouls": 16,
    },
    "69321": {
        "title": "United States Women's 2-0 Netherlands Women's",
        "halves": (48 * 60 + 48.530, 50 * 60 + 4.501),
        "goals": [(2, 60, 56.992, "1-0 Rapinoe (pen)"), (2, 68, 47.100, "2-0 Lavelle")],
        "yellows": [(1, 9, 27.137), (1, 40, 52.972), (2, 57, 54.412)],
        "reds": [],
        "fouls": 21,
    },
    "15986": {
        "title": "Barcelona 2-2 Girona",
        "halves": (48 * 60 + 1.108, 48 * 60 + 8.184),
        "goals": [
            (1, 18, 21.121, "1-0 Messi Cuccittini"),
            (1, 44, 29.908, "1-1 Stuani Curbelo"),
            (2, 50, 18.479, "1-2 Stuani Curbelo"),
            (2, 62, 11.272, "2-2 Piqué Bernabéu"),
        ],
        "yellows": [
            (1, 11, 54.542),
            (1, 13, 56.742),
            (1, 15, 6.494),
            (1, 38, 7.366),
            (2, 60, 26.284),
            (2, 67, 22.773),
            (2, 68, 33.130),
            (2, 80, 38.587),
        ],
        "reds": [(1, 32, 36.585)],
        "fouls": 28,
    },
}


@pytest.mark.parametrize("name", sorted(REAL))
def test_a_real_match_has_its_true_goals_cards_fouls_and_halves(
    name: str, statsbomb_folder: Path
) -> None:
    truth = REAL[name]
    timeline = load_timeline(statsbomb_folder / f"{name}.json")
    first, second = truth["halves"]
    assert timeline.title == truth["title"]
    assert timeline.duration_s == pytest.approx(first + second, abs=1e-9)
    assert [e.time_s for e in timeline.events if e.kind == "period"] == pytest.approx(
        [0.0, first, first + second], abs=1e-9
    )
    goals = [e for e in timeline.events if e.kind == "goal"]
    assert [e.label for e in goals] == [label for *_, label in truth["goals"]]
    for kind, times in (
        ("goal", [t[:3] for t in truth["goals"]]),
        ("yellow_card", truth["yellows"]),
        ("red_card", truth["reds"]),
    ):
        true_s = [clock(*time, first_half_s=first) for time in times]
        found_s = [e.time_s for e in timeline.events if e.kind == kind]
        assert found_s == pytest.approx(true_s, abs=1e-9), kind
    assert timeline.kinds()["foul"] == truth["fouls"]
    assert "own_goal" not in timeline.kinds()
    assert timeline.notes == ()


def test_real_near_misses_follow_the_rule(statsbomb_folder: Path) -> None:
    timeline = load_timeline(statsbomb_folder / "15986.json")
    labels = [e.label for e in timeline.events if e.kind == "near_miss"]
    # Piqué stands on the line at 28:13, Messi hits the post at 59:35; nobody else misses narrowly
    assert [label for label in labels if "saved" not in label] == [
        "Portugués Manzanera (Girona), blocked on the line",
        "Messi Cuccittini (Barcelona), on the post",
    ]
    assert len(labels) == 14


def test_what_players_do_with_the_ball_is_felt_when_zoomed_and_not_otherwise() -> None:
    played = match(
        record(1, "00:10:00.000", "Pass", player="Ada Berg"),
        record(1, "00:10:01.500", "Ball Receipt*", player="Eva Friis"),
        record(1, "00:10:01.500", "Carry", player="Eva Friis"),
        record(1, "00:10:05.000", "Tactical Shift"),
        shot(1, "00:10:06.000", "Off T", player="Eva Friis", xg=0.02),
        shot(1, "00:10:20.000", "Goal", player="Ada Berg"),
        record(2, "00:00:02.000", "Clearance", AWAY, player="Gro van der Holm"),
        record(5, "00:00:02.000", "Pass", AWAY, player="Gro van der Holm"),
    )
    timeline = decode(played)
    assert [(event.time_s, event.kind, event.label) for event in timeline.details] == [
        (600.0, "touch", "pass Berg"),
        (601.5, "touch", "receipt Friis"),
        (601.5, "touch", "carry Friis"),
        (606.0, "shot", "shot Friis"),
        (FIRST_S + 2.0, "touch", "clearance van der Holm"),
    ]
    assert {event.kind for event in timeline.events} == {"period", "goal"}
    part = timeline.window(590.0, 630.0)
    shown = [(event.time_s, event.kind) for event in without_ticks(part)]
    assert shown == [(10.0, "touch"), (11.5, "touch"), (16.0, "shot"), (30.0, "goal")]


def test_a_touch_listed_after_the_end_is_put_at_the_end_without_a_word() -> None:
    timeline = decode(match(record(2, "00:47:00.900", "Pass", player="Ada Berg")))
    assert [event.time_s for event in timeline.details] == [timeline.duration_s]
    assert timeline.notes == ()
