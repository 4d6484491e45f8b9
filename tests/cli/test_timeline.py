from __future__ import annotations

import json
import os
import re

import pytest
import soundfile

import overview_dsp as ov
from overview_dsp.data.readers.registry import list_matches
from tests.cli.commands import ALL
from tests.cli.running import MATCH, QUICK, overview, refused
from tests.data.readers.football_files import (
    GOALSCORERS,
    MINUTES,
    OPENFOOTBALL_TEXT,
    fixture,
    openfootball,
)

CUP = openfootball(fixture("France", "Australia"), fixture("France", "Croatia"))


def test_texts_of_a_file_cannot_control_the_terminal(folder):
    events = [ov.Event(0.4, "goal", "one\x1b[2Jtwo"), ov.Event(3.0, "foul", "a\x1b]0;b\x07c")]
    match = ov.Timeline(duration_s=5.0, events=events, title="a\x1b]0;title\x07")
    ov.save_timeline(match, "match.json")
    shown = overview("timeline", "show", "match.json", "--events")
    passed = overview("render", "match.json", "--transcript", "-", "--gesture", "sweep:0.5")
    missing = overview("timeline", "show", "a\x9b2Jb.json")  # the same, in one character
    assert "a 2Jb.json: no such file" in missing.err
    for outcome in (shown, passed):
        assert outcome.code == 0
        assert "one [2Jtwo" in outcome.out
        assert outcome.out.replace("\n", "").isprintable()


def test_show_reports_span_curve_events_gaps_and_where_they_are_from(folder, match):
    outcome = overview("timeline", "show", MATCH)
    assert outcome.code == 0, outcome.err
    lines = outcome.out.splitlines()
    assert lines[0] == match.title
    assert lines[1] == "span     1:38:00.0 (5880 s)"
    assert lines[2].startswith("curve    1177 points, 0.1013 to 0.9219, synthetic crowd")
    kinds = "3 period, 16 foul, 4 near_miss, 1 own_goal, 3 yellow_card, 5 goal"
    assert lines[3] == f"events   32: {kinds}"
    count = len(match.details)
    assert lines[4] == f"details  {count}: {count} touch; shown in windows"
    assert lines[5] == "gaps     none"
    assert lines[6] == f"from     {match.provenance}"
    assert lines[7:] == [f"note     {note}" for note in match.notes]
    assert os.listdir(folder) == []


def test_show_events_lists_every_event_by_the_name_a_zoom_takes(match):
    outcome = overview("timeline", "show", MATCH, "--events")
    listed = outcome.out.split("\n\n")[1].splitlines()
    assert len(listed) == len(match.events)
    goal = next(line for line in listed if "goal:2 " in line and "own" not in line)
    assert goal.split() == ["37:30.0", "goal:2", "2-1", "Griezmann", "(pen)"]


def test_show_reports_dates_and_gaps(folder):
    text = {
        "overview_timeline": 1,
        "title": "shares",
        "duration_s": 31_536_000,
        "start": "2012-01-01T00:00:00",
        "gaps": [[86_400, 172_800]],
        "intensity": {"time_s": [0, 31_536_000], "value": [13.5, 702.1], "unit": "USD"},
        "events": [{"time_s": 864_000, "kind": "record", "weight": 2}],
    }
    (folder / "s.json").write_text(json.dumps(text))
    lines = overview("timeline", "show", "s.json", "--events").out.splitlines()
    assert lines[1:5] == [
        "span     365 days (31536000 s)",
        "start    2012-01-01, end 2012-12-31 00:00:00",
        "curve    2 points, 13.5 to 702.1, USD",
        "events   1: 1 record",
    ]
    assert lines[5] == "gaps     1, 24:00:00.0 in all: 2012-01-02 to 2012-01-03"
    assert lines[-1].split() == ["2012-01-11", "record:1", "(weight", "2)"]
    text["start"] = "2012-01-01T07:30:00"
    (folder / "s.json").write_text(json.dumps(text))
    lines = overview("timeline", "show", "s.json", "--events").out.splitlines()
    assert lines[2] == "start    2012-01-01 07:30:00, end 2012-12-31 07:30:00"
    assert lines[5].endswith("in all: 2012-01-02 07:30:00 to 2012-01-03 07:30:00")
    assert lines[-1].split()[:2] == ["2012-01-11", "07:30:00"]


def test_show_json_is_the_same_as_data(folder, match):
    report = json.loads(overview("timeline", "show", MATCH, "--json", "--events").out)
    assert report["title"] == match.title
    assert report["sides"] == ["France", "Croatia"]
    assert report["duration_s"] == match.duration_s
    assert report["kinds"] == match.kinds()
    assert report["events"] == len(report["event_list"]) == len(match.events)
    assert report["event_list"][0] == {
        "time_s": 0.0, "kind": "period", "label": "kick-off", "weight": 1.0, "side": 0
    }  # fmt: skip
    assert report["unit"] == match.intensity.unit
    assert report["notes"] == list(match.notes)


def test_show_lists_the_matches_of_a_file_of_several(folder):
    (folder / "cup.json").write_text(json.dumps(CUP))
    outcome = overview("timeline", "show", "cup.json")
    assert outcome.out.splitlines() == [
        "cup.json: 2 matches; choose one with --select",
        "1  2020-07-15  France 2-1 Australia  Final",
        "2  2020-07-15  France 2-1 Croatia  Final",
    ]
    report = json.loads(overview("timeline", "show", "cup.json", "--json").out)
    assert report["matches"] == list(list_matches("cup.json"))
    one = overview("timeline", "show", "cup.json", "--select", "croatia")
    assert one.out.startswith("France 2-1 Croatia, Village Cup 2020")
    refused(overview("timeline", "show", "cup.json", "--select", "Brazil"), "cup.json", "Brazil")


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_show_draws_the_curve(folder, suffix):
    outcome = overview("timeline", "show", MATCH, "--plot", f"out.{suffix}")
    assert outcome.code == 0, outcome.err
    assert os.listdir(folder) == [f"out.{suffix}"]
    assert (folder / f"out.{suffix}").stat().st_size > 5000
    assert outcome.out.splitlines()[-1] == f"out.{suffix}: intensity curve with events"


def test_an_unwritable_picture_gives_a_one_line_error_before_anything_is_read(folder):
    refused(overview("timeline", "show", "no.json", "--plot", "x.gif"), "x.gif", ".png")
    refused(overview("timeline", "show", "no.json", "--plot", "no/x.png"), "no/x.png", "no folder")


def test_convert_writes_the_native_format_and_it_reads_back_the_same(folder):
    (folder / "g.csv").write_text(GOALSCORERS)
    outcome = overview("timeline", "convert", "g.csv", "--select", "1", "-o", "n.json")
    assert outcome.code == 0, outcome.err
    assert outcome.out.startswith(
        "n.json: Northport 1-2 Sudbury, 2014-07-08, 1:30:00.0, 6 events, "
    )
    assert ov.load_timeline("n.json") == ov.load_timeline("g.csv", match="1")
    again = overview("timeline", "convert", "n.json", "--json")
    assert json.loads(again.out)["file"] == "timeline.json"
    assert (folder / "timeline.json").read_bytes() == (folder / "n.json").read_bytes()


def test_convert_writes_one_file_for_each_series_of_a_table(folder):
    rows = [
        f"{year},{name},{year % 7}" for year in (2001, 2002) for name in ("Norway", "A/B", "A B")
    ]
    (folder / "c.csv").write_text("\n".join(["year,country,value", *rows]))
    outcome = overview(
        "timeline", "convert", "c.csv", "--group", "country", "-o", "e.json", "--json"
    )
    assert outcome.code == 0, outcome.err
    files = [one["file"] for one in json.loads(outcome.out)["files"]]
    assert files == ["e-Norway.json", "e-A-B.json", "e-A-B2.json"]
    assert ov.load_timeline("e-A-B.json") == ov.load_timeline("c.csv", match="country=A/B")
    grouped = ("timeline", "convert", "c.csv", "--group", "country")
    refused(overview(*grouped, "--select", "Norway"), "--group", "--select")
    refused(overview("timeline", "convert", "c.csv", "--group", "land"), "land", "country")
    refused(overview("timeline", "show", "c.csv"), "c.csv", "--group 'country'", "country=Norway")


def test_convert_writes_event_lists_that_read_back_the_same_events(folder, match):
    outcome = overview("timeline", "convert", MATCH, "-o", "m.csv")
    assert "1177 points of the curve are not in it" in outcome.out
    again = ov.load_timeline("m.csv")
    assert again.events == match.events
    assert (again.title, again.duration_s) == (match.title, match.duration_s)


def test_convert_refuses_what_it_cannot_write(folder):
    refused(overview("timeline", "convert", "no.json", "-o", "x.wav"), "x.wav", ".json", ".csv")
    refused(overview("timeline", "convert", "no.json", "-o", "no/x.json"), "no folder")
    refused(overview("timeline", "convert", "no.json"), "no.json", "no such file")
    curve = {"overview_timeline": 1, "duration_s": 9, "intensity": {"time_s": [0], "value": [1]}}
    (folder / "c.json").write_text(json.dumps(curve))
    refused(overview("timeline", "convert", "c.json", "-o", "c.csv"), "no events", ".json")
    assert os.listdir(folder) == ["c.json"]


def test_limits_are_options_of_the_command_line(folder):
    (folder / "m.json").write_text(OPENFOOTBALL_TEXT)
    refused(
        overview("timeline", "show", "m.json", "--read", "max-mb=1e-5"),
        "m.json",
        "--read max-mb=MB",
    )
    refused(
        overview("timeline", "show", "m.json", "--read", "max-depth=2"),
        "m.json",
        "--read max-depth=LEVELS",
    )
    assert (
        overview("timeline", "show", "m.json", "--read", "max-depth=9", "--read", "max-mb=1").code
        == 0
    )
    refused(overview("timeline", "show", "m.json", "--read", "max-mb=-1"), "max_mb is -1.0")
    refused(overview("timeline", "show", MATCH, "--read", "rate=50"), "rate does not apply")


@pytest.mark.parametrize(
    "command",
    [
        ("render",),
        ("figures",),
        ("play",),
        ("export",),
        ("timeline", "show"),
        ("timeline", "convert"),
    ],
)
def test_every_command_that_opens_a_timeline_takes_the_same_options(command):
    known = ALL[command]
    option = "--help-all" if getattr(known, "first", ()) else "--help"
    shown = re.sub(r"-\n\s+", "-", overview(*command, option).out)
    for option in ("--value-column", "--time-column", "--map", "--select", "--read"):
        assert f"{option} " in shown
    for key in ("kind", "label", "rate", "duration", "max-mb", "max-depth"):
        assert f"{key}=" in shown


@pytest.mark.parametrize(
    ("read", "words"),
    [
        ("rate", ("not KEY=VALUE", "max-depth")),
        ("rat=50", ("unknown key 'rat'", "did you mean 'rate'?", "max-depth")),
        ("rate=fast", ("--read rate=fast: 'fast' is not a number",)),
        ("max-depth=2.5", ("'2.5' is not a whole number",)),
    ],
)
def test_a_wrong_reading_option_gives_a_one_line_error_with_what_can_be_given(read, words):
    refused(overview("timeline", "show", MATCH, "--read", read), *words)


def test_a_reading_option_given_twice_is_refused():
    twice = ("--read", "rate=5", "--read", "rate=6")
    refused(overview("timeline", "show", MATCH, *twice), "rate occurs twice")


def test_render_takes_a_match_of_a_file(folder):
    (folder / "cup.json").write_text(json.dumps(CUP))
    refused(overview("render", "cup.json", *QUICK), "the file has 2 matches", "--select")
    report = json.loads(overview("render", "cup.json", "--select", "2", *QUICK, "--json").out)
    assert report["title"].startswith("France 2-1 Croatia")
    assert len(soundfile.read(folder / "out.wav")[0]) > 0


def test_show_looks_for_matches_with_the_options_a_format_is_detected_by(folder):
    beats = "".join(f"{int(1000 * (i % 100 == 50))}\n" for i in range(2000))
    (folder / "lead.csv").write_text("hart\n" + beats)
    outcome = overview("timeline", "show", "lead.csv", "--read", "rate=100")
    refused(overview("timeline", "show", "lead.csv"), "lead.csv")
    assert "not a format" not in outcome.err


def test_a_list_of_minutes_is_rendered(folder):
    (folder / "m.csv").write_text(MINUTES)
    assert overview("render", "m.csv", *QUICK).code == 0
