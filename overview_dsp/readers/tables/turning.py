"""Peaks and troughs by prominence, in linear time.

The prominence of a peak is how far one must go down from it on the way to higher ground (or to the
end of the series), the smaller of both sides.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from overview_dsp.readers.tables.thinning import lows_and_highs

MAX_EXTREMA = 200_000
"""Extrema looked at one by one; more are thinned to the lowest and highest of equal stretches,
which keeps every prominent one."""


def peaks(value: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the peaks of a series and their prominences.

    Parameters
    ----------
    value
        Shape (n,), finite.

    Returns
    -------
    tuple
        Indices (first sample of a flat top), ascending, and prominences, > 0. The ends are none.
    """
    turns = _turns(value)
    if len(turns) > MAX_EXTREMA:
        turns = _thinned(value, turns)
    levels = value[turns]
    left = _bases(levels.tolist())
    right = _bases(levels[::-1].tolist())[::-1]
    inner = np.arange(1, len(turns) - 1)
    tops = inner[(levels[inner] > levels[inner - 1]) & (levels[inner] > levels[inner + 1])]
    prominence = np.array([levels[i] - max(left[i], right[i]) for i in tops.tolist()])
    return turns[tops], prominence


def _turns(value: NDArray[np.float64]) -> NDArray[np.int64]:
    """Both ends and every sample where the series turns; of a flat stretch its first."""
    moved = np.flatnonzero(np.diff(value)) + 1
    distinct = np.concatenate(([0], moved)).astype(np.int64)
    if len(distinct) < 3:
        return distinct
    sign = np.sign(np.diff(value[distinct]))
    turning = np.flatnonzero(sign[1:] != sign[:-1]) + 1
    return np.concatenate((distinct[:1], distinct[turning], distinct[-1:]))


def _thinned(value: NDArray[np.float64], turns: NDArray[np.int64]) -> NDArray[np.int64]:
    run = math.ceil(len(turns) / (MAX_EXTREMA // 2))
    kept = turns[lows_and_highs(value[turns], run)]
    inside = np.unique(np.concatenate((turns[:1], kept, turns[-1:])))
    return inside[_turns(value[inside])]


def _bases(levels: list[float]) -> list[float]:
    """For each turn the lowest level between it and higher ground on its left."""
    bases: list[float] = []
    stack: list[tuple[float, float]] = []  # height, lowest since higher ground
    for level in levels:
        low = level
        while stack and stack[-1][0] <= level:
            low = min(low, stack.pop()[1])
        stack.append((level, low))
        bases.append(low)
    return bases
