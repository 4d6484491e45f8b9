"""Cost of the friction table's size: the same movement of the disk on coarser tables."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from overview_dsp.kernels import layout
from overview_dsp.measure.bench import SWEEP_S, timed
from overview_dsp.signal.engine.engine import Engine
from tools.bench.disk import Disk

SIZES = (1_024, 4_096, 16_384, layout.CELLS)
REPEATS = 10


class TableOf:
    """The disk alone on a table of `cells` cells, a divisor of the surface's.

    The engine only lends its coefficients and the memory of a surface that it doesn't use.
    """

    def __init__(self, cells: int, engine: Engine, disk: Disk) -> None:
        self.cells = cells
        self._m = engine.memory
        self._start = layout.SURFACES + (layout.SLOTS - 1) * layout.SLOT_SIZE + layout.SLOT_TABLE
        friction = disk.friction[:: layout.CELLS // cells]
        self._pairs = np.stack([friction, np.append(np.diff(friction), 0.0)], axis=1).ravel()
        self._angles = disk.angles * (cells / math.pi)

    def torque(self) -> NDArray[np.float64]:
        """Return the torque (N m) of the movement, float64 [frames]."""
        torque = np.empty(len(self._angles))
        self._run(torque, 1)
        return torque * (layout.CELLS / self.cells)  # the engine's speeds are in its own cells

    def cost(self) -> float:
        """Return the CPU time (s) for one second of it."""
        torque = np.empty(len(self._angles))
        return 1.0 / timed(REPEATS * SWEEP_S, lambda: self._run(torque, REPEATS))

    def _run(self, torque: NDArray[np.float64], repeats: int) -> None:
        from overview_dsp.kernels.disk_alone import disk_alone

        self._m[self._start : self._start + len(self._pairs)] = self._pairs
        for _ in range(repeats):
            disk_alone(self._m, self._start, self._angles, torque)
