"""How fast the engine runs here, beside other ways to do the same work.

Everything is measured in one run, rounds interleaved, so that ratios hold although the machine's
speed drifts. The work is the bundled match, a 4 s sweep and its recoil.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from overview_dsp.engine import TRACE_COLUMNS, Engine
from overview_dsp.gestures import sweep
from overview_dsp.presets import load_preset
from overview_dsp.surface import CELLS
from overview_dsp.timeline import bundled_timeline

RATE = 48_000
SECONDS = 8.0
PLAIN_SECONDS = 0.25
SOLVER_RTOL = 1e-6


@dataclass(frozen=True)
class Row:
    """A contender: what it does, and how many seconds of sound it makes in a second."""

    name: str
    median: float
    low: float
    high: float


def _loaded() -> Engine:
    engine = Engine(load_preset("football"), bundled_timeline())
    engine.prepare(RATE, round(SECONDS * RATE))
    return engine


def _feed(engine: Engine) -> None:
    engine.reset()
    gesture = sweep(4.0)
    for stamp, theta2, touching in zip(
        gesture.stamps(RATE), gesture.theta2, gesture.touching, strict=True
    ):
        engine.control(float(theta2), bool(touching), int(stamp))


def _voice(engine: Engine, block: int, traced: bool) -> Callable[[], float]:
    frames = round(SECONDS * RATE)
    out = np.zeros((frames, 2), dtype=np.float32)
    table = np.zeros((frames, len(TRACE_COLUMNS))) if traced else None

    def run() -> float:
        _feed(engine)
        started = time.perf_counter()
        for first in range(0, frames, block):
            part = table[first : first + block] if table is not None else None
            engine.process(out[first : first + block], part)
        return SECONDS / (time.perf_counter() - started)

    return run


def _plain_loop(engine: Engine) -> Callable[[], float]:
    """The two disks alone, as anyone would type them: floats, a list for the table."""
    preset = engine.preset
    inertia, k1, k2 = (preset.number(f"disk.{name}") for name in ("inertia", "k1", "k2"))
    table = engine.surface.friction.tolist()
    cells = CELLS * (k1 + k2) / k2 / np.pi
    frames = round(PLAIN_SECONDS * RATE)

    def run() -> float:
        dt = 1.0 / RATE
        theta = omega = 0.0
        hand = 0.0
        started = time.perf_counter()
        for n in range(frames):
            hand += 0.005 * (np.pi * n * dt / 4.0 - hand)
            place = min(max((theta + 0.5 * dt * omega) * cells, 0.0), CELLS - 1e-9)
            i = int(place)
            b = table[i] + (place - i) * (table[i + 1] - table[i])
            k = k1 + k2
            mean = (2 * inertia * omega + dt * (k2 * hand - k * theta)) / (
                2 * inertia + dt * b + 0.5 * dt * dt * k
            )
            theta += dt * mean
            omega = 2 * mean - omega
            torque = b * mean
        assert torque > 0.0
        return PLAIN_SECONDS / (time.perf_counter() - started)

    return run


def _solver(engine: Engine) -> Callable[[], float]:
    """The two disks alone, by scipy's solve_ivp (LSODA)."""
    from scipy.integrate import solve_ivp

    preset = engine.preset
    inertia, k1, k2 = (preset.number(f"disk.{name}") for name in ("inertia", "k1", "k2"))
    table = engine.surface.friction.tolist()
    cells = CELLS * (k1 + k2) / k2 / np.pi

    def motion(t: float, state: list[float]) -> tuple[float, float]:
        theta, omega = state
        place = min(max(theta * cells, 0.0), CELLS - 1e-9)
        i = int(place)
        b = table[i] + (place - i) * (table[i + 1] - table[i])
        return omega, (k2 * np.pi * t / 4.0 - (k1 + k2) * theta - b * omega) / inertia

    def run() -> float:
        started = time.perf_counter()
        solve_ivp(motion, (0.0, 1.0), [0.0, 0.0], method="LSODA", rtol=SOLVER_RTOL, atol=1e-9)
        return 1.0 / (time.perf_counter() - started)

    return run


_INTERPRETED = """
import time, warnings
import numpy as np
warnings.simplefilter("ignore", RuntimeWarning)
from overview_dsp.bench.speed import PLAIN_SECONDS, RATE, _feed, _loaded
engine = _loaded()
_feed(engine)
out = np.zeros((round(PLAIN_SECONDS * RATE), 2), dtype=np.float32)
started = time.perf_counter()
engine.process(out)
print(PLAIN_SECONDS / (time.perf_counter() - started))
"""


def _interpreted() -> float:
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(
        [sys.executable, "-c", _INTERPRETED],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout)


def measure(rounds: int = 7, progress: Callable[[float], None] | None = None) -> list[Row]:
    """Run every contender `rounds` times, in turn; medians with lowest and highest."""
    engine = _loaded()
    contenders: dict[str, Callable[[], float]] = {
        "full voice, one call": _voice(engine, round(SECONDS * RATE), False),
        "full voice with trace": _voice(engine, round(SECONDS * RATE), True),
        "full voice, 64-frame calls": _voice(engine, 64, False),
        "full voice, the same source as plain Python": _interpreted,
        "two disks alone, plain Python loop": _plain_loop(engine),
        f"two disks alone, solve_ivp LSODA, rtol {SOLVER_RTOL:g}": _solver(engine),
    }
    speeds: dict[str, list[float]] = {name: [] for name in contenders}
    contenders["full voice, one call"]()
    for round_ in range(rounds):
        for name, run in contenders.items():
            speeds[name].append(run())
        if progress:
            progress((round_ + 1) / rounds)
    return [
        Row(name, statistics.median(found), min(found), max(found))
        for name, found in speeds.items()
    ]
