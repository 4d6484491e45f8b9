"""Patterns of the base surface, and ribs in data gaps.

A gap has a row of equal ribs (`surface.gap_height`, `surface.gap_period_percent`) that begins and
ends with a groove. Friction in the grooves is a tenth of the base surface's, so a gap can't be
mistaken for data: the curve and the events only add to the base surface. On average a gap has
less friction than the base surface, so it can't be mistaken for an event either.

A gap too narrow for a rib is one groove, at least as wide as the table resolves.

The pattern of the base surface is independent of data (cloth, gravel, a dial).

| pattern | shape of a period |
|---|---|
| none | flat |
| waves | (1 - cos)/2 |
| ridges | a narrow bump in the middle, a fifth of the period wide at half height |
| teeth | a linear rise over nine tenths and a fall over the last one: a ratchet |
| beats | two bumps, a tenth of the period wide at half height, at 0.25 and, 0.6 high, at 0.55 |
| grains | random heights of a fixed seed, connected by half cosines |

Values are 0 to 1. The period is relative to the surface and thus independent of the zoom.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from overview_dsp.arrays import BoolArray, FloatArray
from overview_dsp.data.timeline.gaps import Gaps
from overview_dsp.errors import warn
from overview_dsp.units import clock_text

GROOVE = 0.1
"""Friction at the bottom of a groove relative to the base surface, low enough not to be felt."""

MIN_GAP_CELLS = 4.0  # least width of a gap; narrower ones would fall between the table's points


def ribs(
    gaps: Gaps, duration_s: float, cells: int, height: float, period_percent: float
) -> tuple[BoolArray, FloatArray]:
    """Return which points of a table lie in a gap, and their friction relative to the base surface.

    `gaps` are sorted and disjoint, at least one; `height` is the relative friction of a rib,
    `period_percent` the distance from rib to rib, of the table. Warns (OverviewWarning) of gaps too
    narrow for a rib.
    """
    start, end = np.array(gaps, dtype=np.float64).T * (cells / duration_s)
    width = end - start
    period = period_percent / 100.0 * cells
    count = np.round(width / period)
    narrow = [end - start for (start, end), ribs in zip(gaps, count, strict=True) if ribs < 1]
    if narrow:
        some = "1 gap is" if len(narrow) == 1 else f"{len(narrow)} gaps are"
        warn(
            f"{some} too narrow for perceptible ribs in {clock_text(duration_s)} (narrowest: "
            f"{min(narrow):.3g} s); use a shorter window",
            2,
        )
    widened = np.maximum(width, MIN_GAP_CELLS)
    start = np.clip(start - (widened - width) / 2.0, 0.0, cells - widened)
    # only the last gap that starts before a point can contain it
    begun = np.bincount(np.ceil(start).astype(np.int64), minlength=cells + 1)
    gap = np.cumsum(begun) - 1
    point = np.arange(cells + 1, dtype=np.float64)
    inside = (gap >= 0) & (point <= (start + widened)[gap])
    gap = gap[inside]
    turns = (point[inside] - start[gap]) / widened[gap] * count[gap]
    rib = 0.5 - 0.5 * np.cos(2.0 * np.pi * turns)
    # squared: grooves wide enough for a perceptible pause in a fast sweep
    return inside, GROOVE + (height - GROOVE) * rib * rib


_RIDGE = 0.2
_BEAT = 0.1
_FALL = 0.1
_SEED = 1


def _bump(x: FloatArray, centre: float, width: float) -> FloatArray:
    d: FloatArray = (x % 1.0 - centre) / width
    return np.asarray(np.exp(-4.0 * np.log(2.0) * d * d))


def _grains(x: FloatArray) -> FloatArray:
    heights = np.random.default_rng(_SEED).random(int(x[-1]) + 3)
    at = np.floor(x).astype(np.int64)
    way = 0.5 - 0.5 * np.cos(np.pi * (x - at))
    return heights[at] * (1.0 - way) + heights[at + 1] * way


_PATTERNS: dict[str, Callable[[FloatArray], FloatArray]] = {
    "waves": lambda x: 0.5 - 0.5 * np.cos(2.0 * np.pi * x),
    "ridges": lambda x: _bump(x, 0.5, _RIDGE),
    "teeth": lambda x: np.minimum(x % 1.0 / (1.0 - _FALL), (1.0 - x % 1.0) / _FALL),
    "beats": lambda x: np.maximum(_bump(x, 0.25, _BEAT), 0.6 * _bump(x, 0.55, _BEAT)),
    "grains": _grains,
}


def pattern(name: str, cells: int, period_percent: float) -> FloatArray:
    """Return a pattern at the points of a table, 0 to 1, with a period in % of the table."""
    positions = np.arange(cells + 1, dtype=np.float64)
    if name == "none":
        return np.zeros(cells + 1)
    return _PATTERNS[name](positions / (period_percent / 100.0 * cells))
