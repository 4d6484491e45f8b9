"""Hypothesis strategies for actuators, drawn from the parameter table's own ranges."""

from __future__ import annotations

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from overview_dsp.errors import InputError
from overview_dsp.signal.actuators.model import (
    ACTUATOR_PARAMETERS,
    MAX_CALIBRATION_DB,
    ONE_OF,
    Actuator,
)


@st.composite
def actuators(draw: st.DrawFn, longest_burst_ms: float | None = None) -> Actuator:
    """Any valid actuator."""
    said = draw(st.sampled_from(ONE_OF))
    values = {}
    for id, known in ACTUATOR_PARAMETERS.items():
        if id in ONE_OF and id != said:
            continue
        if id == "resonance.tolerance_percent":
            values[id] = draw(st.sampled_from((0.0, 0.5, 10.0)))
        elif known.choices:
            values[id] = draw(st.sampled_from(known.choices))
        else:
            high = known.high
            if id == "drive.burst_ms" and longest_burst_ms is not None:
                high = longest_burst_ms
            values[id] = draw(st.floats(known.low, high))
    if draw(st.booleans()):
        del values["drive.full_scale"]
    values["drive.peak"] = max(values["drive.peak"], values["drive.rated_rms"])
    gain = draw(st.floats(-MAX_CALIBRATION_DB, MAX_CALIBRATION_DB))
    try:
        return Actuator("drawn", "drawn", "drawn", values, gain_db=gain)
    except InputError:  # a bandwidth or rise that makes no q
        assume(False)
        raise


def signals(actuator: Actuator, rate: float, frames: int) -> dict[str, np.ndarray]:
    """What heats an actuator most, float64."""
    noise = np.random.default_rng(1).uniform(-1.0, 1.0, frames)
    tone = np.sin(2.0 * np.pi * actuator.resonance_hz / rate * np.arange(frames))
    gate = np.sin(2.0 * np.pi * np.arange(frames) / (0.3 * frames)) > 0.0
    broken = np.where(noise > 0.9, np.nan, np.where(noise < -0.9, np.inf, noise * 1e30))
    return {
        "noise": noise * 100.0,
        "tone": tone,
        "square": np.sign(tone) * 1e6,
        "bursts": np.sign(tone) * 1e3 * gate,
        "constant": np.full(frames, -1e30),
        "broken": broken,
    }
