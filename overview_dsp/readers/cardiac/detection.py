"""Beats in a signal: QRS complexes by SleepECG, pulse waves by Elgendi's method.

A signal is an ECG if a good part of its power lies where QRS complexes have theirs (8 to 30 Hz), a
pulse wave (PPG, blood pressure) if nearly all lies below. An ECG whose complexes point down is
turned over first.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.readers.cardiac.extra import needed
from overview_dsp.readers.cardiac.signal import Signal, SilenceFinder, Spans, runs

BLOCK_S = 300.0
MARGIN_S = 15.0
"""A block is searched with this much of its neighbours: the detector's thresholds settle in it."""

REFRACTORY_S = 0.2
"""No heart beats twice within it."""

MIN_PART_S = 2.0
"""A shorter part between two gaps is too short to learn thresholds in."""

MIN_RATE = 50.0
"""Samples a second a heartbeat's shape needs."""

_PULSE_BELOW = 0.1
"""A pulse wave's power from 8 to 30 Hz over that from 0.7 to 8 Hz; measured: 0.0002 (PPG), 0.7 to
1.9 (four ECGs)."""

_TURNED_BELOW = -0.25
"""Skewness of the QRS band that says the complexes point down."""

_RUN_IN_S = 10.0
"""A part is led in and out by its own mirror image: the detector learns its thresholds there."""

_LEAST_PART = 0.25
"""A beat is at least this much of those around it (their upper quartile), else it is a P wave or
noise: SleepECG lowers its thresholds without end where a beat is late."""

_SURE_PART = 0.5
"""What is this high in a pause is a beat: SleepECG is deaf for a while after a false one."""

_PAUSE = 1.4
"""A pause is this many times the usual interval around it."""

_AROUND = 8
"""Beats on either side that a beat is compared with."""

_DETECTOR_HZ = 100.0
"""SleepECG wants this rate or more."""

Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Detection:
    """What a search found.

    Attributes
    ----------
    beats : int64 (n,)
        Sample numbers, ascending.
    silent
        Stretches without signal.
    lost
        Missing samples outside of these, bridged.
    what
        `ECG` or `pulse wave`.
    """

    beats: Indices
    silent: Spans
    lost: int
    what: str


def find_beats(
    signal: Signal, what: str | None = None, progress: Callable[[float], None] = lambda part: None
) -> Detection:
    """Search a signal block by block.

    Parameters
    ----------
    signal
        Of `MIN_RATE` or more.
    what
        `ECG` or `pulse wave`; None = detected from its spectrum.
    progress
        Called with the part done, 0 to 1.

    Raises
    ------
    InputError
        SleepECG is not installed; what reading the signal raises.
    """
    finder = SilenceFinder(signal.rate)
    block, margin = round(BLOCK_S * signal.rate), round(MARGIN_S * signal.rate)
    turned: float | None = None
    found: list[int] = []
    near = REFRACTORY_S * signal.rate
    for first in range(0, signal.length, block):
        end = min(first + block, signal.length)
        low, high = max(0, first - margin), min(end + margin, signal.length)
        samples = signal.read(low, high)
        finder.feed(samples[first - low : end - low])
        for begin, stop in _clean_parts(samples, signal.rate):
            part = _bridged(samples[begin:stop])
            if what is None:
                what = "ECG" if _is_ecg(part, signal.rate) else "pulse wave"
            if turned is None:
                turned = -1.0 if what == "ECG" and _points_down(part, signal.rate) else 1.0
            search = _qrs if what == "ECG" else _pulses
            for beat in (search(part * turned, signal.rate) + low + begin).tolist():
                if first <= beat < end and (not found or beat - found[-1] >= near):
                    found.append(beat)
        progress(end / signal.length)
    return Detection(np.array(found, np.int64), finder.finish(), finder.lost, what or "ECG")


def silent_parts(
    signal: Signal, progress: Callable[[float], None] = lambda part: None
) -> tuple[Spans, int]:
    """Return the stretches without signal, and how many samples are missing outside of them."""
    finder = SilenceFinder(signal.rate)
    block = round(BLOCK_S * signal.rate)
    for first in range(0, signal.length, block):
        end = min(first + block, signal.length)
        finder.feed(signal.read(first, end))
        progress(end / signal.length)
    return finder.finish(), finder.lost


def _clean_parts(samples: NDArray[np.float64], rate: float) -> Spans:
    """Return the parts between stretches without signal that are long enough to search."""
    finder = SilenceFinder(rate)
    finder.feed(samples)
    usable = np.ones(len(samples), np.bool_)
    for first, end in finder.finish():
        usable[first:end] = False
    return [(first, end) for first, end in runs(usable) if end - first >= MIN_PART_S * rate]


def _bridged(part: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the part with its few missing samples interpolated, for the detector's filters."""
    known = np.isfinite(part)
    if known.all():
        return part
    positions = np.arange(len(part))
    return np.interp(positions, positions[known], part[known])


def _is_ecg(part: NDArray[np.float64], rate: float) -> bool:
    from scipy.signal import welch

    hz, power = welch(part - part.mean(), rate, nperseg=min(len(part), round(8.0 * rate)))
    sharp = power[(hz > 8.0) & (hz < 30.0)].sum()
    slow = power[(hz > 0.7) & (hz <= 8.0)].sum()
    return bool(sharp > _PULSE_BELOW * slow)


def _points_down(part: NDArray[np.float64], rate: float) -> bool:
    band = _band_passed(part, rate, 5.0, min(30.0, 0.45 * rate))
    spread = float(np.mean(band**2))
    return spread > 0.0 and float(np.mean(band**3)) < _TURNED_BELOW * spread**1.5


def _band_passed(
    part: NDArray[np.float64], rate: float, low: float, high: float
) -> NDArray[np.float64]:
    from scipy.signal import butter, sosfiltfilt

    sections = butter(2, (low, high), "bandpass", fs=rate, output="sos")
    return np.asarray(sosfiltfilt(sections, part), dtype=np.float64)


def _qrs(part: NDArray[np.float64], rate: float) -> Indices:
    """Return the R waves' positions."""
    from scipy.signal import resample_poly

    heartbeats = needed("sleepecg.heartbeats", "finding beats in an ECG")
    times = max(1, math.ceil(_DETECTOR_HZ / rate))
    # without its offset: the filter would ring on it at the ends
    mirrored = min(round(_RUN_IN_S * rate), len(part) - 1)
    led = np.pad(part - np.median(part), mirrored, mode="reflect")
    if times > 1:
        led = resample_poly(led, times, 1)
    found = heartbeats.detect_heartbeats(np.ascontiguousarray(led), rate * times)
    return _verified(np.asarray(found, np.int64) // times - mirrored, part, rate)


def _verified(positions: Indices, part: NDArray[np.float64], rate: float) -> Indices:
    """Return the beats that are as high as those around them, and those missed in pauses."""
    found = positions[(positions >= 0) & (positions < len(part))]
    if not len(found):
        return found
    # up or down: a beat from elsewhere may point the other way
    height = np.abs(_band_passed(part, rate, 5.0, min(30.0, 0.45 * rate)))
    reach = round(0.05 * rate)  # the detector's position is that of its own filter

    def heights(at: Indices) -> NDArray[np.float64]:
        return np.array([height[max(0, i - reach) : i + reach + 1].max() for i in at])

    usual = _around(heights(found), 75.0)
    kept = found[heights(found) >= _LEAST_PART * usual]
    return _with_missed(kept, height, float(np.median(usual)), rate)


def _with_missed(kept: Indices, height: NDArray[np.float64], usual: float, rate: float) -> Indices:
    """Return the beats and the high peaks between those that lie too far apart."""
    from scipy.signal import find_peaks

    if len(kept) < 3:
        return kept
    intervals = np.diff(kept)
    typical = _around(intervals.astype(np.float64), 50.0)
    edges = np.concatenate([[0], kept, [len(height)]])
    allowed = np.concatenate([typical[:1], typical, typical[-1:]]) * _PAUSE
    apart = round(REFRACTORY_S * rate)
    added = []
    for first, end, limit in zip(edges[:-1], edges[1:], allowed, strict=True):
        low = first + apart if first > 0 else 0
        high = end - apart if end < len(height) else end
        if end - first > limit and high > low:
            peaks, _ = find_peaks(height[low:high], height=_SURE_PART * usual, distance=apart)
            added.extend((peaks + low).tolist())
    return np.sort(np.concatenate([kept, np.array(added, np.int64)]))


def _around(values: NDArray[np.float64], percentile: float) -> NDArray[np.float64]:
    """Return a percentile of each value and `_AROUND` on either side."""
    padded = np.pad(values, _AROUND, constant_values=np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * _AROUND + 1)
    # no row is all NaN: the middle is a value
    return np.asarray(np.nanpercentile(windows, percentile, axis=1), dtype=np.float64)


def _pulses(part: NDArray[np.float64], rate: float) -> Indices:
    """Return the systolic peaks' positions.

    Elgendi et al., "Systolic peak detection in acceleration photoplethysmograms", PLoS ONE 8(10),
    2013: where the squared signal's mean over a peak (111 ms) exceeds that over a beat (667 ms).
    """
    band = _band_passed(part, rate, 0.5, 8.0)
    power = np.maximum(band, 0.0) ** 2
    peak, beat = (np.ones(round(s * rate) | 1) for s in (0.111, 0.667))
    over_peak = np.convolve(power, peak / len(peak), "same")[: len(power)]
    over_beat = np.convolve(power, beat / len(beat), "same")[: len(power)]
    above = over_peak > over_beat + 0.02 * power.mean()
    positions = [
        first + int(np.argmax(band[first:end]))
        for first, end in runs(above)
        if end - first >= 0.111 * rate
    ]
    return np.array(positions, np.int64)
