"""Pyramid of minimum, mean and maximum over runs of a long array, for fast zooming.

Level k has one bin for every `BIN * RATIO**k` values. It is built once, in one pass. Then bins of
any width are computed without reading all values again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline.growable_array import Store

Values = NDArray[np.floating[Any]]
"""float32 or float64."""

BIN = 16  # values per bin of the lowest level; its size is three sixteenths of the values
RATIO = 4  # bins of one level per bin of the next
FEW = 1024  # the highest level has fewer bins than this
CHUNK = 1 << 20  # values read at a time


@dataclass(frozen=True, eq=False)
class Level:
    """Minimum, mean and maximum of bins of `width` values, shape (bins,); the last may be short."""

    width: int
    low: Values
    mean: Values
    high: Values


class PyramidBuilder:
    """Builder of the levels from chunks of values."""

    def __init__(self, dtype: type[np.float32] | type[np.float64]) -> None:
        self._dtype = dtype
        self._stores = [Store(dtype) for _ in range(3)]
        self._rest = np.empty(0, dtype)

    def append(self, values: Values) -> None:
        """Take the next values, shape (n,), of the builder's own type."""
        if len(self._rest):
            values = np.concatenate((self._rest, values))
        whole = len(values) // BIN * BIN
        self._take(values[:whole].reshape(-1, BIN))
        self._rest = values[whole:].copy()

    def _take(self, bins: Values) -> None:
        if len(bins):
            low, mean, high = self._stores
            low.append(bins.min(axis=1))
            mean.append(bins.mean(axis=1, dtype=np.float64).astype(self._dtype))
            high.append(bins.max(axis=1))

    def finish(self) -> tuple[Level, ...]:
        """Return the levels, the finest first; none for fewer values than a bin has."""
        if len(self._rest):
            self._take(self._rest[None, :])
        low, mean, high = (store.finish() for store in self._stores)
        levels = []
        width = BIN
        while len(low):
            levels.append(Level(width, low, mean, high))
            if len(low) < FEW:
                break
            low = _runs(low, np.minimum)
            high = _runs(high, np.maximum)
            mean = (_runs(mean, np.add, np.float64) / RATIO).astype(self._dtype)
            width *= RATIO
        return tuple(levels)


def _runs(values: Values, combine: np.ufunc, dtype: type[np.float64] | None = None) -> Values:
    """Combine each run of RATIO values; the last is filled up with the last value."""
    short = -len(values) % RATIO
    if short:
        values = np.concatenate((values, np.repeat(values[-1:], short)))
    bins = values.reshape(-1, RATIO)
    return np.asarray(combine.reduce(bins, axis=1, dtype=dtype))


def build_pyramid(values: Values) -> tuple[Level, ...]:
    """Return the levels of values in an array or a memory map."""
    builder = PyramidBuilder(np.float32 if values.dtype == np.float32 else np.float64)
    for start in range(0, len(values), CHUNK):
        builder.append(np.asarray(values[start : start + CHUNK]))
    return builder.finish()
