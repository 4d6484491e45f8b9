"""The intensity curve mixed with its rank, so that a curve that is mostly low is felt to move.

    value' = (1 - share) * value + share * rank(value)

The rank of a value is the share of time with lower values; of equal values, the middle of their
ranks. Only times with data count: neither gaps nor what hasn't happened yet.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.gaps import in_gap

Array = NDArray[np.float64]


def mixed_with_rank(levels: Array, known: Array, share: float) -> Array:
    """Return levels (0 to 1) mixed with their rank among the known ones.

    Levels without a curve, and those of a constant one, stay as they are.
    """
    ordered = np.sort(known)
    if not len(ordered) or ordered[0] == ordered[-1]:
        return levels
    lower, upper = (np.searchsorted(ordered, levels, side=side) for side in ("left", "right"))
    rank = (lower + upper) / (2.0 * len(ordered))
    return np.asarray((1.0 - share) * levels + share * rank)


def known_levels(timeline: Timeline, even: Array) -> Array:
    """Return those of a timeline's levels, at even times from end to end, where there are data."""
    curve = timeline.intensity
    if curve is None or curve.is_constant:
        return even[:0]
    last = curve.last_s if timeline.until_s is None else min(curve.last_s, timeline.until_s)
    times = np.linspace(0.0, timeline.duration_s, len(even))
    known = (times >= curve.first_s) & (times <= last) & ~in_gap(timeline.gaps, times)
    return np.asarray(even[known])
