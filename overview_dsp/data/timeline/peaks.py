"""What of a long curve is felt at a position of the surface that many of its points fall on.

The mean is felt, so that noise isn't taken for level. A peak that the mean would lose is kept, at
its full height: where the largest value of a position stands out of the means around it by far more
than is usual in the part shown (the median plus three times what the upper fiftieth lies above
it), and by at least a fiftieth of what the part spans. It is widened to a thousandth of the
surface, since nothing narrower is felt.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

RARE = 0.98
"""Peaks are fewer than this leaves: more would lie too close together to be felt apart."""

STANDS_OUT = 3.0
"""So many times further than the usual spread: noise of any common kind doesn't."""

MATTERS = 0.02
"""A peak stands out by at least this part of what the part shown spans."""

SOME = 7
"""What is usual is measured at every so many positions."""

WIDENED = 1.0 / 2048.0
"""Part of the positions on either side of a peak that get its height: a thousandth in all."""


def with_peaks(mean: NDArray[np.float64], top: NDArray[np.float64]) -> NDArray[np.float64]:
    """What is felt at each position, shape (n,), of the means and the largest values there."""
    around = mean.copy()
    np.maximum(around[1:], mean[:-1], out=around[1:])
    np.maximum(around[:-1], mean[1:], out=around[:-1])
    excess = np.maximum(top - around, 0.0)
    usual, rare = np.quantile(excess[::SOME], (0.5, RARE))
    spans = float(top.max()) - float(mean.min())
    peak = (excess > usual + STANDS_OUT * (rare - usual)) & (excess >= MATTERS * spans)
    if not peak.any():
        return mean
    kept = np.where(peak, top, -np.inf)
    reach, wanted = 0, round(WIDENED * len(mean))
    while reach < wanted:  # the largest of 2 * reach + 1 positions, in few steps
        step = min(reach + 1, wanted - reach)
        wider = kept.copy()
        np.maximum(wider[step:], kept[:-step], out=wider[step:])
        np.maximum(wider[:-step], kept[step:], out=wider[:-step])
        kept = wider
        reach += step
    return np.maximum(mean, kept)
