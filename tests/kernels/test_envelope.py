"""The tactor's envelope: its amplitude's curve, and how it rises and falls."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest

from overview_dsp.kernels.envelope import compress, follow
from tests.kernels.deriving import one_pole

RATE = 48_000.0


@numba.njit
def amplitudes(torque, scale, gate, exponent):
    out = np.zeros(torque.size)
    for n in range(torque.size):
        out[n] = compress(torque[n], scale, gate, exponent)
    return out


@numba.njit
def followed(amplitude, decay, rise):
    out = np.zeros(amplitude.size)
    h = e1 = e2 = 0.0
    for n in range(amplitude.size):
        h, e1, e2 = follow(amplitude[n], h, e1, e2, decay, rise)
        out[n] = e2
    return out, h, e1


def test_compression_is_a_power_law_that_bends_to_one():
    torque = np.geomspace(1e-4, 0.03, 50)
    amplitude = amplitudes(torque, 1.0, 0.0, 0.6)
    slope = np.diff(np.log(amplitude)) / np.diff(np.log(torque))
    assert slope[0] == pytest.approx(0.6, abs=1e-3)
    assert np.all(np.diff(amplitudes(np.geomspace(1e-6, 1e6, 2000), 1.0, 1e-9, 0.6)) >= 0.0)
    assert amplitudes(np.array([1e6]), 1.0, 0.0, 0.6)[0] == pytest.approx(1.0)


def test_torque_below_the_threshold_and_nan_give_exact_silence():
    quiet = np.array([0.0, 1e-3, -1e-3, math.nan])
    assert np.all(amplitudes(quiet, 1.0, 1e-3, 0.6) == 0.0)
    assert amplitudes(np.array([-0.5]), 1.0, 1e-3, 0.6) == amplitudes(
        np.array([0.5]), 1.0, 1e-3, 0.6
    )


def test_the_envelope_outlasts_a_spike_by_its_decay_and_ends_in_exact_zero():
    amplitude = np.zeros(48_000)
    amplitude[100] = 1.0
    envelope, follower, first = followed(amplitude, one_pole(0.010, RATE), one_pole(0.001, RATE))
    later, much_later = envelope[100 + 1440], envelope[100 + 1920]
    assert math.log(later / much_later) == pytest.approx(1.0, rel=0.02)  # 10 ms apart
    assert np.all(envelope[-1000:] == 0.0)
    assert follower == first == 0.0


def test_a_step_rises_as_through_two_low_passes_of_one_time_constant():
    rise = one_pole(0.002, RATE)
    n = np.arange(1, 2001)
    # of (rise / (1 - (1 - rise) / z))**2; in continuous time 1 - (1 + t/tau) exp(-t/tau)
    expected = 1.0 - (1.0 + rise * n) * (1.0 - rise) ** n
    step, *_ = followed(np.ones(2000), one_pole(0.05, RATE), rise)
    assert step == pytest.approx(expected, rel=1e-9)
    time = n / RATE / 0.002
    assert np.abs(step - (1.0 - (1.0 + time) * np.exp(-time))).max() < 0.01


def test_what_it_lets_through_falls_by_6_db_at_its_corner_and_12_db_an_octave_above():
    tau = 0.002
    impulse = np.zeros(1 << 16)
    impulse[0] = 1.0
    # with a decay of 1 the follower is the amplitude itself
    response = np.abs(np.fft.rfft(followed(impulse, 1.0, one_pole(tau, RATE))[0]))
    corner = 1.0 / (2.0 * math.pi * tau)
    level = 20.0 * np.log10(
        np.interp(
            corner * np.array([0.01, 1.0, 8.0, 16.0]),
            np.fft.rfftfreq(1 << 16, 1.0 / RATE),
            response,
        )
    )
    assert level[:2] == pytest.approx([0.0, -6.02], abs=0.02)
    assert level[2] - level[3] == pytest.approx(12.04, abs=0.3)


def test_a_weaker_amplitude_is_approached_by_its_decay_and_a_stronger_one_is_there_at_once():
    decay = one_pole(0.01, RATE)
    amplitude = np.repeat([0.3, 0.1, 0.2], [10, 2000, 10])
    envelope, *_ = followed(amplitude, decay, 1.0)  # a rise of 1: no low-pass
    assert np.all(envelope[:10] == 0.3)
    fall = (1.0 - decay) ** np.arange(1, 2001)
    assert envelope[10:2010] == pytest.approx(0.1 + 0.2 * fall, rel=1e-9)
    assert np.all(envelope[2010:] == 0.2)


def test_the_amplitude_is_of_the_torque_above_the_threshold_in_full_torques():
    torque = np.array([-0.03, 0.002, 0.01, 0.03, 0.2])
    c = np.maximum(np.abs(torque) * 20.0 - 0.05, 0.0) ** 0.5
    tanh = np.tanh(c)  # of which the curve is the Pade form, 1 from c = 3 on
    found = amplitudes(torque, 20.0, 0.05, 0.5)
    assert found == pytest.approx(c * (27.0 + c**2) / (27.0 + 9.0 * c**2), rel=1e-9)
    assert found == pytest.approx(tanh, abs=0.025)
    assert amplitudes(np.array([1.0]), 20.0, 0.05, 1.0) == 1.0
