"""Conversion of a sensor's numbers to m/s² and rad/s along the device's axes."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from overview_dsp.devices.sensors.profile import DETECT, Sensor
from overview_dsp.errors import InputError

GRAVITY = 9.80665  # m/s²
UNIT_TOLERANCE = 0.15  # relative error of gravity at rest up to which it still identifies the unit
COUNTS_PER_G = (2048.0, 4096.0, 8192.0, 16384.0)
COUNTS_TOLERANCE = 0.05
"""Counts of an unscaled 16-bit sensor at 1 g, for ranges of 16, 8, 4 and 2 g."""

FRAME_ACCELERATION = 1.0 / 2048.0
FRAME_ANGULAR_VELOCITY = 1000.0 / 16384.0
"""Values of 1 count in a binary frame, g and deg/s: int16 for ±16 g and ±2000 deg/s."""

ACCELERATION_UNITS = {"m/s²": 1.0, "g": GRAVITY, "mg": 1e-3 * GRAVITY}
ANGULAR_VELOCITY_UNITS = {"rad/s": 1.0, "deg/s": math.pi / 180.0}

Vector = tuple[float, float, float]


def unit(vector: Vector) -> Vector:
    """Return the vector's direction; z for the zero vector."""
    length = math.hypot(*vector)
    if length == 0.0:
        return (0.0, 0.0, 1.0)
    return vector[0] / length, vector[1] / length, vector[2] / length


def angle_between(a: Vector, b: Vector) -> float:
    """Return the angle between two unit vectors, rad."""
    cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return math.acos(max(-1.0, min(1.0, cosine)))


def mix(a: Vector, b: Vector, share: float) -> Vector:
    """Return the vector at `share` (0 to 1) of the line from `a` to `b`."""
    x, y, z = (p + (q - p) * share for p, q in zip(a, b, strict=True))
    return x, y, z


def rotate(rows: tuple[Vector, Vector, Vector], vector: Vector) -> Vector:
    """Return a rotation, given by its rows, of a vector."""
    x, y, z = vector
    p, q, r = (a * x + b * y + c * z for a, b, c in rows)
    return p, q, r


def to_device_axes(
    axes: tuple[tuple[int, float], ...], raw: Sequence[float], factor: float = 1.0
) -> Vector:
    """Return a sensor's vector along the device's axes (`Sensor.axes`), times `factor`."""
    (i, a), (j, b), (k, c) = axes
    return raw[i] * a * factor, raw[j] * b * factor, raw[k] * c * factor


@dataclass(frozen=True)
class Units:
    """Factors to m/s² and rad/s, and the axes; `description` names the detected units."""

    acceleration: float
    angular_velocity: float
    axes: tuple[tuple[int, float], ...]
    description: str
    gyroscope_known: bool = True

    def acceleration_of(self, raw: Sequence[float]) -> Vector:
        """Return the acceleration along the device's axes, m/s²; upwards is positive at rest."""
        return to_device_axes(self.axes, raw, self.acceleration)

    def angular_velocity_of(self, raw: Sequence[float]) -> Vector:
        """Return the angular velocity about the device's axes, rad/s."""
        return to_device_axes(self.axes, raw, self.angular_velocity)


def units_of(sensor: Sensor, binary: bool, at_rest: Sequence[Sequence[float]]) -> Units:
    """Return the units of the profile, or those detected from gravity; InputError if it fits none.

    `binary`: whether the numbers come from binary frames.
    `at_rest`: raw accelerations while the sensor was at rest.
    """
    scale = sensor.number("acceleration.scale")
    gyroscope_scale = sensor.number("angular_velocity.scale")
    detect = sensor.values["acceleration.unit"] == DETECT
    if binary and detect and scale == 1.0:
        scale = FRAME_ACCELERATION
    if binary and sensor.values["angular_velocity.unit"] == DETECT and gyroscope_scale == 1.0:
        gyroscope_scale = FRAME_ANGULAR_VELOCITY
    size = statistics.median(math.hypot(*raw) for raw in at_rest) * abs(scale)
    acceleration_unit = str(sensor.values["acceleration.unit"])
    counts = counts_per_g(size) if detect and not binary and abs(scale) == 1.0 else None
    description, gyroscope_known = "", True
    if counts is not None:
        # a size near a power of two and near no unit: the counts of an unscaled sensor
        scale, acceleration_unit, gyroscope_known = scale / counts, "g", gyroscope_scale != 1.0
        description = f"{counts:g} of the sensor is 1 g"
        if not gyroscope_known:
            description += (
                ", and the unit of its gyroscope is unknown: roll follows gravity alone until "
                "angular_velocity.scale is set (1/131 = 0.007634 at 250 deg/s, 1/16.4 at 2000)"
            )
    elif detect:
        allowed = ("g",) if binary else tuple(ACCELERATION_UNITS)
        near = [name for name in allowed if is_unit_of_gravity(size, ACCELERATION_UNITS[name])]
        if not near:
            raise InputError(
                f"the acceleration at rest is {size:.4g}; must be near that of gravity, 9.81 m/s², "
                "1 g or 1000 mg. Hold the sensor at rest, or set acceleration.unit and "
                "acceleration.scale (g of 1 count, for example) in a file for sensor=FILE.toml"
            )
        acceleration_unit = near[0]
    gyroscope_unit = str(sensor.values["angular_velocity.unit"])
    if gyroscope_unit == DETECT:
        gyroscope_unit = "rad/s" if acceleration_unit == "m/s²" else "deg/s"
    return Units(
        scale * ACCELERATION_UNITS[acceleration_unit],
        gyroscope_scale * ANGULAR_VELOCITY_UNITS[gyroscope_unit],
        sensor.axes,
        description or f"{acceleration_unit}, {gyroscope_unit}",
        gyroscope_known,
    )


def counts_per_g(size: float) -> float | None:
    """Return the counts at 1 g of an unscaled sensor if `size` is near one of them."""
    return next((n for n in COUNTS_PER_G if abs(size / n - 1.0) <= COUNTS_TOLERANCE), None)


def is_unit_of_gravity(size: float, unit: float) -> bool:
    """Return whether `size` is gravity in a unit of `unit` m/s²."""
    return abs(size * unit / GRAVITY - 1.0) <= UNIT_TOLERANCE


def is_gravity(size: float) -> bool:
    """Return whether `size` is gravity in any unit, or in the counts of an unscaled sensor."""
    near = any(is_unit_of_gravity(size, unit) for unit in ACCELERATION_UNITS.values())
    return near or counts_per_g(size) is not None
