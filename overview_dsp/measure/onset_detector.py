"""Onset detector: times at which a signal suddenly gets louder.

The signal is high-passed at 250 Hz to remove rumble. Its level is taken over 2 ms Hann windows
every 0.25 ms. An onset is a rise of the level by at least 9 dB over the highest of the 8 ms up to
1 ms before, above a floor. Its time is the steepest point of the rise, and its strength the highest
level of the 5 ms from there. Onsets closer than 5 ms count as one, at the steepest of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray, SampleArray
from overview_dsp.errors import InputError

HIGH_PASS_HZ = 250.0
WINDOW_S, HOP_S = 2e-3, 0.25e-3
BEFORE_S, GAP_S = 8e-3, 1e-3
RISE_DB = 9.0
MERGE_S = 5e-3
FLOOR_DB = -90.0


@dataclass(frozen=True, eq=False)
class Onsets:
    """Onsets of a signal in order of time.

    Attributes
    ----------
    time_s : float64 (onsets,)
        Times of the onsets, s.
    level_db : float64 (onsets,)
        RMS over 2 ms, dB of full scale.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> found = ov.measure.onsets(result.samples[:, 0], result.sample_rate)
    >>> len(found.time_s) == len(found.level_db)
    True
    """

    time_s: FloatArray
    level_db: FloatArray

    def __repr__(self) -> str:
        span = f", {self.time_s[0]:.3f} to {self.time_s[-1]:.3f} s" if len(self.time_s) else ""
        return f"<Onsets: {len(self.time_s)}{span}>"


def level_curve(signal: SampleArray, sample_rate: float) -> tuple[FloatArray, FloatArray]:
    """Return the times (s, window centres) and levels (dB) of the detector."""
    from scipy.signal import butter, fftconvolve, sosfilt

    data = validation.floats(signal, "signal")
    if not validation.positive(sample_rate, "sample_rate") > 2.0 * HIGH_PASS_HZ:
        raise InputError(
            f"sample_rate is {sample_rate:g} Hz; must be above {2 * HIGH_PASS_HZ:g} Hz"
        )
    if not len(data):
        return data, data
    sos = butter(4, HIGH_PASS_HZ, "highpass", fs=sample_rate, output="sos")
    data = sosfilt(sos, data)
    length = max(8, round(WINDOW_S * sample_rate))
    window = np.hanning(length + 2)[1:-1]
    energy = fftconvolve(data * data, window / window.sum(), mode="same")
    hop = max(1, round(HOP_S * sample_rate))
    at = np.arange(0, len(data), hop)
    return at / sample_rate, 10.0 * np.log10(np.maximum(energy[at], 1e-14))


def onsets(signal: SampleArray, sample_rate: float, floor_db: float = FLOOR_DB) -> Onsets:
    """Find the onsets of a signal, at which it suddenly gets louder.

    Parameters
    ----------
    signal : float32 (frames,)
        One channel.
    sample_rate : float
        Hz.
    floor_db : float
        Lowest level of an onset, dB of full scale.

    Returns
    -------
    Onsets
        Times and levels.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> found = ov.measure.onsets(result.samples[:, 0], result.sample_rate)
    >>> len(found.time_s) > 0
    True
    """
    from scipy.ndimage import maximum_filter1d

    floor_db = validation.real(floor_db, "floor_db")
    times, level = level_curve(signal, sample_rate)
    step = times[1] - times[0] if len(times) > 1 else HOP_S
    before, gap = round(BEFORE_S / step), round(GAP_S / step)
    # the highest level of the window [t - gap - before, t - gap]
    padded = np.concatenate([np.full(before + gap, level[0] if len(level) else 0.0), level])
    past = maximum_filter1d(padded, before + 1, origin=-(before // 2))[: len(level)]
    rising = (level - past >= RISE_DB) & (level > floor_db)
    edges = np.flatnonzero(rising & ~np.concatenate([[False], rising[:-1]]))
    slope = np.diff(level, prepend=level[:1])
    reach = round(MERGE_S / step)
    found: list[tuple[float, float]] = []
    sharpest = 0.0
    for edge in edges.tolist():
        first = max(0, edge - gap - 2)
        steepest = first + int(np.argmax(slope[first : edge + gap + 2]))
        time_s, strength = float(times[steepest]), float(level[steepest : steepest + reach].max())
        if found and time_s - found[-1][0] < MERGE_S:
            before_s, before_db = found.pop()
            strength = max(before_db, strength)
            # texture that begins just before a click is not its onset
            if slope[steepest] <= sharpest:
                found.append((before_s, strength))
                continue
        sharpest = float(slope[steepest])
        found.append((time_s, strength))
    return Onsets(*np.array(found, dtype=np.float64).reshape(-1, 2).T)
