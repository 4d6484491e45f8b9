"""The motor's loop on a simulated knob, in a simulated clock: it gives the hand nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from overview_dsp.devices.force_feedback.passivity import FRICTION_CREDIT_J
from overview_dsp.devices.sensors.profile import load_sensor
from tests.devices.force_feedback.simulation import sim, simulate
from tests.profiles import share

SENSOR = load_sensor("simplefoc")
FRICTION = 3.1e-4
"""The default, N m s/rad."""

DELAYS_S = (0.0, 0.005, 0.02)
"""Each way: the loop has twice that."""


def check_passive(course, motor, loop):
    """The hand got no more than it put in, at any moment."""
    # its own work, with what the knob's motion stores: strictly
    assert motor.user_work > 0.0
    assert course["hand_work"].min() >= -1e-12
    # the motor's, but for the little that the knob's friction had lent
    assert (course["given"] - course["put_in"]).max() <= 2.0 * FRICTION_CREDIT_J
    # and the ledger knew it, but for what is under way and the encoder's step
    ledger = loop.observer
    assert course["credit"].min() >= -FRICTION_CREDIT_J
    way = np.ptp(course["angle"][-50:]) + motor.step_rad
    unknown = np.abs(course["torque"]).max() * way
    assert ledger.absorbed - ledger.returned <= motor.absorbed - motor.returned + unknown
    assert np.abs(course["torque"]).max() <= SENSOR.number("motor.ceiling_nm")


@pytest.mark.parametrize("delay_s", DELAYS_S)
@pytest.mark.parametrize("times", [1, 10])
@pytest.mark.parametrize("hand", ["sweep", "jiggle", "flick"])
def test_the_hand_gets_no_more_than_it_put_in(match, football, hand, times, delay_s):
    preset = football.with_changes({"surface.friction": times * FRICTION})
    path = sim.jiggle(hertz=4.0) if hand == "jiggle" else sim.MOVEMENTS[hand]()
    course, motor, loop = simulate(preset, match, SENSOR, path, 3.5, delay_s)
    check_passive(course, motor, loop)
    assert np.abs(course["torque"]).max() > 5e-4  # and it is felt


@pytest.mark.parametrize(("hertz", "delay_s"), [(5.0, 0.0), (5.0, 0.005), (15.0, 0.0)])
def test_a_hand_that_only_ever_jiggles_is_braked_too(match, football, hertz, delay_s):
    def path(t):
        return 0.3 * np.sin(2.0 * np.pi * hertz * t)

    course, motor, loop = simulate(football, match, SENSOR, path, 2.0, delay_s)
    check_passive(course, motor, loop)
    assert np.abs(course["torque"]).max() > 2e-4


@pytest.mark.parametrize("model", ["bristle", "detent"])
def test_friction_that_sticks_and_wells_that_pull_give_nothing_either(match, football, model):
    preset = football.with_changes({"surface.model": model})
    course, motor, loop = simulate(preset, match, SENSOR, sim.sweep(hertz=1.0), 3.0, 0.005)
    check_passive(course, motor, loop)
    assert np.abs(course["torque"]).max() > 5e-4


@pytest.mark.parametrize("delay_s", DELAYS_S)
@pytest.mark.parametrize("times", [1, 10])
@pytest.mark.parametrize("hand", ["hold", "flick"])
def test_at_rest_the_knob_lies_still(match, football, hand, times, delay_s):
    """Held softly, and thrown and let go: within 0.2 degrees, peak to peak."""
    preset = football.with_changes({"surface.friction": times * FRICTION})
    course, *_ = simulate(preset, match, SENSOR, sim.MOVEMENTS[hand](), 3.0, delay_s)
    last = course["time"] > 2.0
    assert np.degrees(np.ptp(course["angle"][last])) < 0.2


def test_without_the_controller_the_same_hand_is_given_energy(match, football):
    """What the tests above would say of a loop that sends the torque as it is."""
    rigid = {"clutch.max_speed_ratio": 0.0, "disk.k1": 0.00097, "disk.k2": 0.00278}
    preset = football.with_changes({**rigid, "surface.friction": 10 * FRICTION})
    course, motor, _ = simulate(preset, match, SENSOR, sim.jiggle(hertz=4.0), 3.5, 0.02, naive=True)
    assert motor.returned - motor.absorbed > 5e-3
    assert course["hand_work"].min() < 0.0


def test_over_a_goal_the_knob_is_braked_more_than_beside_it(match, football):
    course, *_ = simulate(football, match, SENSOR, sim.sweep(hertz=0.25), 3.0)
    torque = np.abs(course["torque"])
    assert np.percentile(torque, 99.5) > 4.0 * np.median(torque[course["time"] > 1.5])


@settings(max_examples=share(0.25))
@given(
    delay_s=st.floats(0.0, 0.02),
    times=st.floats(1.0, 10.0),
    waves=st.lists(
        st.tuples(st.floats(0.2, 12.0), st.floats(0.0, 0.8), st.floats(0.0, 6.28)),
        min_size=1,
        max_size=3,
    ),
)
def test_no_hand_gets_more_than_it_put_in(match, football, delay_s, times, waves):
    def path(t):
        up = min(1.0, t / 0.5)
        return 1.5 * up + up * sum(
            reach / (1.0 + hertz) * np.sin(2.0 * np.pi * hertz * t + phase)
            for hertz, reach, phase in waves
        )

    preset = football.with_changes({"surface.friction": times * FRICTION})
    course, motor, loop = simulate(preset, match, SENSOR, path, 2.0, delay_s)
    check_passive(course, motor, loop)
