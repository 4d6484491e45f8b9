"""What a knob's own board runs: the surface's friction as a small table, and the disk."""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.design.presets.parameter import Value
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.signal.surface.model import Surface
from overview_dsp.units import HALF_TURN

HIGHEST = 65535

HARD = 1.0 / 3.0
"""Where between the bare surface (0) and the highest friction (1), in ratios, half of a blow
counts: above a card's flanks and below a goal."""

DISK_KEYS = ("disk.inertia", "disk.k1", "disk.k2", "clutch.max_speed_ratio",
             "clutch.tap_duration_s", "input.smoothing_ms")  # fmt: skip
"""Of a preset, what a board's disk is made of."""

_DISK = struct.Struct("<12f")


@dataclass(frozen=True, eq=False)
class BoardTable:
    """A surface as a board holds it.

    Attributes
    ----------
    points : uint16 (n,)
        Friction at equal steps from one end of the surface to the other, each the mean of its cell.
    unit : float
        What 1 of them is, N m s/rad.
    hard : float
        Friction of so much gives half its knock, N m s/rad.
    """

    points: NDArray[np.uint16]
    unit: float
    hard: float


def board_table(surface: Surface, count: int) -> BoardTable:
    """A surface's friction in `count` points.

    What a crossing costs is the integral of the friction, so a point is the mean of all that is
    nearer to it than to the next one: nothing is lost, however narrow.
    """
    friction = surface.resistance
    cells = len(friction) - 1
    summed = np.concatenate([[0.0], np.cumsum(0.5 * (friction[1:] + friction[:-1]))])
    edges = np.clip((np.arange(count + 1) - 0.5) * (cells / (count - 1)), 0.0, cells)
    # the integral of what is linear between the cells
    whole = np.minimum(edges.astype(np.int64), cells - 1)
    part = edges - whole
    integral = summed[whole] + part * (
        friction[whole] + 0.5 * part * (friction[whole + 1] - friction[whole])
    )
    means = np.diff(integral) / np.diff(edges)
    unit = float(means.max()) / HIGHEST
    points = np.clip(np.rint(means / unit), 1, HIGHEST).astype(np.uint16)
    bare = float(np.median(means))
    return BoardTable(points, unit, bare * (float(means.max()) / bare) ** HARD)


def pack_disk(values: Mapping[str, Value], sensor: Sensor) -> bytes:
    """The disk of a preset's `values`, as a board takes it (`KnobDisk` of `surface.h`).

    `sensor` says how much of it the knob gives, and how far it is turned for the timeline.
    """
    inertia, k1, k2, ratio, tap_s, smoothing_ms = (float(values[key]) for key in DISK_KEYS)
    per_rad = HALF_TURN / math.radians(sensor.number("motor.turn_deg"))
    return _DISK.pack(
        inertia, k1, k2, ratio, tap_s * (ratio or 1.0), smoothing_ms * 1e-3,
        sensor.number("motor.board_scale"), sensor.number("motor.knock"),
        sensor.number("motor.home"), sensor.number("motor.ceiling_nm"),
        sensor.number("motor.end_nm_per_rad"),
        -per_rad if sensor.values["motor.reverse"] else per_rad,
    )  # fmt: skip
