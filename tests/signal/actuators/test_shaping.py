"""Sharper edges, a felt level that stays, and what the skin feels less."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.signal.actuators.library import actuator_names, load_actuator
from overview_dsp.signal.actuators.model import Actuator, pacinian_db
from overview_dsp.signal.actuators.stage import ActuatorStage
from tests.signal.actuators.driving import (
    RATE,
    burst,
    changed,
    driven,
    envelope,
    fall_ms,
    highest_mean_square,
    motion,
    rise_ms,
)


def measured(name):
    """A bundled actuator with overdrive, as if its resonance were measured."""
    known = {"resonance__tolerance_percent": 0.2, "shaping__overdrive": 4.0}
    return changed(load_actuator(name), **known)


def edges(actuator, amplitude=0.7):
    """Rise and fall of the motion, ms, its level, and the drive."""
    frequency = actuator.resonance_hz
    drive, _ = driven(actuator, burst(frequency, 0.4, 0.3, amplitude))
    level = envelope(motion(actuator, drive), frequency)
    on = round(0.4 * RATE)
    full = np.median(level[on - RATE // 50 : on])
    return rise_ms(level, full), fall_ms(level[on:], full), full, drive


@pytest.mark.parametrize("name", ["c2", "lra"])
def test_a_c2_rises_and_falls_in_less_than_half_the_time_within_its_rating(name):
    """`shaping.overdrive` against none; the rise alone is what the profile says."""
    actuator = changed(measured(name), shaping__perceptual_weighting=False)
    plain_rise, plain_fall, plain_level, _ = edges(changed(actuator, shaping__overdrive=1.0))
    rise, fall, level, drive = edges(actuator)
    assert plain_rise == pytest.approx(actuator.rise_ms, rel=0.05)
    assert rise <= 0.5 * plain_rise
    assert fall <= 0.5 * plain_fall
    assert level == pytest.approx(plain_level, rel=0.01)
    assert np.abs(drive).max() <= actuator.peak
    window = round(actuator.window_s * RATE)
    assert highest_mean_square(drive, window) <= actuator.mean_square


def test_with_headroom_below_the_peak_the_motion_is_exactly_that_of_the_lower_q():
    c2 = measured("c2")
    roomy = changed(c2, drive__peak=100.0, drive__full_scale=100.0, drive__rated_rms=0.01)
    signal = burst(250.0, 0.1, 0.1, 1e-3)
    drive, _ = driven(roomy, signal)
    wanted = changed(c2, resonance__rise_ms=c2.rise_ms / 4.0)
    moved, expected = motion(c2, drive), motion(wanted, roomy.nominal * signal)
    # the same pole pair; where the zero of the held input lies moves the phase a little
    scale = (moved @ expected) / (expected @ expected)
    assert scale == pytest.approx(4.0, rel=0.02)
    assert np.abs(moved - scale * expected).max() < 0.02 * np.abs(moved).max()


@given(
    st.floats(20.0, 2000.0),
    st.floats(0.6, 100.0),
    st.floats(1.0, 16.0),
    st.sampled_from((8000.0, 44_100.0, 192_000.0)),
)
def test_overdrive_keeps_the_level_at_the_resonance(frequency, q, overdrive, rate):
    values = {
        **load_actuator("voice_coil").values,
        "resonance.frequency_hz": frequency,
        "resonance.q": q,
        "resonance.tolerance_percent": 0.0,
        "shaping.overdrive": overdrive,
        "shaping.perceptual_weighting": False,
    }
    sharp = Actuator("a", "a", "a", values)
    seconds = (12.0 * q / np.pi + 9.0) / frequency
    assume(seconds * rate < 1e6)
    tone = 0.05 * np.sin(2.0 * np.pi * frequency / rate * np.arange(round(seconds * rate)))
    drive, _ = driven(sharp, tone, rate)
    part = round(8 * rate / frequency)
    turning = np.exp(-2j * np.pi * frequency / rate * np.arange(len(tone)))[-part:]
    window = np.hanning(part)
    gain = abs((drive[-part:] * turning) @ window) / abs((tone[-part:] * turning) @ window)
    assert gain == pytest.approx(sharp.nominal, rel=0.02)


@pytest.mark.parametrize("frequency", [50.0, 80.0, 120.0, 175.0, 247.0, 320.0, 500.0, 800.0])
def test_perceptual_weighting_raises_what_the_skin_feels_less(frequency):
    coil = changed(load_actuator("voice_coil"), shaping__perceptual_weighting=True)
    tone = burst(frequency, 0.5, 0.0, 1e-3)
    drive, _ = driven(coil, tone)
    half = len(tone) // 2
    raised = 20.0 * np.log10(np.std(drive[half:]) / np.std(tone[half:]) / coil.nominal)
    assert raised == pytest.approx(-pacinian_db(frequency), abs=3.5)
    plain, _ = driven(changed(coil, shaping__perceptual_weighting=False), tone)
    assert np.allclose(plain, tone.astype(np.float32) * coil.nominal, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("name", actuator_names())
def test_a_rate_that_is_too_low_for_a_resonance_is_reported(name):
    with pytest.raises(ov.InputError, match=rf"actuator {name} needs a sample rate above \d+ Hz"):
        ActuatorStage(load_actuator(name), 150.0)


def test_a_carrier_that_the_actuator_hardly_answers_is_reported(match, football):
    with pytest.warns(ov.OverviewWarning, match=r"lra is felt \d+ dB less .* set that to 175 Hz"):
        ov.render(match, football, ov.pause(0.01), tail="none", actuator=load_actuator("lra"))


@pytest.mark.parametrize("name", ["c2", "cmf", "voice_coil", "dualsense", "headphones"])
def test_a_carrier_that_the_actuator_answers_is_not_reported(match, football, name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ov.render(match, football, ov.pause(0.01), tail="none", actuator=load_actuator(name))
