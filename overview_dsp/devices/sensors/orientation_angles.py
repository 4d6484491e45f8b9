"""Theta2 from an orientation that the sensor has computed: a quaternion or three angles.

Theta2 is the absolute roll angle: face up 0, face down pi, by either wrist. A turn to the left and
a turn to the right move theta2 the same way. Where the sign of the roll changes, it doesn't jump.

Where the device points up or down (pitch beyond 85 degrees), a small tilt changes the roll by any
amount. Theta2 is held there. Below 82 degrees it returns to the true angle, at most at 400 deg/s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from overview_dsp.devices.sensors.calibration import CALIBRATING, Rotation, level_by
from overview_dsp.devices.sensors.profile import DETECT, Sensor
from overview_dsp.devices.sensors.reading import ANGLES, QUATERNION, Counters, Reading, has
from overview_dsp.devices.sensors.units import Vector, rotate, to_device_axes, unit
from overview_dsp.errors import InputError

STEEP = math.cos(math.radians(85.0))
FLAT = math.cos(math.radians(82.0))
JOIN_RAD_S = math.radians(400.0)


class Roll:
    """Theta2 from the direction of up.

    `roll` (rad, -pi to pi, right-handed about x) is present while `theta2` is held, too. `pitch`
    (rad) is the elevation of x. `steep`: whether theta2 is held.
    """

    def __init__(self) -> None:
        self.roll = self.pitch = 0.0
        self.steep = False
        self._theta2: float | None = None
        self._offset = 0.0

    def step(self, elapsed_s: float, up: Vector) -> float:
        """Return theta2 (rad, 0 to pi) after another `elapsed_s`; `up` as from `Orientation`."""
        self.roll = math.atan2(up[1], up[2])
        flatness = math.hypot(up[1], up[2])
        self.pitch = math.atan2(up[0], flatness)
        true = abs(self.roll)
        if flatness < (FLAT if self.steep else STEEP):
            self.steep = True
            self._theta2 = true if self._theta2 is None else self._theta2
            return self._theta2
        if self.steep and self._theta2 is not None:
            self._offset = self._theta2 - true
        self.steep = False
        largest_step = JOIN_RAD_S * elapsed_s
        self._offset -= max(-largest_step, min(largest_step, self._offset))
        self._theta2 = max(0.0, min(math.pi, true + self._offset))
        return self._theta2


LENGTH_TOLERANCE = 0.1  # largest deviation of a quaternion's length from 1
TWIST_DEG = 60.0
OTHERS = 0.5
"""The first angle to turn by `TWIST_DEG` is the twist, if the others turn by less than this share
of it."""

FOLDED_DEG = 120.0  # a larger step between two samples means that the angles fold


def up_vector(quaternion: Sequence[float]) -> Vector | None:
    """Return up in the sensor's own axes; None if the quaternion's length isn't near 1."""
    w, x, y, z = quaternion
    if abs(math.hypot(w, x, y, z) - 1.0) > LENGTH_TOLERANCE:
        return None
    return unit((2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z))


def quaternion_of(reading: Reading) -> tuple[float, float, float, float]:
    """Return the quaternion of a reading; a missing real part is positive."""
    x, y, z = (reading[name] for name in QUATERNION[1:])
    return reading.get("qw", math.sqrt(max(0.0, 1.0 - x * x - y * y - z * z))), x, y, z


class QuaternionAngle:
    """Roll from a quaternion that turns the sensor's axes to the earth's, with z up."""

    def __init__(self, sensor: Sensor, counters: Counters) -> None:
        """Start with a calibration at rest, as an `InertialAngle` does."""
        self._sensor = sensor
        self._counters = counters
        self._first: list[Vector] = []
        self._started: float | None = None
        self._level: Rotation | None = None
        self._last = 0.0
        self.roll = Roll()
        self.status = CALIBRATING

    def theta2(self, time_s: float, reading: Reading) -> float | None:
        """Return theta2, rad, 0 to pi; None while it isn't known."""
        if not has(reading, QUATERNION[1:]):
            return None
        up = up_vector(quaternion_of(reading))
        if up is None:
            self._counters.implausible += 1
            return None
        up = to_device_axes(self._sensor.axes, up)
        if self._started is None:
            self._started = self._last = time_s
        if self._level is None:
            self._first.append(up)
            if time_s - self._started < self._sensor.number("calibration.seconds"):
                return None
            self._level = self._calibrate()
        elapsed, self._last = max(0.0, time_s - self._last), time_s
        return self.roll.step(elapsed, rotate(self._level, up))

    def _calibrate(self) -> Rotation:
        x, y, z = (sum(axis) for axis in zip(*self._first, strict=True))
        rate = len(self._first) / max(self._sensor.number("calibration.seconds"), 1e-3)
        self._first = []
        level, note = level_by(unit((x, y, z)), self._sensor)
        self.status = f"{rate:.3g} Hz, from its quaternion" + (f"; {note}" if note else "")
        return level


class ThreeAngles:
    """Theta2 from the one of three angles that turns; makers order the angles differently.

    The angles at the start are 0. `angles.twist` of a profile selects the angle.
    """

    def __init__(self, sensor: Sensor) -> None:
        chosen = sensor.values["angles.twist"]
        self.twist: int | None = None if chosen == DETECT else int(str(chosen)) - 1
        self._rest: tuple[float, ...] | None = None
        self._last: tuple[float, ...] = ()
        self.status = (
            "which of its angles is the twist? turn it once, face down and back"
            if self.twist is None
            else f"angle {self.twist + 1} of three is the twist"
        )

    def theta2(self, time_s: float, reading: Reading) -> float | None:
        """Return theta2, rad, 0 to pi; None before the first turn; InputError if it folds."""
        if not has(reading, ANGLES):
            return None
        angles = tuple(reading[name] for name in ANGLES)
        if self._rest is None:
            self._rest = self._last = angles
        moved = _differences(angles, self._rest)
        jumped = [step > FOLDED_DEG for step in _differences(angles, self._last)]
        self._last = angles
        if self.twist is None:
            most = max(range(3), key=moved.__getitem__)
            others = max(moved[n] for n in range(3) if n != most)
            if moved[most] < TWIST_DEG or others >= OTHERS * moved[most]:
                return None
            self.twist = most
            self.status = (
                f'angle {most + 1} of three is the twist (angles.twist = "{most + 1}" in '
                "sensor=FILE.toml keeps it)"
            )
        if [n for n in range(3) if not jumped[n]] == [self.twist]:
            raise InputError(
                f"angle {self.twist + 1}, the twist, folds back at 90 degrees and the two others "
                "jump: turn the board by a quarter on its mount, or print its quaternion"
            )
        return math.radians(moved[self.twist])


def _differences(angles: Sequence[float], others: Sequence[float]) -> list[float]:
    return [abs(math.remainder(a - b, 360.0)) for a, b in zip(angles, others, strict=True)]
