"""Matches of other providers through kloppy, on the files that kloppy itself is tested with."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from overview_dsp import installation
from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.football import wyscout
from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import InputError
from tests.data.readers.football_files import wyscout_match
from tests.data.readers.mutations import mutated
from tests.data.readers.outcome import timeline_or_one_line

kloppy = pytest.importorskip("kloppy", reason="needs the extra [football]")
FILES = Path(kloppy.__file__).parent / "tests" / "files"
if not FILES.is_dir():
    pytest.skip("needs the files kloppy is tested with", allow_module_level=True)

FEEDS = {
    "opta": ("opta_f24.xml", "opta_f7.xml"),
    "sportec": ("sportec_events.xml", "sportec_meta.xml"),
    "datafactory": ("datafactory_events.json",),
    "stats perform": ("statsperform_event_ma3.xml", "statsperform_event_ma1.xml"),
    "stats perform json": ("statsperform_event_ma3.json", "statsperform_event_ma1.json"),
    "metrica": ("metrica_events.json", "epts_metrica_metadata.xml"),
    "wyscout v3": ("wyscout_events_v3.json",),
}


def copied(folder: Path, name: str) -> Path:
    """The files of a provider in a folder of their own; returns the events'."""
    for file in FEEDS[name]:
        shutil.copy(FILES / file, folder)
    return folder / FEEDS[name][0]


def told(timeline: Timeline, *kinds: str) -> list[tuple[float, str]]:
    return [(round(e.time_s), e.label) for e in timeline.events if e.kind in kinds]


@pytest.mark.parametrize(
    ("name", "title", "goals"),
    [
        (
            "datafactory",
            "Team A 4-2 Team B, 2011-11-11",
            # the first is an own goal, or the score wouldn't be the file's
            [
                "1-0 own goal, Burhans",
                "1-1 Parker",
                "2-1 Jacks (pen)",
                "3-1 Reyes",
                "4-1 Tarver",
                "4-2 Burhans",
            ],
        ),
        (
            "stats perform",
            "Hamburger SV 2-1 Sandhausen",
            ["1-0 Kinsombi (pen)", "1-1 Bachmann", "2-1 Heyer"],
        ),
        (
            "wyscout v3",
            "Juventus FC 3-0 UC Sampdoria, 2020-09-20",
            ["1-0 Kulusevski", "2-0 Bonucci", "3-0 Santos Aveiro"],
        ),
        ("metrica", "Team A 0-2 Team B", ["0-1", "0-2"]),
    ],
)
def test_a_providers_match_has_its_goals(
    name: str, title: str, goals: list[str], tmp_path: Path
) -> None:
    timeline = load_timeline(copied(tmp_path, name))
    assert timeline.title == title
    assert [label for _, label in told(timeline, "goal", "own_goal")] == goals
    assert not any("but its goals add up to" in note for note in timeline.notes)
    assert {"foul", "near_miss", "period"} <= timeline.kinds().keys()
    assert len(timeline.details) > 500


def test_cards_are_found_also_where_kloppy_leaves_them_in_the_raw_event(tmp_path: Path) -> None:
    assert load_timeline(copied(tmp_path, "wyscout v3")).kinds()["yellow_card"] == 2
    assert load_timeline(copied(tmp_path, "metrica")).kinds()["yellow_card"] == 1
    timeline = load_timeline(copied(tmp_path, "stats perform"))
    assert timeline.kinds()["yellow_card"] == 4
    assert told(timeline, "red_card") == [(4304, "Ritzmaier (Sandhausen), second yellow")]


def test_xml_and_json_are_the_same_match(tmp_path: Path) -> None:
    folders = tmp_path / "xml", tmp_path / "json"
    for folder in folders:
        folder.mkdir()
    xml = load_timeline(copied(folders[0], "stats perform"))
    same = load_timeline(copied(folders[1], "stats perform json"))
    assert same.events == xml.events
    assert same.details == xml.details


def test_own_goals_count_for_the_other_team(tmp_path: Path) -> None:
    timeline = load_timeline(copied(tmp_path, "sportec"))
    assert [label for _, label in told(timeline, "goal", "own_goal")] == [
        "1-0 Petersen",
        "2-0 own goal, Pléa",  # made up for kloppy's tests
    ]
    assert any(
        "has the final score 1-0, but its goals add up to 2-0" in note for note in timeline.notes
    )


def test_a_shoot_out_and_times_outside_of_a_period_are_left_out(tmp_path: Path) -> None:
    timeline = load_timeline(copied(tmp_path, "opta"))
    assert timeline.title.startswith("FC København 2-1 FC Nordsjælland")
    assert timeline.duration_s < 3 * 3600.0
    assert "the shoot-out is omitted: 1 kicks, 1 scored" in timeline.notes
    assert any("are outside their period" in note for note in timeline.notes)


@pytest.mark.parametrize("name", FEEDS)
def test_only_repeated_event_ids_are_noted(name: str, tmp_path: Path) -> None:
    said = "event ids occur more than once"
    path = copied(tmp_path, name)
    repeated = [note for note in load_timeline(path).notes if said in note]
    # kloppy's own Opta file has one id twice
    assert [note[len(said) :].split(";")[0] for note in repeated] == (
        [": '2498907287'"] if name == "opta" else []
    )
    if name == "wyscout v3":
        document = json.loads(path.read_text())
        document["events"].append(document["events"][30])
        path.write_text(json.dumps(document))
        noted = next(note for note in load_timeline(path).notes if said in note)
        assert str(document["events"][30]["id"]) in noted


@pytest.mark.parametrize(
    ("name", "lacks"),
    [
        ("opta", "the folder lacks the match's F7 file"),
        ("stats perform", "the folder lacks the match's MA1 file"),
        ("sportec", "the folder lacks the match information"),
        ("metrica", "the folder lacks the match's EPTS metadata"),
    ],
)
def test_a_missing_companion_file_is_named(name: str, lacks: str, tmp_path: Path) -> None:
    path = copied(tmp_path, name)
    (tmp_path / FEEDS[name][1]).unlink()
    with pytest.raises(InputError, match=lacks):
        load_timeline(path)


def test_of_several_companion_files_the_one_with_the_most_similar_name_is_taken(
    tmp_path: Path,
) -> None:
    for match in ("a_001", "b_002"):
        shutil.copy(FILES / "opta_f24.xml", tmp_path / f"{match}_f24.xml")
        shutil.copy(FILES / "opta_f7.xml", tmp_path / f"{match}_f7.xml")
    assert load_timeline(tmp_path / "a_001_f24.xml").kinds()["goal"] == 1
    (tmp_path / "b_002_f24.xml").rename(tmp_path / "events.xml")
    with pytest.raises(InputError, match="2 files in the folder may be the match's F7"):
        load_timeline(tmp_path / "events.xml")


def test_a_name_that_is_no_text_gives_a_one_line_error(tmp_path: Path) -> None:
    path = copied(tmp_path, "wyscout v3")
    document = json.loads(path.read_text())
    for player in document["players"].values():
        for one in player:
            one["player"]["lastName"] = True
    path.write_text(json.dumps(document))
    with pytest.raises(InputError, match=r"name of a player is True, not text"):
        load_timeline(path)


def test_a_missing_kloppy_gives_a_one_line_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(name: str) -> None:
        raise ImportError(f"No module named '{name}'")

    path = copied(tmp_path, "wyscout v3")
    monkeypatch.setattr(installation, "import_module", fail)
    with pytest.raises(
        InputError, match=r"reading Wyscout v3 .*kloppy .*pip install '[^']*\[football\]'"
    ):
        load_timeline(path)


BOMB = (
    '<?xml version="1.0"?>\n<!DOCTYPE Games [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;">]>\n'
    '<Games><Game><Event type_id="1" id="&b;"/></Game></Games>'
)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_an_xml_bomb_is_refused(encoding: str, tmp_path: Path) -> None:
    path = copied(tmp_path, "opta")
    path.write_text(BOMB, encoding=encoding)
    with pytest.raises(InputError, match="has a document type"):
        load_timeline(path)
    path = copied(tmp_path, "opta")
    (tmp_path / "opta_f7.xml").write_text(BOMB.replace("Games", "SoccerFeed"), encoding=encoding)
    with pytest.raises(InputError, match=r"opta_f7.xml: the XML has a document type"):
        load_timeline(path)


def test_a_file_too_large_for_a_match_is_refused(tmp_path: Path) -> None:
    path = copied(tmp_path, "opta")
    text = path.read_text()
    path.write_text(text.replace("</Game>", "<Event type_id='1'/>" * 900_000 + "</Game>"))
    with pytest.raises(
        InputError, match=r"size is 17 MB; one match must have at most 16 MB.*--read max-mb"
    ):
        load_timeline(path)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.data())
def test_any_change_of_json_gives_a_timeline_or_a_one_line_error(
    tmp_path: Path, data: st.DataObject
) -> None:
    name = data.draw(st.sampled_from(["datafactory", "wyscout v3"]))
    document = json.loads((FILES / FEEDS[name][0]).read_text())
    if "events" in document:
        document["events"] = document["events"][:40]
    path = tmp_path / "changed.json"
    path.write_text(json.dumps(mutated(data, document)))
    timeline_or_one_line(lambda: load_timeline(path))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.data())
def test_any_damage_of_xml_gives_a_timeline_or_a_one_line_error(
    tmp_path: Path, data: st.DataObject
) -> None:
    name = data.draw(st.sampled_from(["opta", "sportec"]))
    path = copied(tmp_path, name)
    text = path.read_text()
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text)))
        put = data.draw(
            st.sampled_from(["", "<", ">", '"', "&", "\0", "1e400", "-", "</Event>", "NaN"])
            | st.text(max_size=3)
        )
        text = text[:at] + put + text[at + data.draw(st.integers(0, 300)) :]
    path.write_text(text, encoding="utf-8", errors="replace")
    timeline_or_one_line(lambda: load_timeline(path))


# --- Wyscout v2: why it has a reader of its own ------------------------------------------------


def of_kloppy(path: Path) -> Any:
    return pytest.importorskip("kloppy.wyscout").load(event_data=str(path), data_version="V2")


def test_kloppy_and_the_own_reader_agree_on_the_real_wyscout_match(data_folder: Path) -> None:
    path = data_folder / "football/wyscout/wyscout_v2_match_2499773.json"
    ours, theirs = load_timeline(path), of_kloppy(path)
    second = next(e.time_s for e in ours.events if e.label == "half-time")

    def at(kind: str, result: str | None = None) -> list[float]:
        return [
            round(e.timestamp.total_seconds() + (second if e.period.id == 2 else 0.0), 2)
            for e in theirs.events
            if e.event_type.name == kind and (result is None or e.result.name == result)
        ]

    for kind, found in (
        ("goal", at("SHOT", "GOAL")),
        ("yellow_card", at("CARD")),
        ("foul", at("FOUL_COMMITTED")),
    ):
        assert found == [round(e.time_s, 2) for e in ours.events if e.kind == kind]
    # but which team played at home it takes from the order in the file
    assert ours.title.startswith("Leicester City 2-3 Liverpool")
    assert [team.name for team in theirs.metadata.teams] == ["Liverpool FC", "Leicester City FC"]


def test_kloppy_has_no_own_goals_of_wyscout_v2(tmp_path: Path) -> None:
    """Should this fail with a newer kloppy, the own reader may be retired."""
    events = [e | {"positions": [{"x": 50, "y": 50}] * 2} for e in wyscout_match()]
    events = [event for event in events if event["matchPeriod"] in ("1H", "2H")]
    teams = list(dict.fromkeys(str(event["teamId"]) for event in events))
    player = {"playerId": 7, "player": {"wyId": 7, "lastName": "A", "firstName": "B"}}
    document = {
        "events": events,
        "teams": {id_: {"team": {"name": id_, "officialName": id_}} for id_ in teams},
        "players": {id_: [player] for id_ in teams},
    }
    path = tmp_path / "v2.json"
    path.write_text(json.dumps(document))
    shots = [e for e in of_kloppy(path).events if e.event_type.name == "SHOT"]
    results = [shot.result.name for shot in shots if shot.result is not None]
    assert results.count("GOAL") == 3
    assert "OWN_GOAL" not in results
    assert wyscout.decode(document).kinds()["own_goal"] == 1
