"""The parts of the motor's loop, one by one."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.devices.force_feedback.motion import (
    LONGEST_S,
    STALE_S,
    MeanTorque,
    Motion,
    SpeedEstimator,
)
from overview_dsp.devices.force_feedback.motor_loop import (
    FORGOTTEN_S,
    IN_A_ROW,
    UNKNOWN_S,
    Commander,
    LoopDelay,
    MotorLoop,
    ReportCheck,
)
from overview_dsp.devices.force_feedback.passivity import (
    FRICTION_CREDIT_J,
    PassivityController,
    PassivityObserver,
)
from overview_dsp.devices.force_feedback.watchdog import SILENT_S, Watchdog
from overview_dsp.devices.sensors.profile import Sensor, load_sensor, parse_sensor
from tests.devices.force_feedback.simulation import sim

STEP = 2.0 * math.pi / 4096
finite = st.floats(-1e3, 1e3)


# --- the mean torque ------------------------------------------------------------------------------


def test_the_mean_torque_misses_nothing_between_two_looks():
    dice = np.random.default_rng(1)
    torque = dice.standard_normal(4800)
    integral = np.concatenate([[0.0], np.cumsum(torque)]) / 48_000
    mean, at, given_impulse = MeanTorque(), 0, 0.0
    mean.update((0.0, 0.0), 0.0)
    while at < 4800:
        step = min(int(dice.integers(1, 300)), 4800 - at)
        at += step
        given_impulse += mean.update((at / 48_000, integral[at]), at / 48_000) * step / 48_000
    assert given_impulse == pytest.approx(integral[-1], abs=1e-12)


def test_the_mean_torque_of_an_engine_that_stands_still_ends():
    mean = MeanTorque()
    assert mean.update((0.0, 0.0), 0.0) == 0.0
    assert mean.update((0.01, 2e-5), 0.01) == pytest.approx(2e-3)
    assert mean.update((0.01, 2e-5), 0.01 + 0.9 * STALE_S) == pytest.approx(2e-3)
    assert mean.update((0.01, 2e-5), 0.01 + 1.1 * STALE_S) == 0.0
    assert mean.update((0.0, 0.0), 0.2) == 0.0  # a reset


# --- the speed ------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [0.1, 0.5, 3.0, -20.0])
def test_the_speed_of_an_angle_in_steps_is_found(speed):
    estimator = SpeedEstimator(STEP)
    for n in range(200):
        estimator.add(n * 1e-3, math.floor(speed * n * 1e-3 / STEP) * STEP)
    motion = estimator.motion()
    assert motion.speed == pytest.approx(speed, rel=0.15, abs=STEP / LONGEST_S)
    assert motion.age_s <= 0.5 * LONGEST_S + 1e-3


def test_a_fast_knob_is_known_sooner_than_a_slow_one():
    ages = []
    for speed in (0.2, 20.0):
        estimator = SpeedEstimator(STEP)
        for n in range(200):
            estimator.add(n * 1e-3, round(speed * n * 1e-3 / STEP) * STEP)
        ages.append(estimator.motion().age_s)
    assert ages[1] < 0.1 * ages[0]


@given(st.lists(st.sampled_from([-STEP, 0.0, STEP]), min_size=2, max_size=200))
def test_an_angle_that_trembles_within_its_resolution_stands_still(trembling):
    estimator = SpeedEstimator(2.01 * STEP)
    for n, angle in enumerate(trembling):
        estimator.add(n * 1e-3, 5.0 + angle)
    assert estimator.motion().speed == 0.0


@given(st.lists(st.tuples(st.floats(0.0, 1.0), finite), max_size=60))
def test_any_angles_give_a_finite_speed(points):
    estimator = SpeedEstimator(STEP)
    for time_s, angle in sorted(points):
        estimator.add(time_s, angle)
        motion = estimator.motion()
        assert math.isfinite(motion.speed)
        assert motion.age_s >= 0.0


# --- the ledger -----------------------------------------------------------------------------------


def test_the_ledger_is_the_work_of_a_known_torque():
    ledger = PassivityObserver(1.0, 1e-12, STEP)
    angles = np.linspace(0.0, 2.0, 2001)
    for angle in angles:
        ledger.add(-3e-3, angle, True)
    assert ledger.absorbed == pytest.approx(6e-3)
    assert ledger.returned == 0.0
    for angle in angles[::-1]:
        ledger.add(-3e-3, angle, True)
    assert ledger.returned == pytest.approx(6e-3)
    assert ledger.credit == pytest.approx(ledger.friction_loss, abs=1e-12)


@given(st.lists(st.tuples(st.floats(-0.1, 0.1), st.floats(-5.0, 5.0)), max_size=80))
def test_the_ledger_never_flatters(reports):
    """However the torque went between two reports, no more was put in than it says."""
    ledger = PassivityObserver(1e3, 1e-4, STEP)
    best = 0.0
    for before, after in pairwise(reports):
        turned = after[1] - before[1]
        best += min(-before[0] * turned, -after[0] * turned)
    for torque, angle in reports:
        ledger.add(torque, angle, True)
    assert ledger.absorbed - ledger.returned <= best + 1e-9
    assert ledger.credit <= ledger.absorbed - ledger.returned + ledger.friction_loss + 1e-9


def test_credit_of_long_ago_is_no_leave_to_push():
    ledger = PassivityObserver(1e-3, 1e-4, STEP)
    for n in range(1000):
        ledger.add(-0.01, 0.1 * n, True)
    assert ledger.absorbed > 0.9
    assert ledger.credit == 1e-3


def test_friction_of_the_knob_brings_a_little_credit_and_trembling_none():
    ledger = PassivityObserver(1.0, 1e-4, STEP)
    for n in range(2000):
        ledger.add(0.0, STEP * (n % 2), True)
    assert ledger.credit == 0.0
    for n in range(1000):
        ledger.add(0.0, 0.01 * n, False)  # a hand that may turn back at any time
    assert ledger.credit == 0.0
    for n in range(1000, 2000):
        ledger.add(0.0, 0.01 * n, True)
    assert ledger.credit == pytest.approx(FRICTION_CREDIT_J)


def test_what_a_lost_device_did_is_not_reckoned():
    ledger = PassivityObserver(1.0, 1e-4, STEP)
    ledger.add(-0.01, 0.0, True)
    ledger.interrupt()
    ledger.add(-0.01, 50.0, True)
    assert ledger.absorbed == ledger.returned == 0.0


# --- the delay ------------------------------------------------------------------------------------


def test_the_delay_is_that_between_a_target_and_its_report():
    delay = LoopDelay(0.6e-4)
    assert delay.seconds(0.0) == UNKNOWN_S
    for n in range(400):
        delay.sent(n * 2e-3, round(0.01 * (n % 7), 4))
        if n >= 6:
            delay.reported(n * 2e-3, round(0.01 * ((n - 6) % 7), 4))
    assert delay.measured
    assert delay.seconds(400 * 2e-3) == pytest.approx(12e-3, abs=1e-9)


def test_a_longer_delay_counts_at_once_and_a_shorter_one_by_and_by():
    delay = LoopDelay(0.6e-4)
    for n, took in enumerate([0.01] * 5 + [0.03] + [0.01] * 500):
        delay.sent(0.1 * n, 0.01 * (n % 7 + 1))
        delay.reported(0.1 * n + took, 0.01 * (n % 7 + 1))
        if n == 5:
            assert delay.seconds(0.1 * n + took) == pytest.approx(0.03)
        if n == 6:
            assert delay.seconds(0.1 * n + took) > 0.025
    assert delay.seconds(51.0) == pytest.approx(0.01, abs=1e-3)


def test_a_target_that_nobody_reports_makes_the_delay_long_until_it_is_forgotten():
    delay = LoopDelay(0.6e-4)
    delay.sent(0.0, 0.01)
    delay.reported(0.01, 0.01)
    delay.sent(1.0, 0.02)
    assert delay.seconds(1.3) == pytest.approx(0.3)
    delay.sent(1.1 + FORGOTTEN_S, 0.02)
    assert delay.seconds(1.2 + FORGOTTEN_S) == pytest.approx(0.01)


# --- the controller -------------------------------------------------------------------------------

motions = st.builds(Motion, st.floats(-200.0, 200.0), st.floats(0.0, 0.03))


@given(
    st.floats(-10.0, 10.0), motions, st.floats(-1.0, 1.0), st.floats(1e-3, 0.5), st.floats(0, 9.0)
)
def test_the_torque_brakes_or_is_none_and_never_passes_its_ceiling(
    wanted, motion, credit, delay_s, now_s
):
    controller = PassivityController(5e-5, 0.02)
    torque = controller.step(wanted, motion, credit, delay_s, now_s)
    assert torque * motion.speed <= 0.0
    assert abs(torque) <= 0.02
    if credit >= 0.0:
        assert abs(torque) <= abs(wanted)
        assert abs(torque * motion.speed) * delay_s <= credit + 1e-15


def test_a_push_is_refused_and_a_brake_passes():
    controller = PassivityController(5e-5, 0.02)
    forward = Motion(2.0, 1e-3)
    assert controller.step(1e-3, forward, 1.0, 2e-3, 0.0) == 0.0
    assert controller.rejected == 1
    assert controller.step(-1e-3, forward, 1.0, 2e-3, 0.0) == -1e-3
    assert controller.limited == 0


def test_damping_is_added_where_more_was_given_than_put_in_and_the_hand_goes_on():
    controller = PassivityController(5e-5, 0.02)
    forward, back = Motion(2.0, 1e-3), Motion(-2.0, 1e-3)
    controller.step(0.0, forward, 0.0, 5e-3, 0.0)
    assert controller.step(0.0, forward, -1e-6, 5e-3, 0.003) == 0.0  # it has only just begun
    assert controller.step(0.0, forward, -1e-6, 5e-3, 0.5) < 0.0
    assert controller.damped == 1
    # to and fro, 10 ms each way: nothing is sure to brake
    for n in range(20):
        motion = back if n % 2 else forward
        for now in np.arange(10) * 1e-3:
            torque = controller.step(-1e-3, motion, -1e-6, 5e-3, 1.0 + n * 1e-2 + now)
            assert torque == 0.0 or n < 2


@pytest.mark.parametrize("delay_s", [0.002, 0.01, 0.04, 0.1])
def test_a_free_knob_never_swings_however_much_is_wanted(delay_s):
    """inertia * speed' = torque of the speed a delay ago: |speed| dies away."""
    dt, inertia = 1e-3, 5e-5
    controller = PassivityController(inertia, 1e9)
    speeds = [20.0] * (round(delay_s / dt) + 1)
    for n in range(20_000):
        known = Motion(speeds[-1 - round(delay_s / dt)], 0.0)
        torque = controller.step(-1e9 * known.speed, known, 1e9, delay_s, n * dt)
        speeds.append(speeds[-1] + dt * torque / inertia)
    assert max(abs(one) for one in speeds[10_000:]) < 1e-3


# --- silence --------------------------------------------------------------------------------------


def test_silence_ends_the_torque_within_50_ms_and_a_steady_voice_brings_it_back():
    watchdog = Watchdog()
    now = 0.0
    while not watchdog.alive(now):
        now += 2e-3
        watchdog.message_received(now)
        assert now < 0.2
    heard = now
    while watchdog.alive(now):
        now += 2e-3
    assert SILENT_S <= now - heard <= 0.046
    assert watchdog.silences == 1
    watchdog.message_received(now + 1.0)
    assert not watchdog.alive(now + 1.0)


def test_a_stammering_motor_gets_no_torque():
    watchdog = Watchdog()
    for n in range(100):
        watchdog.message_received(0.05 * n)
        assert not watchdog.alive(0.05 * n)


# --- words ----------------------------------------------------------------------------------------


@given(st.floats(-1e4, 1e4), st.sampled_from("MmAx"))
def test_every_command_fits_the_commanders_buffer_and_says_the_target(value, letter):
    commander = Commander(letter, 100_000)
    lines = (commander.begin() + commander.target(value) + commander.end()).split(b"\n")
    assert all(len(line) < 20 for line in lines)
    said = commander.target(value).decode()
    assert said[0] == letter
    assert float(said[1:]) == pytest.approx(value, abs=0.51e-4)
    assert not said.startswith(f"{letter}-0.0000")


def test_the_simulated_motor_understands_every_command():
    motor = sim.Motor()
    commander = Commander("M", 10)
    heard = motor.loop(commander.begin())
    assert heard == b""
    assert (motor.enabled, motor.torque_mode, motor.variables, motor.downsample) == (
        True, True, "1000001", 10,
    )  # fmt: skip
    motor.loop(commander.target(-0.5))
    assert motor.torque == pytest.approx(-0.5 * motor.nm_per_unit)
    motor.loop(commander.end())
    assert (motor.torque, motor.enabled) == (0.0, False)


def test_reports_that_cannot_be_are_not_believed():
    check = ReportCheck(5.0)
    assert check.plausible(0.0, 0.0, 1.0)
    assert not check.plausible(0.001, 0.0, 81.0)  # a digit
    assert check.plausible(0.002, 0.0, 1.01)
    assert not check.plausible(0.003, 50.0, 1.01)
    assert check.rejected == 2
    for n in range(IN_A_ROW - 1):
        assert not check.plausible(0.01 + n * 1e-3, 0.0, -30.0)
    assert check.plausible(0.02, 0.0, -30.0)
    assert check.restarted
    assert check.plausible(0.021, 0.0, -30.0)
    assert not check.restarted


def test_the_rate_of_reports_is_that_of_a_second_without_a_gap():
    watchdog = Watchdog()
    for n in range(1500):
        watchdog.message_received(n * 2e-3)
        assert (watchdog.hz is None) == (n < 500)
    assert watchdog.hz == pytest.approx(500.0, rel=0.01)
    watchdog.message_received(4.0)
    assert watchdog.hz is None


# --- the loop -------------------------------------------------------------------------------------


def reports(loop, seconds, start=0.0):
    """Of a motor that applies what it is sent at once."""
    sent, target = [], 0.0
    for n in range(round(seconds * 1000)):
        now = start + n * 1e-3
        angle = 2.0 * now
        loop.receive([(now, {"motor_target": target, "shaft_rad": angle})], now)
        sent.append((now, loop.step(1e-3, now)))
        target = float(sent[-1][1].split()[-1][1:]) if sent[-1][1] else target
    return sent


def test_the_loop_commands_500_times_a_second_and_begins_until_it_is_answered():
    loop = MotorLoop(load_sensor("simplefoc"))
    sent = [loop.step(1e-3, n * 1e-3) for n in range(1100)]
    assert sum(data.startswith(b"@0\n") for data in sent) == 3
    assert all(data.endswith(b"M0.0000\n") for data in sent if data)
    sent = reports(loop, 1.0, start=1.1)
    assert 480 <= sum(bool(data) for _, data in sent) <= 501
    assert loop.alive
    assert loop.torque < 0.0


def test_a_silent_motor_is_sent_zero_within_50_ms_and_on():
    loop = MotorLoop(load_sensor("simplefoc"))
    reports(loop, 0.5)
    assert loop.torque < 0.0
    last = 0.499
    told = None
    for n in range(1, 200):
        data = loop.step(1e-3, last + n * 1e-3)
        if told is None and not loop.alive:
            told = n * 1e-3
            assert data.endswith(b"M0.0000\n")
        if told is not None and data:
            assert data.endswith(b"M0.0000\n")
    assert told <= 0.046


def test_a_torque_that_is_not_finite_is_none():
    loop = MotorLoop(load_sensor("simplefoc"))
    reports(loop, 0.5)
    for torque in (math.nan, math.inf, -math.inf):
        loop.receive([(0.6, {"motor_target": 0.0, "shaft_rad": 1.2})], 0.6)
        loop.step(torque, 0.6)
        assert loop.torque == 0.0


@given(st.lists(st.tuples(finite, finite, finite, st.floats(0.0, 0.1)), max_size=100))
def test_whatever_is_reported_the_command_keeps_the_ceiling(steps):
    sensor = load_sensor("simplefoc")
    loop, now = MotorLoop(sensor), 0.0
    reports(loop, 0.15)
    highest = sensor.number("motor.ceiling_nm") / sensor.number("motor.nm_per_unit")
    now = 0.15
    for torque, target, angle, later in steps:
        now += later
        loop.receive([(now, {"motor_target": target, "shaft_rad": angle})], now)
        for line in loop.step(torque, now).splitlines():
            if line[:2] not in (b"@0", b"MC", b"MM", b"ME"):
                assert abs(float(line[1:])) <= highest


HEAD = 'schema = 1\n[stream]\ncolumns = ["motor_target", "shaft_rad"]\n[motor]\n'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD + 'protocol = "simplefoc"\n', "motor.nm_per_unit is missing"),
        ('schema = 1\n[motor]\nprotocol = "simplefoc"\nnm_per_unit = 1\n', "stream.columns"),
        (HEAD + 'protocol = "odrive"\n', "simplefoc"),
        (HEAD + 'letter = "MM"\n', "not allowed"),
        (HEAD + "ceiling_nm = 11\n", "0 to 10"),
        (HEAD + "inertia = 0\n", "1e-07 to 1"),
        (HEAD + "friction_nm = 0\n", "1e-06 to 1"),
    ],
)
def test_a_wrong_motor_is_refused_in_one_line(text, said):
    with pytest.raises(ov.InputError) as caught:
        parse_sensor(text, "mine", "mine.toml")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_profile_without_a_motor_has_no_force():
    with pytest.raises(ov.InputError, match="simplefoc"):
        MotorLoop(Sensor())
