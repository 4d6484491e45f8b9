"""Detection of heartbeats: QRS complexes (`qrs`), or pulse waves by Elgendi's method.

A signal is an ECG if much of its power is in the band of QRS complexes (8 to 30 Hz), and a pulse
wave (PPG, blood pressure) if nearly all of it is below.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.analysis.heart_signal import Signal, SilenceFinder, Spans, runs
from overview_dsp.data.analysis.qrs import REFRACTORY_S, band_passed, find_qrs

BLOCK_S = 300.0
MARGIN_S = 15.0
"""Overlap of a block with its neighbours, in which the thresholds of the detector settle."""

MIN_PART_S = 2.0
"""Minimum length of a part between two gaps, for the thresholds of the detector."""

MIN_RATE = 50.0
"""Minimum sample rate for the shape of a heartbeat, Hz."""

_PULSE_BELOW = 0.1
"""A pulse wave's power from 8 to 30 Hz over that from 0.7 to 8 Hz; measured: 0.0002 (PPG), 0.7 to
1.9 (four ECGs)."""

NOISY_ABOVE = 0.7
"""Highest value between beats, relative to the height of a beat, above which beats can't be
distinguished from noise."""

_DOUBTFUL_ABOVE = 0.4
"""Above this value, noise alone may look like beats: 1 in 100 stretches of ten seconds of noise is
below. A heart is above it for ten seconds at 6 dB signal-to-noise ratio or less."""

_DOUBTFUL_S = 12.0
"""Minimum length of a stretch of mostly doubtful beats that counts: noise does not look like a
heart for this long."""

_LEAST_NOISY_S = 4.0
"""Minimum length of a noisy stretch that becomes a gap."""

_LEAST_CLEAN_S = 6.0
"""Minimum length of a clean stretch between two noisy ones; a shorter one is joined with them."""

Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Detection:
    """Result of a search for beats.

    Attributes
    ----------
    beats : int64 (n,)
        Sample numbers, ascending.
    silent
        Stretches without signal.
    noisy
        Stretches in which noise hides the beats; they contain none of `beats`.
    lost
        Number of missing samples outside of these, which were interpolated.
    what
        `ECG` or `pulse wave`.
    """

    beats: Indices
    silent: Spans
    noisy: Spans
    lost: int
    what: str


def find_beats(
    signal: Signal,
    what: str | None = None,
    progress: Callable[[float], None] = lambda part: None,
    *,
    gaps: bool = True,
) -> Detection:
    """Search a signal block by block.

    Parameters
    ----------
    signal
        Signal with a sample rate of at least `MIN_RATE`.
    what
        `ECG` or `pulse wave`; None = detected from its spectrum.
    progress
        Called with the finished fraction, 0 to 1.
    gaps
        Whether beats in noise are left out; False for comparisons with other detectors.

    Raises
    ------
    InputError
        The signal can't be read.
    """
    finder = SilenceFinder(signal.rate)
    block, margin = round(BLOCK_S * signal.rate), round(MARGIN_S * signal.rate)
    found: list[int] = []
    noisy: Spans = []
    doubtful: Spans = []
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
            if what == "ECG":
                beats, noise = find_qrs(part, signal.rate)
                noisy += _shifted(runs(noise > NOISY_ABOVE), low + begin, first, end)
                doubtful += _shifted(runs(noise > _DOUBTFUL_ABOVE), low + begin, first, end)
            else:
                beats = _pulses(part, signal.rate)
            for beat in (beats + low + begin).tolist():
                if first <= beat < end and (not found or beat - found[-1] >= near):
                    found.append(beat)
        progress(end / signal.length)
    noisy = _merged_noise(noisy, doubtful, signal.length, signal.rate) if gaps else []
    clear = [beat for beat in found if not any(begin <= beat < stop for begin, stop in noisy)]
    return Detection(np.array(clear, np.int64), finder.finish(), noisy, finder.lost, what or "ECG")


def _shifted(spans: Spans, by: int, first: int, end: int) -> Spans:
    """Return spans shifted by `by` samples and cut to `first` and `end`."""
    moved = [(max(begin + by, first), min(stop + by, end)) for begin, stop in spans]
    return [(begin, stop) for begin, stop in moved if begin < stop]


def _merged_noise(noisy: Spans, doubtful: Spans, length: int, rate: float) -> Spans:
    """Return noisy stretches without short ones, merged where beats between them are doubtful."""
    joined: Spans = [(0, 0)]
    for begin, stop in [*noisy, (length, length)]:
        clear = begin - joined[-1][1]
        short = clear < _LEAST_CLEAN_S * rate and joined[-1][1] > 0 and begin < length
        if not short and clear < _DOUBTFUL_S * rate:
            unsure = _shifted(doubtful, 0, joined[-1][1], begin)
            short = 2 * sum(last - at for at, last in unsure) > clear
        if short:
            joined[-1] = (joined[-1][0], stop)
        else:
            joined.append((begin, stop))
    return [(begin, stop) for begin, stop in joined if stop - begin >= _LEAST_NOISY_S * rate]


def silent_parts(
    signal: Signal, progress: Callable[[float], None] = lambda part: None
) -> tuple[Spans, int]:
    """Return the stretches without signal, and the number of missing samples outside of them."""
    finder = SilenceFinder(signal.rate)
    block = round(BLOCK_S * signal.rate)
    for first in range(0, signal.length, block):
        end = min(first + block, signal.length)
        finder.feed(signal.read(first, end))
        progress(end / signal.length)
    return finder.finish(), finder.lost


def _clean_parts(samples: NDArray[np.float64], rate: float) -> Spans:
    """Return the parts with signal that are long enough to search."""
    finder = SilenceFinder(rate)
    finder.feed(samples)
    usable = np.ones(len(samples), np.bool_)
    for first, end in finder.finish():
        usable[first:end] = False
    return [(first, end) for first, end in runs(usable) if end - first >= MIN_PART_S * rate]


def _bridged(part: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the part with missing samples interpolated, for the filters of the detector."""
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


def _pulses(part: NDArray[np.float64], rate: float) -> Indices:
    """Return the positions of the systolic peaks.

    Elgendi et al., "Systolic peak detection in acceleration photoplethysmograms", PLoS ONE 8(10),
    2013: where the squared signal's mean over a peak (111 ms) exceeds that over a beat (667 ms).
    """
    band = band_passed(part, rate, 0.5, 8.0)
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
