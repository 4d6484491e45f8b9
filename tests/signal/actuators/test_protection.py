"""No preset, gain or parameter passes what an actuator may be given."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.signal.actuators.library import actuator_names, load_actuator
from tests.design.presets.strategies import presets
from tests.profiles import share
from tests.signal.actuators.driving import (
    RATE,
    ROUNDING,
    burst,
    changed,
    driven,
    highest_mean_square,
)
from tests.signal.actuators.strategies import actuators, signals

KINDS = ("noise", "tone", "square", "bursts", "constant", "broken")


def held(actuator, drive, rate):
    assert np.isfinite(drive).all()
    assert np.abs(drive).max(initial=0.0) <= actuator.peak
    window = max(1, round(actuator.window_s * rate))
    assert highest_mean_square(drive, window) <= actuator.mean_square * ROUNDING


@pytest.mark.parametrize("name", actuator_names())
@pytest.mark.parametrize("kind", KINDS)
def test_no_drive_passes_a_bundled_actuators_peak_or_rating(name, kind):
    actuator = load_actuator(name)
    frames = round(1.5 * actuator.window_s * 8000)
    drive, _ = driven(actuator, signals(actuator, 8000, frames)[kind], 8000)
    held(actuator, drive, 8000)
    # and it isn't kept by giving nothing: most of what is allowed is used
    assert highest_mean_square(drive, frames) > 0.4 * actuator.mean_square


@given(
    actuators(longest_burst_ms=400.0),
    st.sampled_from((4500.0, 8000.0, 44_100.0, 192_000.0)),
    st.sampled_from(KINDS),
)
def test_no_drive_passes_any_actuators_peak_or_rating(actuator, rate, kind):
    drive, _ = driven(actuator, signals(actuator, rate, 20_000)[kind], rate)
    held(actuator, drive, rate)


FAINT = changed(
    load_actuator("c2"),
    drive__rated_rms=1e-4,
    drive__peak=1e4,
    drive__full_scale=1e4,
    drive__duty=0.01,
    drive__burst_ms=60_000.0,
)
"""As little heat a sample as there can be."""


@example(FAINT, 768_000.0, "tone")
@given(actuators(), st.sampled_from((4500.0, 768_000.0)), st.sampled_from(KINDS))
def test_the_heat_of_any_actuator_is_kept_and_never_passes_its_limit(actuator, rate, kind):
    """Windows of hours too: sum(y**2) = (heat now - heat then) / leak + sum(heat)."""
    drive, stage = driven(actuator, signals(actuator, rate, 5000)[kind], rate)
    heat, limit, leak = (
        stage._memory[column] for column in (layout.ACT_HEAT, layout.ACT_LIMIT, layout.ACT_LEAK)
    )
    assert heat <= limit
    window = actuator.window_s * rate
    assert limit * (1.0 / leak + window) <= actuator.mean_square * window
    # nothing of it is lost but by its leak
    kept = leak * (1.0 - leak) ** np.arange(len(drive))[::-1]
    assert heat == pytest.approx(np.sum(np.square(drive) * kept), rel=1e-5, abs=0.0)


@given(
    presets(max_kinds=2),
    actuators(longest_burst_ms=100.0),
    st.floats(0.05, 0.3),
)
def test_no_preset_passes_an_actuators_peak_or_rating(match, preset, actuator, seconds):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = ov.render(
            match, preset, ov.sweep(seconds), 8000, tail=0.1, trace=False, actuator=actuator
        )
    held(actuator, result.samples[:, 1].astype(float), 8000)


def test_a_drive_within_the_rating_is_not_taken_back():
    c2 = changed(load_actuator("c2"), shaping__overdrive=1.0)
    signal = burst(250.0, 2.0, 0.1, amplitude=0.8).astype(np.float32)
    drive, stage = driven(c2, signal)
    assert stage.protected.reduction_db == 0.0
    assert np.allclose(drive, signal.astype(float) * np.sqrt(0.5), rtol=1e-6, atol=1e-9)


def test_a_drive_that_heats_is_taken_back_smoothly_and_given_back_when_it_has_cooled():
    c2 = changed(load_actuator("c2"), shaping__overdrive=1.0)
    loud = burst(250.0, 1.0, 3.0, amplitude=6.0)
    drive, stage = driven(c2, np.concatenate([loud, burst(250.0, 0.05, 0.0, amplitude=0.5)]))
    assert stage.protected.reduction_db > 6.0
    crest = np.abs(drive[:RATE]).reshape(-1, RATE // 250).max(axis=1)
    # a few carrier periods for what a person tells apart at all
    assert np.abs(np.diff(20.0 * np.log10(crest))).max() < 2.5
    assert np.abs(drive[-RATE // 100 :]).max() == pytest.approx(0.5 * c2.nominal, rel=1e-3)


@pytest.mark.parametrize("name", actuator_names())
@pytest.mark.parametrize("kind", ["noise", "square", "constant"])
def test_heat_is_taken_back_before_the_last_limit_has_to_cut(name, kind):
    """The last limit is a hard one: it is there for a proof, not to be heard."""
    actuator = load_actuator(name)
    drive, stage = driven(actuator, signals(actuator, RATE, 4 * RATE)[kind][: 4 * RATE])
    memory = stage._memory
    assert memory[layout.ACT_HEAT] < memory[layout.ACT_LIMIT]
    power = np.square(np.abs(drive))
    # nothing falls to nothing from one sample to the next
    assert power[-RATE:].max() > 0.0
    left = np.sqrt(1.0 - memory[layout.ACT_TAKEN])
    assert left > 0.05


def test_a_cold_actuator_bears_most_of_a_burst_at_its_rating():
    cmf = load_actuator("cmf")
    assert cmf.window_s == pytest.approx(5.0)
    drive, _ = driven(cmf, burst(230.0, 0.5, 0.0))
    crest = np.abs(drive).reshape(-1, 480).max(axis=1)
    whole = (crest > 0.7 * cmf.nominal).mean()
    assert whole > 0.4  # of half a second


@settings(max_examples=share(0.5))
@given(st.lists(st.integers(1, 900), min_size=1, max_size=60), st.sampled_from(actuator_names()))
def test_no_partition_changes_a_bit(sizes, name):
    actuator = load_actuator(name)
    signal = signals(actuator, RATE, 12_000)["bursts"]
    assert np.array_equal(driven(actuator, signal)[0], driven(actuator, signal, sizes=sizes)[0])


@pytest.mark.parametrize("name", actuator_names())
def test_silence_in_gives_exact_zeros_in_the_end(name):
    actuator = changed(load_actuator(name), shaping__perceptual_weighting=True)
    drive, stage = driven(actuator, burst(250.0, 0.2, 0.5, amplitude=20.0))
    assert drive.any()
    assert not drive[-RATE // 10 :].any()
    assert stage.silent_samples >= RATE // 10
    memory = stage._memory
    for column in (layout.ACT_POSITION, layout.ACT_SPEED, layout.ACT_W_DELAY_1):
        assert memory[column] == 0.0
