"""`overview presets`: new, edit, diff, morph, randomize, audition, reference, schema."""

from __future__ import annotations

import functools
import json

import pytest
import soundfile

import overview_dsp as ov
from overview_dsp.measure.observer import observing
from tests.cli.running import overview, refused


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("OVERVIEW_PRESETS", str(tmp_path / "own"))
    return tmp_path


def done(*arguments):
    outcome = overview(*arguments)
    assert outcome.code == 0, outcome.err
    return outcome.out


def test_a_new_preset_is_in_the_own_folder_listed_checked_and_played(folder):
    assert "own" in done("presets", "new", "mine", "--base", "heart")
    assert (folder / "own" / "mine.toml").is_file()
    assert "mine" in done("presets", "list")
    assert "valid" in done("presets", "check", "mine")
    assert "no difference" in done("presets", "diff", "mine", "heart")
    refused(overview("presets", "new", "mine"), "already exists")
    refused(overview("presets", "new", "football"), "bundled")
    refused(overview("presets", "new", "../x"), "must be letters")
    refused(overview("presets", "new", "other", "--base", "nothing"), "nothing")


def test_editing_checks_what_was_written(folder, monkeypatch):
    done("presets", "new", "mine")
    (folder / "editor").write_text('#!/bin/sh\nprintf "\\n[disk]\\nk1 = 9e9\\n" >> "$1"\n')
    (folder / "editor").chmod(0o755)
    monkeypatch.setenv("VISUAL", str(folder / "editor"))
    refused(overview("presets", "edit", "mine"), "mine.toml:", "disk.k1", "out of range")
    refused(overview("presets", "edit", "football"), "presets new my-football --base football")
    monkeypatch.setenv("VISUAL", "true")
    refused(overview("presets", "edit", "mine"), "disk.k1")
    for name in ("VISUAL", "EDITOR"):
        monkeypatch.delenv(name, raising=False)
    refused(overview("presets", "edit", "mine"), "set EDITOR", "mine.toml", "presets check mine")


def test_diff_lists_differences_as_a_table_and_as_json(folder):
    assert "surface.friction" in done("presets", "diff", "football", "crowd")
    found = json.loads(done("presets", "diff", "football", "crowd", "--json"))
    first, second = (
        ov.load_preset(name).number("surface.intensity_gain") for name in ("football", "crowd")
    )
    assert {"id": "surface.intensity_gain", "first": first, "second": second, "unit": "x"} in found


def test_morph_and_randomize_write_valid_presets(folder):
    done("presets", "morph", "football", "heart", "--steps", "3", "-o", "between")
    assert sorted(path.name for path in (folder / "between").iterdir()) == [
        f"football-heart-{k}.toml" for k in (1, 2, 3)
    ]
    done("presets", "check", *map(str, (folder / "between").iterdir()))
    done("presets", "randomize", "football", "--seed", "7")
    first = (folder / "football-7.toml").read_bytes()
    done("presets", "randomize", "football", "--seed", "7", "-o", "again.toml")
    assert (folder / "again.toml").read_bytes() == first
    refused(overview("presets", "randomize", "football", "--amount", "2"), "0 to 1")
    refused(overview("presets", "morph", "football", "heart", "--steps", "1"), "2 to 1000")


def test_an_audition_is_a_sound_and_a_picture_of_every_kind(folder):
    report = json.loads(done("presets", "audition", "crowd", "--json"))
    samples, _ = soundfile.read(report["file"])
    assert abs(samples).max(axis=0).min() > 0.01
    assert [entry["kind"] for entry in report["kinds"]] == [
        kind for kind in ("default", "cheer", "burst") for _ in range(2)
    ]
    assert (folder / "crowd-audition.png").stat().st_size > 10_000


def test_the_reference_and_the_schema_are_printed(folder):
    assert "| `inertia` |" in done("presets", "reference")
    assert json.loads(done("presets", "schema"))["title"] == "overView preset"


def test_feel_is_a_table_json_and_a_picture(folder):
    assert "slow recoil" in done("presets", "feel", "crowd")
    report = json.loads(done("presets", "feel", "crowd", "--plot", "feel.png", "--json"))
    assert {kind["kind"] for kind in report["strokes"][0]["kinds"]} == {"default", "cheer", "burst"}
    assert (folder / "feel.png").stat().st_size > 10_000
    refused(overview("presets", "feel", "crowd", "--plot", "feel.txt"), ".png")
    (folder / "flat.json").write_text(
        '{"overview_timeline": 1, "duration_s": 9,'
        ' "intensity": {"time_s": [0, 9], "value": [0, 1]}}'
    )
    refused(overview("presets", "feel", "crowd", "flat.json"), "has no events")


def test_tune_writes_a_valid_preset(folder):
    report = json.loads(done("presets", "tune", "crowd", "--order", "cheer>default", "--json"))
    done("presets", "check", report["file"])
    assert report["reached"] is (report["least_jnds"] >= 2.0)
    refused(overview("presets", "tune", "crowd", "--order", "cheer"), "two kinds")
    refused(overview("presets", "tune", "crowd"), "--order", "--separate")
    report = json.loads(done("presets", "tune", "crowd", "--separate", "--json"))
    assert report["reached"]
    assert list(report["kinds"]) == ["default", "cheer", "burst"]


def test_a_clip_is_imported_into_a_preset(folder):
    done("export", "world-cup-final-2018", "--gesture", "tap:0.5:0.3", "--to", "haptic", "-o", "c")
    done("presets", "import", "c", "--as", "goal", "-o", "mine.toml")
    assert "kinds.goal.points" in done("presets", "diff", "football", "mine.toml")
    refused(overview("presets", "import", "mine.toml", "--as", "goal"), "not JSON")


def test_an_imported_clip_keeps_the_base_variables_and_comments_of_the_preset(folder):
    done("export", "world-cup-final-2018", "--gesture", "tap:0.5:0.3", "--to", "haptic", "-o", "c")
    text = (
        '# my match\nschema = 4\nextends = "football"\ntitle = "Mine"\n\n[variables]\nhard = 40.0'
        '  # how hard\n\n[kinds.goal]\nheight = "$hard * 0.5"  # half\naliases = ["try"]\n'
    )
    (folder / "base.toml").write_text(text)
    for kind in ("goal", "offside"):
        done("presets", "import", "c", "--as", kind, "--base", "base.toml", "-o", "mine.toml")
        written, made = (folder / "mine.toml").read_text(), ov.load_preset("mine.toml")
        lines = written.splitlines()
        assert not [line for line in text.splitlines() if line not in lines]
        assert len(made.kinds[kind].points) == 64
        (folder / "mine.toml").write_text(written.replace("hard = 40.0", "hard = 80.0"))
        assert ov.load_preset("mine.toml").kinds["goal"].height == 40.0
        assert made.kind_for("try") == "goal"
    before, after = ov.load_preset("base.toml"), made
    assert after.kinds["offside"].height == before.kinds["default"].height
    assert {**after.kinds, "offside": None} == {**before.kinds, "offside": None}


def test_an_observer_reports_confusions_as_text_json_and_a_picture(folder, monkeypatch):
    # a hundred timelines take too long here
    few = functools.partial(observing.observe, learned=3, held_out=2)
    monkeypatch.setattr(observing, "observe", few)
    asked = ("presets", "feel", "crowd", "--observer", "--modality", "touch", "--movement", "mixed")
    ov.save_timeline(ov.measure.random_crowd(1), "crowd.json")
    text = done(*asked, "crowd.json", "--plot", "observer.png")
    assert text.startswith(
        "crowd, mixed movement, an observer that learned from 3 random timelines"
    )
    assert "random timelines (2), touch: recall / precision, %" in text
    assert "timelines given (1), touch: recall / precision, %" in text
    assert (folder / "observer.png").stat().st_size > 5_000
    report = json.loads(done(*asked, "--json", "--seed", "1"))
    (strokes,) = (one["strokes"] for one in report["sets"])
    assert [(stroke["name"], stroke["modality"]) for stroke in strokes] == [("mixed", "touch")]
    assert set(strokes[0]["kinds"]) == {"cheer", "burst"}
    assert isinstance(report["warnings"], list)


@pytest.mark.parametrize(
    "option", [("--movement", "mixed"), ("--modality", "touch"), ("--seed", "1")]
)
def test_an_observers_options_without_it_are_refused(option):
    refused(overview("presets", "feel", "crowd", *option), f"{option[0]} needs --observer")


def test_an_unknown_modality_or_movement_is_refused_with_the_known_ones():
    ask = ("presets", "feel", "crowd", "--observer")
    refused(overview(*ask, "--modality", "smell"), "touch")
    refused(overview(*ask, "--movement", "cold"), "steady")


def test_each_timeline_must_have_events(folder):
    ov.save_timeline(ov.measure.random_crowd(1), "one.json")
    ov.save_timeline(ov.Timeline("flat", 10.0, (), ov.Intensity([0.0, 9.0], [1.0, 2.0])), "no.json")
    ask = ("presets", "feel", "crowd")
    refused(overview(*ask, "one.json", "no.json"), "no.json", "no events")
    refused(overview(*ask, "--observer", "one.json", "no.json"), "no.json", "no events")
