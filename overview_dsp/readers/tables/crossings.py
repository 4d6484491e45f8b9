"""Crossings of round levels, with hysteresis.

Levels are the one to three round numbers (1, 2, 2.5 or 5 times a power of ten apart) nearest to the
middle of the series' central 80 %. A level is crossed when the series, having been more than the
hysteresis below it, gets more than that above it (or the reverse); the event is at the first sample
past the level on that way. The hysteresis is 3 % of the central range, and doubles, up to 24 %,
while there are more than `MOST` crossings; if there still are, only the middle level is kept, and
none if that isn't enough.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MOST = 16
"""Most crossings: more would be a texture, not places."""

_LEVELS = 3
_HYSTERESIS = (0.03, 0.06, 0.12, 0.24)


@dataclass(frozen=True)
class Crossing:
    """The sample after which the series stays across `level`; `up` or down."""

    index: int
    level: float
    up: bool


def round_levels(low: float, high: float) -> list[float]:
    """Return one to three round numbers strictly between two values; none where no room is."""
    span = high - low
    if not math.isfinite(span) or span <= 0.0 or span < 1e-9 * max(abs(low), abs(high)):
        return []
    power = 10.0 ** math.floor(math.log10(span))
    for step in (power * m for m in (0.1, 0.2, 0.25, 0.5, 1.0, 2.0, 2.5, 5.0)):
        if step <= 0.0:
            return []
        first, last = math.floor(low / step) + 1, math.ceil(high / step) - 1
        if 1 <= last - first + 1 <= _LEVELS:
            found = range(first, last + 1)
            levels = [round(k * step, 12) if step < 1e3 else k * step for k in found]
            return [level for level in levels if low < level < high]  # rounding may miss
    return []


def crossings(
    value: NDArray[np.float64], low: float, high: float
) -> tuple[list[Crossing], list[float], float]:
    """Find the crossings of a series.

    Parameters
    ----------
    value
        Shape (n,), finite.
    low, high
        The ends of its central 80 %.

    Returns
    -------
    tuple
        Crossings by index, the levels that were used (none: too many crossings), the hysteresis.
    """
    levels = round_levels(low, high)
    if not levels:
        return [], [], 0.0
    middle = min(levels, key=lambda level: abs(level - (low + high) / 2.0))
    for chosen in (levels, [middle]):
        for share in _HYSTERESIS:
            margin = share * (high - low)
            found = [c for level in chosen for c in _of_level(value, level, margin)]
            if len(found) <= MOST:
                return sorted(found, key=lambda c: (c.index, c.level)), chosen, margin
    return [], [], 0.0


def _of_level(value: NDArray[np.float64], level: float, margin: float) -> list[Crossing]:
    state = np.where(value > level + margin, 1, np.where(value < level - margin, -1, 0))
    decided = np.flatnonzero(state)
    turned = np.flatnonzero(np.diff(state[decided])) + 1
    found = []
    for k in turned.tolist():
        before, here = int(decided[k - 1]), int(decided[k])
        up = bool(state[here] > 0)
        way = value[before : here + 1]
        behind = np.flatnonzero(way < level if up else way > level)
        found.append(Crossing(before + int(behind[-1]) + 1, level, up))
    return found
