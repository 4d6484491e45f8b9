"""The disk alone by general means: a plain Python loop, scipy's solvers, a filter.

A solver may choose its own steps. It runs at the loosest tolerance whose torque is as close to a
tight reference as the kernel's torque, both at the middle of each sample.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from overview_dsp.kernels.layout import CELLS
from overview_dsp.measure.bench import DISK, RATE, SWEEP_S, Contender, prepared, timed
from overview_dsp.signal.engine.engine import Engine
from tools.bench.disk import Disk, disk_alone

SOLVED_S = 0.5
"""Duration of the part of the sweep that the solvers compute."""

METHODS = ("LSODA", "RK45", "DOP853")
TOLERANCES = tuple(10.0 ** (-0.5 * step) for step in range(4, 24))
REFERENCE_TOLERANCE = 1e-13
LOOP_S = 0.25


def plain_loop(disk: Disk, frames: int) -> list[float]:
    """Return the torque (N m) of a straightforward loop: floats, and a list for the table."""
    table = disk.friction.tolist()
    angles = disk.angles[:frames].tolist()
    inertia, k1, k2 = disk.inertia, disk.k1, disk.k2
    k = k1 + k2
    cells = CELLS * k / k2 / math.pi
    dt = 1.0 / RATE
    theta = omega = 0.0
    torque = []
    for angle in angles:
        position = min(max((theta + 0.5 * dt * omega) * cells, 0.0), CELLS - 1e-9)
        i = int(position)
        b = table[i] + (position - i) * (table[i + 1] - table[i])
        mean = (2 * inertia * omega + dt * (k2 * angle - k * theta)) / (
            2 * inertia + dt * b + 0.5 * dt * dt * k
        )
        theta += dt * mean
        omega = 2 * mean - omega
        torque.append(b * mean)
    return torque


def solved(disk: Disk, method: str, tolerance: float) -> NDArray[np.float64]:
    """Return the torque (N m) at the middle of each sample of `SOLVED_S`, by scipy's solve_ivp."""
    from scipy.integrate import solve_ivp

    table = disk.friction.tolist()
    inertia, k1, k2 = disk.inertia, disk.k1, disk.k2
    k = k1 + k2
    cells = CELLS * k / k2 / math.pi
    speed = math.pi / SWEEP_S

    def friction(theta: float) -> float:
        position = min(max(theta * cells, 0.0), CELLS - 1e-9)
        i = int(position)
        value: float = table[i] + (position - i) * (table[i + 1] - table[i])
        return value

    def motion(t: float, state: list[float]) -> tuple[float, float]:
        theta, omega = state
        return omega, (k2 * speed * t - k * theta - friction(theta) * omega) / inertia

    middle = (np.arange(round(SOLVED_S * RATE)) + 0.5) / RATE
    found = solve_ivp(
        motion, (0.0, SOLVED_S), [0.0, 0.0], method=method, t_eval=middle,
        rtol=tolerance, atol=tolerance * 1e-2,
    )  # fmt: skip
    torque: NDArray[np.float64] = np.array([friction(at) for at in found.y[0]]) * found.y[1]
    return torque


def error(torque: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
    """Return the RMS of the difference, relative to the RMS of the reference."""
    return float(np.sqrt(np.mean((torque - reference) ** 2) / np.mean(reference**2)))


def loosest(
    disk: Disk, method: str, reference: NDArray[np.float64], allowed: float
) -> tuple[float, float]:
    """Return the loosest tolerance whose error is at most `allowed`, and that error.

    If every error is larger, this is the tightest tolerance.
    """
    found = math.inf
    for tolerance in TOLERANCES:
        found = error(solved(disk, method, tolerance), reference)
        if found <= allowed:
            return tolerance, found
    return TOLERANCES[-1], found


def contenders(progress: Callable[[float], None] | None = None) -> list[Contender]:
    """Return the plain loop, the solvers and the filter."""
    engine = prepared()
    disk = Disk.of(engine)
    part = replace(disk, angles=disk.angles[: round(SOLVED_S * RATE)])
    reference = solved(part, "DOP853", REFERENCE_TOLERANCE)
    ours = error(disk_alone(engine, part), reference)
    rows = []
    for number, method in enumerate(METHODS):
        tolerance, found = loosest(part, method, reference, ours)
        name = (
            f"scipy solve_ivp {method}, rtol {tolerance:.1g}, error {found:.1e} (ours {ours:.1e})"
        )

        def run(method: str = method, tolerance: float = tolerance) -> float:
            return timed(SOLVED_S, lambda: solved(part, method, tolerance))

        rows.append(Contender(DISK, name, run))
        if progress:
            progress((number + 1) / len(METHODS))
    frames = round(LOOP_S * RATE)
    return [
        *rows,
        Contender(
            DISK,
            "a plain Python loop",
            lambda: timed(LOOP_S, lambda: plain_loop(disk, frames)),
        ),
        Contender(
            DISK, "scipy.signal.lfilter, friction fixed", lambda: timed(SWEEP_S, fixed(engine))
        ),
    ]


def fixed(engine: Engine) -> Callable[[], object]:
    """Return the disk with constant friction, that of the surface's first point, as a filter."""
    from scipy.signal import lfilter

    disk = Disk.of(engine)
    b = float(disk.friction[0])
    dt = 1.0 / RATE
    k = disk.k1 + disk.k2
    least = disk.inertia + 0.5 * b * dt + 0.25 * k * dt * dt
    twice = 2.0 * disk.inertia - 0.5 * k * dt * dt
    back = disk.inertia - 0.5 * b * dt + 0.25 * k * dt * dt
    forward = np.array([0.25, 0.5, 0.25]) * (disk.k2 * dt * dt)
    return lambda: lfilter(forward / least, [1.0, -twice / least, back / least], disk.angles)
