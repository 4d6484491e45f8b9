"""Test signal for measuring an actuator."""

from __future__ import annotations

import math

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.errors import InputError
from overview_dsp.kernels.decibels import gain_of_db

EDGE_S = 0.01  # duration of the fade-in and fade-out of a test signal
LOWEST_HZ = 1.0
HIGHEST_PART = 0.45
MAX_SECONDS = 600.0
MIN_LEVEL_DB = -80.0


def log_sweep(
    low_hz: float, high_hz: float, seconds: float, level_db: float, sample_rate: float
) -> FloatArray:
    """Return a logarithmic sine sweep for measuring an actuator.

    Parameters
    ----------
    low_hz, high_hz : float
        First and last frequency, 1 Hz to 0.45 times the sample rate.
    seconds : float
        Duration, 0.1 to 600 s, with fades of 10 ms.
    level_db : float
        Amplitude, -80 to 0 dB relative to 1.
    sample_rate : float
        Hz.

    Returns
    -------
    float64 (frames,)
        One channel.

    Raises
    ------
    InputError
        A value is out of range.

    Examples
    --------
    >>> ov.actuators.log_sweep(100.0, 400.0, 1.0, level_db=-20.0, sample_rate=8000).shape
    (8000,)
    """
    low_hz, high_hz = validation.real(low_hz, "low_hz"), validation.real(high_hz, "high_hz")
    seconds, level_db = validation.real(seconds, "seconds"), validation.real(level_db, "level_db")
    sample_rate = validation.positive(sample_rate, "sample_rate")
    # each written so that NaN fails
    if not LOWEST_HZ <= low_hz < high_hz <= HIGHEST_PART * sample_rate:
        raise InputError(
            f"sweep is from {low_hz:g} to {high_hz:g} Hz; must rise within {LOWEST_HZ:g} to "
            f"{HIGHEST_PART * sample_rate:g} Hz"
        )
    validation.within(seconds, "sweep duration", 0.1, MAX_SECONDS, " s")
    validation.within(level_db, "level", MIN_LEVEL_DB, 0.0, " dB")
    frames = round(seconds * sample_rate)
    octaves = math.log(high_hz / low_hz)
    time = np.arange(frames) / sample_rate
    turns = low_hz * seconds / octaves * np.expm1(time * (octaves / seconds))
    swept = gain_of_db(level_db) * np.sin(2.0 * math.pi * turns)
    return swept * edges(frames, round(EDGE_S * sample_rate))


def edges(frames: int, length: int) -> FloatArray:
    """Return a gain of 1 with smooth fades of `length` frames from and to 0."""
    at = np.arange(frames)
    near = np.clip(np.minimum(at, frames - 1 - at) / length, 0.0, 1.0)
    return 0.5 - 0.5 * np.cos(math.pi * near)
