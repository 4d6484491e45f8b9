"""The two signals: carrier, bandwidth, DC, ceiling, exact silence."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.parameters import KIND_PARAMETERS, MODE_PARAMETERS, SHAPES

CEILING = 10 ** (-1 / 20)


@pytest.mark.parametrize("rate", [8000.0, 44_100.0, 48_000.0, 192_000.0])
def test_the_carrier_is_250_hz(match, football, rate):
    engine = ov.Engine(football, match)
    engine.prepare(rate, 512)
    tone = engine.tactor_of(np.full(round(10 * rate), 0.01)).astype(float)[round(rate) :]
    ups = np.flatnonzero((tone[:-1] < 0) & (tone[1:] >= 0))
    times = ups - tone[ups] / (tone[ups + 1] - tone[ups])
    frequency = (len(times) - 1) / (times[-1] - times[0]) * rate
    assert frequency == pytest.approx(250.0, abs=1e-3)


@pytest.mark.parametrize("gesture", [ov.sweep(4.0), ov.sweep(6.0)])
def test_the_tactors_energy_lies_around_its_carrier(match, football, gesture):
    result = ov.render(match, football, gesture, trace=False)
    tactor = result.samples[:, 1].astype(float)
    power = np.abs(np.fft.rfft(tactor)) ** 2
    frequency = np.fft.rfftfreq(len(tactor), 1 / result.sample_rate)
    band = (frequency >= 150.0) & (frequency <= 350.0)
    assert power[band].sum() / power.sum() >= 0.95
    assert frequency[power.argmax()] == pytest.approx(250.0, abs=10.0)


@pytest.mark.parametrize("gesture", [ov.sweep(1.0), ov.sweep(4.0), ov.tap(1.0, 3.0)])
def test_there_is_no_dc(match, football, gesture):
    result = ov.render(match, football, gesture, trace=False)
    held = round(gesture.duration_s * result.sample_rate)
    for part in (result.samples, result.samples[:held]):
        # a window, as a cut through a cycle of the carrier has a mean of its own
        mean = np.average(part, axis=0, weights=np.hanning(len(part)))
        assert np.abs(mean).max() < 1e-4


@pytest.mark.parametrize("gesture", [ov.sweep(1.0), ov.sweep(4.0), ov.tap(1.0, 1.5)])
def test_the_demo_is_loud_but_never_at_the_ceiling_for_long(match, football, gesture):
    result = ov.render(match, football, gesture, trace=False)
    peaks = np.abs(result.samples).max(axis=0)
    assert np.all(peaks <= CEILING)
    assert np.all(peaks > 10 ** (-12 / 20))
    assert (np.abs(result.samples) > 0.98 * CEILING).mean() < 0.002


def values(known):
    if known.choices:
        return st.sampled_from(known.choices)
    edge = st.sampled_from([known.low, known.high])
    return edge | st.floats(known.low, known.high)


def modes():
    return st.builds(ov.ClickMode, **{key: values(known) for key, known in MODE_PARAMETERS.items()})


MODELLED = (
    "model",
    "stiffness",
    "damping",
    "static_ratio",
    "stribeck_speed",
    "break_away",
    "material",
    "pitch_hz",
)


def kinds():
    return st.builds(
        ov.EventKind,
        height=values(KIND_PARAMETERS["height"]),
        width_percent=values(KIND_PARAMETERS["width_percent"]),
        shape=st.sampled_from(SHAPES),
        gain_db=values(KIND_PARAMETERS["gain_db"]),
        modes=st.lists(modes(), max_size=6).map(tuple),
        **{key: values(KIND_PARAMETERS[key]) for key in MODELLED},
    )


@given(
    changes=st.fixed_dictionaries(
        {id: values(known) for id, known in ov.presets.PARAMETERS.items()}
    ),
    kind=kinds(),
    goal=kinds(),
    seed=st.integers(0, 10),
)
def test_any_preset_in_range_stays_finite_and_under_the_ceiling(
    match, football, changes, kind, goal, seed
):
    preset = replace(football, values=changes, kinds={"default": kind, "goal": goal})
    engine = ov.Engine(preset, match, seed=seed)
    engine.prepare(8000.0, 4000)
    for theta2, touching, at in (
        (3.0, True, 0), (0.5, True, 900), (2.0, False, 1500), (3.14, True, 2200),
    ):  # fmt: skip
        engine.control(theta2, touching, at)
    out = np.zeros((4000, 2), dtype=np.float32)
    trace = np.zeros((4000, 10))
    engine.process(out, trace)
    assert np.isfinite(out).all()
    assert np.isfinite(trace).all()
    assert np.abs(out).max() <= 10 ** (changes["output.ceiling_db"] / 20) * (1 + 1e-7)
    assert engine.meters.resets == 0


def test_the_ceiling_holds_at_the_loudest_settings(match, football):
    loud = football.with_changes(
        {
            "tactor.gain_db": 12.0,
            "click.gain_db": 12.0,
            "tactor.reference_torque_mnm": 0.1,
            "output.ceiling_db": -1.0,
        }
    )
    result = ov.render(match, loud, ov.tap(1.0, 1.0))
    peaks = np.abs(result.samples).max(axis=0)
    assert np.all(peaks <= CEILING)
    assert np.all(peaks > 0.95 * CEILING)
    assert result.engine.meters.limited_samples > 0


def test_an_untouched_engine_gives_exact_zeros(match, football):
    engine = ov.Engine(football, match)
    engine.prepare(48_000, 4096)
    out = np.full((4096, 2), np.nan, dtype=np.float32)
    engine.process(out)
    assert np.all(out == 0.0)
    assert math.copysign(1.0, float(out[-1, 0])) == 1.0
