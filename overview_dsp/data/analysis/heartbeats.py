"""Detection of heartbeats: QRS complexes (`qrs`), or pulse waves by Elgendi's method.

A signal is an ECG if its average beat has sharp waves (8 to 30 Hz), and a pulse wave (PPG, blood
pressure) if its pulses resemble each other; otherwise it is neither. Stretches whose beats can't be
trusted are noisy.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from overview_dsp.arrays import BoolArray, FloatArray, IntArray
from overview_dsp.data.analysis import beat_quality, qrs
from overview_dsp.data.analysis.heart_signal import Signal, SilenceFinder
from overview_dsp.data.analysis.other_shapes import find_other_shapes
from overview_dsp.data.analysis.runs import Spans, merged, runs

BLOCK_S = 300.0
MARGIN_S = 15.0
"""Overlap of a block with its neighbours, in which the thresholds of the detector settle."""

MIN_PART_S = 2.0  # minimum length of a part between two gaps, for the thresholds of the detector
MIN_RATE = 50.0  # minimum sample rate for the shape of a heartbeat, Hz
_AROUND_S = 1.5  # time on either side of a noisy stretch that counts as noisy, too
_LEAST_NOISY_S = 2.0  # minimum length of a noisy stretch that becomes a gap
_LEAST_CLEAN_S = 6.0
"""Minimum length of a trusted stretch between two noisy ones; a shorter one is joined with them."""

_HIDDEN_HEIGHT = 0.35
_HIDDEN_RATIO = 1.25
"""Height of a peak, relative to a beat and to the highest peaks of the neighbouring intervals, from
which the peak may be a beat."""


@dataclass(frozen=True, eq=False)
class Detection:
    """Result of a search for beats.

    `beats`: sample numbers, ascending.
    `silent`: stretches without signal.
    `noisy`: stretches in which noise hides the beats; they contain none of `beats`.
    `lost`: number of missing samples outside of these, which were interpolated.
    `what`: `ECG`, `pulse wave` or `neither`.
    `other`, for each beat: whether it has another shape than those around it.
    `hidden`, for each beat: whether the interval before it has a peak that may be one.
    """

    beats: IntArray
    silent: Spans
    noisy: Spans
    lost: int
    what: str
    other: BoolArray
    hidden: BoolArray


def find_beats(
    signal: Signal,
    what: str | None = None,
    progress: Callable[[float], None] = lambda part: None,
    *,
    gaps: bool = True,
) -> Detection:
    """Search a signal with a rate of at least `MIN_RATE` block by block; InputError if unreadable.

    `what`: `ECG` or `pulse wave`; None = detected from its beats.
    `progress`: called with the finished fraction, 0 to 1.
    `gaps`: whether beats in noise are left out; False for comparisons with other detectors.
    """
    finder = SilenceFinder(signal.rate)
    block, margin = round(BLOCK_S * signal.rate), round(MARGIN_S * signal.rate)
    found: list[tuple[int, bool, bool]] = []
    doubtful: dict[float, Spans] = {beat_quality.LIMIT: [], beat_quality.STRICT_LIMIT: []}
    near = qrs.REFRACTORY_S * signal.rate
    for first in range(0, signal.length, block):
        end = min(first + block, signal.length)
        low, high = max(0, first - margin), min(end + margin, signal.length)
        samples = signal.read(low, high)
        finder.feed(samples[first - low : end - low])
        parts = _clean_parts(samples, signal.rate)
        # the longest part has the most beats to decide the kind by
        for begin, stop in sorted(parts, key=lambda part: part[0] - part[1]):
            what = what or _kind(_bridged(samples[begin:stop]), signal.rate)
        for begin, stop in parts:
            part = _Part(_bridged(samples[begin:stop]), signal.rate, what)
            for limit, spans in doubtful.items():
                moved = ((low + begin + a, low + begin + b) for a, b in part.doubtful(limit))
                spans += [(max(a, first), min(b, end)) for a, b in moved if a < end and b > first]
            for beat, other, hidden in part.beats():
                at = beat + low + begin
                if first <= at < end and (not found or at - found[-1][0] >= near):
                    found.append((at, other, hidden))
        progress(end / signal.length)
    noisy: Spans = []
    for limit in (beat_quality.LIMIT, beat_quality.STRICT_LIMIT) if gaps else ():
        found_noise = merged(doubtful[limit], _LEAST_CLEAN_S * signal.rate)
        least = _LEAST_NOISY_S * signal.rate
        noisy = [(begin, stop) for begin, stop in found_noise if stop - begin >= least]
        if 2 * sum(stop - begin for begin, stop in noisy) <= signal.length:
            break
    beats = np.array([at for at, _, _ in found], np.int64)
    others = np.array([other for _, other, _ in found], np.bool_)
    hiding = np.array([hidden for _, _, hidden in found], np.bool_)
    clear = np.ones(len(beats), np.bool_)
    for begin, stop in noisy:
        clear[slice(*np.searchsorted(beats, (begin, stop)))] = False
    return Detection(
        beats[clear],
        finder.finish(),
        noisy,
        finder.lost,
        what or "neither",
        others[clear],
        hiding[clear],
    )


def _kind(part: FloatArray, rate: float) -> str | None:
    """Return `ECG` or `pulse wave`; None if a part has no beats that can be trusted."""
    signal, work_rate, _ = qrs.decimated(part, rate)
    band = qrs.band_passed(part, rate, 0.5, 8.0)
    _, alike = beat_quality.pulse_likeness(band, _pulses(band, rate), rate)
    likeness = float(np.median(alike)) if len(alike) > 2 else 0.0
    if beat_quality.is_ecg(signal, qrs.find_qrs(signal, work_rate), work_rate, likeness):
        return "ECG"
    doubt = _Part(part, rate, "pulse wave").doubt
    return "pulse wave" if (doubt < 0.0).any() else None


class _Part:
    """Beats of a part without missing samples, and the doubt about them."""

    def __init__(self, part: FloatArray, rate: float, what: str | None) -> None:
        self._length, self._rate = len(part), rate
        self._fewer = 1
        self._other = self._hidden = np.zeros(0, np.bool_)
        if what == "ECG":
            signal, work_rate, self._fewer = qrs.decimated(part, rate)
            search = qrs.find_qrs(signal, work_rate)
            added, differs, size = find_other_shapes(signal, search.beats, work_rate)
            self._beats = np.concatenate([search.beats, added])
            self._other = np.concatenate([differs, np.ones(len(added), np.bool_)])
            order = np.argsort(self._beats, kind="stable")
            self._beats, self._other = self._beats[order], self._other[order]
            noise = search.noise
            if self._other.any():
                noise = qrs.noise_height(search.height, self._beats, work_rate)
            self.doubt = beat_quality.ecg_doubt(search, noise, self._beats[self._other], work_rate)
            self._hidden = _hidden(size, self._beats, work_rate)
        elif what == "pulse wave":
            band = qrs.band_passed(part, rate, 0.5, 8.0)
            self._beats = _pulses(band, rate)
            self._other = self._hidden = np.zeros(len(self._beats), np.bool_)
            self.doubt = beat_quality.pulse_doubt(band, self._beats, rate)
        else:
            self._beats = np.zeros(0, np.int64)
            self.doubt = np.full(1, np.inf)

    def doubtful(self, limit: float) -> Spans:
        """Return the stretches, in samples, whose index is above a limit."""
        if (self.doubt > limit).all():
            return [(0, self._length)]
        second, wider = round(self._rate), round(_AROUND_S * self._rate)
        return [
            (max(0, first * second - wider), min(self._length, end * second + wider))
            for first, end in runs(self.doubt > limit)
        ]

    def beats(self) -> list[tuple[int, bool, bool]]:
        """Return the position of each beat, whether it has another shape, and `hidden`."""
        at = (self._beats * self._fewer).tolist()
        return list(zip(at, self._other.tolist(), self._hidden.tolist(), strict=True))


def _hidden(size: FloatArray, beats: IntArray, rate: float) -> BoolArray:
    """Return which intervals before a beat have a peak that may be a beat."""
    reach = round(0.25 * rate)
    highest = np.array(
        [size[a + reach : b - reach].max(initial=0.0) for a, b in itertools.pairwise(beats)]
    )
    found = np.zeros(len(beats), np.bool_)
    if len(highest) > 1:
        padded = np.pad(highest, 1, mode="edge")
        beside = np.maximum(padded[:-2], padded[2:])
        found[1:] = (highest >= _HIDDEN_HEIGHT) | (highest >= _HIDDEN_RATIO * beside) & (
            highest > 0.2
        )
    return found


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


def _clean_parts(samples: FloatArray, rate: float) -> Spans:
    """Return the parts with signal that are long enough to search."""
    finder = SilenceFinder(rate)
    finder.feed(samples)
    usable = np.ones(len(samples), np.bool_)
    for first, end in finder.finish():
        usable[first:end] = False
    return [(first, end) for first, end in runs(usable) if end - first >= MIN_PART_S * rate]


def _bridged(part: FloatArray) -> FloatArray:
    """Return the part with missing samples interpolated, for the filters of the detector."""
    known = np.isfinite(part)
    if known.all():
        return part
    positions = np.arange(len(part))
    return np.interp(positions, positions[known], part[known])


def _pulses(band: FloatArray, rate: float) -> IntArray:
    """Return the positions of the systolic peaks in the band of a pulse wave.

    Elgendi et al., "Systolic peak detection in acceleration photoplethysmograms", PLoS ONE 8(10),
    2013: where the squared signal's mean over a peak (111 ms) exceeds that over a beat (667 ms).
    """
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
