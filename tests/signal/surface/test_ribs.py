"""The ribs of a gap, point by point, against their formula."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.signal.surface.patterns import ribs

CELLS, DURATION = 400, 100.0  # four cells a second


def felt(*gaps, height=3.0, period=2.0):
    """The table, NaN where there is data."""
    table = np.full(CELLS + 1, math.nan)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ov.OverviewWarning)
        inside, friction = ribs(gaps, DURATION, CELLS, height, period)
    table[inside] = friction
    return table


def formula(start, end, count, height=3.0):
    """The gap's own, from cell `start` to cell `end`, both in it."""
    table = np.full(CELLS + 1, math.nan)
    for point in range(math.ceil(start), math.floor(end) + 1):
        rib = math.sin(math.pi * count * (point - start) / (end - start)) ** 2
        table[point] = 0.1 + (height - 0.1) * rib**2
    return table


@pytest.mark.parametrize(
    ("gap", "count"),
    [
        ((20.0, 60.0), 20),  # periods of 2 s
        ((10.3, 17.4), 4),  # 3.55 periods, rounded
        ((10.3, 17.2), 3),
        ((0.0, 8.0), 4),
        ((92.0, 100.0), 4),
        ((0.0, 100.0), 50),
        ((40.0, 41.1), 1),
    ],
)
def test_a_gap_has_whole_ribs_as_long_as_the_period_or_nearly(gap, count):
    expected = formula(4.0 * gap[0], 4.0 * gap[1], count)
    assert felt(gap) == pytest.approx(expected, abs=1e-9, nan_ok=True)


def test_the_period_is_a_part_of_the_table():
    expected = formula(0.0, 400.0, 100, 2.0)
    assert felt((0.0, 100.0), height=2.0, period=1.0) == pytest.approx(expected, abs=1e-9)


def test_gaps_are_distinguished_and_data_between_them_is_data():
    gaps = ((0.0, 8.0), (8.5, 12.5), (50.0, 60.0))
    parts = [formula(0, 32, 4), formula(34, 50, 2), formula(200, 240, 5)]
    assert felt(*gaps) == pytest.approx(np.fmax.reduce(parts), abs=1e-9, nan_ok=True)
    assert np.isnan(felt(*gaps)[33])


@pytest.mark.parametrize(
    ("gap", "first", "last"),
    [
        ((50.0, 50.0), 198, 202),
        ((0.0, 0.1), 0, 4),
        ((99.9, 100.0), 396, 400),
        ((25.0, 25.9), 100, 103),
    ],
)
def test_a_gap_too_narrow_for_a_rib_is_one_groove_of_four_cells_or_its_own(gap, first, last):
    table = felt(gap)
    assert np.flatnonzero(~np.isnan(table)).tolist() == list(range(first, last + 1))
    assert table[first : last + 1] == pytest.approx(np.full(last - first + 1, 0.1))


def test_the_narrow_gaps_are_counted_and_the_narrowest_is_named():
    with pytest.warns(
        ov.OverviewWarning, match=r"^1 gap is too narrow.*1:40\.0 .*narrowest: 0\.9 s"
    ):
        ribs(((5.0, 5.9), (20.0, 21.1)), DURATION, CELLS, 3.0, 2.0)
    with pytest.warns(ov.OverviewWarning, match=r"^2 gaps are too narrow.*narrowest: 0\.25 s"):
        ribs(((5.0, 5.9), (20.0, 20.25)), DURATION, CELLS, 3.0, 2.0)
