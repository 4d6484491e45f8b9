"""What the feel report says, of presets and timelines where it is known."""

from __future__ import annotations

import json

import pytest

import overview_dsp as ov
from overview_dsp.errors import InputError
from overview_dsp.measure.perceived_level import GESTURES
from overview_dsp.measure.report import feel_report
from overview_dsp.signal.actuators.model import pacinian_db
from tests.cli.running import MATCH, overview

SWEEPS = ("slow", "medium", "fast")


def preset_of(**heights):
    # on football's soft spring, what is .3 % wide holds the disk for up to 144 ms
    kinds = {
        name: ov.EventKind(height=height, width_percent=0.06, modes=(ov.ClickMode(1000.0, 20.0),))
        for name, height in heights.items()
    }
    kinds.setdefault("default", ov.EventKind(height=4.0, width_percent=0.3))
    # on the times that a test gives: without football's map
    values = ov.load_preset("football").with_value("surface.angle_map", 0.0).values
    return ov.Preset("x", "x", "x", values, kinds)


def timeline_of(*kinds, spacing=1.0):
    events = tuple(ov.Event(spacing * (i + 1), kind) for i, kind in enumerate(kinds))
    return ov.Timeline(title="", duration_s=spacing * (len(kinds) + 1), events=events)


def test_every_gesture_goes_out_and_recoils():
    report = feel_report(preset_of(a=20.0), timeline_of("a", "a", "a"))
    assert [stroke.name for stroke in report.strokes] == [
        name for gesture in GESTURES for name in (gesture, f"{gesture} recoil")
    ]
    assert all(stroke.kinds[0].events == 3 for stroke in report.strokes)


def test_a_higher_kind_is_stronger_sharper_and_louder_at_every_speed():
    report = feel_report(
        preset_of(low=6.0, high=60.0), timeline_of("low", "high", "low", "high", "low")
    )
    for name in SWEEPS:
        low, high = report.stroke(name).kinds
        assert high.contrast_db > low.contrast_db + 2.3 > 4.6
        assert high.sharpness > low.sharpness
        assert high.click_db > low.click_db
    assert not any("feel the same" in line or "hardly" in line for line in report.warnings())


def test_kinds_with_equal_profiles_are_indistinct_and_a_warning_names_both():
    report = feel_report(preset_of(a=20.0, b=20.0), timeline_of(*"abbaabba"))
    for name in SWEEPS:
        assert [(a, b) for a, b, _ in report.stroke(name).indistinct] == [("a", "b")]
    (line,) = (line for line in report.warnings() if "feel the same" in line)
    assert line.startswith("a and b feel the same in")


def test_what_does_not_stand_out_is_masked():
    report = feel_report(preset_of(a=0.05), timeline_of("a", "a", "a"))
    for name in SWEEPS:
        assert report.stroke(name).kinds[0].masked == 3
    assert any(line.startswith("a is hardly felt in") for line in report.warnings())


def test_events_that_follow_within_30_ms_are_merged_and_others_are_not():
    timeline = timeline_of("a", "b", "a", spacing=1.0)
    near = ov.Timeline(
        title="",
        duration_s=60.0,
        events=(ov.Event(20.0, "a"), ov.Event(20.4, "b"), ov.Event(40.0, "a")),
    )
    preset = preset_of(a=20.0, b=10.0)
    assert sum(kind.merged for kind in feel_report(preset, timeline).stroke("slow").kinds) == 0
    fast = feel_report(preset, near).stroke("fast")
    assert [kind.merged for kind in fast.kinds] == [1, 1]
    assert sum(kind.merged for kind in feel_report(preset, near).stroke("slow").kinds) == 0


def test_the_felt_level_falls_outside_the_best_range_of_the_carrier():
    assert [pacinian_db(hz) for hz in (200.0, 250.0, 300.0)] == [0.0, 0.0, 0.0]
    assert pacinian_db(50.0) == pytest.approx(-20.0)
    assert pacinian_db(600.0) == pytest.approx(-10.0)
    timeline = timeline_of("a", "a")
    best, low = (
        feel_report(preset_of(a=20.0).with_changes({"tactor.frequency_hz": hz}), timeline)
        for hz in (250.0, 100.0)
    )
    apart = best.stroke("slow").kinds[0].level_db - low.stroke("slow").kinds[0].level_db
    assert apart == pytest.approx(10.0, abs=1.5)


def test_the_time_at_rest_does_not_count_for_the_level_between_events():
    report = feel_report(preset_of(a=20.0), timeline_of("a", "a"))
    assert report.stroke("tap").event_free_db > -60.0


def test_the_report_is_json_and_a_table():
    report = feel_report(preset_of(a=20.0), timeline_of("a"))
    json.dumps(report.to_json(), allow_nan=False)
    assert "slow recoil" in report.table()


FAST = {"fast": ov.sweep(1.5)}


def test_each_kind_is_counted_over_all_timelines_with_its_spread():
    preset = preset_of(low=6.0, high=60.0)
    timelines = [timeline_of("low", "high", "low"), timeline_of("low", "high", "high", "low")]
    report = feel_report(preset, timelines, FAST, order=())
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
    report = feel_report(preset, [timeline_of(*"abba")], FAST, order=["b", "a"])
    (line,) = (line for line in report.warnings() if "feel the same" not in line)
    assert line.startswith("b is less than one JND above a in fast (")
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
    report = feel_report(preset_of(low=6.0, high=60.0), [beside], FAST)
    stroke = report.strokes[0]
    assert stroke.lost == (("low", "high", 1),)
    assert (stroke.kind("low").lost, stroke.kind("high").lost) == (1, 0)
    with pytest.raises(InputError, match=r"^no kind of the report is named 'hihg'; did you mean"):
        stroke.kind("hihg")
    assert "lost: low beside high: 1" in report.table()


def test_an_event_that_the_disk_never_reaches_is_missed():
    report = feel_report(
        preset_of(a=20.0), [timeline_of("a", "a", "a")], {"part": ov.sweep(1.0, 0.0, 0.6)}
    )
    kind = report.strokes[0].kind("a")
    assert (kind.events, kind.missed) == (3, 1)
    assert "never passed in part: 1 a" in report.warnings()


def test_an_event_less_than_one_jnd_above_the_rest_is_masked():
    # 1.02 times the bare friction
    report = feel_report(preset_of(faint=0.02, high=60.0), [timeline_of("faint", "high")], FAST)
    assert report.strokes[0].kind("faint").masked == 1
    assert report.strokes[0].kind("high").masked == 0


def test_the_command_measures_several_timelines(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = overview("presets", "feel", "football", MATCH, MATCH, "--json")
    assert done.code == 0, done.err
    report = json.loads(done.out)
    assert len(report["timelines"]) == 2
    goal = next(kind for kind in report["strokes"][0]["kinds"] if kind["kind"] == "goal")
    assert goal["events"] == 10
    assert len(report["strokes"]) == 8
