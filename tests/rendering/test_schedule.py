"""A sweep lets go when the disk has arrived: never before an event is met, never too late."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.gestures.model import Change
from overview_dsp.gestures.scripts import ARRIVAL_S
from overview_dsp.rendering import offline
from overview_dsp.rendering.schedule import SETTLE_S
from tests.examples import plain_preset, timeline_of

RATE = 8_000


def releases(result: ov.Result) -> np.ndarray:
    """When the hand lets go, s: the first frames without it."""
    return result.trace.time[1:][np.diff(result.trace.touching) < 0.0]


def clutched(preset: ov.Preset) -> ov.Preset:
    return preset.with_changes({"clutch.max_speed_ratio": 1.1, "clutch.tap_duration_s": 1.8})


@pytest.mark.parametrize("name", ["football", "ratchet", "silk"])
@pytest.mark.parametrize("slips", [False, True])
def test_when_it_lets_go_depends_on_no_partition_into_blocks(match, monkeypatch, name, slips):
    preset = ov.load_preset(name)
    preset = clutched(preset) if slips else preset
    gesture = ov.sweep(0.6) + ov.sweep(0.05, 0.2, 0.4) + ov.sweep(0.7, 1.0, 0.0)
    whole = ov.render(match, preset, gesture, RATE)
    assert len(releases(whole)) == 3
    for block in (1024, 61, 7):
        monkeypatch.setattr(offline, "BLOCK", block)
        assert np.array_equal(ov.render(match, preset, gesture, RATE).samples, whole.samples)
    (many,) = ov.render_many([ov.RenderJob(match, preset, gesture)], RATE)
    assert np.array_equal(many.samples, whole.samples)


@pytest.mark.parametrize("seconds", [0.3, 1.0, 2.0])
def test_every_event_was_met_and_the_disk_is_there(match, football, seconds):
    result = ov.render(match, football, ov.sweep(seconds), RATE, tail="none")
    (release,) = releases(result)
    assert seconds + SETTLE_S <= release < seconds + ARRIVAL_S
    out = result.strikes.time_s < release
    assert set(result.strikes.event[out]) == set(range(len(match.events)))
    assert result.trace.cursor[round(release * RATE) - 2] == pytest.approx(1.0, abs=1e-3)


def test_a_disk_that_does_not_arrive_is_let_go_after_a_second_and_a_half():
    slow = plain_preset().with_changes({"disk.k1": 1e-5, "disk.k2": 1e-4})
    (release,) = releases(ov.render(timeline_of(50.0), slow, ov.sweep(0.5), RATE, tail="none"))
    assert release == pytest.approx(0.5 + ARRIVAL_S, abs=2.0 / RATE)


def test_a_written_take_lets_go_at_the_latest_time(tmp_path, match, football):
    ov.save_gesture(ov.sweep(0.4), tmp_path / "take.csv")
    take = ov.load_gesture(tmp_path / "take.csv")
    assert take.on_arrival == ()
    (release,) = releases(ov.render(match, football, take, RATE, tail="none"))
    assert release == pytest.approx(0.4 + ARRIVAL_S, abs=2.0 / RATE)


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
    result = ov.render(timeline_of(99.96), preset, ov.sweep(1.0), RATE, tail="none")
    (release,) = releases(result)
    assert result.strikes.time_s[0] < release < 1.0 + ARRIVAL_S


def test_events_that_the_hand_went_over_and_the_disk_never_met_are_named():
    timeline = timeline_of(10.0, 50.0, 80.0, 95.0)
    met = ov.render(timeline, plain_preset(), ov.sweep(0.5), RATE)
    assert met.unreached == ()
    # a tap to 90 % that lets go before the disk is there
    short = ov.render(timeline, clutched(plain_preset()), ov.tap(0.9, 0.6), RATE)
    passed = set(short.strikes.event.tolist())
    assert 0 in passed
    assert 2 not in passed
    assert short.unreached == tuple(sorted({0, 1, 2} - passed))
    window = replace(ov.tap(0.9, 0.6), changes=(Change(0.1, {"window": [0.0, 50.0]}),))
    assert ov.render(timeline, clutched(plain_preset()), window, RATE).unreached == ()
