"""A pattern on the bare surface: what it is made of before any data (cloth, gravel, a dial).

| pattern | course over a period |
|---|---|
| none | flat |
| waves | (1 - cos)/2 |
| ridges | a narrow bump in the middle, a fifth of the period wide at half height |
| teeth | rises in a line over nine tenths, falls over the last one: a ratchet |
| grains | heights by chance, joined by half cosines; the same surface always |

Values are 0 to 1; the period is a part of the surface, so it feels the same at any zoom.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_RIDGE = 0.2
_FALL = 0.1
_SEED = 1


def _waves(x: Array) -> Array:
    return 0.5 - 0.5 * np.cos(2.0 * np.pi * x)


def _ridges(x: Array) -> Array:
    d: Array = (x % 1.0 - 0.5) / _RIDGE
    bump: Array = np.exp(-4.0 * np.log(2.0) * d * d)
    return bump


def _teeth(x: Array) -> Array:
    part = x % 1.0
    return np.minimum(part / (1.0 - _FALL), (1.0 - part) / _FALL)


def _grains(x: Array) -> Array:
    heights = np.random.default_rng(_SEED).random(int(x[-1]) + 3)
    at = np.floor(x).astype(np.int64)
    way = 0.5 - 0.5 * np.cos(np.pi * (x - at))
    return heights[at] * (1.0 - way) + heights[at + 1] * way


_PATTERNS: dict[str, Callable[[Array], Array]] = {
    "waves": _waves,
    "ridges": _ridges,
    "teeth": _teeth,
    "grains": _grains,
}


def pattern(name: str, cells: int, period_percent: float) -> Array:
    """The pattern at the cells + 1 points of a table, 0 to 1.

    Parameters
    ----------
    name : one of `presets.parameters.PATTERNS`
    period_percent : of the table, from one ridge to the next
    """
    positions = np.arange(cells + 1, dtype=np.float64)
    if name == "none":
        return np.zeros(cells + 1)
    return _PATTERNS[name](positions / (period_percent / 100.0 * cells))
