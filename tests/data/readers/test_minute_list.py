from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.readers import load_timeline
from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.football import minute_list
from overview_dsp.data.readers.football.minute_list import COLUMNS, decode, sniff
from overview_dsp.data.readers.football.minutes import Clock, Minute, parse_minute
from overview_dsp.data.readers.football.vocabulary import meaning, normalize_terms
from overview_dsp.data.readers.registry import list_matches
from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import InputError
from tests.data.readers.football_files import GOALSCORERS, MINUTES
from tests.data.readers.outcome import timeline_or_one_line


def told(timeline: Timeline) -> list[tuple[float, str, str]]:
    return [(e.time_s, e.kind, e.label) for e in timeline.events if e.kind != "period"]


def rows(*lines: str, header: str = "minute,type,player,team") -> str:
    return "\n".join([header, *lines]) + "\n"


def test_a_list_is_detected_by_its_content_and_read(tmp_path: Path) -> None:
    (tmp_path / "x").write_text(MINUTES)
    timeline = load_timeline(tmp_path / "x")
    assert timeline.title == "Northport 1-2 Sudbury"
    assert told(timeline) == [
        (18 * 60, "own_goal", "0-1 own goal, Berg 18'"),
        (47 * 60, "yellow_card", "Friis (Sudbury) 45+2'"),
        # the first half lasted 47 minutes
        (48 * 60, "goal", "0-2 Friis 46'"),
        (72 * 60, "goal", "1-2 Berg (pen) 70'"),
        (95 * 60, "red_card", "Friis (Sudbury), second yellow 90+3'"),
    ]
    assert timeline.duration_s == 95 * 60
    assert any(
        "omitted, not a football event kind: 1 substitution" in note for note in timeline.notes
    )
    assert any(
        "own goals: the team in the list is that of the player" in note for note in timeline.notes
    )


@pytest.mark.parametrize(
    "text",
    [
        MINUTES.replace(",", ";"),
        MINUTES.replace(",", "\t"),
        MINUTES.replace("\n", "\r\n"),
        "\ufeff" + MINUTES,
        MINUTES.replace("minute,type,player,team", "Min,Event Type,player_name,Team Name"),
        MINUTES.replace("45+2,", "45'+2',").replace("90+3',", "90 + 3,"),
        MINUTES.replace("own goal", "OwnGoal").replace("second yellow", "Second Yellow card"),
        MINUTES.replace("minute,type", "time,type"),
    ],
)
def test_the_same_list_written_otherwise_is_the_same(text: str, tmp_path: Path) -> None:
    (tmp_path / "x").write_text(text, newline="")
    (tmp_path / "y").write_text(MINUTES)
    assert told(load_timeline(tmp_path / "x")) == told(load_timeline(tmp_path / "y"))


@pytest.mark.parametrize(
    "text",
    [
        "minute,category,value\n1,a,3\n2,b,4\n",
        "time,event,value\n0.5,start,3\n1.0,x,4\n",
        "time,scorer\n1,A\n",
        "time,action\n12:30,walk\n12:31,run\n",
        "minute,value\n1,3\n",
        "minute,player,heart_rate,zone\n1,Ann,120,green\n2,Ann,150,red\n3,Ann,130,green\n",
        "minutes,name,price,signal\n1,a,3,hold\n2,a,4,tor\n3,a,3,hold\n4,a,5,buy\n",
        "minute,flow,light\n1,30,red\n2,40,yellow\n3,50,red\n",
        "minute,flow,light\n1,30,red\n2,40,\n3,50,\n",
        "minute,side,flow,light\n1,left,30,red\n2,right,40,green\n3,left,50,red\n",
        "minute,name,hr,color\n1,Ann,120,yellow\n2,Ann,150,blue\n",
    ],
)
def test_a_table_of_something_else_is_left_to_other_readers(text: str, tmp_path: Path) -> None:
    (tmp_path / "x").write_text(text)
    assert not sniff(DataFile.open(tmp_path / "x"))


@given(
    names=st.lists(
        st.sampled_from(sorted({n for known in COLUMNS.values() for n in known})), max_size=6
    ),
    cells=st.lists(
        st.sampled_from(("45+2", "goal", "x", "", "1", "TRUE", '"', "2014-01-01")), max_size=12
    ),
)
def test_any_header_of_known_columns_gives_a_timeline_or_a_one_line_error(
    names: list[str], cells: list[str], tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("h") / "x"
    width = max(len(names), 1)
    lines = [",".join(cells[i : i + width]) for i in range(0, len(cells), width)]
    path.write_text("\n".join([",".join(names), *lines]) + "\n")
    timeline_or_one_line(lambda: load_timeline(path))


def test_stoppage_time_may_have_a_column_of_its_own() -> None:
    text = rows("45,2,goal,A,N", "90,,goal,B,S", header="minute,added_time,type,player,team")
    assert [time for time, _, _ in told(decode(text))] == [47 * 60, 92 * 60]


def test_seconds_make_times_exact_and_count_minutes_from_0() -> None:
    text = rows("13,6,goal,A,N", "78,5.5,goal,B,S", header="minute,second,type,player,team")
    assert [time for time, _, _ in told(decode(text))] == [786.0, 78 * 60 + 5.5]
    assert told(decode(rows("13:06,goal,A,N")))[0] == (786.0, "goal", "A")


def test_a_period_column_places_stoppage_time_written_as_running_minutes() -> None:
    header = "period,minute,type,player,team"
    text = rows("1,46,goal,A,N", "2,46,goal,B,S", header=header)
    assert [time for time, _, _ in told(decode(text))] == [46 * 60, 47 * 60]
    for second in ("2H", "SecondHalf", "2nd half", "2.0"):
        again = rows("1,46,goal,A,N", f"{second},46,goal,B,S", header=header)
        assert told(decode(again)) == told(decode(text))
    restarting = rows("1,46,goal,A,N", "2,1,goal,B,S", header=header)
    assert told(decode(restarting))[1][0] == 47 * 60


def test_a_row_of_the_whistle_gives_the_end_of_a_half() -> None:
    text = rows("44,goal,A,N", "47:30,half-time,,", "60,goal,B,S", "94:10,full time,,")
    timeline = decode(text)
    periods = [(e.time_s, e.label) for e in timeline.events if e.kind == "period"]
    assert periods[1:] == [(2850.0, "half-time"), (2850.0 + 49 * 60 + 10, "full time")]
    assert told(timeline)[1][0] == 2850.0 + 15 * 60
    assert not any("stoppage" in note for note in timeline.notes)


def test_minutes_above_90_are_stoppage_time_unless_the_list_writes_that_with_a_plus() -> None:
    stoppage = decode(rows("50,goal,A,N", "94,goal,B,S"))
    assert stoppage.duration_s == 94 * 60
    assert stoppage.kinds()["period"] == 3
    extra = decode(rows("90+2,goal,A,N", "94,goal,B,S"))
    assert [time for time, _, _ in told(extra)] == [92 * 60, 96 * 60]
    assert extra.kinds()["period"] == 5
    assert decode(rows("112,goal,A,N")).duration_s == 120 * 60


def test_two_events_of_one_minute_without_names_are_two() -> None:
    text = rows("10,foul", "10,foul", "10,foul", header="minute,type")
    assert [label for _, _, label in told(decode(text))] == ["10'", "10' (2)", "10' (3)"]


def test_tables_of_other_programs_are_understood() -> None:
    elapsed = (
        "time.elapsed,time.extra,team.name,player.name,type,detail\n"
        "27,,N,A. Berg,Card,Yellow Card\n"
        "45,2,N,A. Berg,Goal,Penalty\n"
        "90,3,S,E. Friis,Card,Red Card\n"
    )
    assert told(decode(elapsed)) == [
        (27 * 60, "yellow_card", "Berg (N) 27'"),
        (47 * 60, "goal", "1-0 Berg (pen) 45+2'"),
        (95 * 60, "red_card", "Friis (S) 90+3'"),
    ]
    with_outcomes = (
        ",minute,second,expanded_minute,period,type,outcome_type,team,player,card_type,is_own_goal\n"
        "0,0,0,0,PreMatch,FormationSet,Successful,N,,,False\n"
        "1,13,6,13,FirstHalf,Goal,Successful,N,A Berg,,False\n"
        "2,14,6,14,FirstHalf,Foul,Unsuccessful,S,E Friis,,False\n"
        "3,14,6,14,FirstHalf,Foul,Successful,N,A Berg,,False\n"
        "4,14,30,14,FirstHalf,Card,Successful,S,E Friis,SecondYellow,False\n"
        "5,47,30,47,FirstHalf,End,Successful,S,,,False\n"
        "6,78,5,82,SecondHalf,Goal,Successful,N,A Berg,,True\n"
        "7,93,10,97,SecondHalf,End,Successful,N,,,False\n"
        "8,0,0,0,PostGame,End,Successful,N,,,False\n"
    )
    assert told(decode(with_outcomes)) == [
        (786.0, "goal", "1-0 Berg"),
        (846.0, "foul", "Friis (S)"),
        (870.0, "red_card", "Friis (S), second yellow"),
        (2850.0 + 33 * 60 + 5, "own_goal", "1-1 own goal, Berg"),
    ]
    assert decode(with_outcomes).duration_s == 2850.0 + 48 * 60 + 10
    shots = (
        "id,minute,result,xG,player,h_a,situation,match_id,h_team,a_team,date\n"
        "1,12,Goal,0.3,E Friis,a,OpenPlay,7,N,S,2017-09-23\n"
        "2,22,SavedShot,0.3,A Berg,h,OpenPlay,7,N,S,2017-09-23\n"
        "3,45,OwnGoal,0.3,E Friis,a,OpenPlay,7,N,S,2017-09-23\n"
        "4,80,Goal,0.7,A Berg,h,Penalty,7,N,S,2017-09-23\n"
    )
    assert [label for _, _, label in told(decode(shots))] == [
        "0-1 Friis 12'",
        "Berg (N), saved 22'",
        "1-1 own goal, Friis 45'",
        "2-1 Berg (pen) 80'",
    ]


def test_a_shoot_out_is_left_out() -> None:
    text = rows("1,10,goal,A,N", "5,120,goal,B,S", "5,120,penalty saved,A,N",
                header="period,minute,type,player,team")  # fmt: skip
    timeline = decode(text)
    assert timeline.kinds()["goal"] == 1
    assert any("shoot-out is omitted: 2 rows" in note for note in timeline.notes)


@pytest.mark.parametrize(
    ("words", "details", "kind", "detail"),
    [
        ("Goal", "", "goal", ""),
        ("goal", "Normal Goal", "goal", ""),
        ("Goal", "Penalty", "goal", "pen"),
        ("Penalty Goal", "", "goal", "pen"),
        ("Goal (pen)", "", "goal", "pen"),
        ("Goal - Header", "", "goal", ""),
        ("penalty", "", "goal", "pen"),
        ("Goal (P)", "", "goal", "pen"),
        ("Shot outside the penalty area", "goal", "goal", ""),
        ("End", "Successful", "half_end", ""),
        ("Penalty", "missed", "near_miss", "penalty missed"),
        ("Goal", "Missed Penalty", "near_miss", "penalty missed"),
        ("penalty saved", "", "near_miss", "penalty saved"),
        ("Goal", "Own Goal", "own_goal", ""),
        ("OG", "", "own_goal", ""),
        ("OwnGoal", "", "own_goal", ""),
        ("Shot", "Goal", "goal", ""),
        ("Shot", "Saved", "near_miss", "saved"),
        ("SavedShot", "", "near_miss", "saved"),
        ("ShotOnPost", "", "near_miss", "on the post"),
        ("Attempt Saved", "", "near_miss", "saved"),
        ("near_miss", "", "near_miss", ""),
        ("Shot", "Off Target", "", ""),
        ("MissedShots", "", "", ""),
        ("Save", "", "", ""),
        ("Goal kick", "", "", ""),
        ("goal_kick", "", "", ""),
        ("Var", "Goal cancelled", "", "cancelled"),
        ("Goal disallowed", "", "", "cancelled"),
        ("Assist", "", "", ""),
        ("Yellow Card", "", "yellow_card", ""),
        ("yellow", "", "yellow_card", ""),
        ("YC", "", "yellow_card", ""),
        ("Card", "Yellow", "yellow_card", ""),
        ("Card", "Red Card", "red_card", ""),
        ("Card", "Second Yellow card", "red_card", "second yellow"),
        ("yellow-red card", "", "red_card", "second yellow"),
        ("2nd yellow", "", "red_card", "second yellow"),
        ("red_card", "", "red_card", ""),
        ("Foul", "", "foul", ""),
        ("Foul committed", "", "foul", ""),
        ("Handball", "", "foul", ""),
        ("Foul won", "", "", "suffered"),
        ("Substitution", "", "", ""),
        ("subst", "", "", ""),
        ("Pass", "", "", ""),
        ("Half-time", "", "half_end", ""),
        ("Full Time", "", "match_end", ""),
        ("Kick-off", "", "period", ""),
        ("Period", "half-time", "half_end", ""),
        ("GOAL! Jones scores (1-0)", "", "goal", ""),
        ("Goal by Hill", "", "goal", ""),
        ("GOAL - Jones", "", "goal", ""),
        ("Jones scores the penalty", "", "goal", "pen"),
        ("Penalty for France", "", "", ""),
        ("Penalty for France, not scored", "", "near_miss", "penalty missed"),
        ("Goal line clearance", "", "", ""),
        ("Goal attempt by Hill", "", "", ""),
        ("GOAL! Disallowed after a check", "", "", "cancelled"),
        ("but what a save", "", "", ""),
        ("Smith fouls Jones", "", "foul", ""),
        ("Chance for Jones, wide", "", "near_miss", ""),
        ("saved by our keeper", "", "near_miss", "saved"),
        ("Tor! Meier trifft", "", "goal", ""),
        ("Torwart", "", "", ""),
        ("Elfmetertor", "", "goal", "pen"),
        ("Elfmeter verschossen", "", "near_miss", "penalty missed"),
        ("Gelbe Karte Huber", "", "yellow_card", ""),
        ("Gelb-Rote Karte", "", "red_card", "second yellow"),
        ("Eigentor Schulz", "", "own_goal", ""),
        ("But de Mbappé", "", "goal", ""),
        ("Deuxième carton jaune", "", "red_card", "second yellow"),
        ("Gol de Messi", "", "goal", ""),
        ("Gol anulado", "", "", "cancelled"),
        ("Tarjeta roja", "", "red_card", ""),
        ("Doppia ammonizione", "", "red_card", "second yellow"),
        ("Jones nearly scores from 20 yards", "", "", ""),
        ("Smith should have scored", "", "", ""),
        ("Substitution: Smith, who scored, off", "", "", ""),
        ("Half time: Smith scored twice", "", "half_end", ""),
        ("Formation converted to 4-4-2", "", "", ""),
        ("Foul by Kenneth Paal", "", "foul", ""),
        ("Foul", "Emmanuel Latte Lath", "foul", ""),
        ("Substitution: Latte Lath on", "", "", ""),
        ("Shot", "Shot by Tor Hansen saved", "near_miss", "saved"),
        ("Shot", "Schuss neben das Tor", "", ""),
        ("Chance", "Kopfball über das Tor", "", ""),
        ("Goal! No, offside", "", "", "cancelled"),
        ("But! Refusé pour hors-jeu", "", "", "cancelled"),
        ("Tor! Zählt nicht", "", "", "cancelled"),
        ("Goal of the month vote", "", "", ""),
        ("Goal in danger as Smith breaks", "", "", ""),
        ("Goal - line tech", "", "", ""),
        ("Gol contra el Madrid", "", "", ""),
        ("Gol contra", "", "own_goal", ""),
        ("Elfmeter", "", "", ""),
        ("Elfmeter", "verschossen", "near_miss", "penalty missed"),
        ("Elfmeter", "verwandelt", "goal", "pen"),
        ("Penalti", "fallo", "near_miss", "penalty missed"),
        ("Rigore", "parato", "near_miss", "penalty missed"),
        ("Penalty scored by Kane", "", "goal", "pen"),
        ("Palo de Messi", "", "near_miss", "on the post"),
        ("Elfmeter verwandelt", "", "goal", "pen"),
        ("verwandelter Foulelfmeter", "", "goal", "pen"),
        ("Handelfmeter verwandelt", "Yilmaz", "goal", "pen"),
        ("Strafstoß verwandelt", "", "goal", "pen"),
        ("Foulelfmeter verschossen", "", "near_miss", "penalty missed"),
        ("Tooooooor! Lang mit dem 3:2", "", "goal", ""),
        ("Siegtreffer", "", "goal", ""),
        ("Lattentreffer", "", "near_miss", "on the post"),
        ("Lang trifft nur die Latte", "", "near_miss", "on the post"),
        ("Ampelkarte", "", "red_card", "second yellow"),
        ("Meier sieht Gelb", "", "yellow_card", ""),
        ("Meier sieht die Rote Karte", "", "red_card", ""),
    ],
)
def test_words_mean_a_football_kind(words: str, details: str, kind: str, detail: str) -> None:
    further = normalize_terms(details, is_detail=True)
    found = meaning(normalize_terms(words), further, own=False, penalty=False)
    assert found == (kind, detail)


TOLD = ["3,Foul von Schmidt", "17',Tor! Meier trifft (1:0)", "45+2,Gelbe Karte", "60,Auswechslung"]


@pytest.mark.parametrize(
    "header", ["Minute,Was", "minute,what happened", "time,Text", "Min.,Notiz"]
)
def test_a_match_in_ones_own_words_is_read_whatever_its_column_is_called(
    header: str, tmp_path: Path
) -> None:
    (tmp_path / "x.csv").write_text(rows(*TOLD, header=header))
    timeline = load_timeline(tmp_path / "x.csv")
    assert told(timeline) == [
        (180.0, "foul", "Foul von Schmidt 3'"),
        (1020.0, "goal", "Tor! Meier trifft (1:0) 17'"),
        (2820.0, "yellow_card", "45+2'"),
    ]
    assert any("1 Auswechslung" in note for note in timeline.notes)


def test_the_words_of_the_guide_are_read_as_it_says() -> None:
    guide = (Path(__file__).parents[3] / "docs/guide/data.md").read_text(encoding="utf-8")
    lines = re.findall(r"^\| `([a-z_]+)` \| (.+?) \| (.+?) \|$", guide, re.M)
    lines = [line for line in lines if line[0] in TERMS]
    assert len(lines) == len(TERMS)
    for kind, *columns in lines:
        for word in re.findall(r"`(.+?)`", " ".join(columns)):
            found = meaning(normalize_terms(word), "", own=False, penalty=False)
            assert found[0] == kind, word


TERMS = ("goal", "own_goal", "near_miss", "yellow_card", "red_card", "foul")


@pytest.mark.parametrize(
    ("text", "minute"),
    [
        ("38", Minute(38)),
        ("38'", Minute(38)),
        ("38.0", Minute(38)),
        ("90+3", Minute(90, 3)),
        ("90'+3'", Minute(90, 3)),
        (" 90 + 3 ’", Minute(90, 3)),
        ("12:34", Minute(12, None, 34.0)),
        ("45+2:30.5", Minute(45, 2, 30.5)),
    ],
)
def test_minutes_are_parsed(text: str, minute: Minute) -> None:
    assert parse_minute(text, "x") == minute


@pytest.mark.parametrize(
    "text",
    ["", "x", "-1", "1.5", "12:60", "999", "90+99", "٣", "1e2", "9" * 9],
)
def test_an_invalid_minute_gives_a_one_line_error(text: str) -> None:
    with pytest.raises(InputError, match=r"^line 3: .*minute"):
        parse_minute(text, "line 3")


def test_a_field_of_blanks_takes_no_time() -> None:
    with pytest.raises(InputError, match="isn't a minute"):
        parse_minute("1" + " " * 120_000 + "x", "line 3")


@given(st.lists(st.tuples(st.integers(0, 120), st.integers(0, 15)), min_size=1, max_size=8))
def test_laid_minutes_keep_their_order_and_lie_within_the_match(
    listed: list[tuple[int, int]],
) -> None:
    minutes = [Minute(b, a if b in (45, 90, 105, 120) and a else None) for b, a in listed]
    clock = Clock.from_minutes(minutes)
    ordered = sorted(minutes, key=lambda m: (clock.period_of(m), m.on_clock))
    times = [clock.time_s(minute) for minute in ordered]
    assert times == sorted(times)
    assert times[0] >= 0.0
    assert times[-1] <= clock.duration_s


def test_goals_of_many_matches_need_a_choice(tmp_path: Path) -> None:
    (tmp_path / "g.csv").write_text(GOALSCORERS)
    with pytest.raises(InputError, match=r"g\.csv: the file has 2 matches; .*'sudbury eastham'"):
        load_timeline(tmp_path / "g.csv")
    assert list_matches(tmp_path / "g.csv") == (
        "2014-07-08  Northport 1-2 Sudbury",
        "2014-07-09  Sudbury 0-1 Eastham",
    )
    timeline = load_timeline(tmp_path / "g.csv", match="Northport")
    assert timeline.title == "Northport 1-2 Sudbury, 2014-07-08"
    assert told(timeline) == [
        (10.5 * 60, "goal", "0-1 Friis 11'"),
        # the team of a list of goals is the one that gets the score
        (28.5 * 60, "own_goal", "1-1 own goal, Sudbury 29'"),
        (89.5 * 60, "goal", "1-2 Friis (pen) 90'"),
    ]
    extra = load_timeline(tmp_path / "g.csv", match="Eastham")
    assert extra.duration_s == 120 * 60


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (rows("soon,goal,A,N"), "line 2, column 'minute': 'soon' isn't a minute"),
        (rows(",goal,A,N"), r"line 2, .*: is missing; write a minute"),
        (rows("10,goal,A,N", "20,goal,B,S", "30,goal,C,T"), "line 4: the team is 'T'; .*'N' and"),
        (rows("10,pass,A,N"), "the list has no goal, card, foul or near miss"),
        (rows(), "the list has no rows below the header"),
        (
            rows("9,1,goal", header="period,minute,type"),
            "column 'period': '9' is not a period; must be 1",
        ),
        (
            rows("1,goal,maybe", header="minute,type,own goal"),
            "column 'own goal': 'maybe' must be TRUE or FALSE",
        ),
        (
            rows("1,70,goal", header="minute,second,type"),
            "column 'second': 70.0 is out of range",
        ),
        (
            rows("1,x,goal", header="minute,added,type"),
            "line 2, column 'added': 'x' isn't a number",
        ),
    ],
)
def test_a_wrong_row_is_named(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        decode(text)


@given(
    st.sampled_from((MINUTES, GOALSCORERS)),
    st.integers(0, 300),
    st.integers(0, 40),
    st.text(max_size=6),
    st.sampled_from((None, "1", "Northport")),
)
def test_any_change_gives_a_timeline_or_a_one_line_error(
    text: str, at: int, length: int, put: str, match: str | None
) -> None:
    timeline_or_one_line(lambda: decode(text[:at] + put + text[at + length :], match))


def test_every_goal_of_the_real_list_is_counted(data_folder: Path) -> None:
    lines = list_matches(data_folder / "football/goalscorers_2010s.csv")
    scores = [re.search(r" (\d+)-(\d+) ", line) for line in lines]
    assert sum(int(score[1]) + int(score[2]) for score in scores if score) == 9808


def test_the_real_list_of_goals_is_exact(data_folder: Path) -> None:
    path = data_folder / "football/goalscorers_2010s.csv"
    timeline = load_timeline(path, match="2014-07-08 Brazil Germany")
    assert timeline.title == "Brazil 1-7 Germany, 2014-07-08"
    minutes = [e.time_s / 60 + 0.5 for e in timeline.events if e.kind == "goal"]
    assert minutes == [11, 23, 24, 26, 29, 69, 79, 90]
    final = load_timeline(path, match="2018-07-15 France Croatia")
    assert final.title == "France 4-2 Croatia, 2018-07-15"
    assert [e.kind for e in final.events if "goal" in e.kind] == ["own_goal"] + ["goal"] * 5


@pytest.mark.parametrize(
    ("header", "last"),
    [("Minute;Was", "45+2"), ("Minute;Was", "44"), ("Spielminute;Ereignis", "45+2"),
     ("Minute;Was passiert ist", "45.+2")],
)  # fmt: skip
def test_a_match_in_sentences_stays_one_with_more_unknown_rows(header: str, last: str) -> None:
    unknown = ("Der Trainer tobt", "Regen", "Viel Betrieb", "Pause fuer die Fans")
    rows = [
        "14;Tor! Brandt",
        f"{last};gelbe Karte",
        *(f"{50 + i};{t}" for i, t in enumerate(unknown)),
    ]
    timeline = load_timeline("\n".join([header, *rows, ""]).encode())
    assert [e.kind for e in timeline.events if e.kind != "period"] == ["goal", "yellow_card"]
    (note,) = [note for note in timeline.notes if note.startswith("omitted")]
    assert "1 Der Trainer tobt" in note


@pytest.mark.parametrize(
    ("rows", "note"),
    [
        (["12,Goal,A,Croatia", "30,Foul,B,Croatia"], "only the team 'Croatia' is named: the score"),
        (["12,Goal,A,Croatia", "30,Foul,B,France", "40,Goal,C,"], "1 goal has no team: the score"),
    ],
)
def test_a_score_that_cannot_be_counted_is_noted(rows: list[str], note: str) -> None:
    text = "\n".join(["minute,type,player,team", *rows, ""])
    (found,) = [one for one in load_timeline(text.encode()).notes if "score" in one]
    assert found.startswith(note)


def test_columns_have_the_first_header_of_their_words_and_several_details() -> None:
    header = ["", "Qualifier", "x", "Team", "team", "player_name", "card type", "Details", "Team"]
    assert minute_list._columns(header) == {
        "details": ["Details", "card type", "Qualifier"],
        "player": ["player_name"],
        "team": ["Team"],
    }
