"""Documents of live football services are read right, or refused with the reason."""

from __future__ import annotations

import copy
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from tests.data.readers.service_documents import (
    api_event,
    api_football,
    api_list,
    data_card,
    data_goal,
    football_data,
    liga_goal,
    open_liga,
)


def load(document, **options):
    return ov.load_timeline(json.dumps(document).encode(), **options)


def events_of(timeline):
    return [(one.kind, one.label) for one in timeline.events if one.kind != "period"]


def times_of(timeline, kind):
    return [one.time_s for one in timeline.events if one.kind == kind]


API = [
    api_event(12, "Card", "Yellow Card", 2, "Tim Mann"),
    api_event(23, "Goal", "Normal Goal"),
    api_event(30, "subst", "Substitution 1"),
    api_event(45, "Goal", "Penalty", 2, "Jon Friis", extra=2),
    api_event(52, "Goal", "Own Goal", 1, "Tim Mann"),
    api_event(60, "Goal", "Missed Penalty", 2, "Jon Friis"),
    api_event(66, "Card", "Second Yellow card", 2, "Tim Mann"),
]
API_EVENTS = [
    ("yellow_card", "Mann (Sudbury) 12'"),
    ("goal", "1-0 Berg 23'"),
    ("goal", "1-1 Friis (pen) 45+2'"),
    ("own_goal", "2-1 own goal, Mann 52'"),
    ("near_miss", "Friis (Sudbury), penalty missed 60'"),
    ("red_card", "Mann (Sudbury), second yellow 66'"),
]


def test_api_football_in_progress_is_known_until_its_minute():
    match = load(api_football(API, elapsed=70, goals=(2, 1)))
    assert events_of(match) == API_EVENTS
    assert match.title == "Nordhavn 2-1 Sudbury, First League, Round 30, 2026-05-09"
    assert match.known_until_s == 47 * 60 + 25 * 60  # the first half lasts until 45+2
    assert match.duration_s == 92 * 60
    assert times_of(match, "goal")[0] == 22.5 * 60
    assert [one.label for one in match.events if one.kind == "period"] == ["kick-off", "half-time"]


def test_a_finished_match_has_no_future_and_a_shoot_out_is_noted():
    kicks = [
        api_event(120, "Goal", "Penalty", team, "Kim Dahl", comments="Penalty Shootout")
        for team in (1, 2, 1)
    ]
    document = api_football([*API, *kicks], "PEN", 120, (2, 1), penalty=(2, 1))
    match = load(document)
    assert match.known_until_s is None
    assert match.duration_s == 122 * 60
    assert events_of(match) == API_EVENTS
    assert "the shoot-out is omitted: 2-1" in match.notes


def test_a_list_of_events_alone_is_known_until_its_last_event():
    match = load(api_list(API))
    assert [kind for kind, _ in events_of(match)] == [kind for kind, _ in API_EVENTS]
    assert match.known_until_s == 47 * 60 + 21 * 60
    assert any("no home team and no clock" in note for note in match.notes)


def test_football_data_org():
    goals = [
        data_goal(23),
        data_goal(45, 2, "Jon Friis", "PENALTY", added=2),
        data_goal(52, 1, "Tim Mann", "OWN"),
    ]
    cards = [data_card(12, 2, "Tim Mann"), data_card(66, 2, "Tim Mann", "YELLOW_RED")]
    match = load(football_data(goals, cards, score=(2, 1)))
    expected = [one for one in API_EVENTS if one[0] != "near_miss"]
    assert events_of(match) == expected
    assert match.title == "Nordhavn 2-1 Sudbury, First League, 2026-05-09"
    assert match.known_until_s == 72 * 60


def test_the_full_time_of_football_data_org_includes_a_shoot_out_that_is_no_score():
    pair = {"home": 1, "away": 1}
    more = {
        "regularTime": pair,
        "extraTime": {"home": 0, "away": 0},
        "penalties": {"home": 4, "away": 2},
    }
    goals = [data_goal(10), data_goal(80, 2)]
    match = load(football_data(goals, status="FINISHED", score=(5, 3), **more))
    assert match.title.startswith("Nordhavn 1-1 Sudbury")
    assert match.duration_s == 120 * 60
    assert "the shoot-out is omitted: 4-2" in match.notes


def test_open_liga_counts_a_goal_for_the_team_whose_score_rises():
    goals = [
        liga_goal(1, 1, 61, "Mann", 3, isOwnGoal=True),
        liga_goal(1, 0, 20, goal_id=1),
        liga_goal(2, 1, 88, "Friis", 4, isPenalty=True),
    ]
    match = load(open_liga(goals, [("Halbzeitergebnis", 1, 0)]))
    assert events_of(match) == [
        ("goal", "1-0 Berg 20'"),
        ("own_goal", "1-1 own goal, Mann 61'"),
        ("goal", "2-1 Friis (pen) 88'"),
    ]
    assert match.known_until_s == 88 * 60
    assert load(open_liga(goals, [("Endergebnis", 2, 1)], finished=True)).known_until_s is None


def test_open_liga_uses_the_corrected_entry_of_a_score_and_notes_a_goal_without_a_minute():
    goals = [
        liga_goal(1, 0, 20, "Berg", 1),
        liga_goal(1, 0, 21, "Dahl", 2),
        liga_goal(2, 0, None, goal_id=3),
    ]
    match = load(open_liga(goals))
    assert events_of(match) == [("goal", "1-0 Dahl 21'")]
    assert "1 goal without a minute left out" in match.notes


REPEATED = [
    ("twice in one minute", [23, 23], 1, 1),
    ("two goals of one player in one minute", [23, 23], 2, 2),
    ("once in each of two minutes", [23, 24], 1, 1),
    ("two goals of one player a minute apart", [23, 24], 2, 2),
    ("the score lags", [23], 0, 1),
]


@pytest.mark.parametrize(("minutes", "score", "count"), [row[1:] for row in REPEATED])
@pytest.mark.parametrize("service", ["api", "data"])
def test_a_repeated_goal_is_read_once_unless_the_score_counts_it(service, minutes, score, count):
    if service == "api":
        events = [api_event(minute, "Goal", "Normal Goal") for minute in minutes]
        match = load(api_football(events, goals=(score, 0)))
    else:
        goals = [data_goal(minute) for minute in minutes]
        match = load(football_data(goals, score=(score, 0)))
    assert match.kinds().get("goal", 0) == count
    assert any("repeated event" in note for note in match.notes) == (len(minutes) > count)


def test_a_repeated_card_is_read_once():
    cards = [data_card(12), data_card(12), data_card(13)]
    assert load(football_data([], cards)).kinds()["yellow_card"] == 2


REVIEW = api_event(25, "Var", "Goal Disallowed - offside")


@pytest.mark.parametrize(
    ("events", "score", "labels"),
    [
        ([api_event(23, "Goal", "Normal Goal"), REVIEW], 0, []),
        ([api_event(23, "Goal", "Normal Goal"), REVIEW], 1, ["1-0 Berg 23'"]),
        ([api_event(10, "Goal", "Normal Goal"), REVIEW], 0, ["1-0 Berg 10'"]),
        (
            [
                api_event(22, "Goal", "Normal Goal"),
                api_event(24, "Goal", "Normal Goal", player="Kim Dahl"),
                REVIEW,
            ],
            1,
            ["1-0 Dahl 24'"],
        ),
        (
            [api_event(23, "Goal", "Normal Goal"), api_event(25, "Var", "Goal confirmed")],
            1,
            ["1-0 Berg 23'"],
        ),
    ],
)
def test_a_goal_that_the_video_referee_withdrew_is_a_kind_of_its_own(events, score, labels):
    match = load(api_football(events, goals=(score, 0)))
    assert [one.label for one in match.events if one.kind == "goal"] == labels
    withdrawn = sum(one["type"] == "Goal" for one in events) - len(labels)
    assert match.kinds().get("withdrawn_goal", 0) == withdrawn
    assert any("1 withdrawn goal not counted: " in note for note in match.notes) == bool(withdrawn)


def test_one_of_several_matches_is_selected_by_words_or_id():
    document = football_data([data_goal(23)], score=(1, 0))
    other = copy.deepcopy(document) | {"id": 440012, "goals": [data_goal(40), data_goal(41)]}
    other["homeTeam"]["name"], other["score"]["fullTime"]["home"] = "Westport", 2
    listed = {"filters": {}, "resultSet": {"count": 2}, "matches": [document, other]}
    for which in ("westport", "440012", "2"):
        assert load(listed, match=which).kinds()["goal"] == 2
    with pytest.raises(ov.InputError, match="2 matches; select one"):
        load(listed)


@pytest.mark.parametrize(
    ("document", "message"),
    [
        (
            api_football([]) | {"errors": {"token": "Missing application key"}, "response": []},
            "API-Football reports .Missing application key",
        ),
        (api_football([], "NS", None), "the match has not begun; follow its URL"),
        (
            {"matches": [{k: v for k, v in football_data().items() if k != "goals"}]},
            "football-data.org has no events of the match; request the match alone",
        ),
        (
            api_football([api_event(None, "Goal", "Normal Goal")]),
            r"events\[0\]: the event has no minute",
        ),
        (
            api_football([api_event("soon", "Goal", "Normal Goal")]),
            r"events\[0\].time.elapsed is 'soon'; must be a whole number",
        ),
        (football_data([data_goal(500)]), r"goals\[0\].minute: '?500'? is out of range"),
        (open_liga([]), "the match has not begun"),
        (
            {"filters": {}, "matches": [football_data() | {"goals": 3}]},
            r"matches\[0\].goals is 3; must be a list",
        ),
    ],
)
def test_another_document_is_refused_with_its_reason(document, message):
    with pytest.raises(ov.InputError, match=message) as error:
        load(document)
    assert "\n" not in str(error.value)


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-5, 200) | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.text(max_size=4), inner),
    max_leaves=4,
)
DOCUMENTS = [
    api_football(API, goals=(2, 1)),
    api_list(API),
    football_data([data_goal(23)], [data_card(3)]),
    open_liga([liga_goal(1, 0, 20)], [("Halbzeitergebnis", 1, 0)]),
]


def places(value, path=()):
    yield path
    items = value.items() if isinstance(value, dict) else ()
    for key, one in enumerate(value) if isinstance(value, list) else items:
        yield from places(one, (*path, key))


PLACES = [(one, path) for one in DOCUMENTS for path in places(one) if path]


@pytest.mark.parametrize("text", ["a\x1b[2Jb", "a\x1fb", "\x85"])
def test_control_characters_do_not_reach_a_terminal(text):
    for document, path in PLACES:
        check_value(document, path, text)


@given(st.sampled_from(PLACES), VALUES)
def test_any_value_in_any_place_is_read_or_refused(place, value):
    check_value(*place, value)


def check_value(document, path, value):
    changed = copy.deepcopy(document)
    inner = changed
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    try:
        match = load(changed)
    except ov.InputError as error:
        said = str(error)
    else:
        said = match.title
        assert match.known_until_s is None or match.known_until_s < match.duration_s
    assert said.replace("\n", " ").isprintable()
