"""Each small unit against its own formula: smoother, limiter, DC blocker, noise."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.kernels.dc_block import CORNER_HZ, block_dc
from overview_dsp.kernels.friction_lookup import friction_at
from overview_dsp.kernels.layout import CELLS
from overview_dsp.kernels.limiter import limit
from overview_dsp.kernels.noise import next_state, seed_state, white
from overview_dsp.kernels.smoother import latency, smooth
from overview_dsp.kernels.texture import texture_level
from tests.kernels.deriving import one_pole

RATE = 48_000.0


@numba.njit
def smoothed(target, a):
    out = np.zeros(target.size)
    y1 = y2 = 0.0
    for n in range(target.size):
        y1, y2 = smooth(target[n], y1, y2, a)
        out[n] = y2
    return out


@numba.njit
def blocked(x, pole):
    out = np.zeros(x.size)
    before = y = 0.0
    for n in range(x.size):
        y = block_dc(x[n], before, y, pole)
        before = x[n]
        out[n] = y
    return out


@numba.njit
def limited(x, ceiling):
    out = np.zeros(x.size)
    for n in range(x.size):
        out[n] = limit(x[n], ceiling)
    return out


@numba.njit
def noises(state, count):
    out = np.zeros(count)
    for n in range(count):
        state = next_state(state)
        out[n] = white(state)
    return out


@numba.njit
def friction_table(m, positions):
    out = np.zeros(positions.size)
    for n in range(positions.size):
        out[n] = friction_at(m, 0, positions[n])
    return out


@numba.njit
def grain(torque, omega, gain):
    return texture_level(torque, omega, gain)


def test_the_smoother_has_the_stated_step_response():
    tau = 0.004
    step = smoothed(np.ones(4800), one_pole(tau, RATE))
    time = np.arange(1, 4801) / RATE
    expected = 1.0 - (1.0 + time / tau) * np.exp(-time / tau)
    # the sampled filter lies within one sample of the continuous one
    assert np.abs(step - expected).max() < 1.5 / (RATE * tau * math.e)
    assert np.all(np.diff(step) >= 0.0)


@pytest.mark.parametrize("tau", [0.0005, 0.004, 0.05])
def test_the_smoothers_latency_is_the_centroid_of_its_impulse_response(tau):
    a = one_pole(tau, RATE)
    impulse = np.zeros(144_000)
    impulse[0] = 1.0
    response = smoothed(impulse, a)
    assert response.sum() == pytest.approx(1.0, rel=1e-9)
    assert (response * np.arange(144_000)).sum() == pytest.approx(latency(a), rel=1e-9)


def test_the_dc_blocker_is_3_db_down_at_its_corner_and_removes_dc():
    pole = math.exp(-2 * math.pi * CORNER_HZ / RATE)
    impulse = np.zeros(1 << 16)
    impulse[0] = 1.0
    response = np.abs(np.fft.rfft(blocked(impulse, pole)))
    frequency = np.fft.rfftfreq(1 << 16, 1 / RATE)
    at_corner = np.interp(CORNER_HZ, frequency, response)
    assert 20 * math.log10(at_corner) == pytest.approx(-3.01, abs=0.05)
    assert response[0] < 1e-6


def test_the_dc_blocker_dies_away_to_exact_zero():
    x = np.zeros(48_000)
    x[:1000] = 1.0
    assert np.all(blocked(x, math.exp(-2 * math.pi * CORNER_HZ / RATE))[-1000:] == 0.0)


@given(x=st.floats(-1e12, 1e12), ceiling=st.floats(0.01, 0.9))
def test_nothing_passes_the_ceiling_and_nothing_below_half_of_it_is_changed(x, ceiling):
    (y,) = limited(np.array([x]), ceiling)
    assert abs(float(np.float32(y))) <= float(np.float32(ceiling))
    if abs(x) <= 0.5 * ceiling:
        assert y == x
    assert y * x >= 0.0


def test_the_limiter_is_smooth_and_never_falls():
    y = limited(np.linspace(0.0, 4.0, 40_001), 0.8)
    slope = np.diff(y) / 1e-4
    assert np.all(slope >= 0.0)
    assert slope.max() <= 1.0 + 1e-9
    assert np.abs(np.diff(slope)).max() < 1e-3


def test_noise_is_white_uniform_and_repeatable():
    first = noises(np.uint64(seed_state(7)), 100_000)
    assert np.array_equal(first, noises(np.uint64(seed_state(7)), 100_000))
    assert not np.array_equal(first, noises(np.uint64(seed_state(8)), 100_000))
    assert abs(first.mean()) < 0.01
    assert first.var() == pytest.approx(1.0 / 3.0, rel=0.02)
    assert -1.0 <= first.min() < -0.999
    assert 0.999 < first.max() < 1.0
    correlation = np.corrcoef(first[:-1], first[1:])[0, 1]
    assert abs(correlation) < 0.02


@given(seed=st.integers(-(2**70), 2**70))
def test_any_seed_gives_a_state_that_is_not_zero(seed):
    assert 0 < seed_state(seed) < 2**64


def test_friction_is_linear_between_points_and_clamped_beyond_them():
    values = np.sin(np.arange(CELLS + 1) * 0.01) + 2.0
    m = np.zeros(2 * (CELLS + 1))
    m[0::2] = values
    m[1:-1:2] = np.diff(values)
    positions = np.array(
        [-5.0, 0.0, 10.25, CELLS - 0.5, float(CELLS), CELLS + 9.0, math.nan, 1e300]
    )
    expected = np.interp(np.nan_to_num(positions, nan=0.0), np.arange(CELLS + 1), values)
    assert friction_table(m, positions) == pytest.approx(expected, rel=1e-12)


def test_grain_grows_with_torque_and_with_speed_and_is_silent_at_rest():
    assert grain(0.0, 0.0, 1.0) == 0.0
    assert grain(2.0, 1.0, 1.0) > grain(1.0, 1.0, 1.0)
    assert grain(1.0, 2.0, 1.0) > grain(1.0, 1.0, 1.0)
    assert grain(-1.0, -1.0, 1.0) == grain(1.0, 1.0, 1.0)
