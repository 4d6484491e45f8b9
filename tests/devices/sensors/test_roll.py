from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.devices.sensors.orientation_angles import JOIN_RAD_S, Roll
from overview_dsp.devices.sensors.units import GRAVITY
from tests.devices.sensors.moving import course, fed, frames, hand, lines, turning

pytest.importorskip("vqf", reason="needs vqf: pip install '.[sensors]'")

LEVEL = {"calibration__level_deg": 0.0}


def up(roll: float, pitch: float = 0.0) -> tuple[float, float, float]:
    return math.sin(pitch), math.cos(pitch) * math.sin(roll), math.cos(pitch) * math.cos(roll)


@given(st.floats(-math.pi, math.pi), st.floats(-1.4, 1.4))
def test_face_up_is_0_face_down_is_pi_by_either_wrist(roll, pitch):
    assert Roll().step(0.01, up(roll, pitch)) == pytest.approx(abs(roll), abs=1e-9)


def test_nothing_jumps_where_the_angle_changes_sign():
    one = Roll()
    theta2 = [one.step(0.01, up(math.radians(angle))) for angle in np.arange(-30.0, 400.0, 0.5)]
    assert np.abs(np.diff(theta2)).max() < math.radians(0.6)
    assert min(theta2) < math.radians(0.5)
    assert max(theta2) > math.radians(179.5)


def test_beyond_vertical_theta2_is_held_and_continues_without_a_jump():
    one = Roll()
    path = []
    for pitch in [
        *np.arange(0.0, 180.0, 0.5),
        *[180.0] * 200,
    ]:  # over the top: roll is turned round beyond it
        angle = math.radians(pitch)
        path.append(one.step(0.002, (math.sin(angle), 0.1 * math.cos(angle), math.cos(angle))))
        assert one.steep or abs(pitch - 90.0) > 4.0
        assert not one.steep or abs(pitch - 90.0) < 9.0
    assert np.abs(np.diff(path)).max() <= JOIN_RAD_S * 0.002 + 1e-9
    assert path[-1] == pytest.approx(math.pi - 0.0997, abs=0.01)


@given(st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)), max_size=60))
def test_theta2_stays_in_its_range_for_every_direction_of_gravity(ups):
    one = Roll()
    for vector in ups:
        assert 0.0 <= one.step(0.01, vector) <= math.pi


@pytest.mark.parametrize("rate", [25.0, 100.0, 400.0, 2000.0])
@pytest.mark.parametrize("wrist", [1, -1])
def test_a_twist_is_followed_at_every_rate(rate, wrist):
    roll = wrist * course(rate, (0, 0), (2, 0), (3, 180), (4, 180), (5, 40), (6, 40))
    _, turns = fed(hand(**LEVEL), frames(*turning(roll, rate, noise=1.0), rate), rate)
    found = np.array([math.nan if turn is None else turn.theta2 for turn in turns])
    moving = np.arange(len(roll)) / rate > 1.1
    error = np.degrees(found - np.abs(roll))[moving]
    assert np.sqrt(np.mean(error**2)) < 1.0
    assert np.abs(error).max() < 5.0


def test_acceleration_alone_is_enough_for_a_slow_hand():
    rate = 100.0
    roll = course(rate, (0, 0), (2, 0), (4, 180), (5, 180), (7, 0), (8, 0))
    acceleration, _ = turning(roll, rate, noise=1.0)
    one = hand(**LEVEL)
    _, turns = fed(one, lines(acceleration), rate)
    found = np.array([math.nan if turn is None else turn.theta2 for turn in turns])
    error = np.degrees(found - roll)[round(1.2 * rate) :]
    assert np.sqrt(np.mean(error**2)) < 5.0
    assert any("gravity alone" in said for said in one.take_messages())


@pytest.mark.parametrize("bias_deg_s", [0.0, 0.5, 4.0])
def test_at_rest_the_roll_drifts_less_than_a_degree_in_a_minute(bias_deg_s):
    rate = 100.0
    bias = np.radians([bias_deg_s, -bias_deg_s, bias_deg_s])
    roll = course(rate, (0, 0), (2, 0), (3, 60), (63, 60))
    one = hand(**LEVEL)
    _, turns = fed(one, frames(*turning(roll, rate, bias=bias, noise=1.0), rate), rate)
    resting = np.degrees([turn.theta2 for turn in turns[round(3.5 * rate) :]])
    assert np.ptp(resting) < 1.0
    assert resting[-1] == pytest.approx(60.0, abs=1.0)


def test_missing_samples_cause_small_errors_only():
    rate = 200.0
    roll = course(rate, (0, 0), (2, 0), (4, 150), (6, 20))
    pieces = frames(*turning(roll, rate), rate)
    kept = [n for n in range(len(pieces)) if n % 7 not in (2, 3, 4) or n < 300]
    one = hand(**LEVEL)
    _, turns = fed(one, [pieces[n] for n in kept], rate)
    error = [abs(turn.theta2 - roll[n]) for n, turn in zip(kept, turns, strict=True) if turn]
    assert math.degrees(max(error)) < 1.5
    assert one.counters.lost == len(pieces) - len(kept) - (len(pieces) - 1 - kept[-1])


@pytest.mark.parametrize(
    ("unit", "scale"), [("m/s²", 1.0), ("g", 1 / GRAVITY), ("mg", 1000 / GRAVITY)]
)
def test_units_are_detected_by_gravity(unit, scale):
    rate = 100.0
    roll = course(rate, (0, 0), (2, 0), (3, 90), (4, 90))
    acceleration, speed = turning(roll, rate)
    speed = speed if unit == "m/s²" else np.degrees(speed)
    one = hand(**LEVEL)
    _, turns = fed(one, lines(np.hstack([acceleration * scale, speed])), rate)
    assert math.degrees(turns[-1].theta2) == pytest.approx(90.0, abs=0.5)
    assert any(unit in said for said in one.take_messages())


def test_a_clock_of_another_unit_is_reported_in_one_line():
    rows = [[n, 0.0, 0.0, 9.81] for n in range(4000)]
    one = hand(columns=("t_s", "ax", "ay", "az"))
    events, _ = fed(one, lines(rows), 100.0)
    assert events == []
    (said,) = [said for said in one.take_messages() if " s apart" in said]
    assert "t_us" in said


def test_gravity_of_no_known_unit_is_reported_in_one_line_and_gives_no_events():
    one = hand()
    events, _ = fed(one, lines([[10.0, -20.0, 12000.0]] * 300), 100.0)
    assert events == []
    (said,) = [said for said in one.take_messages() if "gravity" in said]
    assert "acceleration.scale" in said
    assert "\n" not in said


def test_raw_numbers_are_read_with_a_scale_and_turned_axes():
    rate = 100.0
    roll = course(rate, (0, 0), (2, 0), (3, 120), (4, 120))
    acceleration, speed = turning(roll, rate)
    # the sensor lies on its side: its x is the device's y, its y the device's -x
    raw = np.column_stack([
        acceleration[:, 1], -acceleration[:, 0], acceleration[:, 2],
        speed[:, 1], -speed[:, 0], speed[:, 2],
    ])  # fmt: skip
    raw[:, :3] *= 16384 / GRAVITY
    raw[:, 3:] = np.degrees(raw[:, 3:]) * 131.0
    one = hand(
        acceleration__unit="g", acceleration__scale=1 / 16384,
        angular_velocity__unit="deg/s", angular_velocity__scale=1 / 131,
        axes__x="-y", axes__y="x",
    )  # fmt: skip
    _, turns = fed(one, lines(np.rint(raw)), rate)
    assert math.degrees(turns[-1].theta2) == pytest.approx(120.0, abs=0.5)


def test_the_attitude_at_the_start_is_face_up_unless_it_is_far_from_the_z_axis():
    rate = 100.0
    for start, level, ends in ((8.0, 20.0, 82.0), (8.0, 0.0, 90.0), (35.0, 20.0, 90.0)):
        roll = course(rate, (0, start), (2, start), (3, 90), (4, 90))
        one = hand(calibration__level_deg=level)
        _, turns = fed(one, frames(*turning(roll, rate), rate), rate)
        assert math.degrees(turns[-1].theta2) == pytest.approx(ends, abs=0.5)
        said = " ".join(one.take_messages())
        assert ("face up is 8.0 degrees" in said) == (level > 0.0 and start < level)
        assert ("from face up" in said) == (level > 0.0 and start > level)


def test_a_sensor_that_stops_is_reported_once_and_releases():
    rate = 100.0
    roll = course(rate, (0, 0), (2, 0), (3, 90), (5, 90))
    pieces = frames(*turning(roll, rate, noise=1.0), rate)
    one = hand(**LEVEL)
    events, _ = fed(one, pieces, rate)
    assert events[-1].touching
    stuck = frames([[0.1, 9.7, 0.2]] * 400, [[0.0, 0.01, 0.0]] * 400, rate, 5_000_000)
    events, _ = fed(one, stuck, rate, 5.0)
    assert not events[-1].touching
    assert sum("stopped" in said for said in one.take_messages()) == 1
