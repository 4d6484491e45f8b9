"""Roll against optical motion capture, streamed through the serial decoder byte by byte."""

from __future__ import annotations

import math

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.devices.sensors import calibration
from overview_dsp.devices.sensors.calibration import GravityTilt
from tests.devices.sensors.moving import frames, hand
from tests.devices.sensors.optical import TRIALS, load_trial, needs_data

pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")
pytestmark = needs_data


@pytest.fixture(scope="module", params=TRIALS)
def streamed(request):
    """A trial, and the roll, theta2 (degrees) and events that a hand made of its bytes."""
    trial = load_trial(request.param)
    one = hand(calibration__level_deg=0.0)
    roll, theta2 = np.full((2, len(trial.roll)), math.nan)
    events = []
    for n, frame in enumerate(frames(trial.acceleration, trial.turning, trial.rate)):
        for byte in frame:
            events += one.feed(bytes([byte]), n / trial.rate)
        if one.angle is not None:
            roll[n] = math.degrees(one._converter.roll.roll)
            theta2[n] = math.degrees(one.angle.theta2)
    assert one.counters.readings == len(roll)
    assert not any("gyroscope" in said for said in one.take_messages())
    return request.param, trial, roll, theta2, events


def test_roll_is_within_a_degree_of_the_truth(streamed):
    name, trial, roll, theta2, _ = streamed
    raw = np.degrees(np.arctan2(trial.acceleration[:, 1], trial.acceleration[:, 2]))
    by_theta2 = np.sqrt(np.mean((theta2 - np.abs(trial.roll))[trial.scored] ** 2))
    print(
        f"{name}: roll {trial.rmse(roll):.2f}, theta2 {by_theta2:.2f}, "
        f"raw accelerometer {trial.rmse(raw):.2f} degrees"
    )
    assert trial.rmse(roll) <= 1.0
    assert by_theta2 <= 1.0
    assert trial.rmse(raw) > 4.0


@pytest.mark.soak
@pytest.mark.parametrize("name", TRIALS)
def test_half_a_sample_less_of_lag_is_no_gain(name, monkeypatch):
    trial = load_trial(name)
    found = []
    for part in (0.5, 0.0):
        monkeypatch.setattr(calibration, "HALF_WAY", part)
        one = hand(calibration__level_deg=0.0)
        roll = np.full(len(trial.roll), math.nan)
        for n, frame in enumerate(frames(trial.acceleration, trial.turning, trial.rate)):
            one.feed(frame, n / trial.rate)
            if one.angle is not None:
                roll[n] = math.degrees(one._converter.roll.roll)
        found.append(trial.rmse(roll))
    print(f"{name}: half way between samples {found[0]:.3f}, a sample's own {found[1]:.3f} degrees")
    assert abs(found[1] - found[0]) < 0.05


@pytest.mark.parametrize(("name", "most"), [*zip(TRIALS, (4.6, 7.9), strict=True)])
def test_gravity_alone_is_better_than_the_raw_accelerometer(name, most):
    trial = load_trial(name)
    gravity = GravityTilt()
    still = (0.0, 0.0, 0.0)
    up = np.array([gravity.step(1 / trial.rate, tuple(one), still) for one in trial.acceleration])
    error = trial.rmse(np.degrees(np.arctan2(up[:, 1], up[:, 2])))
    print(f"{name}: by gravity alone {error:.2f} degrees")
    assert error < most
    assert error < trial.rmse(
        np.degrees(np.arctan2(trial.acceleration[:, 1], trial.acceleration[:, 2]))
    )


def test_the_cursor_has_no_jump_that_the_truth_has_not(streamed):
    _, trial, _, theta2, _ = streamed
    for samples in (1, 3):  # 3.5 and 10.5 ms
        moved = np.abs(theta2[samples:] - theta2[:-samples])
        true = np.abs(np.abs(trial.roll[samples:]) - np.abs(trial.roll[:-samples]))
        assert np.nanmax(moved - true) < 5.0


def test_the_same_movement_as_touch_and_as_twist_differs_by_the_sensors_error(
    streamed, match, football
):
    name, trial, _, _, events = streamed
    # the longest time held in the first minute
    assert events
    taken = [event for event in events if event.time_s < 60.0] or events[:4000]
    time_s = np.array([event.time_s for event in taken]) - taken[0].time_s
    felt = np.array([event.theta2 for event in taken])
    touching = np.array([event.touching for event in taken])
    touching[-1] = False

    def torque(theta2, source):
        gesture = ov.Gesture(
            time_s, theta2, touching, time_s[-1] + 0.1,
            np.full(len(time_s), ov.gestures.SOURCES.index(source)),
        )  # fmt: skip
        return ov.render(match, football, gesture, sample_rate=8000, tail=0.1).trace

    as_twist, as_touch = torque(felt, "serial"), torque(felt, "touch")
    assert np.array_equal(as_twist.torque, as_touch.torque)
    assert np.array_equal(as_twist.cursor, as_touch.cursor)
    at = np.rint(np.array([event.time_s for event in taken]) * trial.rate).astype(int)
    true = np.radians(np.abs(trial.roll[at]))
    seen = ~np.isnan(true)
    true[~seen] = felt[~seen]
    by_truth = torque(true, "touch")
    apart = np.degrees(np.abs(felt - true)).max()
    cursor = 180.0 * np.sqrt(np.mean((by_truth.cursor - as_twist.cursor) ** 2))
    print(f"{name}: off by up to {apart:.1f} degrees, the cursor by {cursor:.2f} RMS")
    assert cursor < 2.0
