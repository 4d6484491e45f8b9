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

SENSOR = load_sensor("simplefoc")
POINTS = 1025
pytestmark = pytest.mark.skipif(simulated_board.compiler() is None, reason="needs a C compiler")


@pytest.fixture(scope="module")
def surface(match, football):
    return ov.build_surface(match, football)


@pytest.fixture(scope="module")
def played(match, football, surface):
    frames = knob_session.frames_for(surface, football, SENSOR)
    return measure_knob.Match("final", match, surface, frames)


@pytest.fixture(scope="module")
def hand(football):
    return measure_knob.User(SENSOR, football)


BARE = 1.4e-4


def points_of(table, count):
    return table.parts.reshape(-1)[:count].astype(float)


def events_of(table, count):
    parts = -(-count // 32)
    return table.parts[parts:, :30].reshape(-1, 3)


def test_the_energy_of_a_crossing_is_kept_with_few_points(surface):
    whole = np.trapezoid(surface.friction) / (len(surface.friction) - 1)
    for count in (8193, POINTS, 65):
        table = board_table(surface, count, BARE)
        cells = np.full(count, 1.0 / (count - 1))
        cells[[0, -1]] *= 0.5
        points = points_of(table, count)
        assert float(points @ cells) * table.unit == pytest.approx(whole, rel=2e-3)
        assert points.min() >= 1


def test_the_events_of_a_table_have_their_span_and_a_push_that_grows_with_the_height(surface):
    events = events_of(board_table(surface, 8193, BARE), 8193).astype(int)
    assert len(events) == 260
    sent = events[events[:, 2] > 0]
    assert len(sent) == len(surface.event)
    inside = np.isfinite(surface.span)
    low, high = (surface.span * 8192).T
    assert (sent[inside[:, 0], 0] < low[inside[:, 0]]).all()
    assert (sent[inside[:, 1], 1] > high[inside[:, 1]]).all()
    assert (sent[:, 1] - sent[:, 0] >= 3).all()
    assert (sent[~inside[:, 0], 0] == 0).all()
    assert (sent[~inside[:, 1], 1] == 8192).all()
    push = {
        surface.kind_names[kind]: 1e-2 * one
        for kind, one in zip(surface.kind, sent[:, 2], strict=True)
    }
    assert push["goal"] > push["own_goal"] > 2 * push["yellow_card"] > 4 * push["foul"] > 4.0


def test_a_board_of_few_points_gets_its_strongest_events_in_order(surface):
    few = events_of(board_table(surface, 65, BARE), 65)
    assert len(few) == 10
    strongest = np.sort(np.sort(surface.release)[-10:])
    pushes = np.rint(80.0 * (strongest / BARE) ** 0.65)
    assert np.sort(few[:, 2]).tolist() == pushes.tolist()
    assert (np.diff(few[:, 0].astype(int)) >= 0).all()


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


SPEEDS = [(1.0, False), (2.0, False), (4.0, False), (6.0, False), (2.0, True)]


@pytest.mark.parametrize("knob", measure_knob.KNOBS)
@pytest.mark.parametrize(("seconds", "arm"), SPEEDS)
def test_every_event_is_passed_and_every_goal_knocks(played, hand, seconds, arm, knob):
    course = knob_session.stroke(
        played.frames, hand.over(seconds, arm), seconds + 0.5, measure_knob.KNOBS[knob]
    )
    assert measure_knob.never_passed(played, course) == 0
    goals = measure_knob.knocks(played, course)["goal"]
    assert len(goals) == played.kinds.count("goal")
    length_ms, push = np.median(goals, axis=0)
    assert 3.0 <= length_ms <= 5.0
    assert push >= 25.0  # uN m s; 30 over many matches


@pytest.mark.parametrize("seconds", [1.0, 2.0, 4.0])
def test_the_disk_arrives_within_a_fifth_of_a_second(played, hand, seconds):
    for at in (0.1, 0.34, 0.58, 0.66, 0.98):
        path = hand.stopping(at, seconds, False)
        course = knob_session.stroke(played.frames, path, seconds * at + 0.7)
        assert measure_knob.late_by(course, seconds * at) <= 0.2
        assert abs(course.disk[-1] - course.angle[-1] / math.pi) < 1e-3


@pytest.mark.parametrize("knob", measure_knob.KNOBS)
@pytest.mark.parametrize(("counts", "most"), [(16384, 1e-5), (4096, 1.6e-5)])
@pytest.mark.parametrize("steps", [4000, 1000])
def test_a_shaking_hand_is_given_no_energy(played, hand, steps, counts, most, knob):
    """About the middle, a goal, and in and out of the stiff ends, also of a slow board."""
    goal = math.pi * float(played.positions("goal")[0])
    felt = 0.0
    for about in (0.0, goal, 1.5, math.pi):
        for hertz, degrees in ((5.0, 0.5), (8.0, 3.0), (10.0, 5.0), (20.0, 8.0), (2.0, 25.0)):
            path = hand.jiggling(about, hertz, degrees)
            course = knob_session.stroke(
                played.frames, path, 2.4, measure_knob.KNOBS[knob], steps, counts
            )
            assert course.greatest_rise(1.2) < most
            felt = max(felt, np.abs(course.torque).max())
    assert felt > 5e-3


def test_a_resting_hand_is_only_nudged(played, hand):
    """The disk comes to a goal on which the hand has come to rest."""
    goal = float(played.positions("goal")[0])
    for beyond in np.linspace(-2e-3, 4e-3, 7):
        path = hand.stopping(goal + beyond, 2.0, True)
        course = knob_session.stroke(played.frames, path, 4.0, measure_knob.REAL)
        arrived = course.time > 2.0 * (goal + beyond) + 0.2
        assert np.ptp(course.angle[arrived]) < 2e-3
        assert course.greatest_rise(2.0 * goal + 0.2) < 1e-5


@pytest.mark.parametrize("seconds", [2.0, 4.0])
def test_a_goal_is_more_than_a_card_and_a_card_more_than_a_foul_at_the_fingers(
    played, hand, seconds
):
    course = knob_session.stroke(
        played.frames, hand.over(seconds, False), seconds, measure_knob.REAL
    )
    rises = measure_knob.felt_rises(played, course)
    goal, card, foul = (
        np.nanmedian(rises[np.array(played.kinds) == kind])
        for kind in ("goal", "yellow_card", "foul")
    )
    assert goal >= 2.0 * card
    assert goal >= 3.5 * foul
    assert card > foul > 2e-4


@pytest.mark.filterwarnings("ignore::overview_dsp.OverviewWarning")
@pytest.mark.parametrize("name", sorted(path.stem for path in ROOT.glob("presets/*.toml")))
def test_every_preset_is_passed_below_the_ceiling(match, name):
    """Also those whose pull to the start would be many times the ceiling."""
    preset = ov.load_preset(name)
    surface = ov.build_surface(match, preset)
    frames = knob_session.frames_for(surface, preset, SENSOR)
    played, user = (
        measure_knob.Match(name, match, surface, frames),
        measure_knob.User(SENSOR, preset),
    )
    for seconds in (1.0, 4.0):
        course = knob_session.stroke(frames, user.over(seconds, False), seconds + 0.5)
        assert measure_knob.never_passed(played, course) == 0
        assert np.abs(course.torque).max() <= 0.02 * (1.0 + 1e-6)
        assert course.greatest_rise() < 1e-5


@pytest.mark.parametrize("hertz", [1.0, 2.0])
def test_a_goal_that_is_scrubbed_knocks_each_time(played, hand, hertz):
    for goal in played.positions("goal")[:2]:
        path = hand.jiggling(math.pi * float(goal), hertz, 12.0)
        course = knob_session.stroke(played.frames, path, 5.2)
        begun = 4800
        passes = np.flatnonzero(np.diff(course.disk[begun:] > goal)) + begun
        assert len(passes) >= round(8.0 * hertz) - 1
        starts = np.flatnonzero(course.knocks)
        assert all(np.abs(starts - at).min() < 100 for at in passes[1:])  # within 25 ms


def test_the_delay_of_the_serial_line_changes_no_bit(surface, football):
    here, far = (
        knob_session.simulate(surface, football, SENSOR, knob_session.glide(2.0), 2.3, delay_s)
        for delay_s in (0.0, 0.02)
    )
    assert np.array_equal(here.torque, far.torque[: len(here.torque)])
    assert np.abs(here.torque).max() > 5e-3
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
