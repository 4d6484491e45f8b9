"""An actuator's profile into the memory block, and the coefficients that the kernels make of it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.kernels import layout
from overview_dsp.kernels.device.derive_actuator import SKIN_HZ, derive_actuator
from overview_dsp.signal.actuators.model import LOWEST_Q, Actuator

HIGHEST_PART = 0.45
"""A resonance must lie below this part of the sample rate."""


def write_actuator(
    memory: NDArray[np.float64],
    at: int,
    actuator: Actuator | None,
    sample_rate: float,
) -> None:
    """Put an actuator's coefficients into memory at `at`, its state as new; None: no actuator.

    Its heat stays: an output that is opened again finds it as warm as it was left. Before the
    audio runs.

    Raises
    ------
    InputError
        A resonance that the sample rate (Hz) is too low for.
    """
    if actuator is not None:
        _check_rate(actuator, actuator.resonance_hz, sample_rate)
        if actuator.values["shaping.equal_sensation"]:
            _check_rate(actuator, SKIN_HZ, sample_rate)
    heat = float(memory[at + layout.ACT_HEAT])
    memory[at : at + layout.ACT_SIZE] = 0.0
    if actuator is not None:
        for column, value in _given(actuator).items():
            memory[at + column] = value
        derive_actuator(memory, at, float(sample_rate))
    memory[at + layout.ACT_HEAT] = min(heat, float(memory[at + layout.ACT_LIMIT]))
    memory.view(np.int64)[at + layout.ACT_ON] = actuator is not None


def _given(actuator: Actuator) -> dict[int, float]:
    """What the coefficients are made of, by column."""
    return {
        layout.GIVEN_NOMINAL: actuator.nominal,
        layout.GIVEN_GAIN_DB: actuator.gain_db,
        layout.GIVEN_PEAK: actuator.peak,
        layout.GIVEN_MEAN_SQUARE: actuator.mean_square,
        layout.GIVEN_WINDOW_S: actuator.window_s,
        layout.GIVEN_DUTY: actuator.number("drive.duty"),
        layout.GIVEN_RESONANCE_HZ: actuator.resonance_hz,
        layout.GIVEN_Q: actuator.q,
        layout.GIVEN_SHARPENED_Q: max(LOWEST_Q, actuator.q / actuator.number("shaping.sharpen")),
        layout.GIVEN_EQUAL_SENSATION: float(bool(actuator.values["shaping.equal_sensation"])),
    }


def _check_rate(actuator: Actuator, frequency_hz: float, sample_rate: float) -> None:
    # written so that NaN fails
    if not frequency_hz / HIGHEST_PART < sample_rate < math.inf:
        raise InputError(
            f"actuator {actuator.name} needs a sample rate above "
            f"{frequency_hz / HIGHEST_PART:.0f} Hz, not {sample_rate:g}"
        )
