"""The disk alone: input for other ways to compute it, and our torque."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.kernels.layout import CELLS
from overview_dsp.measure.bench import RATE, SWEEP_S, disk
from overview_dsp.signal.engine.engine import Engine


@dataclass(frozen=True, eq=False)
class Disk:
    """Parameters and input of the disk alone, touched and moved at a constant speed.

    `friction` is float64 (CELLS + 1,) N m s/rad. `angles` is the input angle (rad) at the middle of
    each sample of `SWEEP_S` at `RATE`.
    """

    inertia: float
    k1: float
    k2: float
    friction: NDArray[np.float64]
    angles: NDArray[np.float64]

    @classmethod
    def of(cls, engine: Engine) -> Disk:
        """Return an engine's disk and surface."""
        inertia, k1, k2 = (engine.preset.number(f"disk.{name}") for name in ("inertia", "k1", "k2"))
        middle = (np.arange(round(SWEEP_S * RATE)) + 0.5) / RATE
        return cls(inertia, k1, k2, engine.surface.friction, middle * (math.pi / SWEEP_S))


def disk_alone(engine: Engine, inputs: Disk) -> NDArray[np.float64]:
    """Return our torque (N m) of the disk alone, float64 [frames]."""
    torque = np.empty(len(inputs.angles))
    disk(engine, inputs.angles * (CELLS / math.pi), torque)
    return torque
