"""Share splits in prices that weren't adjusted for them: a jump that is none of the share's worth.

Where an adjusted column is there, it decides: the factor between it and the price jumps at a split
(and a little at a dividend), and at nothing else. A step of at least a fifth whose factor jumps as
far as the price is a split; one whose factor stays is a move, however near to a whole ratio.

Without one, a step counts as a split only if all of these hold

- the price falls by a third or more or rises by a half or more, 8 times as far as its steps usually
  do (robust deviation);
- it is a whole ratio (2:1, 3:1, 3:2, 1:10 ...): the opening price within 2 % of the last close, or,
  with no opening prices, the close within 1 %;
- it lasts: the median of ten samples after it is nearer to the new price than to the old one;
- it isn't a day of alarm: price times volume stays below 3 times the median of the 20 days before.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

RATIOS = (1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 50.0)
"""New shares for an old one; a reverse split has the inverse."""

_WORDS = {1.5: "3:2", 2.5: "5:2"}
_LEAST_FACTOR = math.log(1.2)
_EXTREME = 8.0
_NEAR_OPEN, _NEAR_CLOSE, _NEAR_FACTOR = 0.02, 0.01, 0.02
_ALARM, _BEFORE, _AFTER = 3.0, 20, 10


@dataclass(frozen=True)
class Split:
    """A split between a sample and sample `index`.

    `ratio` is such as `2:1` (two new shares for an old one), `factor` what prices from there on are
    multiplied by to compare with those before.
    """

    index: int
    ratio: str
    factor: float


def find_splits(
    price: NDArray[np.float64],
    adjusted: NDArray[np.float64] | None = None,
    opening: NDArray[np.float64] | None = None,
    volume: NDArray[np.float64] | None = None,
) -> list[Split]:
    """Find splits the price isn't adjusted for.

    Parameters
    ----------
    price
        The close, shape (n,), NaN = missing.
    adjusted, opening, volume
        The columns beside it, where the table has them, same shape.

    Returns
    -------
    list
        In order; none for a column with values of 0 or below.
    """
    known = np.flatnonzero(~np.isnan(price))
    if len(known) < 3 or float(price[known].min()) <= 0.0:
        return []
    step = np.diff(np.log(price[known]))
    if adjusted is not None:
        return _by_factor(price, adjusted, known, step)
    usual = 1.4826 * float(np.median(np.abs(step)))
    found = []
    large = np.flatnonzero((np.abs(step) >= math.log(1.4)) & (np.abs(step) > _EXTREME * usual))
    for k in large.tolist():
        before, here = int(known[k]), int(known[k + 1])
        at = price[here]
        near = _NEAR_CLOSE
        if opening is not None and opening[here] > 0.0:
            at, near = opening[here], _NEAR_OPEN
        ratio = _whole(math.log(price[before] / at), near)
        if ratio and _lasts(price[known], k + 1) and not _alarm(price, volume, known, k + 1):
            found.append(Split(here, ratio, _factor(ratio)))
    return found


def _by_factor(
    price: NDArray[np.float64],
    adjusted: NDArray[np.float64],
    known: NDArray[np.int64],
    step: NDArray[np.float64],
) -> list[Split]:
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.log(adjusted[known] / price[known])
    jump = np.diff(factor)
    with np.errstate(invalid="ignore"):
        large = np.flatnonzero(np.abs(jump) >= _LEAST_FACTOR)
    found = []
    for k in large.tolist():
        # a wrong adjusted value jumps too; the price doesn't with it
        if not math.isfinite(jump[k]) or abs(step[k] + jump[k]) > 0.5 * abs(jump[k]):
            continue
        ratio = _whole(jump[k], _NEAR_FACTOR)
        words = ratio or f"{math.exp(jump[k]):.4g}:1"
        found.append(Split(int(known[k + 1]), words, _factor(words)))
    return found


def _whole(log_ratio: float, near: float) -> str:
    """The whole ratio within `near` of this one, or empty."""
    size = abs(log_ratio)
    best = min(RATIOS, key=lambda ratio: abs(size - math.log(ratio)))
    if abs(size - math.log(best)) > math.log1p(near):
        return ""
    words = _WORDS.get(best, f"{best:g}:1")
    return words if log_ratio > 0.0 else ":".join(reversed(words.split(":")))


def _factor(ratio: str) -> float:
    new, old = ratio.split(":")
    return float(new) / float(old)


def _lasts(price: NDArray[np.float64], at: int) -> bool:
    after = math.log(float(np.median(price[at : at + _AFTER])))
    new, old = math.log(price[at]), math.log(price[at - 1])
    return abs(after - new) < abs(after - old)


def _alarm(
    price: NDArray[np.float64],
    volume: NDArray[np.float64] | None,
    known: NDArray[np.int64],
    at: int,
) -> bool:
    if volume is None:
        return False
    turnover = price[known] * volume[known]
    before = turnover[max(0, at - _BEFORE) : at]
    before = before[before > 0.0]
    return bool(before.size and turnover[at] > _ALARM * float(np.median(before)))
