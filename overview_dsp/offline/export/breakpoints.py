"""An amplitude curve as few straight pieces, the points spent where they are felt.

A step in amplitude is felt by its ratio, so the error is measured in dB. `breakpoints` adds points
one by one, in the piece where most is wrong for longest and there at the worst point (Ramer,
Douglas and Peucker's split, with a queue), until the budget is spent or no error is a third of a
step. `control_points` takes the best of all ways to lay a limited number of pieces over a part of a
clip, by dynamic programming: the one with the fewest windows of 10 ms that are more than a step
off; strikes count more than what is between them.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from overview_dsp.offline.export.clip import NOTICEABLE_DB, felt_db
from overview_dsp.units import JUST_NOTICEABLE_DB

GOOD_ENOUGH_DB = JUST_NOTICEABLE_DB / 3.0

GRID_MS = 10
"""Points lie on this grid: a window of the felt level."""

STRIKE_WEIGHT = 4.0
"""A window in which something strikes counts as so many."""

_LARGEST_DB = 10.0
_PER_DB = 0.02
"""Besides windows that are off, so much is an error of 1 dB: of two ways, the nearer one."""


def breakpoints(
    level: NDArray[np.float64],
    budget: int,
    kept: Iterable[int] = (),
) -> NDArray[np.int64]:
    """The positions to join by straight lines, both ends among them.

    Parameters
    ----------
    level : float64 (n,), n >= 2
    budget
        How many positions, 2 or more; those that must be are there even if they are more.
    kept
        Places that must be there.

    Returns
    -------
    int64 (m,), ascending
    """
    last = len(level) - 1
    target = felt_db(level)
    positions = {0, last}
    positions.update(position for position in kept if 0 < position < last)
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
    level: NDArray[np.float64],
    struck: Sequence[int],
    most: int,
    apart_ms: tuple[int, int],
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Points to join by straight lines, from silence to silence.

    Parameters
    ----------
    level : float64 (n,)
        Amplitude at each millisecond, the shortest distance or longer.
    struck
        Places of strikes, ms.
    most
        How many points after the first, 2 or more.
    apart_ms
        The shortest and the longest distance between neighbours, ms.

    Returns
    -------
    places : int64 (m,)
        The first and the last place are the part's ends.
    amplitudes : float64 (m,)
    """
    count = (len(level) - 1) // GRID_MS
    places = np.arange(count + 1) * GRID_MS
    node = level[places].copy()
    places[-1] = len(level) - 1
    node[0] = node[-1] = 0.0
    windows = level[: count * GRID_MS].reshape(count, GRID_MS)
    target = felt_db(np.sqrt(np.mean(windows**2, axis=1)))
    weight = np.ones(count)
    for place in struck:
        weight[place // GRID_MS : place // GRID_MS + 2] = STRIKE_WEIGHT
    cost = _costs(places, node, target, weight, apart_ms)
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
    return places[order], node[order]


def _costs(
    places: NDArray[np.int64],
    node: NDArray[np.float64],
    target: NDArray[np.float64],
    weight: NDArray[np.float64],
    apart_ms: tuple[int, int],
) -> NDArray[np.float64]:
    """What a straight piece from one node to another costs, (nodes, nodes); infinite if barred."""
    count = len(target)
    cost = np.full((count + 1, count + 1), np.inf)
    middle = np.arange(count) + 0.5
    for first in range(count):
        for end in range(
            int(np.searchsorted(places, places[first] + apart_ms[0])),
            int(np.searchsorted(places, places[first] + apart_ms[1], side="right")),
        ):
            part = (middle[first:end] - first) / (end - first)
            line = node[first] + (node[end] - node[first]) * part
            error = np.abs(felt_db(line) - target[first:end])
            off = (error > NOTICEABLE_DB) + _PER_DB * np.minimum(error, _LARGEST_DB)
            cost[first, end] = float(weight[first:end] @ off)
    return cost
