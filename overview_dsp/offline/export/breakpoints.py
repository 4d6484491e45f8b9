"""Piecewise linear approximation of amplitude curves with the least perceptible error.

Amplitudes are perceived by ratio, so the error is measured in dB. `breakpoints` adds points one by
one, at the worst point of the piece with the largest total error (Ramer, Douglas and Peucker, with
a queue), until the budget is spent or no error exceeds a third of a JND. `control_points` finds the
best pieces of a limited number for a part of a clip by dynamic programming: those with the fewest
windows of 10 ms with an error above a JND. Windows with strikes have a higher weight.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterable, Sequence

import numpy as np

from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.offline.export.clip import NOTICEABLE_DB, felt_db
from overview_dsp.units import JUST_NOTICEABLE_DB

GOOD_ENOUGH_DB = JUST_NOTICEABLE_DB / 3.0
GRID_MS = 10  # grid of the points: a window of the felt level
STRIKE_WEIGHT = 4.0  # weight of a window with a strike
_LARGEST_DB = 10.0
_PER_DB = 0.02  # cost of an error of 1 dB, which selects the better of otherwise equal solutions


def breakpoints(level: FloatArray, budget: int, required: Iterable[int] = ()) -> IntArray:
    """Return the positions of a piecewise linear approximation of `level`, including both ends.

    `budget`: number of positions, 2 or more; exceeded only by the `required` positions.
    """
    last = len(level) - 1
    target = felt_db(level)
    positions = {0, last}
    positions.update(position for position in required if 0 < position < last)
    queue: list[tuple[float, int, int, int]] = []

    def measure(first: int, end: int) -> None:
        low, high = first + 1, end - 1
        if high < low:
            return
        inside = np.arange(low, high + 1)
        line = level[first] + (level[end] - level[first]) * (inside - first) / (end - first)
        error = np.abs(felt_db(line) - target[low : high + 1])
        worst = int(np.argmax(error))
        if error[worst] >= GOOD_ENOUGH_DB:
            heapq.heappush(queue, (-float(error.sum()), low + worst, first, end))

    ordered = sorted(positions)
    for first, end in itertools.pairwise(ordered):
        measure(first, end)
    while queue and len(positions) < budget:
        _, position, first, end = heapq.heappop(queue)
        positions.add(position)
        measure(first, position)
        measure(position, end)
    return np.array(sorted(positions), dtype=np.int64)


def control_points(
    level: FloatArray, strikes_ms: Sequence[int], most: int, spacing_ms: tuple[int, int]
) -> tuple[IntArray, FloatArray]:
    """Return the points of a piecewise linear approximation that starts and ends in silence.

    `level`: amplitude at each millisecond, at least as long as the shortest distance.
    `strikes_ms`: positions of strikes, ms.
    `most`: highest number of points after the first, 2 or more.
    `spacing_ms`: shortest and longest distance between neighbours, ms.

    Returns the positions, ms, of which the first and the last are the ends of the part, and
    amplitudes.
    """
    count = (len(level) - 1) // GRID_MS
    positions_ms = np.arange(count + 1) * GRID_MS
    node = level[positions_ms].copy()
    positions_ms[-1] = len(level) - 1
    node[0] = node[-1] = 0.0
    windows = level[: count * GRID_MS].reshape(count, GRID_MS)
    target = felt_db(np.sqrt(np.mean(windows**2, axis=1)))
    weight = np.ones(count)
    for at in strikes_ms:
        weight[at // GRID_MS : at // GRID_MS + 2] = STRIKE_WEIGHT
    cost = _costs(positions_ms, node, target, weight, spacing_ms)
    best = np.full(count + 1, np.inf)
    best[0] = 0.0
    totals, origins = [best], [np.zeros(count + 1, np.int64)]
    for _ in range(most):
        total = totals[-1][:, None] + cost
        origins.append(np.argmin(total, axis=0))
        totals.append(total.min(axis=0))
    pieces = int(np.argmin([total[-1] for total in totals]))
    chosen = [count]
    for origin in origins[pieces:0:-1]:
        chosen.append(int(origin[chosen[-1]]))
    order = np.array(chosen[::-1])
    return positions_ms[order], node[order]


def _costs(
    positions_ms: IntArray,
    node: FloatArray,
    target: FloatArray,
    weight: FloatArray,
    spacing_ms: tuple[int, int],
) -> FloatArray:
    """Return the cost of each linear piece between nodes, (nodes, nodes); inf if not allowed."""
    count = len(target)
    cost = np.full((count + 1, count + 1), np.inf)
    middle = np.arange(count) + 0.5
    for first in range(count):
        for end in range(
            int(np.searchsorted(positions_ms, positions_ms[first] + spacing_ms[0])),
            int(np.searchsorted(positions_ms, positions_ms[first] + spacing_ms[1], side="right")),
        ):
            part = (middle[first:end] - first) / (end - first)
            line = node[first] + (node[end] - node[first]) * part
            error = np.abs(felt_db(line) - target[first:end])
            off = (error > NOTICEABLE_DB) + _PER_DB * np.minimum(error, _LARGEST_DB)
            cost[first, end] = float(weight[first:end] @ off)
    return cost
