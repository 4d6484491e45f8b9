from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.football import wyscout as reader
from overview_dsp.data.readers.football.wyscout import decode
from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import InputError
from tests.data.readers.football_files import (
    AWAY_ID,
    HOME_ID,
    companion,
    wyscout_event,
    wyscout_match,
    wyscout_public,
)
from tests.data.readers.mutations import mutated
from tests.data.readers.outcome import timeline_or_one_line


def found(timeline: Timeline, *kinds: str) -> list[tuple[float, str]]:
    return [(e.time_s, e.label) for e in timeline.events if e.kind in kinds]


def write(folder: Path, document: Any, name: str = "events.json") -> Path:
    (folder / name).write_text(json.dumps(document))
    return folder / name


def test_a_match_is_read_from_its_tags() -> None:
    timeline = decode(wyscout_match())
    assert timeline.duration_s == 2864.0 + 3000.0 + 910.0 + 920.0
    assert timeline.kinds() == {
        "period": 5,
        "foul": 4,
        "goal": 3,
        "yellow_card": 1,
        "near_miss": 3,
        "own_goal": 1,
        "red_card": 2,
    }
    # the team of the first event comes first, which is noted
    assert timeline.title == f"team {AWAY_ID} 3-1 team {HOME_ID}"
    assert "the home team is unknown" in timeline.notes[0]


def test_the_keepers_tag_of_a_goal_is_no_goal_and_a_free_kick_is_one() -> None:
    goals = found(decode(wyscout_match()), "goal")
    assert goals == [(899.058, "1-0"), (1350.4, "2-0"), (3364.0, "3-1 (pen)")]


def test_an_own_goal_counts_for_the_other_team() -> None:
    assert found(decode(wyscout_match()), "own_goal") == [(2964.0, "3-0 own goal")]


def test_near_misses_are_saves_posts_and_penalties_not_scored() -> None:
    assert [label.split(", ")[1] for _, label in found(decode(wyscout_match()), "near_miss")] == [
        "saved",
        "on the post",
        "penalty missed",
    ]


def test_a_second_yellow_is_one_red_card() -> None:
    assert found(decode(wyscout_match()), "red_card") == [
        (3464.0, f"team {AWAY_ID}, second yellow"),
        (3564.0, f"team {AWAY_ID}"),
    ]


def test_a_shoot_out_is_left_out_and_noted() -> None:
    note = decode(wyscout_match()).notes[-1]
    assert note == f"the shoot-out is omitted: 2 kicks; scored: team {AWAY_ID} 1, team {HOME_ID} 0"


def test_both_shapes_of_the_format_are_the_same() -> None:
    events = wyscout_match()
    assert decode(wyscout_public(events)) == decode(events)
    assert decode({"events": events}) == decode(events)


def test_an_objects_teams_and_players_are_named() -> None:
    document = {
        "events": wyscout_match(),
        "teams": {
            str(AWAY_ID): {"team": {"name": "Sudbury"}},
            str(HOME_ID): {"team": {"name": "Northport"}},
        },
        "players": {
            str(AWAY_ID): [{"player": {"wyId": 7, "shortName": "E.Friis", "lastName": "Friis"}}]
        },
    }
    timeline = decode(document)
    assert timeline.title == "Sudbury 3-1 Northport"
    assert timeline.event("goal", 1).label == "1-0 Friis"


def test_the_companion_beside_the_file_gives_names_home_and_score(tmp_path: Path) -> None:
    path = write(tmp_path, wyscout_match())
    write(tmp_path, [companion(wyId=1), companion()], "matches_England.json")
    timeline = load_timeline(path)
    assert timeline.title == "Northport City 1-3 Sudbury, 2017-09-23"
    assert timeline.event("goal", 1).label == "0-1"
    assert not any("home" in note for note in timeline.notes)


def test_companions_without_events_are_refused_by_name(tmp_path: Path) -> None:
    path = write(tmp_path, [companion()], "matches_England.json")
    with pytest.raises(InputError, match=r"matches of Wyscout, without their events; read"):
        load_timeline(path)


def test_a_companion_whose_score_differs_is_noted(tmp_path: Path) -> None:
    other = companion()
    other["teamsData"][str(HOME_ID)]["score"] = 4
    write(tmp_path, [other], "matches.json")
    timeline = load_timeline(write(tmp_path, wyscout_match()))
    assert timeline.title.startswith("Northport City 4-3 Sudbury")
    assert any(
        "has the final score 4-3, but its goals add up to 1-3" in note for note in timeline.notes
    )


@pytest.mark.parametrize("content", ["{", "[1]", "{}", '[{"wyId": 2499773}]', "\x00", "hello"])
def test_a_broken_companion_does_not_stop_the_reader(content: str, tmp_path: Path) -> None:
    (tmp_path / "matches.json").write_text(content)
    timeline = load_timeline(write(tmp_path, wyscout_match()))
    assert timeline.kinds()["goal"] == 3
    assert (content == "{") == any("was not read" in note for note in timeline.notes)


SEASON = [
    wyscout_event("1H", 5.0, HOME_ID, 8, match=11),
    wyscout_event("1H", 50.0, AWAY_ID, 10, 101, match=11),
    wyscout_event("1H", 5.0, HOME_ID, 8, match=2499773),
    wyscout_event("1H", 60.0, HOME_ID, 10, 101, match=2499773),
    wyscout_event("1H", 70.0, AWAY_ID, 8, match=2499773),
]


def test_one_match_of_a_season_is_chosen_by_number_id_or_words(tmp_path: Path) -> None:
    path = write(tmp_path, SEASON)
    with pytest.raises(InputError, match=r"has 2 matches; .*--select"):
        load_timeline(path)
    assert load_timeline(path, match="1").duration_s == 50.0
    assert load_timeline(path, match="2499773").duration_s == 70.0
    write(tmp_path, [companion()], "matches.json")
    assert load_timeline(path, match="northport").duration_s == 70.0
    assert reader.matches(DataFile.open(path)) == [
        "11",
        "2017-09-23  Northport City 1-3 Sudbury  2499773",
    ]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"matchPeriod": "3H"}, "matchPeriod is '3H'; must be one of 1H, 2H"),
        ({"matchPeriod": None}, "matchPeriod is None"),
        ({"eventSec": "x"}, "eventSec is 'x', not a number"),
        ({"eventSec": -1}, r"eventSec is -1\.0; must be the time in the period"),
        ({"eventSec": 1e9}, "eventSec is"),
        (
            {"teamId": 5},
            f"the goal's teamId is 5; must be one of the match's teams, {AWAY_ID} and {HOME_ID}",
        ),
        ({"teamId": None}, "the goal's teamId is missing"),
    ],
)
def test_a_broken_event_is_named(changes: dict[str, Any], words: str) -> None:
    events = wyscout_match()
    events[2] |= changes
    with pytest.raises(InputError, match=f"^event 3: {words}"):
        decode(events)


def test_a_goal_tagged_twice_counts_once() -> None:
    events = wyscout_match()
    events.append(wyscout_event("1H", 900.0, AWAY_ID, 7, 101))
    timeline = decode(events)
    assert timeline.kinds()["goal"] == 3
    assert any("event 23 repeats the goal of event 3" in note for note in timeline.notes)


def test_an_id_of_several_events_is_noted() -> None:
    events = wyscout_match()
    words = "event ids occur more than once"
    assert not any(words in note for note in decode(events).notes)
    for event, name in zip(events, (7, 8, 7, 8, 9), strict=False):
        event["id"] = name
    assert f"{words}: '7', '8'; all these events were read" in decode(events).notes


@given(st.data())
def test_any_change_gives_a_timeline_or_a_one_line_error(data: st.DataObject) -> None:
    document = mutated(data, {"events": copy.deepcopy(wyscout_match()), "teams": {}, "players": {}})
    timeline_or_one_line(lambda: decode(document))


@given(st.data())
def test_any_change_of_the_companion_gives_a_timeline(data: st.DataObject) -> None:
    from overview_dsp.data.readers.football.wyscout import _companion

    told = _companion(mutated(data, companion()))
    if told is not None:
        known = {"2499773": told[1]}
        assert timeline_or_one_line(lambda: decode(wyscout_match(), None, known)) is not None


def test_the_real_match_is_exact(data_folder: Path) -> None:
    timeline = load_timeline(data_folder / "football/wyscout/wyscout_v2_match_2499773.json")
    assert timeline.title == "Leicester City 2-3 Liverpool, 2017-09-23"
    half = next(e.time_s for e in timeline.events if e.label == "half-time")
    goals = [(round(e.time_s - (half if e.time_s > half else 0), 2), e.label)
             for e in timeline.events if e.kind == "goal"]  # fmt: skip
    assert goals == [
        (899.06, "0-1 Salah"),
        (1350.38, "0-2 Coutinho"),
        (2859.85, "1-2 Okazaki"),
        (1326.26, "1-3 Henderson"),
        (1416.87, "2-3 Vardy"),
    ]
    assert timeline.kinds()["foul"] == 27
    yellows = [(round(e.time_s - (half if e.time_s > half else 0), 2), e.label.split("(")[1][:3])
               for e in timeline.events if e.kind == "yellow_card"]  # fmt: skip
    assert yellows == [
        (982.77, "Lei"),
        (1267.76, "Lei"),
        (2775.20, "Liv"),
        (611.71, "Liv"),
        (1574.16, "Liv"),
        (2768.30, "Lei"),
    ]


def test_what_is_no_event_is_a_detail_that_is_felt_when_zoomed() -> None:
    timeline = decode(
        {
            "events": [
                wyscout_event("1H", 1.0, HOME_ID, 8),
                wyscout_event("1H", 5.5, AWAY_ID, 1),
                wyscout_event("1H", 9.0, HOME_ID, 10, 2101),
                wyscout_event("1H", 20.0, HOME_ID, 10, 101),
                wyscout_event("1H", 40.0, HOME_ID, 5),
                wyscout_event("2H", 2.0, AWAY_ID, 7),
            ]
        }
    )
    assert [(e.time_s, e.kind, e.label) for e in timeline.details] == [
        (1.0, "touch", "pass"),
        (5.5, "touch", "duel"),
        (9.0, "shot", "shot"),
        (42.0, "touch", "touch"),
    ]
    assert {"touch", "shot"}.isdisjoint(timeline.kinds())
