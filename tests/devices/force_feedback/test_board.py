"""A knob whose own board runs the surface: its firmware, compiled here, on a simulated knob."""

from __future__ import annotations

import ctypes
import math
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.devices.force_feedback.board_loop import (
    PERIOD_S,
    RESEND_S,
    BoardLoop,
    board_table,
)
from overview_dsp.devices.sensors.frames import FrameDecoder, framed
from overview_dsp.devices.sensors.profile import load_sensor
from overview_dsp.devices.sensors.reading import Counters
from tests.devices.force_feedback.board_frames import all_frames
from tests.devices.force_feedback.simulation import ROOT
from tests.profiles import share

sys.path.insert(0, str(ROOT / "tools"))
import knob_session
import measure_knob
import simulated_board
from simulated_motor import jiggle

SENSOR = load_sensor("simplefoc")
POINTS = 1025
EARLIER_FOOTBALL = ROOT / "tests/earlier/0.1.0/presets/football.toml"
pytestmark = pytest.mark.skipif(simulated_board.compiler() is None, reason="needs a C compiler")


@pytest.fixture(scope="module")
def surface(match, football):
    return ov.build_surface(match, football)


def test_the_energy_of_a_crossing_is_kept_with_few_points(surface):
    whole = np.trapezoid(surface.friction) / (len(surface.friction) - 1)
    for count in (8193, POINTS, 65):
        table = board_table(surface, count)
        cells = np.full(count, 1.0 / (count - 1))
        cells[[0, -1]] *= 0.5
        assert float(table.points @ cells) * table.unit == pytest.approx(whole, rel=2e-3)
        assert table.points.min() >= 1


def given_to(motor, frames):
    """What the board says after these frames, each state of it."""
    decoder = FrameDecoder(Counters())
    for frame in frames:
        motor.loop(frame)
    said = b"".join(motor.loop(b"") for _ in range(4000))
    return [one for one in decoder.feed(said) if "knob_points" in one]


def everything(surface, football, points=POINTS):
    loop = BoardLoop(SENSOR, 1_000_000)
    loop.render(surface, football.values)
    return all_frames(loop, points)


def test_a_board_has_the_table_that_was_sent(surface, football):
    motor = simulated_board.BoardMotor(points=POINTS)
    state = given_to(motor, everything(surface, football))[-1]
    assert (state["knob_points"], state["knob_hz"]) == (POINTS, 4000)
    assert (state["knob_table"], state["knob_disk"], state["knob_rejected"]) == (1, 1, 0)


def test_a_missing_part_is_reported_and_the_table_is_not_used(surface, football):
    frames = everything(surface, football)
    del frames[7]  # after the disk six parts
    motor = simulated_board.BoardMotor(points=POINTS)
    state = given_to(motor, frames)[-1]
    assert (state["knob_table"], state["knob_filling"], state["knob_missing"]) == (0, 1, 6)


@settings(max_examples=share(0.25))
@given(st.integers(0, 34), st.integers(0, 600), st.integers(1, 0xFFFF), st.booleans())
def test_a_damaged_frame_is_refused_without_effect(surface, football, which, bit, burst, cut):
    """A burst of up to 16 bits anywhere, or a lost byte."""
    frames = everything(surface, football)
    frame = bytearray(frames[which])
    if cut:
        del frame[bit % (len(frame) - 1)]
    else:
        at = bit % (8 * len(frame))
        value = int.from_bytes(frame, "little") ^ burst << at
        frame = bytearray(value.to_bytes(len(frame) + 2, "little")[: len(frame)])
        if frame == frames[which]:
            return
    motor = simulated_board.BoardMotor(points=POINTS)
    state = given_to(motor, [*frames[:which], bytes(frame), b"\0", *frames[which + 1 :]])[-1]
    assert state["knob_rejected"] >= 1
    assert (state["knob_table"], state["knob_disk"]) != (1, 1)


def test_a_table_arrives_over_a_line_that_loses_a_third_of_the_frames(surface, football):
    course = knob_session.simulate(
        surface, football, SENSOR, lambda t: 0.0, 0.05, delay_s=0.02, loss=0.3
    )
    assert course.ready_after_s < 3.0


def test_a_surface_that_changes_is_crossfaded_to(surface, football, match):
    """While the hand turns: the torque never jumps, and the new surface is the one in use."""
    motor = simulated_board.BoardMotor()
    loop, decoder = BoardLoop(SENSOR, 1_000_000), FrameDecoder(Counters())
    loop.render(surface, football.values)
    other = ov.build_surface(match, football.with_changes({"surface.friction": 6e-4}))
    torques, tables = [], []
    for tick in range(1500):
        now = tick * PERIOD_S
        said = b""
        sent = loop.step(True, now)
        while motor.time < now + PERIOD_S:
            said += motor.loop(sent)
            sent = b""
            motor.angle = 0.3 * max(0.0, motor.time - 1.0)
            motor.time += motor.dt
        loop.receive([(now, one) for one in decoder.feed(said)], now)
        if tick == 800:
            loop.render(other, football.values)
        torques.append(motor.torque)
        tables.append(motor.table)
    assert set(tables) == {0, 1, 2}
    change = tables.index(2)
    before, after = np.mean(torques[change - 50 : change]), np.mean(torques[-50:])
    assert after < 1.4 * before < 0.0
    steps = np.abs(np.diff(torques[change - 5 : change + 30]))
    assert steps.max() < 0.3 * abs(after - before)


@pytest.mark.parametrize(
    ("steps", "hertz", "degrees", "about"),
    [(4000, 5.0, 11.0, 1.5), (1000, 20.0, 8.0, 0.0), (1000, 15.0, 11.0, math.pi)],
)
def test_a_shaking_hand_gains_no_energy(match, football, steps, hertz, degrees, about):
    """About the middle, and in and out of the stiff ends of a slow board."""
    if steps == 1000:
        # the board's core has the clutch of 0.1.0, which at 1 kHz gives energy where shaft 2 is as
        # stiff as football's is now: football as it was, until the core has the present clutch
        football = ov.load_preset(EARLIER_FOOTBALL)
    surface = ov.build_surface(match, football)
    path = jiggle(hertz, math.radians(degrees), 0.4, about)
    course = knob_session.simulate(surface, football, SENSOR, path, 1.2, 0.02, hertz=steps)
    assert course.greatest_rise(since=0.4) < 1e-5
    assert np.abs(course.torque).max() > 2e-3  # and it is felt


def test_a_goal_is_a_knock_without_the_delay_of_the_serial_line(surface, football):
    here, far = (
        knob_session.simulate(surface, football, SENSOR, knob_session.glide(2.0), 2.3, delay_s)
        for delay_s in (0.0, 0.02)
    )
    goal, card, foul = (
        np.median(measure_knob.torque_rises(here, surface, kind))
        for kind in ("goal", "yellow_card", "foul")
    )
    assert goal > 1.5 * card
    assert card > foul > 2e-4
    assert np.median(measure_knob.impact_rises(here, surface)) > 5e-3
    assert np.array_equal(here.torque, far.torque[: len(here.torque)])
    assert far.ready_after_s > here.ready_after_s
    assert here.greatest_rise() < 1e-5


def test_the_ends_hold(surface, football):
    """A hand that pushes 45 degrees beyond with 20 mN m/rad."""
    course = knob_session.simulate(
        surface, football, SENSOR, lambda t: -min(math.pi / 4.0, 2.0 * t), 1.2, stiffness=0.02
    )
    still = course.time > 1.0
    assert math.degrees(-course.angle[still].min()) < 8.0
    assert math.degrees(np.ptp(course.angle[still])) < 0.2
    assert course.torque[still].min() > 5e-3


def test_the_torque_ends_40_ms_after_the_host_is_killed(surface, football):
    course = knob_session.simulate(
        surface, football, SENSOR, knob_session.glide(3.0), 1.2, 0.0, 0.0, killed_at=1.0
    )
    assert np.abs(course.torque[(course.time > 0.9) & (course.time < 1.0)]).min() > 1e-4
    assert not course.torque[course.time > 1.0 + PERIOD_S + 0.04].any()


def test_a_board_without_a_table_gives_no_torque():
    motor = simulated_board.BoardMotor()
    for _ in range(2000):
        motor.loop(b"")
        motor.step(0.01)
        assert motor.torque == 0.0
    assert motor.angle > 0.5


@pytest.mark.parametrize("reverse", [False, True])
def test_the_torque_opposes_the_turn_in_both_directions(surface, football, reverse):
    sensor = SENSOR.with_defaults({"motor.reverse": True}) if reverse else SENSOR
    way = -1.0 if reverse else 1.0
    course = knob_session.simulate(
        surface, football, sensor, lambda t: way * min(1.5, 1.5 * t), 0.9, 0.002
    )
    turning = course.time > 0.3
    assert (way * course.torque[turning]).max() < 0.0
    assert course.disk[-1] > 0.2


def test_frames_are_sent_at_a_limited_rate(surface, football):
    """One word each 2 ms; a disk or a table that the board has isn't sent again."""
    loop = BoardLoop(SENSOR, 1_000_000)
    loop.render(surface, football.values)
    motor, decoder = simulated_board.BoardMotor(points=POINTS), FrameDecoder(Counters())
    sizes = []
    for tick in range(1000):
        now = 0.001 * tick
        sent = loop.step(True, now)
        said = b"".join(motor.loop(sent if n == 0 else b"") for n in range(8))
        loop.receive([(now, one) for one in decoder.feed(said)], now)
        sizes.append(len(sent))
    assert loop.ready
    assert sum(size > 0 for size in sizes) == pytest.approx(500, abs=2)
    assert max(sizes[-200:]) == len(framed(bytes((19, 1))))
    assert sum(sizes) < 2 * sum(map(len, everything(surface, football))) + 500 * 8
    assert RESEND_S > PERIOD_S


def test_a_step_takes_any_angle():
    """A NaN from a sensor that is unplugged is no torque and no state."""
    motor = simulated_board.BoardMotor()
    for angle in (math.nan, math.inf, -math.inf, 1e30):
        assert motor._library.board_step(motor._knob, ctypes.c_float(angle)) == 0.0
