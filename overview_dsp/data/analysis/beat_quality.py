"""Kind of a heart recording, and an index of whether its beats can be trusted.

The weights of the index were fitted by logistic regression to noise on other records:
docs/explanation/hearts.md states its accuracy.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import BoolArray, FloatArray, IntArray
from overview_dsp.data.analysis.qrs import Search, around

_BEAT_S = 0.6
_SHARP_HZ = 8.0
_MOST_HZ = 30.0
_LEAST_SHARP = 0.12
_SURELY_SHARP = 1.0
"""Minimum power of an ECG's average beat from 8 to 30 Hz, relative to that below, and the power
above which it is hardly a pulse wave."""

_PULSE_NOISE = 0.25
_MOST_PULSE_NOISE = 0.75
_SURE_PULSE = 0.95
"""Minimum noise of a pulse wave that is searched as an ECG (the second one where sharp waves were
found), and minimum median likeness of its pulses (an ECG in noise: up to 0.91)."""

WINDOW_S = 8  # time over which the index is computed
LIMIT = -1.0
STRICT_LIMIT = -2.5
"""Index above which beats can't be trusted; the second one if more than half of a recording is
above the first."""

_LEAST_BEATS = 3
# free: share of peaks that are no beats; odd: deviation of intervals; spread: of heights
_WEIGHTS = {"": -6.08, "noise": 3.6, "free": 4.33, "odd": 8.09, "spread": 4.33}
_FREE_HEIGHT = 0.5
_FREE_APART_S = 0.25
_PARTNER_S = 0.08

_PULSE_WINDOW_S = 10
_PULSE_S = (0.15, 0.35)
_PULSE_FREE = 0.1
_PULSE_LIKENESS = 0.65
_PULSE_ODD = 0.25
"""Maximum share of peaks without a beat, minimum likeness to the median pulse (20th percentile),
and maximum deviation of intervals, in octaves, of pulses that can be trusted."""


def is_ecg(signal: FloatArray, search: Search, rate: float, pulse_likeness: float) -> bool:
    """Return whether the beats that were searched as those of an ECG have its sharp waves.

    The noise of the averages of odd and of even beats is independent, so that their cross spectrum
    has the power of the beat only. In a pulse wave the search finds sharp noise instead, but the
    pulses are alike (`pulse_likeness`).
    """
    half = round(_BEAT_S / 2.0 * rate)
    beats = search.beats[(search.beats >= half) & (search.beats < len(signal) - half)]
    if len(beats) < 4:
        return False
    shapes = signal[beats[:, None] + np.arange(-half, half)]
    odd, even = (
        np.fft.rfft((mean - mean.mean()) * np.hanning(len(mean)))
        for mean in (shapes[::2].mean(axis=0), shapes[1::2].mean(axis=0))
    )
    power = (odd * even.conj()).real
    hz = np.fft.rfftfreq(2 * half, 1.0 / rate)
    sharp = power[(hz >= _SHARP_HZ) & (hz <= _MOST_HZ)].sum()
    slow = power[hz < _SHARP_HZ].sum()
    least = _PULSE_NOISE if sharp < _SURELY_SHARP * slow else _MOST_PULSE_NOISE
    a_pulse = pulse_likeness > _SURE_PULSE and float(np.median(search.noise)) > least
    return bool(sharp > max(0.0, _LEAST_SHARP * slow)) and not a_pulse


def ecg_doubt(search: Search, noise: FloatArray, others: IntArray, rate: float) -> FloatArray:
    """Return the index of each second of an ECG: above `LIMIT` if its beats can't be trusted.

    `search` is the result of `find_qrs`. `noise` (n,) is the height between all beats. `others` are
    the beats of another shape, which no term counts as wrong. `rate` is in Hz.
    """
    from scipy.signal import find_peaks

    height = search.height
    beats = search.beats[~_close_to(search.beats, others, 0.05 * rate)]
    reach = max(1, round(0.03 * rate))
    near = np.clip(beats[:, None] + np.arange(-reach, reach + 1), 0, len(height) - 1)
    tall = height[near].max(axis=1) if len(beats) else np.zeros(0)
    peaks, _ = find_peaks(height, _FREE_HEIGHT, distance=max(1, round(_FREE_APART_S * rate)))
    peaks = peaks[~_close_to(peaks, others, 0.2 * rate)]
    sums = _Windows(len(height), rate, WINDOW_S)
    level = sums.mean(np.arange(len(noise)), np.minimum(noise, 1.5))
    free = _free(sums, beats, peaks, rate)
    middle, octaves = _octaves(beats, others)
    odd = sums.mean(middle, octaves)
    log = np.log(tall + 0.05)
    variance = sums.mean(beats, log**2) - sums.mean(beats, log) ** 2
    spread = np.minimum(np.sqrt(np.maximum(variance, 0.0)), 1.0)
    found = (
        _WEIGHTS[""]
        + _WEIGHTS["noise"] * level
        + _WEIGHTS["free"] * free
        + _WEIGHTS["odd"] * odd * np.minimum(1.0, level / 0.4)
        + _WEIGHTS["spread"] * spread
    )
    found[sums.count(np.concatenate([beats, others])) < _LEAST_BEATS * sums.part] = np.inf
    return found


def pulse_likeness(band: FloatArray, beats: IntArray, rate: float) -> tuple[IntArray, FloatArray]:
    """Return the pulses inside a band-passed part, and their likeness to the median pulse."""
    low, high = (round(s * rate) for s in _PULSE_S)
    inside = beats[(beats >= low) & (beats < len(band) - high)]
    if not len(inside):
        return inside, np.zeros(0)
    shapes = band[inside[:, None] + np.arange(-low, high)]
    shapes = shapes - shapes.mean(axis=1, keepdims=True)
    shapes /= np.maximum(np.linalg.norm(shapes, axis=1, keepdims=True), 1e-12)
    median = np.median(shapes, axis=0)
    return inside, shapes @ (median / max(float(np.linalg.norm(median)), 1e-12))


def pulse_doubt(band: FloatArray, beats: IntArray, rate: float) -> FloatArray:
    """Return the index of each second of a pulse wave: above 0 if its beats can't be trusted."""
    from scipy.signal import find_peaks

    sums = _Windows(len(band), rate, _PULSE_WINDOW_S)
    inside, likeness = pulse_likeness(band, beats, rate)
    if len(inside) < 3:
        return np.full(sums.seconds, np.inf)
    usual = float(np.median(np.diff(beats)))
    # half an interval apart: without the dicrotic waves
    peaks, _ = find_peaks(band, 0.5 * np.median(band[beats]), distance=max(1, round(0.5 * usual)))
    free = _free(sums, beats, peaks, rate)
    unlike = sums.share(inside[likeness < _PULSE_LIKENESS], inside)
    odd = sums.mean(*_octaves(beats, beats[:0]))
    bad = (free > _PULSE_FREE) | (unlike > 0.2) | (odd > _PULSE_ODD)
    bad |= sums.count(beats) < _LEAST_BEATS * sums.part
    return np.where(bad, np.inf, -np.inf)


def _free(sums: _Windows, beats: IntArray, peaks: IntArray, rate: float) -> FloatArray:
    """Return the share of beats without a peak, and of peaks without a beat, among all."""
    partner = _PARTNER_S * rate
    lone = beats[~_close_to(beats, peaks, partner)], peaks[~_close_to(peaks, beats, partner)]
    return sums.share(np.concatenate(lone), np.concatenate([beats, peaks]))


def _octaves(beats: IntArray, others: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the middle of each interval without another beat, and its distance from the usual."""
    if len(beats) < 2:
        return np.zeros(0), np.zeros(0)
    steps = np.diff(beats).astype(np.float64)
    middle = (beats[1:] + beats[:-1]) / 2.0
    whole = np.searchsorted(others, beats[1:]) == np.searchsorted(others, beats[:-1])
    if not whole.any():
        return np.zeros(0), np.zeros(0)
    return middle[whole], np.abs(np.log2(steps[whole] / around(steps[whole], 8, 50.0)))


def _close_to(at: IntArray, others: IntArray, within: float) -> BoolArray:
    """Return which positions have one of `others` within a distance."""
    others = np.sort(others)
    low = np.searchsorted(others, at - within)
    return np.asarray(low < np.searchsorted(others, at + within, side="right"))


class _Windows:
    """Sums over a sliding window, for each second of a part; the window stays inside the part."""

    def __init__(self, length: int, rate: float, window_s: int) -> None:
        self.seconds = max(1, -(-length // max(1, round(rate))))
        self._rate = max(1, round(rate))
        size = min(window_s, self.seconds)
        self.part = size / window_s
        """Length of the windows, relative to `window_s`."""
        self._first = np.clip(np.arange(self.seconds) - size // 2, 0, self.seconds - size)
        self._end = self._first + size

    def count(self, at: NDArray[np.generic], values: FloatArray | None = None) -> FloatArray:
        """Return the sum of values at positions, or the number of positions."""
        second = np.minimum(np.asarray(at, np.int64) // self._rate, self.seconds - 1)
        each = np.bincount(second, values, self.seconds)
        total = np.concatenate([[0.0], np.cumsum(each)])
        return np.asarray(total[self._end] - total[self._first])

    def mean(self, at: NDArray[np.generic], values: FloatArray) -> FloatArray:
        """Return the mean of values at positions, 0 without one."""
        return self.count(at, values) / np.maximum(self.count(at), 1.0)

    def share(self, marked: NDArray[np.generic], of: NDArray[np.generic]) -> FloatArray:
        """Return the number of marked positions relative to that of all."""
        return self.count(marked) / np.maximum(self.count(of), 1.0)
