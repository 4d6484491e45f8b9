"""Matches in openfootball's plain text: the same as in its JSON."""

from __future__ import annotations

import re
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.readers import list_matches, load_timeline
from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.football import openfootball
from overview_dsp.data.timeline import Timeline
from overview_dsp.errors import InputError
from tests.data.readers.outcome import timeline_or_one_line

CUP = """= Made-up Cup 2031        # nowhere

Group A   |  Ruritania   Freedonia
▪ Final   |  Sun Jul/6

▪ Semi-finals
Wed Jul 2
   18:00     Ruritania     3-0 (2-0)     Grand Fenwick   @ Castle Park, Zenda
               (Ada Berg 7', 45+2' Lund 60'(pen.))
   22:00     Freedonia     2-1 pen. 1-1 a.e.t. (1-1, 0-1)   Sylvania
               (Firefly 88';
                Trentino 12' (o.g.))
Thu Jul 3    Elbonia   0-1 a.e.t. (0-0)  Syldavia   @ Klow
                 (Sponsz 105+1')

(19) Match for third place
(20) Sat Jul/5 21:00   Elbonia  -  Sylvania   @ Klow

Final
(21) Sun Jul/6  18:00   1. FC Zenda 04  v  Freedonia   4-2 (2-1)
        [Berg 18' (og) Lund 38' (p)
         59'; Firefly 28', 69' (pen.) Chico 90+4']
"""


@pytest.fixture
def cup(tmp_path: Path) -> Path:
    (tmp_path / "cup.txt").write_text(CUP, encoding="utf-8")
    return tmp_path / "cup.txt"


def told(timeline: Timeline) -> list[tuple[float, str]]:
    return [(e.time_s, e.label) for e in timeline.events if e.kind in ("goal", "own_goal")]


def test_the_matches_of_a_text_are_listed_with_date_score_and_round(cup: Path) -> None:
    assert list_matches(cup) == (
        "Wed Jul 2  Ruritania 3-0 Grand Fenwick  Semi-finals",
        "Wed Jul 2  Freedonia 1-1 Sylvania  Semi-finals",
        "Thu Jul 3  Elbonia 0-1 Syldavia  Semi-finals",
        "Sun Jul/6  1. FC Zenda 04 4-2 Freedonia  Final",
    )


def test_goals_are_at_their_minutes_for_their_team(cup: Path) -> None:
    timeline = load_timeline(cup, match="Ruritania")
    assert timeline.title == "Ruritania 3-0 Grand Fenwick, Made-up Cup 2031, Semi-finals, Wed Jul 2"
    assert told(timeline) == [
        (390.0, "1-0 Berg 7'"),
        (2790.0, "2-0 Berg 45+2'"),
        (3690.0, "3-0 Lund (pen) 60'"),
    ]
    final = load_timeline(cup, match="Zenda")
    assert [label for _, label in told(final)] == [
        "1-0 own goal, Berg 18'",
        "1-1 Firefly 28'",
        "2-1 Lund (pen) 38'",
        "3-1 Lund 59'",
        "3-2 Firefly (pen) 69'",
        "3-3 Chico 90+4'",
    ]
    assert any(
        "the file has the final score 4-2, but its goals add up to 3-3" in note
        for note in final.notes
    )


def test_extra_time_shoot_outs_and_goals_of_the_second_team_alone(cup: Path) -> None:
    timeline = load_timeline(cup, match="Sylvania")
    assert [label for _, label in told(timeline)] == [
        "0-1 own goal, Trentino 12'",
        "1-1 Firefly 88'",
    ]
    assert timeline.duration_s == 7200.0
    assert "the shoot-out is omitted: Freedonia 2, Sylvania 1" in timeline.notes
    assert [label for _, label in told(load_timeline(cup, match="3"))] == ["0-1 Sponsz 105+1'"]


def test_football_txt_and_json_give_the_same_match(cup: Path) -> None:
    goal: dict[str, Any] = {"name": "Ada Berg", "minute": 7}
    document = {
        "name": "Made-up Cup 2031",
        "matches": [
            {
                "round": "Semi-finals",
                "date": "Wed Jul 2",
                "team1": "Ruritania",
                "team2": "Grand Fenwick",
                "score": {"ft": [3, 0], "ht": [2, 0]},
                "goals1": [
                    goal,
                    goal | {"minute": 45, "offset": 2},
                    {"name": "Lund", "minute": 60, "penalty": True},
                ],
                "goals2": [],
            }
        ],
    }
    assert load_timeline(cup, match="1") == openfootball.decode(document)


SCORES = {
    "a league's page": "= League 2031\n\n▪ Matchday 1\n[Fri Aug/11]\n"
    "  20.00  Ruritania   0-3 (0-2)  Freedonia\n  21.00  Elbonia  1-1 (0-0)  Syldavia\n",
    "teams first": "= League\n» Matchday 1\n  Fri Aug/11 2031\n  20:00  Ruritania v Elbonia 0-3\n",
    "one match": "Final\nSun Jul/15  18:00   Ruritania   4-2 (2-1)   Elbonia   @ Klow\n",
    "scorers alone": "= Cup\nFri Aug 11\n  Ruritania  0-3 (0-2)  Elbonia\n   (Berg, Berg, Lund)\n",
}


@pytest.mark.parametrize("name", SCORES)
def test_scores_without_minutes_are_refused_with_what_is_missing(name: str, tmp_path: Path) -> None:
    path = tmp_path / "scores.txt"
    path.write_text(SCORES[name], encoding="utf-8")
    for of_it in (list_matches, load_timeline):
        with pytest.raises(InputError) as refused:
            of_it(path)
        first, second = str(refused.value).splitlines()
        assert "scores.txt: the openfootball file has scores of matches" in first
        assert "no goals with minutes" in first
        assert "write the goals below their match" in second


def test_a_match_without_any_goal_is_whole(tmp_path: Path) -> None:
    (tmp_path / "x.txt").write_text("= Cup\nFri Aug 11\n  Ruritania  0-0 (0-0)  Elbonia\n")
    assert load_timeline(tmp_path / "x.txt").kinds() == {"period": 3}


@pytest.mark.parametrize(
    "text",
    [
        "Jan 12 10:00:01 host kernel: read 3-4 sectors\nJan 12 10:00:05 host: read 1-4 sectors\n",
        "= A letter\nJul 4\nWe won 3-2 in the end\nThen came\nthe rain\nand all\n",
        "= what,when\n2-1,3-4 a\n",
        "A 2-1 B\nC 0-0 D\n",
        "a letter\n\nIt was 3-2 in the end\n(at 5' o'clock)\n",
        "0:00 Intro\n1:15 It's a joke\n",
        "time,event\n1,it's\n",
    ],
)
def test_other_texts_are_not_detected_as_football_txt(text: str, tmp_path: Path) -> None:
    (tmp_path / "x.txt").write_text(text)
    if "letter" not in text:
        assert not openfootball.sniff_text(DataFile.open(tmp_path / "x.txt"))
    timeline_or_one_line(lambda: load_timeline(tmp_path / "x.txt"))


@given(st.integers(0, len(CUP) - 1), st.text(max_size=4), st.integers(0, 9))
def test_any_change_gives_a_timeline_or_a_one_line_error(at: int, put: str, cut: int) -> None:
    text = CUP[:at] + put + CUP[at + cut :]
    timeline_or_one_line(lambda: openfootball.decode(openfootball.document_of(text), "1"))


PARTS = st.sampled_from(CUP.splitlines()) | st.sampled_from(
    ["A 2-1 B", "A  12-0  B", "\tA v B\t2-1", " 3-0", "3-0 B", "A 100-1 B", "A - B", "A\u00a01-1 B"]
)


@given(st.lists(PARTS, min_size=1, max_size=4))
def test_a_text_without_a_score_is_no_match_without_reading_its_lines(lines: list[str]) -> None:
    with TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        (Path(folder) / "x.txt").write_text("\n".join(["= Cup", *lines]), encoding="utf-8")
        source = DataFile.open(Path(folder) / "x.txt")
        found = openfootball.sniff_text(source)
        patch.setattr(openfootball, "_A_SCORE", re.compile(""))
        assert openfootball.sniff_text(source) == found


def test_the_lines_of_a_text_without_a_score_are_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "x.txt").write_text("= Cup\nRuritania - Elbonia\n2031-07-04,3\n")
    monkeypatch.delattr(openfootball, "document_of")
    assert not openfootball.sniff_text(DataFile.open(tmp_path / "x.txt"))
