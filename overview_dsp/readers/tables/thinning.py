"""Long series by their lowest and highest samples: few enough to find events among."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

MOST = 400_000
"""Samples that are kept; beyond, every two runs become one."""

RUN = 64
"""Samples in a run at first."""

STEPS = 16
"""How many of the largest steps up, and down, are kept besides."""


def lows_and_highs(value: NDArray[np.float64], run: int) -> NDArray[np.int64]:
    """Return where the lowest and the highest of each `run` values are (the first of equal ones).

    Parameters
    ----------
    value
        Shape (n,), finite.

    Returns
    -------
    ndarray
        Indices, ascending.
    """
    whole = len(value) // run * run
    rows = value[:whole].reshape(-1, run)
    begins = np.arange(0, whole, run)
    found = [begins + rows.argmin(axis=1), begins + rows.argmax(axis=1)]
    if whole < len(value):
        rest = value[whole:]
        found.append(np.array([whole + rest.argmin(), whole + rest.argmax()]))
    return np.unique(np.concatenate(found))


@dataclass
class Thinner:
    """Takes samples block by block and keeps the lowest and highest of equal runs.

    Every prominent turning point, both extremes and the largest steps are among those kept, at
    their own times.
    """

    run: int = RUN
    count: int = 0
    _parts: list[NDArray[np.float64]] = field(default_factory=list)
    _kept: int = 0
    _steps: NDArray[np.float64] = field(default_factory=lambda: np.empty((3, 0)))

    def add(
        self, time_s: NDArray[np.float64], value: NDArray[np.float64], step: NDArray[np.float64]
    ) -> None:
        """Take samples with a value, in order, shape (n,); `step` NaN = none."""
        if not len(value):
            return
        self.count += len(value)
        samples = np.stack((time_s, value, step))
        self._steps = _largest(np.concatenate((self._steps, _largest(samples)), axis=1))
        part = samples[:, lows_and_highs(value, self.run)]
        self._parts.append(part)
        self._kept += part.shape[1]
        while self._kept > MOST:
            whole = np.concatenate(self._parts, axis=1)
            whole = whole[:, lows_and_highs(whole[1], 4)]
            self._parts, self._kept = [whole], whole.shape[1]
            self.run *= 2

    def finish(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return times, values and steps of the samples kept, in order."""
        whole = np.concatenate((*self._parts, self._steps), axis=1)
        _, first = np.unique(whole[0], return_index=True)
        time_s, value, step = whole[:, first]
        return time_s, value, step


def _largest(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """The samples with the largest steps up and down."""
    known = np.flatnonzero(~np.isnan(samples[2]))
    step = samples[2, known]
    if len(known) > 2 * STEPS:
        order = np.argpartition(step, (STEPS, len(step) - STEPS))
        known = known[np.concatenate((order[:STEPS], order[-STEPS:]))]
    return samples[:, np.sort(known)]
