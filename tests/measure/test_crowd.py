"""What is said of events where they lie: on timelines where it is known."""

from __future__ import annotations

import json

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.presets.retuning import save_retuned
from overview_dsp.measure.crowd import crowd_report
from overview_dsp.measure.tuning import in_crowd
from overview_dsp.measure.tuning.in_crowd import REST, VERIFIED, gaps_on, tuned_on
from tests.cli.running import MATCH, overview
from tests.measure.test_feel_report import preset_of, timeline_of

FAST = {"fast": ov.sweep(1.5)}


def test_each_kind_is_counted_over_all_timelines_with_its_spread():
    preset = preset_of(low=6.0, high=60.0)
    timelines = [timeline_of("low", "high", "low"), timeline_of("low", "high", "high", "low")]
    report = crowd_report(preset, timelines, FAST)
    assert [stroke.name for stroke in report.strokes] == ["fast", "fast recoil"]
    for stroke in report.strokes:
        # by their friction
        assert [(kind.kind, kind.events) for kind in stroke.kinds] == [("high", 3), ("low", 4)]
        for kind in stroke.kinds:
            assert kind.missed == kind.lost == 0
            assert kind.low_db <= kind.level_db <= kind.high_db
            assert 0.0 <= kind.lag_ms <= 24.0
    ((high, low, steps),) = report.strokes[0].gaps
    assert (high, low) == ("high", "low")
    assert steps == pytest.approx(
        (report.strokes[0].kind("high").level_db - report.strokes[0].kind("low").level_db) / 2.3
    )
    assert report.warnings() == []


def test_an_order_that_is_not_kept_is_named_with_its_strokes():
    preset = preset_of(a=30.0, b=30.0)
    report = crowd_report(preset, [timeline_of(*"abba")], FAST, target=["b", "a"])
    (line,) = report.warnings()
    assert line.startswith("b is less than a step above a in fast (")
    assert "fast recoil" in line


def test_what_lies_beside_a_higher_event_is_lost_to_it_by_name():
    beside = ov.Timeline(
        "",
        duration_s=10.0,
        events=(
            ov.Event(2.0, "low"),
            ov.Event(5.0, "high"),
            ov.Event(5.05, "low"),
            ov.Event(8.0, "low"),
        ),
    )
    report = crowd_report(preset_of(low=6.0, high=60.0), [beside], FAST)
    stroke = report.strokes[0]
    assert stroke.lost == (("low", "high", 1),)
    assert (stroke.kind("low").lost, stroke.kind("high").lost) == (1, 0)
    assert "lost: low beside high: 1" in report.table()


def test_an_event_that_the_disk_never_meets_is_missed():
    report = crowd_report(
        preset_of(a=20.0), [timeline_of("a", "a", "a")], {"part": ov.sweep(1.0, 0.0, 0.6)}
    )
    kind = report.strokes[0].kind("a")
    assert (kind.events, kind.missed) == (3, 1)
    assert "never met in part: 1 a" in report.warnings()


def test_what_is_below_a_step_of_the_rest_is_masked():
    # 1.02 times the bare friction
    report = crowd_report(preset_of(faint=0.02, high=60.0), [timeline_of("faint", "high")], FAST)
    assert report.strokes[0].kind("faint").masked == 1
    assert report.strokes[0].kind("high").masked == 0


def test_the_command_measures_several_timelines(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = overview("presets", "feel", "football", MATCH, MATCH, "--json")
    assert done.code == 0, done.err
    crowd = json.loads(done.out)["crowd"]
    assert len(crowd["timelines"]) == 2
    goal = next(kind for kind in crowd["strokes"][0]["kinds"] if kind["kind"] == "goal")
    assert goal["events"] == 10
    assert len(crowd["strokes"]) == 8


CHILD = """# my match, kept as it is
schema = 3
extends = "football"
title = "Mine"

[variables]
hard = 40.0  # how hard

[kinds.goal]
height = "$hard * 0.5"  # half

# the cards
[kinds.yellow_card]
height = 33.0
"""


def test_a_retuned_child_keeps_its_text(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    source = tmp_path / "child.toml"
    source.write_text(CHILD)
    out = tmp_path / "elsewhere" / "made.toml"
    out.parent.mkdir()
    changes = {
        "goal": {"height": 30.0},
        "yellow_card": {"height": 11.0, "width_percent": 0.08},
        "foul": {"height": 2.5},
    }
    path, made = save_retuned(source, changes, out)
    assert made == ov.load_preset(path)
    for kind, values in changes.items():
        for key, value in values.items():
            assert getattr(made.kinds[kind], key) == pytest.approx(value, rel=1e-3)
    kept = [line for line in CHILD.splitlines() if not line.startswith("height")]
    text = path.read_text()
    assert [line for line in text.splitlines() if line in kept][: len(kept)] == kept
    assert 'height = "($hard * 0.5) * 1.5"  # half' in text
    # it still follows its variables
    path.write_text(text.replace("hard = 40.0", "hard = 80.0"))
    assert ov.load_preset(path).kinds["goal"].height == pytest.approx(60.0)


def test_a_file_of_an_older_schema_is_retuned_where_its_keys_are_the_present_ones(tmp_path):
    source, out = tmp_path / "child.toml", tmp_path / "made.toml"
    for version in (1, 2):
        source.write_text(CHILD.replace("schema = 3", f"schema = {version}"))
        _, made = save_retuned(source, {"goal": {"height": 30.0}}, out)
        assert made.kinds["goal"].height == pytest.approx(30.0)
        assert out.read_text() == CHILD.replace('0.5"', '0.5) * 1.5"').replace('"$', '"($')
    out.unlink()
    source.write_text(CHILD.replace("schema = 3", "schema = 2") + "\n[disk]\ncatch_up = 1.1\n")
    with pytest.raises(ov.InputError, match=r"child\.toml: has keys of an older schema") as error:
        save_retuned(source, {"goal": {"height": 30.0}}, out)
    assert "\n" not in str(error.value)
    assert not out.exists()


def test_a_child_of_a_file_extends_it_from_another_folder_too(tmp_path):
    (tmp_path / "base.toml").write_text(CHILD)
    child = tmp_path / "child.toml"
    child.write_text('schema = 3\nextends = "base.toml"\n')
    folder = tmp_path / "deep" / "er"
    folder.mkdir(parents=True)
    _, made = save_retuned(child, {"goal": {"height": 7.0}}, folder / "made.toml")
    assert made.kinds["goal"].height == 7.0
    assert made.title == "Mine"


def test_a_preset_is_tuned_where_its_events_lie_and_says_what_it_cannot_reach(
    match, football, monkeypatch
):
    target = ["goal", "yellow_card", "foul"]
    with monkeypatch.context() as short:
        short.setattr(in_crowd, "ROUNDS", 3)  # whatever it reaches by then
        found = tuned_on(football, target, [match])
    gaps = gaps_on(found.preset, target, [match], VERIFIED)
    least = min(gap + (second == REST) for *_, second, gap in gaps)
    assert found.least_steps == pytest.approx(least)
    assert found.reached == (not found.unreached) == (least >= 2.0)
    same = ["goal", "own_goal"]
    limited = tuned_on(
        preset_of(goal=20.0, own_goal=20.0), same, [timeline_of(*["goal", "own_goal"] * 2)]
    )
    assert limited.reached
    heights = [limited.preset.kinds[kind].height for kind in same]
    assert heights[0] > 1.5 * heights[1]


def test_what_cannot_be_reached_is_told_by_kind_gesture_and_timeline():
    # the strongest event lies so near to the other that this gets its level
    crowd = ov.Timeline("crowd", duration_s=10.0, events=(ov.Event(5.0, "a"), ov.Event(5.0, "b")))
    found = tuned_on(preset_of(a=20.0, b=19.0), ["a", "b"], [crowd])
    assert not found.reached
    assert all("a is " in line or "b is " in line for line in found.unreached)
    assert any(
        "steps above b in " in line and " on crowd, 2 wanted" in line for line in found.unreached
    )


def test_a_kind_that_no_timeline_has_is_one_line(match, football):
    with pytest.raises(ov.InputError, match="no event of kind 'shot' is on the timelines given"):
        tuned_on(football, ["goal", "shot"], [match])


def test_the_command_tunes_on_timelines_and_keeps_the_text(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(in_crowd, "ROUNDS", 3)
    (tmp_path / "child.toml").write_text(CHILD)
    done = overview(
        *("presets", "tune", "child.toml", MATCH, "--order", "goal>yellow_card>foul"),
        *("-o", "out.toml", "--json"),
    )
    assert done.code == 0, done.err
    report = json.loads(done.out)
    assert report["reached"] == (report["unreached"] == [])
    text = (tmp_path / "out.toml").read_text()
    assert text.startswith("# my match, kept as it is\n")
    assert 'extends = "football"' in text
    assert "hard = 40.0  # how hard" in text
    made = ov.load_preset("out.toml")
    for name, kind in report["kinds"].items():
        assert np.isclose(made.kinds[name].height, kind["height"])
