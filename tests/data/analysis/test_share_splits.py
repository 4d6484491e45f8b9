"""Share splits are told from crashes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from overview_dsp.data.analysis.share_splits import find_splits


def walk(count: int = 400, seed: int = 0, level: float = 100.0) -> NDArray[np.float64]:
    steps = np.random.default_rng(seed).normal(0.0, 0.015, count)
    return level * np.exp(np.cumsum(steps))


def split_at(price: NDArray[np.float64], index: int, ratio: float) -> NDArray[np.float64]:
    found = price.copy()
    found[index:] /= ratio
    return found


@pytest.mark.parametrize(
    ("ratio", "words"),
    [(2.0, "2:1"), (3.0, "3:1"), (1.5, "3:2"), (10.0, "10:1"), (20.0, "20:1"), (0.1, "1:10"),
     (7.0, "7:1"), (0.5, "1:2")],
)  # fmt: skip
@pytest.mark.parametrize("beside", ["nothing", "open", "adjusted", "volume"])
def test_a_split_is_found_whatever_columns_there_are(ratio: float, words: str, beside: str) -> None:
    worth = walk()
    worth[200] = worth[199] * 1.001  # a close that tells by itself
    price = split_at(worth, 200, ratio)
    opening = np.concatenate([price[:1], price[:-1]]) if beside == "open" else None
    if opening is not None:
        opening[200] /= ratio
    (found,) = find_splits(
        price,
        adjusted=worth / 30.0 if beside == "adjusted" else None,
        opening=opening,
        volume=split_at(np.full(400, 1e6), 200, 1.0 / ratio) if beside == "volume" else None,
    )
    assert (found.index, found.ratio) == (200, words)
    assert found.factor == pytest.approx(ratio)


@pytest.mark.parametrize("fall", [0.5, 0.4813, 2.0 / 3.0, 1.0 / 3.0])
def test_a_crash_is_no_split_though_it_halves_the_price(fall: float) -> None:
    worth = walk()
    worth[200:] *= fall * worth[199] / worth[200]
    price = worth.copy()
    assert find_splits(price, adjusted=worth) == []
    # it opens far from a whole ratio, or is traded as in an alarm
    opening = np.concatenate([price[:1], price[:-1]])
    opening[200] = worth[199] * fall * 1.08
    volume = np.full(400, 1e6)
    volume[200] = 6e6 / fall
    assert find_splits(price, opening=opening) == []
    assert find_splits(price, volume=volume) == []


def test_a_price_that_comes_back_is_a_wrong_value_and_no_split() -> None:
    price = walk()
    price[200] = price[199] / 2.0
    assert find_splits(price) == []


def test_a_dividend_and_a_wrong_adjusted_value_are_no_splits() -> None:
    worth = walk()
    price = worth.copy()
    price[200:] *= 0.97
    assert find_splits(price, adjusted=worth) == []
    adjusted = worth.copy()
    adjusted[100] *= 2.0
    assert find_splits(worth, adjusted=adjusted) == []


def test_doubling_is_usual_in_a_wild_series() -> None:
    wild = np.exp(np.cumsum(np.random.default_rng(1).choice([-1.0, 1.0], 200) * math.log(2.0)))
    assert find_splits(wild) == []


def test_what_is_not_above_0_is_no_price() -> None:
    assert find_splits(np.array([1.0, 0.0, 1.0, 2.0, 4.0])) == []
    assert find_splits(np.array([np.nan, 1.0, 2.0])) == []
