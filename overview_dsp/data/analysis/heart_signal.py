"""Sampled signals of a heart, read in parts, and stretches without signal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline.curve_builder import CurveBuilder
from overview_dsp.data.timeline.intensity import Intensity

Spans = list[tuple[int, int]]
"""Runs of samples, (first, end), ascending, not overlapping."""

MIN_GAP_S = 0.1
"""Shorter runs of missing samples are interpolated: they are too short for a beat."""

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

    def read(self, first: int, end: int) -> NDArray[np.float64]:
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

    def read(self, first: int, end: int) -> NDArray[np.float64]:
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


def runs(marked: NDArray[np.bool_]) -> Spans:
    """Return the runs of True values."""
    edges = np.flatnonzero(np.diff(marked.view(np.int8), prepend=0, append=0)).reshape(-1, 2)
    return [(first, end) for first, end in edges.tolist()]


class SilenceFinder:
    """Detector of missing and flat stretches of a signal, block by block."""

    def __init__(self, rate: float) -> None:
        self._shortest = {"missing": MIN_GAP_S * rate, "flat": FLAT_S * rate}
        self._open: dict[str, int | None] = {"missing": None, "flat": None}
        self._found: dict[str, Spans] = {"missing": [], "flat": []}
        self._last = np.nan
        self._done = 0
        self.lost = 0  # missing samples in runs too short for a gap

    def feed(self, block: NDArray[np.float64]) -> None:
        """Process the next samples."""
        if not len(block):
            return
        self._follow("missing", ~np.isfinite(block), 0)
        # a sample that equals the one before it is flat; the run also includes the first of them
        same = np.diff(block, prepend=self._last) == 0.0
        self._follow("flat", same, 1)
        self._last = float(block[-1])
        self._done += len(block)

    def finish(self) -> Spans:
        """Return the stretches without signal, merged."""
        for what in self._open:
            self._close(what, self._done)
        merged: Spans = []
        for first, end in sorted([*self._found["missing"], *self._found["flat"]]):
            if merged and first <= merged[-1][1]:
                merged[-1] = (merged[-1][0], max(end, merged[-1][1]))
            else:
                merged.append((first, end))
        return merged

    def _follow(self, what: str, marked: NDArray[np.bool_], before: int) -> None:
        if not marked[0]:
            self._close(what, self._done)
        for first, end in runs(marked):
            if self._open[what] is None:
                self._open[what] = self._done + first - before
            if end < len(marked):
                self._close(what, self._done + end)

    def _close(self, what: str, end: int) -> None:
        first, self._open[what] = self._open[what], None
        if first is None:
            return
        if end - first >= self._shortest[what]:
            self._found[what].append((first, end))
        elif what == "missing":
            self.lost += end - first
