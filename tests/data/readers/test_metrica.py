from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.football.metrica import decode
from overview_dsp.errors import InputError
from tests.data.readers.football_files import METRICA, METRICA_ROWS, metrica
from tests.data.readers.outcome import timeline_or_one_line
from tests.data.timeline.strategies import without_ticks


def found(text: str, *kinds: str) -> list[tuple[float, str]]:
    return [(e.time_s, e.label) for e in decode(text).events if e.kind in kinds]


def test_a_match_is_read_with_its_score_and_kinds(tmp_path: Path) -> None:
    (tmp_path / "x").write_text(METRICA)
    timeline = load_timeline(tmp_path / "x")
    assert timeline.title == "Home 1-2 Away"
    assert timeline.duration_s == 5745.2
    assert timeline.kinds() == {
        "period": 3,
        "goal": 2,
        "near_miss": 2,
        "foul": 1,
        "yellow_card": 1,
        "own_goal": 1,
        "red_card": 1,
    }
    assert timeline.intensity is not None
    assert timeline.notes == ()


def test_goals_carry_the_score_and_penalties_are_named() -> None:
    assert found(METRICA, "goal") == [(91.56, "1-0 Player4"), (4000.0, "1-2 Player8 (pen)")]


def test_a_goal_kick_is_no_goal() -> None:
    assert found(metrica("Home,BALL LOST,GOAL KICK,1,5,6,P", "Home,PASS,,1,9,9,P"), "goal") == []


def test_a_goal_without_a_shot_is_an_own_goal_of_the_team_that_kicks_off_next() -> None:
    assert found(METRICA, "own_goal") == [(3498.8, "1-1 own goal, Player5")]
    crossed = METRICA.replace(
        "Home,SET PIECE,KICK OFF,2,1,3551.68", "Away,SET PIECE,KICK OFF,2,1,3551.68"
    )
    assert found(crossed, "own_goal") == []
    assert (3498.8, "2-0 Player5") in found(crossed, "goal")


def test_a_row_given_twice_is_left_out_and_noted() -> None:
    lines = METRICA.splitlines()
    goal = next(i for i, line in enumerate(lines) if ",91.56," in line and "GOAL" in line)
    again = decode("\n".join([*lines[: goal + 1], lines[goal], *lines[goal + 1 :]]))
    assert again.events == decode(METRICA).events
    assert again.notes == (f"line {goal + 2} repeats line {goal + 1}: omitted",)


def test_a_shot_long_after_the_award_of_a_penalty_is_not_a_penalty() -> None:
    late = METRICA.replace("PENALTY,2,1,4000,", "PENALTY,2,1,3960,")
    assert (4000.0, "1-2 Player8") in found(late, "goal")


def test_periods_lie_where_the_files_clock_has_them() -> None:
    assert found(METRICA, "period") == [
        (0.04, "kick-off"),
        (2885.4, "half-time"),
        (5745.2, "full time"),
    ]


def test_periods_whose_clock_restarts_are_concatenated_with_a_note() -> None:
    text = metrica(
        "Home,PASS,,1,0,1,P", "Home,PASS,,1,2800,2801,P", "Home,SHOT,ON TARGET-GOAL,2,10,11,P",
        "Away,PASS,,2,2700,2701,P",
    )  # fmt: skip
    assert found(text, "goal") == [(2811.0, "1-0 P")]
    assert decode(text).duration_s == 5502.0
    assert "clock restarts in period 2" in decode(text).notes[0]


def test_extra_time_is_read_and_a_shoot_out_left_out() -> None:
    more = (
        "Home,SHOT,GOAL,3,6000,6001,P",
        "Home,PASS,,4,7000,7001,P",
        "Home,SHOT,GOAL,5,7100,7101,P",
    )
    timeline = decode(metrica(*METRICA_ROWS, *more))
    assert timeline.kinds()["goal"] == 3
    labels = [e.label for e in timeline.events if e.kind == "period"]
    assert labels == ["kick-off", "half-time", "extra time", "extra-time half-time", "full time"]
    assert "shoot-out" in timeline.notes[0]


@pytest.mark.parametrize("mark", [";", "\t", "|"])
def test_other_separators_and_cases_are_the_same(mark: str) -> None:
    assert decode(METRICA.replace(",", mark)).events == decode(METRICA).events
    assert decode("\n\n" + METRICA.replace("\n", "\r\n")).events == decode(METRICA).events


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        (",1,91.56,", ",1,soon,", "line 4, column 'Start Time .s.': 'soon' isn't a time"),
        (",1,91.56,", ",1,nan,", "line 4, column 'Start Time .s.': 'nan' isn't a time"),
        (",1,91.56,", ",1,999999,", "line 4, .*times must be 0 to 86400 s"),
        (
            "GOAL,1,1,91",
            "GOAL,7,1,91",
            "column 'Period': '7' is not a period; periods must be 1 to 5",
        ),
        ("Home,FAULT", "Third,FAULT", "line 9, column 'Team': 'Third' is a third team"),
        ("Player4", '"Player4', "line 4: .*check the quotes"),
        ("Player4,", "Player4,a,b,c,d,e,f,g", "line 4: .* fields for 14 columns"),
    ],
)
def test_a_wrong_row_is_named(before: str, after: str, words: str) -> None:
    text = METRICA.replace(before, after, 1)
    assert text != METRICA
    with pytest.raises(InputError, match=words):
        decode(text)


@given(st.integers(0, len(METRICA)), st.integers(0, 80), st.text(max_size=6))
def test_any_change_gives_a_timeline_or_a_one_line_error(at: int, length: int, put: str) -> None:
    timeline_or_one_line(lambda: decode(METRICA[:at] + put + METRICA[at + length :]))


def test_the_real_match_is_exact(data_folder: Path) -> None:
    path = data_folder / "football/metrica/Sample_Game_1_RawEventsData.csv"
    timeline = load_timeline(path)
    assert timeline.title == "Home 3-1 Away"
    times = {
        kind: [e.time_s for e in timeline.events if e.kind == kind]
        for kind in ("goal", "own_goal", "yellow_card", "foul", "period", "red_card")
    }
    assert times["goal"] == [91.56, 3600.20, 3961.28]
    assert times["own_goal"] == [3498.80]
    assert times["yellow_card"] == [1968.92, 5038.12, 5143.84, 5490.52]
    assert len(times["foul"]) == 22
    assert times["period"][1:] == [2885.40, 5745.20]
    assert times["red_card"] == []
    assert timeline.duration_s == 5745.20
    cards = [e.label for e in timeline.events if e.kind == "yellow_card"]
    assert [label.split("(")[1] for label in cards] == ["Home)", "Away)", "Home)", "Away)"]
    assert timeline.event("own_goal", 1).label == "1-1 own goal, Player5"


def test_what_is_no_event_is_a_detail_that_is_felt_when_zoomed() -> None:
    timeline = decode(METRICA)
    assert [(e.time_s, e.kind, e.label) for e in timeline.details[:3]] == [
        (0.04, "touch", "set piece Player9"),
        (50.2, "touch", "ball lost Player1"),
        (140.0, "touch", "set piece Player9"),
    ]
    assert [e.time_s for e in timeline.details if e.kind == "shot"] == [220.5]
    part = timeline.window(80.0, 230.0)
    assert [event.kind for event in without_ticks(part)] == [
        *("goal", "touch", "near_miss", "near_miss", "shot"),
    ]


def test_the_third_period_follows_the_second_if_the_clock_restarts_in_each() -> None:
    text = metrica(
        "Home,PASS,,1,0,1,P", "Home,PASS,,1,2800,2801,P", "Home,PASS,,2,10,11,P",
        "Away,PASS,,2,2700,2701,P", "Home,SHOT,ON TARGET-GOAL,3,8,9,P", "Away,PASS,,3,900,901,P",
    )  # fmt: skip
    assert found(text, "goal") == [(5510.0, "1-0 P")]
    assert decode(text).duration_s == 6403.0
