"""The work that every contender does: the bundled match, a sweep of 4 s and its recoil."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.readers import bundled_timeline
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture, sweep
from overview_dsp.design.presets.library import load_preset
from overview_dsp.design.presets.model import Preset
from overview_dsp.signal.engine.engine import Engine

RATE = 48_000
SWEEP_S = 4.0
SECONDS = 8.0
"""Of sound in one run of the full voice."""


def prepared(
    timeline: Timeline | None = None,
    preset: Preset | None = None,
    rate: float = RATE,
    frames: int = round(SECONDS * RATE),
    memory: NDArray[np.float64] | None = None,
) -> Engine:
    """An engine ready for blocks of up to `frames`."""
    engine = Engine(preset or load_preset("football"), timeline or bundled_timeline())
    engine.prepare(rate, frames, memory=memory)
    return engine


def feed(engine: Engine, gesture: Gesture) -> None:
    """A gesture's control events, from now on."""
    now = engine.sample_time
    for stamp, theta2, touching in zip(
        gesture.stamps(engine.sample_rate), gesture.theta2, gesture.touching, strict=True
    ):
        engine.control(float(theta2), bool(touching), now + int(stamp))


def fed(engine: Engine, gesture: Gesture) -> Engine:
    """The engine as new, with a gesture's events waiting."""
    engine.reset()
    feed(engine, gesture)
    return engine


def the_sweep() -> Gesture:
    """The movement of the full voice's work."""
    return sweep(SWEEP_S)


@dataclass(frozen=True, eq=False)
class Disk:
    """What the disk alone needs: a held disk under a steadily moving hand.

    `friction` is float64 (CELLS + 1,) N m s/rad; `hand` the angle (rad) at the middle of each of
    the samples of `SWEEP_S` at `RATE`.
    """

    inertia: float
    k1: float
    k2: float
    friction: NDArray[np.float64]
    hand: NDArray[np.float64]

    @classmethod
    def of(cls, engine: Engine) -> Disk:
        """An engine's disk and surface."""
        inertia, k1, k2 = (engine.preset.number(f"disk.{name}") for name in ("inertia", "k1", "k2"))
        middle = (np.arange(round(SWEEP_S * RATE)) + 0.5) / RATE
        return cls(inertia, k1, k2, engine.surface.friction, middle * (math.pi / SWEEP_S))
