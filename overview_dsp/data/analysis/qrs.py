"""Detection of QRS complexes in an ECG by shape and rhythm, and of noise that hides them.

Four passes over a part of a few minutes, each starting from the beats of the one before:

1. Similarity of each moment to a beat: the energy of the QRS band over 150 ms, times its
   correlation with the median of all beats found so far, over the usual height of a beat. The
   correlation distinguishes a beat from the motion of an electrode of the same height (averaged
   templates: Moody and Mark, "QRS morphology representation and noise estimation using the
   Karhunen-Loeve transform", Computers in Cardiology 1989; the band: Pan and Tompkins, IEEE Trans.
   Biomed. Eng. 32(3), 1985). From the second pass on, the signal is whitened by the noise between
   the beats, so that the correlation is a matched filter (Hamilton and Tompkins,
   "Adaptive matched filtering for QRS detection", Proc. IEEE EMBS 1988).
2. Sequence of the peaks with the greatest sum of heights over a threshold, less a cost for
   intervals that differ from the usual one (dynamic programming as in Ellis, "Beat
   tracking by dynamic programming", J. New Music Res. 36(1), 2007). The cost is small in
   a clean signal, so that arrhythmias are kept, and grows with the noise.

Beats of another shape (ventricular ones) are then searched beside them (`other_shapes`).
`tools/measure_beats.py` compares this detector with others. The constants were chosen by a random
search on other noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from overview_dsp.arrays import BoolArray, FloatArray, IntArray

REFRACTORY_S = 0.2  # minimum time between two beats
_WORK_HZ = 500.0  # signals of at least twice this rate are decimated
_BAND_HZ = (8.0, 30.0)
_WHITE_HZ = (4.0, 50.0)
"""Band of the whitened signal."""

_BEAT_S = 0.1  # distance from a beat up to which the signal does not count as noise
_FREE_S = 0.12  # distance from a beat up to which its similarity to itself does not count as noise
_SPECTRUM_S = 1.0
_LEAST_POWER = 1e-6
"""Minimum noise power, relative to its maximum, that limits the gain of the whitening."""

_HALF_S = 0.075  # half the window of a complex
_UNLIKE = 0.3  # weight of the energy of a peak that has no similarity to the beats
_LIKENESS_POWER = 2.4
_LEAST_HEIGHT = 0.15
_MOST_HEIGHT = 1.3
_THRESHOLD = (0.38, 0.55)
_INTERVAL_COST = (0.08, 0.8)
"""Minimum height of a beat, and maximum cost of an interval, in a clean and in a noisy signal."""

_NOISY_FROM = (0.3, 0.6)
"""Noise heights (as from `find_qrs`) below which a signal is clean, and above which it is noisy."""

_COST_PER_OCTAVE = 1.45
_INTERVAL_REACH_S = 3.0
_PASSES = 4
_AROUND = 8
"""Number of beats on either side to which a beat is compared."""

_WINDOW_S = 2.0  # time in which even a slow heart beats once
_SPLIT_WITHIN = 0.15
_SPLIT_HEIGHT = 0.92
_SPLIT_BELOW = 0.6
_SPLIT_NOISE = 0.15
"""A low beat that splits a usual interval in two and is lower than both neighbours is more likely a
peak of the noise: it does not count as a beat in the estimates, and is dropped in noise."""


@dataclass(frozen=True, eq=False)
class Search:
    """Beats of a part without missing samples.

    `beats`: positions of the R waves, in samples, ascending.
    `height`: similarity of each sample to a beat, relative to the usual height of a beat.
    `noise`: highest value between beats around each sample, relative to the same height.
    """

    beats: IntArray
    height: FloatArray
    noise: FloatArray


def decimated(part: FloatArray, rate: float) -> tuple[FloatArray, float, int]:
    """Return a part around its median at less than twice `_WORK_HZ`, its rate and the divisor."""
    from scipy.signal import resample_poly

    fewer = max(1, int(rate // _WORK_HZ))
    centred = part - np.median(part)
    if fewer > 1:
        centred = resample_poly(centred, 1, fewer)
    return centred, rate / fewer, fewer


def find_qrs(signal: FloatArray, rate: float) -> Search:
    """Find the beats of a signal from `decimated`, pointing up or down."""
    from scipy.signal import find_peaks

    band = band_passed(signal, rate, *_BAND_HZ)
    half, on_r = max(1, round(_HALF_S * rate)), round(0.05 * rate)
    norm = np.sqrt(np.maximum(summed(band**2, half), 0.0))
    beats = np.zeros(0, np.int64)
    height = _over_usual(norm, rate)
    for pass_number in range(_PASSES):
        peaks, _ = find_peaks(height, height=_LEAST_HEIGHT, distance=max(1, round(0.1 * rate)))
        if not len(peaks):
            return Search(beats, height, np.ones(len(signal)))
        noisy = np.ones(len(peaks))
        usual = np.full(len(peaks), np.nan)
        if len(beats) > 1:
            noise = noise_height(height, beats, rate)
            low, high = _NOISY_FROM
            noisy = np.clip((noise[peaks] - low) / (high - low), 0.0, 1.0)
            usual = usual_interval(beats, peaks)
        gain = np.minimum(height[peaks], _MOST_HEIGHT) - _between(_THRESHOLD, noisy)
        beats = peaks[
            _best_sequence(peaks / rate, gain, usual / rate, _between(_INTERVAL_COST, noisy))
        ]
        if pass_number == _PASSES - 1:
            break
        beats = beats[~_splitters(beats, height)]
        white = _whitened(signal, beats, rate)
        norm = np.sqrt(np.maximum(summed(white**2, half), 0.0))
        template = _template(
            white, _on_peaks(beats, band, on_r) if pass_number == 0 else beats, half
        )
        if template is None:
            break
        likeness = np.correlate(white, template, "same") / np.maximum(norm, 1e-12)
        alike = _UNLIKE + (1.0 - _UNLIKE) * np.clip(likeness, 0.0, 1.0) ** _LIKENESS_POWER
        height = _over_usual(norm * alike, rate)
    split = _splitters(beats, height)
    noise = noise_height(height, beats[~split], rate)
    beats = beats[~(split & (noise[beats] > _SPLIT_NOISE))]
    # move each beat to the largest sample of its wave
    return Search(_on_peaks(beats, band, max(1, round(0.02 * rate))), height, noise)


def _splitters(beats: IntArray, height: FloatArray) -> BoolArray:
    """Return which beats split a usual interval and are lower than their neighbours."""
    found = np.zeros(len(beats), np.bool_)
    if len(beats) < 4:
        return found
    both = (beats[2:] - beats[:-2]).astype(np.float64)
    lower = np.minimum(height[beats[:-2]], height[beats[2:]])
    low = height[beats[1:-1]] < np.minimum(_SPLIT_HEIGHT * lower, _SPLIT_BELOW)
    for _ in range(2):  # the usual interval, then again without the splitters
        usual = usual_interval(beats[~found], beats[1:-1])
        found[1:-1] = low & (np.abs(both / usual - 1.0) < _SPLIT_WITHIN)
    return found


def _best_sequence(
    at_s: FloatArray, gain: FloatArray, usual_s: FloatArray, cost: FloatArray
) -> IntArray:
    """Return the indices of the peaks that are beats: the path of greatest gain less cost.

    Each peak has a time, a gain, the usual interval (NaN = unknown) and a maximum interval cost.
    """
    total = gain.copy()
    before = np.full(len(gain), -1)
    first = np.searchsorted(at_s, at_s - _INTERVAL_REACH_S)
    last = np.searchsorted(at_s, at_s - REFRACTORY_S - 0.05, side="right")
    best_far, far, passed = -math.inf, -1, 0  # best peak more than the longest interval before
    for i in range(len(gain)):
        low, high = int(first[i]), int(last[i])
        while passed < low:
            if total[passed] > best_far:
                best_far, far = float(total[passed]), passed
            passed += 1
        previous, best = -1, 0.0
        if high > low:
            octaves = np.abs(np.log2((at_s[i] - at_s[low:high]) / usual_s[i]))
            deviation = np.minimum(_COST_PER_OCTAVE * octaves, 1.0)
            totals = total[low:high] - cost[i] * np.where(np.isnan(deviation), 0.0, deviation)
            nearest = int(np.argmax(totals))
            if totals[nearest] > best:
                previous, best = low + nearest, float(totals[nearest])
        if best_far - cost[i] > best:
            previous, best = far, best_far - float(cost[i])
        total[i] += best
        before[i] = previous
    path = []
    at = int(np.argmax(total))
    while at >= 0:
        path.append(at)
        at = int(before[at])
    return np.array(path[::-1], np.int64)


def _whitened(signal: FloatArray, beats: IntArray, rate: float) -> FloatArray:
    """Return the signal, filtered so that the noise between beats has a flat spectrum."""
    from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
    from scipy.signal import welch

    wide = band_passed(signal, rate, *_WHITE_HZ)
    reach = round(_BEAT_S * rate)
    beside = np.ones(len(wide), np.bool_)
    near = beats[:, None] + np.arange(-reach, reach + 1)
    beside[np.clip(near, 0, len(wide) - 1)] = False
    if not beside.any():
        return wide
    at = np.arange(len(wide))
    size = min(len(wide), round(_SPECTRUM_S * rate))
    hz, power = welch(np.interp(at, at[beside], wide[beside]), rate, nperseg=size)
    if not power.max() > 0.0:
        return wide
    length = next_fast_len(len(wide) + size, real=True)  # longer, for the tail of the filter
    each_hz = rfftfreq(length, 1.0 / rate)
    gain = 1.0 / np.sqrt(np.interp(each_hz, hz, np.maximum(power, _LEAST_POWER * power.max())))
    gain[(each_hz < _WHITE_HZ[0]) | (each_hz > _WHITE_HZ[1])] = 0.0
    return np.asarray(irfft(rfft(wide, length) * gain, length)[: len(wide)], dtype=np.float64)


def _template(band: FloatArray, beats: IntArray, half: int) -> FloatArray | None:
    """Return the median beat, normalised; None for too few beats."""
    at = beats[(beats >= 2 * half) & (beats < len(band) - 2 * half)]
    if len(at) < 3:
        return None
    shapes = band[at[:, None] + np.arange(-half, half + 1)]
    norms = np.linalg.norm(shapes, axis=1, keepdims=True)
    median = np.median(shapes / np.maximum(norms, 1e-12), axis=0)
    size = float(np.linalg.norm(median))
    return np.asarray(median / size) if size > 0.0 else None


def _on_peaks(at: IntArray, band: FloatArray, reach: int) -> IntArray:
    """Return the position of the largest value within `reach` of each position."""
    near = np.clip(at[:, None] + np.arange(-reach, reach + 1), 0, len(band) - 1)
    nearest = np.argmax(np.abs(band[near]), axis=1)
    return np.asarray(near[np.arange(len(at)), nearest], dtype=np.int64)


def noise_height(height: FloatArray, beats: IntArray, rate: float) -> FloatArray:
    """Return the height of the signal between beats, shape (n,): the usual maximum of 2 s."""
    rest = height.copy()
    reach = round(_FREE_S * rate)
    near = beats[:, None] + np.arange(-reach, reach + 1)
    rest[np.clip(near, 0, len(rest) - 1)] = 0.0
    return _along(around(_highest(rest, rate), 2, 60.0), len(rest), rate)


def _over_usual(height: FloatArray, rate: float) -> FloatArray:
    """Return heights relative to the usual beat around them."""
    usual = _along(around(_highest(height, rate), 5, 40.0), len(height), rate)
    return height / np.maximum(usual, 1e-12)


def _highest(height: FloatArray, rate: float) -> FloatArray:
    """Return the maximum of each `_WINDOW_S`; a shorter last one has at least the one before."""
    size = max(1, round(_WINDOW_S * rate))
    count = -(-len(height) // size)
    found = np.pad(height, (0, count * size - len(height))).reshape(count, size).max(axis=1)
    if count > 1 and len(height) % size:
        found[-1] = max(found[-1], found[-2])
    return np.asarray(found)


def _along(of_windows: FloatArray, length: int, rate: float) -> FloatArray:
    size = max(1, round(_WINDOW_S * rate))
    return np.interp(np.arange(length), (np.arange(len(of_windows)) + 0.5) * size, of_windows)


def usual_interval(beats: IntArray, at: IntArray) -> FloatArray:
    """Return the median interval around each of the positions `at`, in samples."""
    usual = around(np.diff(beats).astype(np.float64), _AROUND, 50.0)
    return np.interp(at, (beats[1:] + beats[:-1]) / 2.0, usual)


def around(values: FloatArray, reach: int, percentile: float) -> FloatArray:
    """Return a percentile of each value and `reach` on either side."""
    padded = np.pad(values, reach, constant_values=np.nan)
    ordered = np.sort(np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1), axis=1)
    # NaN is sorted to the end; np.nanpercentile is 30 times slower
    place = (np.count_nonzero(np.isfinite(ordered), axis=1) - 1) * (percentile / 100.0)
    below, rows = place.astype(np.int64), np.arange(len(ordered))
    low, high = ordered[rows, below], ordered[rows, np.ceil(place).astype(np.int64)]
    return np.asarray(low + (high - low) * (place - below), dtype=np.float64)


def summed(values: FloatArray, half: int) -> FloatArray:
    """Return the sum over each value and `half` on either side."""
    total = np.concatenate([np.zeros(half + 1), np.cumsum(values), np.zeros(half)])
    total[len(total) - half :] = total[len(total) - half - 1]
    return np.asarray(total[2 * half + 1 :] - total[: len(values)])


def _between(ends: tuple[float, float], part: FloatArray) -> FloatArray:
    return ends[0] + (ends[1] - ends[0]) * part


def band_passed(signal: FloatArray, rate: float, low: float, high: float) -> FloatArray:
    """Return a signal's band from `low` to `high` Hz, without delay."""
    from scipy.signal import butter, sosfiltfilt

    sections = butter(2, (low, min(high, 0.45 * rate)), "bandpass", fs=rate, output="sos")
    return np.asarray(sosfiltfilt(sections, signal), dtype=np.float64)
