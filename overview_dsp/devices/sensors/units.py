"""From a sensor's numbers to m/s² and rad/s along the device's axes."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from overview_dsp.devices.sensors.profile import DETECT, Sensor
from overview_dsp.errors import InputError

GRAVITY = 9.80665
"""m/s²."""

NEAR = 0.15
"""Gravity at rest may be off by so much and still shows its unit."""

RAW = (2048.0, 4096.0, 8192.0, 16384.0)
RAW_NEAR = 0.05
"""What a bare 16-bit sensor says of 1 g, by its range (16, 8, 4 or 2 g)."""

FRAME_ACCELERATION = 1.0 / 2048.0
FRAME_ANGULAR_VELOCITY = 1000.0 / 16384.0
"""g and deg/s of 1 in a binary frame: +-16 g and +-2000 deg/s in an int16, as common sensors do."""

ACCELERATION_UNITS = {"m/s²": 1.0, "g": GRAVITY, "mg": 1e-3 * GRAVITY}
ANGULAR_VELOCITY_UNITS = {"rad/s": 1.0, "deg/s": math.pi / 180.0}

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Units:
    """Factors to m/s² and rad/s, and the axes.

    `words` says what was detected; `turning_known` is False where what 1 of the gyroscope is can't
    be.
    """

    acceleration: float
    angular_velocity: float
    axes: tuple[tuple[int, float], ...]
    words: str
    turning_known: bool = True

    def acceleration_of(self, raw: Sequence[float]) -> Vector:
        """Acceleration along the device's x, y and z, m/s²; upwards is positive at rest."""
        return self._turned(raw, self.acceleration)

    def angular_velocity_of(self, raw: Sequence[float]) -> Vector:
        """Angular velocity about the device's x, y and z, rad/s."""
        return self._turned(raw, self.angular_velocity)

    def _turned(self, raw: Sequence[float], factor: float) -> Vector:
        (i, a), (j, b), (k, c) = self.axes
        return raw[i] * a * factor, raw[j] * b * factor, raw[k] * c * factor


def units_of(sensor: Sensor, binary: bool, at_rest: Sequence[Sequence[float]]) -> Units:
    """Units as the profile says, or detected from gravity.

    `binary`: the numbers are of binary frames; `at_rest`: accelerations as sent, while it lay
    still.

    Raises
    ------
    InputError
        Gravity is that of no unit: says what was read and what to write.
    """
    scale = sensor.number("acceleration.scale")
    turning = sensor.number("angular_velocity.scale")
    detect = sensor.values["acceleration.unit"] == DETECT
    if binary and detect and scale == 1.0:
        scale = FRAME_ACCELERATION
    if binary and sensor.values["angular_velocity.unit"] == DETECT and turning == 1.0:
        turning = FRAME_ANGULAR_VELOCITY
    size = statistics.median(math.hypot(*raw) for raw in at_rest) * abs(scale)
    unit = str(sensor.values["acceleration.unit"])
    counts = raw_of(size) if detect and not binary and abs(scale) == 1.0 else None
    words, turning_known = "", True
    if counts is not None:
        # what is near a power of two and near no unit: the counts of a bare sensor
        scale, unit, turning_known = scale / counts, "g", turning != 1.0
        words = f"{counts:g} of the sensor is 1 g"
        if not turning_known:
            words += (
                ", and what 1 of its gyroscope is can't be known: by gravity alone until "
                "angular_velocity.scale says it (1/131 = 0.007634 at 250 deg/s, 1/16.4 at 2000)"
            )
    elif detect:
        allowed = ("g",) if binary else tuple(ACCELERATION_UNITS)
        near = [name for name in allowed
                if abs(size * ACCELERATION_UNITS[name] / GRAVITY - 1.0) <= NEAR]  # fmt: skip
        if not near:
            raise InputError(
                f"the acceleration at rest is {size:.4g}; gravity is 9.81 m/s², 1 g or 1000 mg. "
                "Hold it still, or give sensor=FILE.toml with acceleration.unit and "
                "acceleration.scale (g for 1 of the sensor, say)"
            )
        unit = near[0]
    turned = str(sensor.values["angular_velocity.unit"])
    if turned == DETECT:
        turned = "rad/s" if unit == "m/s²" else "deg/s"
    return Units(
        scale * ACCELERATION_UNITS[unit],
        turning * ANGULAR_VELOCITY_UNITS[turned],
        sensor.axes,
        words or f"{unit}, {turned}",
        turning_known,
    )


def raw_of(size: float) -> float | None:
    """What a bare sensor says of 1 g, if `size` is that; None if it is none of `RAW`."""
    return next((counts for counts in RAW if abs(size / counts - 1.0) <= RAW_NEAR), None)


def shows_gravity(size: float) -> bool:
    """Whether `size` is gravity in any unit, or in the counts of a bare sensor."""
    near = any(abs(size * one / GRAVITY - 1.0) <= NEAR for one in ACCELERATION_UNITS.values())
    return near or raw_of(size) is not None
