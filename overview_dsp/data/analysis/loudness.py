"""Loudness by ITU-R BS.1770 and EBU R 128, streamed, with a few numbers per second in memory.

The samples are K-weighted, squared, weighted by channel and summed over steps of 100 ms. Loudness
is a mean over steps: momentary over 400 ms, short-term over 3 s.

The Recommendation has coefficients for 48 kHz only. The formulas in this module agree with them to
1e-7, and have the same response at other rates, as far as the bilinear transform allows (Brecht De
Man, "Evaluation of implementations of the EBU R128 loudness measurement", AES 145, 2018; also in
libebur128).
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import BoolArray, FloatArray, IntArray
from overview_dsp.data.analysis.runs import RunFinder

MIN_RATE = 4000  # lowest sample rate, Hz: below it, the shelf would be above half the rate
_SHELF_HZ = 1681.974450955533
_SHELF_DB = 3.999843853973347
_SHELF_Q = 0.7071752369554196
_SHELF_BAND = 0.4996667741545416  # the exponent of the gain at the shelf's middle
_HIGH_PASS_HZ = 38.13547087602444
_HIGH_PASS_Q = 0.5003270373238773

STEPS_PER_S = 10  # EBU Tech 3341: a live meter renews its reading at least ten times a second
MOMENTARY_STEPS = 4
SHORT_TERM_STEPS = 30

SILENCE_LUFS = -70.0  # absolute gate of BS.1770: anything quieter is silence and gets this value
MAX_SAMPLE = 1e6
"""Samples more than 120 dB above full scale come from broken files and count as missing."""

_RELATIVE_GATE_LU = -10.0
_BLOCK_SAMPLES = 1_000_000
_OFFSET_DB = -0.691  # cancels the filters' gain at 997 Hz


def k_weighting(sample_rate: float) -> FloatArray:
    """Return the shelf and the high-pass as second-order sections, float64 (2, 6).

    `sample_rate` is in Hz, at least `MIN_RATE`.
    """
    k = math.tan(math.pi * _SHELF_HZ / sample_rate)
    high = 10.0 ** (_SHELF_DB / 20.0)
    band = high**_SHELF_BAND
    a0 = 1.0 + k / _SHELF_Q + k * k
    shelf = [
        (high + band * k / _SHELF_Q + k * k) / a0,
        2.0 * (k * k - high) / a0,
        (high - band * k / _SHELF_Q + k * k) / a0,
        1.0,
        2.0 * (k * k - 1.0) / a0,
        (1.0 - k / _SHELF_Q + k * k) / a0,
    ]
    k = math.tan(math.pi * _HIGH_PASS_HZ / sample_rate)
    a0 = 1.0 + k / _HIGH_PASS_Q + k * k
    # the numerator is not divided by a0, as in the table of the Recommendation
    poles = [1.0, 2.0 * (k * k - 1.0) / a0, (1.0 - k / _HIGH_PASS_Q + k * k) / a0]
    return np.array([shelf, [1.0, -2.0, 1.0, *poles]], dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Steps:
    """The power of a recording, step by step.

    `energy`: sum of the weighted squares of the samples in each step.
    `count`: number of samples in that sum, without missing ones.
    `missing`: runs (first, end) of missing samples (NaN, infinite, absurd) of a step or longer.
    `lost`: number of missing samples outside of these.
    """

    sample_rate: int
    frames: int
    energy: FloatArray
    count: IntArray
    missing: tuple[tuple[int, int], ...]
    lost: int

    def loudness(self, steps: int) -> FloatArray:
        """Return the loudness around the start of each step and around the end, LUFS.

        Shape (steps + 1,). Windows are of `steps` steps, centred, and cut at the recording's ends.
        Never below `SILENCE_LUFS`; NaN where all samples are missing.
        """
        ones = np.ones(steps)
        ahead = steps - steps // 2  # steps of the window that follow its middle
        whole = slice(ahead - 1, ahead + len(self.energy))
        # not by a running sum, which would keep the rounding of loud parts in quiet ones
        energy = np.convolve(self.energy, ones)[whole]
        samples = np.rint(np.convolve(self.count, ones)[whole])
        return np.where(samples > 0, _lufs(energy / np.maximum(samples, 1)), np.nan)

    def integrated(self) -> float:
        """Return the gated loudness of the whole, LUFS; `SILENCE_LUFS` for silence.

        Blocks of 400 ms, overlapping by 75 %, gated at -70 LUFS and at 10 LU below their mean
        (BS.1770-5, annex 1). A recording shorter than a block is one block.
        """
        width = min(MOMENTARY_STEPS, len(self.energy))
        energy = np.convolve(self.energy, np.ones(width), "valid")
        count = np.convolve(self.count, np.ones(width), "valid")
        power = energy[count > 0] / count[count > 0]
        for gate in (SILENCE_LUFS, None):
            if gate is None:
                gate = float(_lufs(power.mean())) + _RELATIVE_GATE_LU
            power = power[_OFFSET_DB + 10.0 * np.log10(np.maximum(power, 1e-30)) > gate]
            if not len(power):
                return SILENCE_LUFS
        return float(_lufs(power.mean()))


class StepMeter:
    """Meter for the blocks of a recording; `finish` returns its steps.

    `sample_rate` is at least `MIN_RATE`; `weights` has the weight of the power of each channel.
    """

    def __init__(self, sample_rate: int, weights: tuple[float, ...]) -> None:
        self._rate = sample_rate
        self._weighted = np.array([i for i, weight in enumerate(weights) if weight > 0.0])
        self._all_weighted = len(self._weighted) == len(weights)
        self._weights = np.array(weights)[self._weighted]
        self._filter = k_weighting(sample_rate)
        self._state = np.zeros((2, 2, len(self._weighted)))
        self._frames = 0
        self._energy: list[FloatArray] = []
        self._count: list[IntArray] = []
        self._missing = RunFinder(sample_rate / STEPS_PER_S)

    @property
    def block_frames(self) -> int:
        """Block size, samples: whole seconds, so that all blocks but the last end with a step."""
        return self._rate * max(1, round(_BLOCK_SAMPLES / (self._rate * len(self._weights))))

    def feed(self, block: NDArray[np.floating[Any]]) -> None:
        """Process the next block (frames, channels): `block_frames`, or fewer in the last one."""
        from scipy.signal import sosfilt

        frames = len(block)
        selected = block if self._all_weighted else block[:, self._weighted]
        with np.errstate(invalid="ignore"):  # a signalling NaN would warn; it is missing, below
            samples = np.array(selected, dtype=np.float64)
        bad: BoolArray | None = None
        # two passes instead of a mask; a NaN anywhere makes both NaN
        if not (samples.max() <= MAX_SAMPLE and samples.min() >= -MAX_SAMPLE):
            bad = np.asarray(~(np.abs(samples) <= MAX_SAMPLE).all(axis=1), np.bool_)
            samples[bad] = 0.0
        self._missing.feed(np.zeros(frames, np.bool_) if bad is None else bad)
        weighted, self._state = sosfilt(self._filter, samples, axis=0, zi=self._state)
        np.square(weighted, out=weighted)
        # a matrix product of one channel takes half as long as the filter
        alone = len(self._weights) == 1
        power = weighted[:, 0] * self._weights[0] if alone else weighted @ self._weights
        if bad is not None:
            power[bad] = 0.0
        steps = -(-frames * STEPS_PER_S // self._rate)
        edges = (np.arange(steps) * self._rate + STEPS_PER_S // 2) // STEPS_PER_S
        edges = edges[edges < frames]
        self._energy.append(np.add.reduceat(power, edges))
        count = np.diff(edges, append=frames)
        if bad is not None:
            count = count - np.add.reduceat(bad, edges, dtype=np.int64)
        self._count.append(count)
        self._frames += frames

    def so_far(self) -> Steps:
        """Return the steps so far; more blocks may follow."""
        other = copy.copy(self)
        other._missing = copy.deepcopy(self._missing)
        return other.finish()

    def finish(self) -> Steps:
        """Return the steps of all blocks."""
        return Steps(
            self._rate,
            self._frames,
            np.concatenate(self._energy),
            np.concatenate(self._count),
            tuple(self._missing.finish()),
            self._missing.lost,
        )


def _lufs(power: FloatArray | float) -> FloatArray:
    """Return the loudness of a mean weighted square, not below silence."""
    floor = 10.0 ** ((SILENCE_LUFS - _OFFSET_DB) / 10.0)
    lufs: FloatArray = _OFFSET_DB + 10.0 * np.log10(np.maximum(power, floor))
    return lufs
