"""What the feel report says, of presets and timelines where it is known."""

from __future__ import annotations

import json

import pytest

import overview_dsp as ov
from overview_dsp.design.gestures import sweep
from overview_dsp.measure.report import GESTURES, feel_report
from overview_dsp.measure.tuning import ordering, separated, separating, tuned
from overview_dsp.measure.tuning.ordering import SPEEDS, WANTED_STEPS
from overview_dsp.offline.rendering.audition import pages
from overview_dsp.signal.actuators.sensitivity import pacinian_db


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
    for name in SPEEDS:
        low, high = report.stroke(name).kinds
        assert high.contrast_db > low.contrast_db + 2.3 > 4.6
        assert high.sharpness > low.sharpness
        assert high.click_db > low.click_db
    assert not any("alike" in line or "hardly" in line for line in report.warnings())


def test_kinds_with_one_profile_feel_alike_and_a_warning_names_both():
    report = feel_report(preset_of(a=20.0, b=20.0), timeline_of(*"abbaabba"))
    for name in SPEEDS:
        assert [(a, b) for a, b, _ in report.stroke(name).alike] == [("a", "b")]
    (line,) = (line for line in report.warnings() if "alike" in line)
    assert line.startswith("a and b feel alike in")


def test_what_does_not_stand_out_is_masked():
    report = feel_report(preset_of(a=0.05), timeline_of("a", "a", "a"))
    for name in SPEEDS:
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


def test_what_is_felt_of_a_carrier_falls_off_its_best_range():
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


def test_held_still_counts_for_nothing():
    report = feel_report(preset_of(a=20.0), timeline_of("a", "a"))
    assert report.stroke("tap").event_free_db > -60.0


def test_the_report_is_json_and_a_table():
    report = feel_report(preset_of(a=20.0), timeline_of("a"))
    json.dumps(report.to_json(), allow_nan=False)
    assert "slow recoil" in report.table()


@pytest.fixture(scope="module")
def two_apart():
    """Two kinds that are nearly one, tuned."""
    return tuned(preset_of(strong=20.0, weak=18.0), ("strong", "weak"), seed=1)


def test_tuning_sets_kinds_two_steps_apart_at_every_speed(two_apart):
    found = two_apart
    assert found.reached
    assert found.least_steps >= WANTED_STEPS
    assert found.preset.kinds["strong"].height > found.preset.kinds["weak"].height
    report = feel_report(found.preset, timeline_of("strong", "weak", "weak", "strong"), SPEEDS)
    for name in SPEEDS:
        strong, weak = report.stroke(name).kinds
        assert strong.level_db > weak.level_db + 2.3


def test_no_two_kinds_feel_alike_once_they_are_set_apart():
    preset = preset_of(a=20.0, b=20.0, d=8.0)
    found = separated(preset, ("a", "d"), seed=1)
    assert found.reached
    report = feel_report(
        found.preset, pages(found.preset), {"slow": sweep(5.0), "fast": sweep(1.0)}
    )
    for name in ("slow", "fast"):
        assert report.stroke(name).alike == ()
        levels = {kind.kind: kind.level_db for kind in report.stroke(name).kinds}
        assert levels["a"] > levels["d"] + 2.3
    assert separated(found.preset, ("a", "d"), seed=2).preset.kinds == found.preset.kinds


@pytest.mark.parametrize(
    ("search", "module", "length"),
    [(tuned, ordering, "GENERATIONS"), (separated, separating, "TRIES")],
)
def test_a_search_gives_the_same_preset_for_a_seed(monkeypatch, search, module, length):
    monkeypatch.setattr(module, length, 4)  # however far it comes
    preset = preset_of(a=20.0, d=20.0)
    one, again = (search(preset, ("a", "d"), seed=1).preset for _ in range(2))
    assert one.kinds == again.kinds != preset.kinds


def test_a_target_that_is_none_is_one_line():
    preset = preset_of(strong=20.0, weak=10.0)
    for target, words in (
        (("strong",), "two kinds or more"),
        (("strong", "wek"), "did you mean 'weak'"),
        (("strong", "strong"), "twice"),
    ):
        with pytest.raises(ov.InputError, match=words):
            tuned(preset, target)


def test_a_preset_that_is_apart_already_stays_as_it_is(two_apart):
    apart = two_apart.preset
    found = tuned(apart, ("strong", "weak"), seed=2)
    assert found.preset.kinds == apart.kinds
    assert found.reached
