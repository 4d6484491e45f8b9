"""Calibration of a sensor at rest at the start: units, rate, bias, direction of up."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from overview_dsp.devices.sensors.orientation import HIGHEST_BIAS_DEG_S
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.units import Units, Vector, angle_between, unit, units_of
from overview_dsp.errors import InputError

STILL_DEG_S = 3.0  # largest standard deviation of a gyroscope at rest

SLOWEST_HZ, FASTEST_HZ = 25.0, 2000.0
IMPOSSIBLE_HZ, IMPOSSIBLE_S = 50_000.0, 0.5

Rotation = tuple[Vector, Vector, Vector]  # rows of a rotation
NO_ROTATION: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
CALIBRATING = "calibrating: keep it at rest, face up"


@dataclass(frozen=True)
class RawSample:
    """One sample as received: time (s), acceleration, angular velocity if there is any."""

    time_s: float
    acceleration: tuple[float, ...]
    angular_velocity: tuple[float, ...] | None


@dataclass(frozen=True)
class Calibration:
    """Result of a calibration.

    `bias` is in rad/s, `level` turns the first direction of up to face up, `description` is a text.
    """

    units: Units
    period_s: float
    bias: Vector
    level: Rotation
    description: str


def calibrate(sensor: Sensor, binary: bool, samples: Sequence[RawSample]) -> Calibration:
    """Calibrate by the first samples; InputError if gravity or the clock fits no unit."""
    units = units_of(sensor, binary, [one.acceleration for one in samples])
    period = statistics.median(b.time_s - a.time_s for a, b in pairwise(samples))
    if not 1.0 / IMPOSSIBLE_HZ <= period <= IMPOSSIBLE_S:
        raise InputError(
            f"the samples are {period:.3g} s apart; must come {SLOWEST_HZ:g} to {FASTEST_HZ:g} "
            "times per second. Check the unit of the stamps (t_us, t_ms, t_s), and reduce any "
            "delay(...) in the sketch to at most 10"
        )
    rate = 1.0 / period
    has_gyroscope = samples[0].angular_velocity
    units_text = units.description if has_gyroscope else units.description.split(",")[0]
    notes = [f"{rate:.4g} Hz, {units_text}"]
    if not 0.95 * SLOWEST_HZ <= rate <= 1.05 * FASTEST_HZ:
        notes.append(f"made for {SLOWEST_HZ:g} to {FASTEST_HZ:g} Hz")
    if rate < 0.95 * SLOWEST_HZ:
        notes.append("reduce the delay(...) in the sketch's loop() to at most 10")
    bias, note = _bias(units, samples)
    notes.append(note)
    up = unit(_mean([units.acceleration_of(one.acceleration) for one in samples]))
    level, note = level_by(up, sensor)
    notes.append(note)
    return Calibration(units, period, bias, level, "; ".join(note for note in notes if note))


def level_by(up: Vector, sensor: Sensor) -> tuple[Rotation, str]:
    """Return the rotation that makes `up` face up, and a note about it.

    So does the opposite of the sensor's own z: its z points down, or its signs are turned round.
    Where `up` is too far from either (`calibration.level_deg`), its own axes stay.
    """
    lean = math.degrees(angle_between(up, (0.0, 0.0, 1.0)))
    limit = sensor.number("calibration.level_deg")
    if lean <= limit:
        note = f"face up is {lean:.1f} degrees from the sensor's own z axis"
        return levelling_rotation(up), note
    if lean >= 180.0 - limit:
        p, q, r = levelling_rotation((up[0], -up[1], -up[2]))
        flipped = tuple((row[0], -row[1], -row[2]) for row in (p, q, r))
        return flipped, "it started face down by its own z axis, which counts as face up"  # type: ignore[return-value]
    if limit == 0.0:
        return NO_ROTATION, ""
    return NO_ROTATION, f"it started {lean:.0f} degrees from face up: its own axes are used"


def _mean(vectors: Sequence[Vector]) -> Vector:
    x, y, z = (statistics.fmean(axis) for axis in zip(*vectors, strict=True))
    return x, y, z


def _bias(units: Units, samples: Sequence[RawSample]) -> tuple[Vector, str]:
    """Return the gyroscope's bias (0 if unknown), and a note on why it is unknown."""
    speeds = [
        units.angular_velocity_of(one.angular_velocity) for one in samples if one.angular_velocity
    ]
    if not units.gyroscope_known:
        return (0.0, 0.0, 0.0), ""
    if not speeds:
        return (0.0, 0.0, 0.0), "no gyroscope: roll follows gravity alone"
    bias = _mean(speeds)
    spread = max(statistics.pstdev(axis) for axis in zip(*speeds, strict=True))
    still = math.degrees(spread) <= STILL_DEG_S
    if not still or math.degrees(math.hypot(*bias)) > HIGHEST_BIAS_DEG_S:
        return (0.0, 0.0, 0.0), "it moved at the start: its bias is measured at the next rest"
    return bias, ""


def levelling_rotation(up: Vector) -> Rotation:
    """Return the smallest rotation that turns `up` to z (Rodrigues; up[2] > 0)."""
    x, y, z = up
    k = 1.0 / (1.0 + z)
    return (1.0 - k * x * x, -k * x * y, -x), (-k * x * y, 1.0 - k * y * y, -y), (x, y, z)
