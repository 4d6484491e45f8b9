"""Perception of vibration by touch: just noticeable differences (JNDs), and pulses of a level.

A *pulse* is a peak of the felt level. `pulse_indices` finds peaks of a prominence of at least
`JND_DB` that are at least `MERGED_S` from any higher one. `touch_pulses` finds those that an
observer detects, by the millisecond.
"""

from __future__ import annotations

import math

import numpy as np

from overview_dsp.arrays import FloatArray, IntArray, SampleArray

JND_DB = 2.3  # just noticeable difference (JND) of amplitude (Israr and Tan 2006: 2.2 to 2.5 dB)
JND_DURATION = 1.25
JND_SHARPNESS = 2.0
MERGED_S = 0.030  # two pulses closer than this are felt as one
FALL_DB = 6.0


def ratio_jnds(first: float, second: float, step: float) -> float:
    """Return the difference of two values in ratios of `step`; NaN unless both are above 0."""
    if not (first > 0.0 and second > 0.0):
        return math.nan
    return abs(math.log(first / second)) / math.log(step)


PULSE_HOP_S = 0.002  # time between two levels in which pulses are sought, s


def pulse_indices(level: FloatArray) -> IntArray:
    """Return the indices of the pulses in a level (dB, one value per `PULSE_HOP_S`)."""
    from scipy.signal import find_peaks

    found, _ = find_peaks(level, prominence=JND_DB, distance=round(MERGED_S / PULSE_HOP_S))
    return np.asarray(found, dtype=np.int64)


def near_peak(level: FloatArray, peak: int, fall_db: float) -> int:
    """Return how many levels around a peak stay within `fall_db` of it, the peak included."""
    below = np.flatnonzero(level < level[peak] - fall_db)
    after = int(np.searchsorted(below, peak))
    first = below[after - 1] + 1 if after else 0
    return int((below[after] if after < len(below) else len(level)) - first)


TOUCH_FLOOR_DB = -50.0  # lowest level that a finger feels, dB of full scale

PULSE_PROMINENCE_DB = 2.5
"""Prominence of a pulse: a just noticeable step of amplitude on the skin (Israr and Tan 2006)."""

MIN_PULSE_GAP_MS = 30  # of two pulses nearer than this, only the higher one is detected

BEFORE_MS, AFTER_MS = 15.0, 40.0
"""A pulse belongs to an event from this long before the disk enters it to this long after."""

TRAILING_S = 0.15
"""Output after the disk turns back that still belongs to the outward stroke: its last pulse."""


def levels(signal: SampleArray, sample_rate: float, window_s: float, floor_db: float) -> FloatArray:
    """Return the RMS over a window around each millisecond, dB of full scale, above a floor."""
    energy = np.zeros(len(signal) + 1)
    np.cumsum(np.square(signal, dtype=np.float64), out=energy[1:])
    middle = np.arange(0.0, len(signal), sample_rate / 1000.0).astype(np.int64)
    half = int(window_s * sample_rate / 2.0)
    first, end = np.maximum(middle - half, 0), np.minimum(middle + half, len(signal))
    mean = (energy[end] - energy[first]) / (end - first)
    return np.asarray(np.maximum(10.0 * np.log10(mean + 1e-12), floor_db), dtype=np.float64)


def touch_pulses(level: FloatArray) -> IntArray:
    """Return the milliseconds of the pulses in a level that a finger detects."""
    return find_pulses(np.maximum(level, TOUCH_FLOOR_DB), PULSE_PROMINENCE_DB, TOUCH_FLOOR_DB + 3.0)


def find_pulses(level: FloatArray, prominence_db: float, lowest_db: float) -> IntArray:
    """Return the milliseconds of a level's prominent peaks, at least 30 ms from any higher one."""
    from scipy.signal import find_peaks

    rises, _ = find_peaks(level, prominence=prominence_db, height=lowest_db)
    # only a prominent peak hides a lower one near it
    alone = np.full(len(level), -np.inf)
    alone[rises] = level[rises]
    found, _ = find_peaks(alone, distance=MIN_PULSE_GAP_MS)
    return np.asarray(found, dtype=np.int64)
