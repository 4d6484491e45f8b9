"""Sampled signals of a heart, read in parts, and stretches without signal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import FloatArray
from overview_dsp.data.analysis.runs import RunFinder, Spans, merged
from overview_dsp.data.timeline.curve_builder import CurveBuilder
from overview_dsp.data.timeline.intensity import Intensity

MIN_GAP_S = 0.1  # shorter runs of missing samples are interpolated: they are too short for a beat
FLAT_S = 3.0
"""A signal with one exact value for this long is a disconnected lead; a pause of the heart has
noise."""

_BLOCK = 1 << 20


class Signal(Protocol):
    """Samples at a steady rate; NaN = missing."""

    @property
    def name(self) -> str:
        """Name of the signal."""

    @property
    def rate(self) -> float:
        """Sample rate, Hz, > 0."""

    @property
    def length(self) -> int:
        """Number of samples."""

    def read(self, first: int, end: int) -> FloatArray:
        """Return the samples from `first` up to `end`, shape (end - first,)."""


@dataclass(frozen=True, eq=False)
class Samples:
    """A signal in memory (a `Signal`)."""

    name: str
    rate: float
    values: NDArray[np.float32]

    @property
    def length(self) -> int:
        """Number of samples."""
        return len(self.values)

    def read(self, first: int, end: int) -> FloatArray:
        """Return samples, NaN = missing."""
        return self.values[first:end].astype(np.float64)


def recorded(signal: Signal) -> Intensity | None:
    """Return a signal as a curve for a picture, None for fewer than two samples."""
    builder = CurveBuilder(np.float32)
    for first in range(0, signal.length, _BLOCK):
        builder.append(signal.read(first, min(first + _BLOCK, signal.length)))
    if builder.count < 2:
        return None
    return builder.finish(step_s=1.0 / signal.rate, unit=signal.name)


class SilenceFinder:
    """Detector of missing and flat stretches of a signal, block by block."""

    def __init__(self, rate: float) -> None:
        self._missing, self._flat = RunFinder(MIN_GAP_S * rate), RunFinder(FLAT_S * rate)
        self._last = np.nan

    @property
    def lost(self) -> int:
        """Number of missing samples in runs too short for a gap."""
        return self._missing.lost

    def feed(self, block: FloatArray) -> None:
        """Process the next samples."""
        if not len(block):
            return
        self._missing.feed(~np.isfinite(block))
        # a sample that equals the one before it is flat; the run also includes the first of them
        same = np.diff(block, prepend=self._last) == 0.0
        self._flat.feed(same, before=1)
        self._last = float(block[-1])

    def finish(self) -> Spans:
        """Return the stretches without signal, merged."""
        return merged([*self._missing.finish(), *self._flat.finish()], 1)
