"""Detection of beats of another shape, such as ventricular ones, beside those of a QRS search.

The search for beats mistakes another frequent shape for noise. Here, peaks of a wider band that are
not beats are clustered by their correlation, since noise does not repeat a shape.
"""

from __future__ import annotations

import numpy as np

from overview_dsp.arrays import BoolArray, FloatArray, IntArray
from overview_dsp.data.analysis.qrs import REFRACTORY_S, around, band_passed, summed, usual_interval

_BAND_HZ = (4.0, 30.0)
_HALF_S = 0.075
_SNIPPET_S = 0.12
"""Half of the time that is compared."""

_LAG_S = 0.04  # maximum shift between two compared shapes
_ALIKE = 0.85  # minimum correlation within a class
_LEAST_COUNT = 3
_LEAST_PEAK = 0.45
_LEAST_SIZE = 0.75
_LEAST_LIKENESS = 0.945
"""Minimum size of the peaks, and of the median peak of a class, relative to the beats; minimum
median correlation with the median of the class."""

_LEAST_SHARE = 0.62  # minimum share of the peaks that the classes explain: the rest is noise
_BEATS_ALIKE = 0.82
"""Minimum of the 20th percentile of the beats' correlation with their median: above, shapes can be
compared."""

_T_WAVE_S = 0.42
_P_WAVE_S = 0.28
_WAVE_SPREAD_S = 0.04
"""Maximum time from a beat to its T wave, and from a P wave to its beat, and their deviation."""

_ROOM = 1.25
_BIGEMINY = 0.85
"""Minimum length of an interval with a beat of another shape, relative to the others; share of
intervals with such a beat above which the others are too few to compare."""

_PAUSE = 1.4
"""Minimum length of a pause in which a single peak is a beat, relative to the usual interval."""

_SINGLE_SIZE = 0.65  # minimum size of that peak, relative to the beats
_CLEAR_OF_NOISE = 1.8  # and relative to other peaks, if there are many
_MOST_PEAKS = 4000


def find_other_shapes(
    signal: FloatArray, beats: IntArray, rate: float
) -> tuple[IntArray, BoolArray, FloatArray]:
    """Find the beats of another shape beside those that were found in a signal of `qrs.decimated`.

    Return the positions of further beats, ascending; whether each of `beats` has another shape,
    too; and the size of each sample relative to the surrounding beats.
    """
    from scipy.signal import find_peaks

    none, differs = np.zeros(0, np.int64), np.zeros(len(beats), np.bool_)
    wide = band_passed(signal, rate, *_BAND_HZ)
    norm = np.sqrt(np.maximum(summed(wide**2, max(1, round(_HALF_S * rate))), 0.0))
    if len(beats) < 4:
        return none, differs, norm / max(float(norm.max()), 1e-12)
    usual_size = around(norm[beats], 8, 50.0)
    size = norm / np.maximum(np.interp(np.arange(len(norm)), beats, usual_size), 1e-12)
    beat_shapes = _snippets(wide, beats, rate)
    likeness = _likeness(beat_shapes, np.median(beat_shapes, axis=0), rate)
    if np.percentile(likeness, 20) < _BEATS_ALIKE:
        return none, differs, size
    likeness_around = np.stack([around(likeness, 2, 50.0), around(likeness, 8, 50.0)]).min(axis=0)
    differs = (likeness < 0.7) & (likeness_around > 0.9)
    apart = round(REFRACTORY_S * rate)
    peaks, _ = find_peaks(size, _LEAST_PEAK, distance=apart)
    peaks = peaks[np.abs(peaks - _nearest(beats, peaks)) > apart]
    if not len(peaks) or len(peaks) > _MOST_PEAKS:
        return none, differs, size
    at = np.searchsorted(beats, peaks)
    since = (peaks - beats[np.maximum(at - 1, 0)]) / rate
    until = (beats[np.minimum(at, len(beats) - 1)] - peaks) / rate
    alike, wave = _classes(_snippets(wide, peaks, rate), size[peaks], since, until, rate)
    rest = ~alike & ~wave
    if alike.sum() < _LEAST_SHARE * (alike.sum() + rest.sum()):
        alike[:] = False
    alike &= _in_long_intervals(beats, at, alike)
    # a single beat of another shape in a pause
    usual = usual_interval(beats, peaks)
    ends = np.concatenate([[0], beats, [len(signal)]])
    level = around(size[peaks], 8, 50.0)
    many = np.searchsorted(peaks, peaks + 10 * rate) - np.searchsorted(peaks, peaks - 10 * rate) > 4
    single = rest & (ends[at + 1] - ends[at] > _PAUSE * usual) & (size[peaks] > _SINGLE_SIZE)
    single &= ~many | (size[peaks] > _CLEAR_OF_NOISE * level)
    return peaks[alike | single], differs, size


def _in_long_intervals(beats: IntArray, at: IntArray, marked: BoolArray) -> BoolArray:
    """Return which peaks are in an interval that has room for a beat; `at`: index of the next beat.

    Noise also lies in ordinary intervals. In bigeminy all intervals are long.
    """
    steps = np.diff(beats)
    between = np.clip(at - 1, 0, len(steps) - 1)
    holds = np.zeros(len(steps), np.bool_)
    holds[between[marked]] = True
    if holds.mean() > _BIGEMINY:
        once = np.bincount(between[marked], minlength=len(steps)) == 1
        return np.full(len(at), bool(once.mean() > _BIGEMINY))
    long_ones = steps[between] >= _ROOM * np.median(steps[~holds])
    return np.asarray(long_ones & bool(np.median(long_ones[marked]) if marked.any() else False))


def _classes(
    shapes: FloatArray, size: FloatArray, since: FloatArray, until: FloatArray, rate: float
) -> tuple[BoolArray, BoolArray]:
    """Return which shapes are of a large and uniform class, and which are waves of a beat.

    `since` and `until`: time from and to the beat beside each shape, s.
    """
    found, wave = np.zeros(len(shapes), np.bool_), np.zeros(len(shapes), np.bool_)
    rest = np.arange(len(shapes))
    while len(rest) >= _LEAST_COUNT:
        seed = rest[np.argmax(size[rest])]
        members = rest[_likeness(shapes[rest], shapes[seed], rate) > _ALIKE]
        if len(members) >= _LEAST_COUNT:
            windows, correlation = _lagged(shapes[members], shapes[seed], rate)
            aligned = windows[np.arange(len(members)), correlation.argmax(axis=1)]
            middle = np.median(aligned, axis=0)
            likeness = float(np.median(_likeness(shapes[members], middle, rate)))
            large = float(np.median(size[members])) >= _LEAST_SIZE
            close = any(
                float(np.percentile(apart[members], 80)) < limit
                and float(np.std(apart[members])) < _WAVE_SPREAD_S
                for apart, limit in ((since, _T_WAVE_S), (until, _P_WAVE_S))
            )
            wave[members] = close and not large
            found[members] = large and likeness >= _LEAST_LIKENESS
        rest = np.setdiff1d(rest, np.append(members, seed))
    return found, wave


def _snippets(wide: FloatArray, at: IntArray, rate: float) -> FloatArray:
    """Return the signal around each position, with a margin for the lags."""
    reach = round((_SNIPPET_S + _LAG_S) * rate)
    padded = np.pad(wide, reach)
    return np.asarray(padded[at[:, None] + np.arange(2 * reach + 1)])


def _lagged(shapes: FloatArray, to: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    """Return the windows of each shape at each lag, and their correlation with the middle of `to`.

    Shapes (n, lags, samples) and (n, lags).
    """
    lag = max(1, round(_LAG_S * rate))
    middle = to[lag : len(to) - lag]
    windows = np.lib.stride_tricks.sliding_window_view(shapes, len(middle), axis=1)
    norms = np.linalg.norm(windows, axis=2) * np.linalg.norm(middle)
    return windows, (windows @ middle) / np.maximum(norms, 1e-12)


def _likeness(shapes: FloatArray, to: FloatArray, rate: float) -> FloatArray:
    if to.shape[0] < shapes.shape[1]:  # a median of aligned shapes has no margin
        lag = (shapes.shape[1] - to.shape[0]) // 2
        to = np.pad(to, lag)
    return np.asarray(_lagged(shapes, to, rate)[1].max(axis=1))


def _nearest(beats: IntArray, at: IntArray) -> IntArray:
    """Return the beat nearest to each position."""
    after = np.clip(np.searchsorted(beats, at), 1, len(beats) - 1)
    low, high = beats[after - 1], beats[after]
    return np.where(at - low <= high - at, low, high)
