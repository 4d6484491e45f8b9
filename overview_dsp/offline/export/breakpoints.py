"""An amplitude curve as few straight pieces, the points spent where they are felt.

A step in amplitude is felt by its ratio, so the error is measured in dB. Points are added one by
one, in the piece where most is wrong for longest and there at the worst point (Ramer, Douglas and
Peucker's split, with a queue), until the budget is spent or no error is a third of a step.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from overview_dsp.offline.export.clip import FLOOR
from overview_dsp.units import JUST_NOTICEABLE_DB

GOOD_ENOUGH_DB = JUST_NOTICEABLE_DB / 3.0


def felt_db(amplitude: NDArray[np.float64]) -> NDArray[np.float64]:
    """Amplitude in dB of full scale, silent below `FLOOR`."""
    return 20.0 * np.log10(np.maximum(amplitude, FLOOR))


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
