from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.football import openfootball as reader
from overview_dsp.data.readers.football.openfootball import decode
from overview_dsp.errors import InputError
from tests.data.readers.football_files import fixture, openfootball
from tests.data.readers.mutations import mutated
from tests.data.readers.outcome import timeline_or_one_line


def found(document: Any, match: str | None = None) -> list[tuple[float, str, str]]:
    return [
        (e.time_s, e.kind, e.label) for e in decode(document, match).events if e.kind != "period"
    ]


def test_one_match_is_read_in_the_middle_of_its_minutes() -> None:
    timeline = decode(openfootball(fixture()))
    assert timeline.title == "Northport 2-1 Sudbury, Village Cup 2020, Final, 2020-07-15"
    # 45+2 makes the first half 47 minutes; minute 46 is the first of the second
    assert found(openfootball(fixture())) == [
        (46.5 * 60, "goal", "1-0 Berg 45+2'"),
        (47.5 * 60, "goal", "1-1 Friis (pen) 46'"),
        (81.5 * 60, "own_goal", "2-1 own goal, van der Holm 80'"),
    ]
    assert timeline.duration_s == 92 * 60
    assert [e.time_s for e in timeline.events if e.kind == "period"] == [0.0, 47 * 60, 92 * 60]
    assert "stoppage" in timeline.notes[0]


def test_newer_files_write_stoppage_into_the_minute() -> None:
    newer = fixture()
    newer["goals1"] = [{"name": "Ada Berg", "minute": "45+2"}, {"name": "Gro van der Holm",
                       "minute": "80", "owngoal": True}]  # fmt: skip
    newer["goals2"][0]["minute"] = "46"
    assert found(openfootball(newer)) == found(openfootball(fixture()))


def test_older_files_have_rounds_teams_as_objects_and_scores_apart() -> None:
    older = fixture({"name": "Northport", "code": "NOR"}, {"name": "Sudbury"})  # type: ignore[arg-type]
    del older["score"], older["round"]
    older |= {"score1": 2, "score2": 1, "score1i": 1, "score2i": 0}
    document = {"name": "Village Cup 2020", "rounds": [{"name": "Final", "matches": [older]}]}
    assert decode(document) == decode(openfootball(fixture()))


def test_extra_time_is_laid_out_and_a_shoot_out_left_out_and_noted() -> None:
    long = fixture(score={"p": [4, 3], "et": [2, 2], "ft": [1, 1], "ht": [0, 0]})
    long["goals1"] = [{"name": "A", "minute": 50}, {"name": "A", "minute": 105, "offset": 1}]
    long["goals2"] = [{"name": "B", "minute": 60}, {"name": "B", "minute": 106}]
    timeline = decode(openfootball(long))
    assert timeline.title.startswith("Northport 2-2 Sudbury")
    assert timeline.duration_s == 121 * 60
    assert [e.time_s / 60 for e in timeline.events if e.kind == "goal"] == [
        49.5,
        59.5,
        105.5,
        106.5,
    ]
    assert any("shoot-out is omitted: Northport 4, Sudbury 3" in note for note in timeline.notes)


def test_goals_that_do_not_make_the_score_are_noted() -> None:
    timeline = decode(openfootball(fixture(score={"ft": [3, 1]})))
    assert timeline.title.startswith("Northport 3-1 Sudbury")
    assert any(
        "has the final score 3-1, but its goals add up to 2-1" in note for note in timeline.notes
    )


def test_a_match_without_goals_is_a_match_without_goals() -> None:
    plain = fixture(score={"ft": [0, 0]})
    del plain["goals1"], plain["goals2"]
    timeline = decode(openfootball(plain))
    assert timeline.kinds() == {"period": 3}
    assert timeline.title.startswith("Northport 0-0 Sudbury")
    plain["score"] = {"ft": [5, 4]}
    timeline = decode(openfootball(plain))
    assert "final score 5-4" in timeline.title
    assert any("has no goals" in note for note in timeline.notes)


CUP = openfootball(
    fixture("France", "Australia", date="2020-06-16", round="Matchday 1"),
    fixture("Croatia", "Nigeria", date="2020-06-16", round="Matchday 1"),
    fixture("France", "Côte d'Ivoire", date="2020-07-01"),
    fixture("France", "Croatia", date="2020-07-15"),
)


@pytest.mark.parametrize(
    ("match", "teams"),
    [
        ("1", "France 2-1 Australia"),
        ("4", "France 2-1 Croatia"),
        ("France Croatia", "France 2-1 Croatia"),
        ("croatia FRANCE", "France 2-1 Croatia"),
        ("cote d'ivoire", "France 2-1 Côte d'Ivoire"),
        ("niger", "Croatia 2-1 Nigeria"),
        ("2020-07-15", "France 2-1 Croatia"),
    ],
)
def test_a_match_is_chosen_by_number_or_words(match: str, teams: str) -> None:
    assert decode(CUP, match).title.startswith(teams)


@pytest.mark.parametrize(
    ("match", "words"),
    [
        (None, r"the file has 4 matches; .*--select.*1 to 4.*'france croatia'.*timeline show"),
        ("Brazil", "none of the 4 matches has 'Brazil'"),
        ("0", "match is 0; must be 1 to 4"),
        ("5", "match is 5"),
        ("2031", "none of the 4 matches has '2031'"),
        (
            "France",
            r"3 matches have 'France' \(1: .*France 2-1 Australia.*or select a number",
        ),
        (" - ", "match is .*must be a number, 1 to 4, or words"),
    ],
)
def test_no_or_an_unclear_choice_gives_a_one_line_error(
    match: str | None, words: str, tmp_path: Path
) -> None:
    (tmp_path / "cup.json").write_text(json.dumps(CUP))
    with pytest.raises(InputError, match=rf"cup\.json: {words}"):
        load_timeline(tmp_path / "cup.json", match=match)


def test_a_whole_word_outranks_a_part_of_one() -> None:
    cup = openfootball(fixture("Nigeria", "Peru"), fixture("Niger", "Mali"), fixture("A", "B"))
    assert decode(cup, "niger").title.startswith("Niger 2-1 Mali")


def test_a_match_not_played_yet_is_refused() -> None:
    with pytest.raises(InputError, match="neither a score nor goals"):
        decode({"matches": [{"team1": "A", "team2": "B", "date": "2030-01-01"}]})
    assert decode({"matches": [{"team1": "A", "team2": "B", "score": [1, 0]}]}).title


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        ({"name": "A"}, r"matches\[0\]: goals1\[0\].minute is None"),
        ({"minute": 300}, r"goals1\[0\]: 300 is out of range; minutes must be 0 to 150"),
        ({"minute": -1}, r"goals1\[0\]: -1 is out of range"),
        ({"minute": "soon"}, r"goals1\[0\].minute: 'soon' isn't a minute"),
        ({"minute": 90, "offset": 99}, "99 is out of range; stoppage time must be 0 to 60 minutes"),
        ({"minute": 90, "offset": []}, r"goals1\[0\].offset is \[\]"),
        ({"minute": True}, "minute is True"),
        ([], r"goals1\[0\] is \[\]; must be an object"),
    ],
)
def test_a_wrong_goal_is_named(goal: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        decode(openfootball(fixture(goals1=[goal])))


@given(st.data())
def test_any_change_gives_a_timeline_or_a_one_line_error(data: st.DataObject) -> None:
    document = mutated(data, copy.deepcopy(openfootball(fixture())))
    timeline_or_one_line(lambda: decode(document))


def test_every_match_of_the_real_cup_is_read(data_folder: Path) -> None:
    document = json.loads((data_folder / "football/openfootball/worldcup_2018.json").read_text())
    path = data_folder / "football/openfootball/worldcup_2018.json"
    from overview_dsp.data.readers.data_file import DataFile

    assert len(reader.matches(DataFile.open(path))) == 64
    counts = {"goal": 0, "own_goal": 0}
    penalties = stoppage = 0
    for number in range(1, 65):
        timeline = decode(document, str(number))
        assert not any("but its goals add up to" in note for note in timeline.notes), timeline.title
        for event in timeline.events:
            if event.kind in counts:
                counts[event.kind] += 1
                penalties += "(pen)" in event.label
                stoppage += "+" in event.label
    assert counts == {"goal": 169 - 12, "own_goal": 12}
    assert (penalties, stoppage) == (22, 22)


def test_the_real_final_is_exact(data_folder: Path) -> None:
    path = data_folder / "football/openfootball/worldcup_2018.json"
    timeline = load_timeline(path, match="France Croatia")
    assert timeline.title.startswith("France 4-2 Croatia, World Cup 2018, Final")
    told = [(e.kind, e.time_s / 60 + 0.5) for e in timeline.events if "goal" in e.kind]
    minutes = [18, 28, 38, 59, 65, 69]
    assert told == [("own_goal" if m == 18 else "goal", m) for m in minutes]
