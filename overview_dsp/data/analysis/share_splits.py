"""Detection of share splits in prices that are not adjusted for them.

An adjusted column decides, if there is one: its ratio to the price changes only at a split, and a
little at a dividend. A step of at least a fifth in price and ratio is a split. A step in the price
only is a change of value.

Without an adjusted column, a step is a split only if all of these conditions hold:

- the price falls by a third or more or rises by a half or more, 8 times the
  robust deviation of its steps;
- it is a whole ratio (2:1, 3:1, 3:2, 1:10 ...): the opening price within 2 % of the last close, or,
  with no opening prices, the close within 1 %;
- it lasts: the median of the next ten samples is nearer to the new price than to the old one;
- trade is normal: price times volume is below 3 times the median of the 20 days before.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from overview_dsp.arrays import FloatArray, IntArray

RATIOS = (1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 50.0)
"""New shares per old share; a reverse split has the inverse."""

_WORDS = {1.5: "3:2", 2.5: "5:2"}
_LEAST_FACTOR = math.log(1.2)
_EXTREME = 8.0
_NEAR_OPEN, _NEAR_CLOSE, _NEAR_FACTOR = 0.02, 0.01, 0.02
_ALARM, _BEFORE, _AFTER = 3.0, 20, 10


@dataclass(frozen=True)
class Split:
    """Share split directly before sample `index`.

    `ratio` is a text such as `2:1` (two new shares per old share). Prices from `index` on, times
    `factor`, are comparable with those before.
    """

    index: int
    ratio: str
    factor: float


def find_splits(
    price: FloatArray,
    adjusted: FloatArray | None = None,
    opening: FloatArray | None = None,
    volume: FloatArray | None = None,
) -> list[Split]:
    """Find splits for which the price (the close, NaN = missing) is not adjusted, in order.

    There are none for a column with values of 0 or below. `adjusted`, `opening` and `volume` are
    other columns of the table.
    """
    known = np.flatnonzero(~np.isnan(price))
    if len(known) < 3 or float(price[known].min()) <= 0.0:
        return []
    step = np.diff(np.log(price[known]))
    if adjusted is not None:
        return _by_factor(price, adjusted, known, step)
    turnover = None if volume is None else price[known] * volume[known]
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
        if ratio and _lasts(price[known], k + 1) and not _is_heavy_trading(turnover, k + 1):
            found.append(Split(here, ratio, _factor(ratio)))
    return found


def _by_factor(
    price: FloatArray, adjusted: FloatArray, known: IntArray, step: FloatArray
) -> list[Split]:
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.log(adjusted[known] / price[known])
    jump = np.diff(factor)
    with np.errstate(invalid="ignore"):
        large = np.flatnonzero(np.abs(jump) >= _LEAST_FACTOR)
    found = []
    for k in large.tolist():
        # a wrong adjusted value changes the ratio without the price
        if not math.isfinite(jump[k]) or abs(step[k] + jump[k]) > 0.5 * abs(jump[k]):
            continue
        ratio = _whole(jump[k], _NEAR_FACTOR)
        words = ratio or f"{math.exp(jump[k]):.4g}:1"
        found.append(Split(int(known[k + 1]), words, _factor(words)))
    return found


def _whole(log_ratio: float, near: float) -> str:
    """Return the whole-number ratio within `near` of this one, or ""."""
    size = abs(log_ratio)
    best = min(RATIOS, key=lambda ratio: abs(size - math.log(ratio)))
    if abs(size - math.log(best)) > math.log1p(near):
        return ""
    words = _WORDS.get(best, f"{best:g}:1")
    return words if log_ratio > 0.0 else ":".join(reversed(words.split(":")))


def _factor(ratio: str) -> float:
    new, old = ratio.split(":")
    return float(new) / float(old)


def _lasts(price: FloatArray, at: int) -> bool:
    after = math.log(float(np.median(price[at : at + _AFTER])))
    new, old = math.log(price[at]), math.log(price[at - 1])
    return abs(after - new) < abs(after - old)


def _is_heavy_trading(turnover: FloatArray | None, at: int) -> bool:
    if turnover is None:
        return False
    before = turnover[max(0, at - _BEFORE) : at]
    before = before[before > 0.0]
    return bool(before.size and turnover[at] > _ALARM * float(np.median(before)))
