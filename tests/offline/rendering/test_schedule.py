"""The release rule, rendered: shaft 2 disengages when the disk has arrived, never before an event
that the hand went over is met, and after 2.5 s at the latest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.gestures.model import Change
from overview_dsp.kernels.derive import ARRIVAL_S
from overview_dsp.offline.rendering import offline
from tests.examples import plain_preset, timeline_of
from tests.parameters import first_in_gate

RATE = 8_000
NEAR = 0.006
"""Of the timeline: a disk so close to its target has arrived."""


def falls(result: ov.RenderResult, column: str) -> np.ndarray:
    """When a column of the trace falls to 0, s: the first frames without it."""
    return result.trace.time[1:][np.diff(getattr(result.trace, column)) < 0.0]


def clutched(preset: ov.Preset) -> ov.Preset:
    return preset.with_changes({"clutch.max_speed_ratio": 1.1, "clutch.tap_duration_s": 1.6})


@pytest.mark.parametrize("name", first_in_gate(["football", "ratchet", "silk"]))
@pytest.mark.parametrize("slips", [False, True])
def test_when_it_disengages_depends_on_no_partition_into_blocks(match, monkeypatch, name, slips):
    preset = ov.load_preset(name)
    preset = clutched(preset) if slips else preset
    rest = ov.pause(3.0)
    gesture = ov.sweep(0.6) + rest + ov.sweep(0.05, 0.2, 0.4) + rest + ov.sweep(0.7, 1.0, 0.0)
    whole = ov.render(match, preset, gesture, RATE)
    assert len(falls(whole, "engaged")) == len(falls(whole, "touching")) == 3
    assert (falls(whole, "engaged") >= falls(whole, "touching")).all()
    for block in (1024, 61, 7):
        monkeypatch.setattr(offline, "BLOCK", block)
        assert np.array_equal(ov.render(match, preset, gesture, RATE).samples, whole.samples)
    (many,) = ov.render_many([ov.RenderJob(match, preset, gesture)], RATE)
    assert np.array_equal(many.samples, whole.samples)


@pytest.mark.parametrize("gesture", ["sweep:0.3", "sweep:1", "sweep:2", "tap:1", "tap:1:0.001"])
def test_every_event_is_met_and_the_disk_is_there_before_it_recoils(match, football, gesture):
    result = ov.render(match, football, gesture, RATE)
    (touched,), (engaged,) = falls(result, "touching"), falls(result, "engaged")
    assert touched == pytest.approx(ov.parse_gesture(gesture).duration_s, abs=2.0 / RATE)
    assert touched < engaged < touched + ARRIVAL_S
    out = result.strikes.time_s < engaged
    assert set(result.strikes.event[out]) == set(range(len(match.events)))
    assert result.trace.cursor[round(engaged * RATE) - 2] > 1.0 - NEAR - 1e-3


def test_a_disk_that_does_not_arrive_is_released_after_two_and_a_half_seconds():
    slow = plain_preset().with_changes({"disk.k1": 1e-5, "disk.k2": 1e-4, "surface.friction": 2e-3})
    result = ov.render(timeline_of(50.0), slow, ov.sweep(0.5), RATE)
    assert falls(result, "touching") == pytest.approx([0.5], abs=2.0 / RATE)
    assert falls(result, "engaged") == pytest.approx([0.5 + ARRIVAL_S], abs=2.0 / RATE)
    assert result.trace.cursor.max() < 1.0 - NEAR


def test_a_written_take_releases_as_the_gesture_does(tmp_path, match, football):
    ov.save_gesture(ov.sweep(0.4), tmp_path / "take.csv")
    take = ov.load_gesture(tmp_path / "take.csv")
    written, played = (ov.render(match, football, one, RATE) for one in (take, ov.sweep(0.4)))
    assert np.array_equal(written.samples, played.samples)
    assert len(falls(written, "engaged")) == 1


def test_how_long_a_steep_ridge_holds_the_disk_depends_little_on_the_sample_rate():
    kind = ov.EventKind(300.0, width_percent=0.0168, shape="plateau")
    preset = replace(clutched(plain_preset()), kinds={"default": kind})
    timeline = timeline_of(20.0, 35.0, 50.0, 65.0, 80.0)
    times = [
        ov.render(timeline, preset, ov.tap(0.95, 4.0), rate, trace=False).strikes.time_s[:5]
        for rate in (22_050, 44_100, 192_000)
    ]
    assert np.abs(times[0] - times[2]).max() <= 0.5e-3
    assert np.abs(times[1] - times[2]).max() <= 0.5e-3


def test_an_event_just_before_the_end_is_waited_for():
    kind = ov.EventKind(5.0, width_percent=0.01)
    preset = replace(plain_preset(), kinds={"default": kind})
    preset = preset.with_changes({"surface.friction": 2e-3})
    result = ov.render(timeline_of(99.96), preset, ov.sweep(1.0), RATE)
    (engaged,) = falls(result, "engaged")
    assert 1.0 < result.strikes.time_s[0] < engaged < 1.0 + ARRIVAL_S


def test_events_that_the_input_passed_and_the_disk_did_not_reach_are_named():
    timeline = timeline_of(10.0, 50.0, 80.0, 95.0)
    met = ov.render(timeline, plain_preset(), ov.sweep(0.5), RATE)
    assert met.unreached == ()
    # a disk so slow that a tap to 90 % has not arrived after 2.5 s
    slow = clutched(plain_preset()).with_changes({"clutch.tap_duration_s": 5.0})
    short = ov.render(timeline, slow, ov.tap(0.9, 0.1), RATE)
    passed = set(short.strikes.event.tolist())
    assert 0 in passed
    assert 2 not in passed
    assert short.unreached == tuple(sorted({0, 1, 2} - passed))
    window = replace(ov.tap(0.9, 0.1), changes=(Change(0.1, {"window": [0.0, 50.0]}),))
    assert ov.render(timeline, slow, window, RATE).unreached == ()
