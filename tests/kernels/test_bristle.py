"""Bristles: the step's energy ledger, the model's own differential equation, a finer time step."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from overview_dsp.kernels import math_functions
from overview_dsp.kernels.bristle import (
    bristle_step,
    convert_deflection,
    speed_after,
    steady_torque,
)

step = math_functions.plain(bristle_step)
leave = math_functions.plain(speed_after)
INERTIA, SPRING, VISCOUS = 2e-5, 6e-3, 1e-4  # kg m2, N m/rad, N m s/rad


@given(
    hands=st.lists(st.floats(-3.0, 3.0).map(lambda x: round(x, 9)), min_size=2, max_size=40),
    zs=st.lists(st.floats(1e-9, 1.0), min_size=40, max_size=40),
    rate=st.floats(8000.0, 768_000.0),
    stiffness=st.floats(0.1, 1e6),
    damping=st.floats(0.0, 1.0),
    viscous=st.floats(0.0, 1.0),
    break_away=st.floats(0.05, 0.95),
)
def test_every_step_gives_no_energy_and_books_what_it_takes(
    hands, zs, rate, stiffness, damping, viscous, break_away
):
    """In rad and rad a step: dE + dS + losses = work of the hand, every loss >= 0."""
    dt = 1.0 / rate
    spring = SPRING / INERTIA * dt * dt
    per_step = INERTIA * rate  # the scale of `two_disk`
    x = v = z = 0.0
    for hand, most in zip(hands, zs, strict=False):
        resistance = per_step * (2.0 + 0.5 * spring) + viscous
        push = per_step * (2.0 * v + spring * (hand - x))
        middle, bent, torque = step(push, resistance, z, stiffness * dt, damping, most, break_away)
        torque *= rate  # N m
        after = leave(v, middle)
        energy = INERTIA * rate * rate * v * v / 2 + SPRING * x * x / 2 + stiffness * z * z / 2
        x_after = x + middle
        energy_after = (
            INERTIA * rate * rate * after * after / 2
            + SPRING * x_after * x_after / 2
            + stiffness * bent * bent / 2
        )
        work = SPRING * hand * middle
        # what leaving slower than the midpoint rule would costs
        stopped = INERTIA * rate * rate * ((2.0 * middle - v) ** 2 - after**2) / 2
        lost_viscous = viscous * rate * middle * middle
        lost_bristle = torque * middle - stiffness * (bent * bent - z * z) / 2
        size = energy + energy_after + abs(work) + abs(torque * middle) + stopped
        assert abs(energy_after - energy + lost_viscous + lost_bristle + stopped - work) <= (
            1e-12 * size
        )
        assert lost_bristle >= -1e-12 * size
        assert stopped >= -1e-12 * size
        assert torque * middle >= -stiffness * z * z / 2 * (1.0 + 1e-9)
        x, v, z = x_after, after, bent


@given(z=st.floats(-1e3, 1e3), before=st.floats(0.1, 1e6), stiffness=st.floats(0.1, 1e6))
def test_bristles_that_change_their_stiffness_gain_no_energy(z, before, stiffness):
    after = math_functions.plain(convert_deflection)(z, before, stiffness)
    assert stiffness * after * after <= before * z * z * (1.0 + 1e-12)
    assert after * z >= 0.0


@numba.njit
def simulated(rate, stiffness, pull, seconds, sliding, static, stribeck):
    """Angle, speed and bristle torque of a disk pulled by a spring whose far end moves."""
    dt = 1.0 / rate
    spring = SPRING / INERTIA * dt * dt
    per_step = INERTIA * rate
    x = v = z = 0.0
    out = np.zeros((round(seconds * rate), 3))
    for n in range(len(out)):
        most = steady_torque(sliding, static, stribeck, v * rate) / stiffness
        push = per_step * (2.0 * v + spring * (pull * (n + 0.5) * dt - x))
        resistance = per_step * (2.0 + 0.5 * spring) + VISCOUS
        middle, z, torque = bristle_step(push, resistance, z, stiffness * dt, 1e-3, most, 0.7)
        v = speed_after(v, middle)
        x += middle
        out[n] = x, middle * rate, torque * rate
    return out


def test_stiff_bristles_stop_the_disk_at_once_and_dont_shake_it():
    v, z = 0.02 / 8000.0, 0.0
    for _ in range(20):
        middle, z, _ = step(
            INERTIA * 8000.0 * 2.0 * v, INERTIA * 8000.0 * 2.0, z, 1e6 / 8000.0, 0.0, 1.0, 0.7
        )
        v = leave(v, middle)
    assert abs(v) < 1e-3 * 0.02 / 8000.0


def broke_loose(angle, speed, rate, stribeck=0.3):
    """When the disk first goes faster than the Stribeck speed, s."""
    return (int(np.argmax(speed > stribeck)) + 1) / rate


@pytest.mark.parametrize("stiffness", [2.0, 50.0, 2e3, 1e6])
def test_break_away_and_sliding_agree_with_a_64_times_finer_step(stiffness):
    results = []
    for rate in (8000.0, 64 * 8000.0):
        creeping = simulated(rate, stiffness, 1.0, 1.5, 4e-3, 2.0, 0.3)
        fast = simulated(rate, stiffness, 3.0, 3.0, 4e-3, 2.0, 0.3)
        half = len(fast) // 2
        results.append(
            (
                broke_loose(creeping[:, 0], creeping[:, 1], rate),
                creeping[:, 2].max(),
                fast[half:, 2].mean(),
                fast[-1, 0],
            )
        )
    assert results[0] == pytest.approx(results[1], rel=0.01)
    # the disk held against the static torque, and no more
    assert results[0][0] > 7e-3 / SPRING
    assert results[0][1] == pytest.approx(8e-3, rel=0.03)


@pytest.mark.parametrize("speed", [0.05, 0.3, 1.0])
def test_sliding_steadily_the_torque_is_the_stribeck_curve(speed):
    # held back so much by viscous friction that it can't creak
    sliding, static, stribeck = 4e-3, 2.0, 0.3
    most = sliding * (1.0 + (static - 1.0) * math.exp(-((speed / stribeck) ** 2)))
    z = 0.0
    for _ in range(4000):
        _, z, torque = step(
            1e3 * speed / 8000.0 + most / 8000.0, 1e3, z, 20.0 / 8000.0, 1e-3, most / 20.0, 0.7
        )
    assert torque * 8000.0 == pytest.approx(most, rel=1e-3)


@pytest.mark.parametrize("stiffness", [2.0, 50.0])
def test_the_disk_follows_the_models_differential_equation(stiffness):
    sliding, static, stribeck, edge_part, damping, pull = 4e-3, 2.0, 0.3, 0.7, 1e-3, 1.0

    def motion(time, state):
        x, omega, z = state
        most = sliding / stiffness * (1.0 + (static - 1.0) * math.exp(-((omega / stribeck) ** 2)))
        edge = edge_part * most
        gives = 0.0
        if z * omega > 0.0 and abs(z) > edge:
            gives = (abs(z) - edge) / (most - edge)
        bend = omega * (1.0 - gives)
        torque = stiffness * z + (damping * bend if gives < 1.0 else 0.0)
        return omega, (SPRING * (pull * time - x) - torque - VISCOUS * omega) / INERTIA, bend

    seconds = 2.0
    truth = solve_ivp(
        motion, (0.0, seconds), (0.0, 0.0, 0.0), "LSODA", rtol=1e-8, atol=1e-12, max_step=1e-3
    )
    fine = simulated(768_000.0, stiffness, pull, seconds, sliding, static, stribeck)
    coarse = simulated(48_000.0, stiffness, pull, seconds, sliding, static, stribeck)
    for rate, found in ((768_000.0, fine), (48_000.0, coarse)):
        at = np.clip((truth.t * rate).astype(int) - 1, 0, len(found) - 1)
        error = np.abs(found[at, 0] - truth.y[0]).max()
        assert error < 300.0 / rate * truth.y[0].max()
    assert truth.y[1].max() > 2.0  # it broke loose
