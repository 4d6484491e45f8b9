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
from overview_dsp.devices.sensors.reading import (
    ANGLES,
    QUATERNION,
    AngleSample,
    Counters,
    Reading,
    has,
    touch_state,
)
from overview_dsp.devices.sensors.units import Vector, angle_between, rotate, to_device_axes, unit
from overview_dsp.errors import InputError

STEEP = math.cos(math.radians(85.0))
FLAT = math.cos(math.radians(82.0))
JOIN_RAD_S = math.radians(400.0)


class Roll:
    """Theta2 from the direction of up.

    `roll` (rad, -pi to pi, right-handed about x) is present while `theta2` is held, too.
    `steep`: whether theta2 is held.
    """

    def __init__(self) -> None:
        self.roll = 0.0
        self.steep = False
        self._theta2: float | None = None
        self._offset = 0.0

    def step(self, elapsed_s: float, up: Vector) -> float:
        """Return theta2 (rad, 0 to pi) after another `elapsed_s`; `up` as from `GravityTilt`."""
        flatness = math.hypot(up[1], up[2])
        self.roll = math.atan2(up[1], up[2])
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
OTHERS = 0.4
"""The first angle to turn by `TWIST_DEG` is the twist, if the others never turned by this share of
it; of a magnetic field, another part changes by half as much."""

FOLDED_DEG = 120.0  # a larger step between two samples means that the angles fold


def up_vector(quaternion: Sequence[float]) -> Vector:
    """Return up in the sensor's own axes, of a quaternion w, x, y, z."""
    w, x, y, z = quaternion
    return unit((2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z))


def in_order(numbers: Sequence[float], order: str) -> Sequence[float]:
    """Return w, x, y and z of four numbers in this order."""
    return (numbers[3], *numbers[:3]) if order == "xyzw" else numbers


def order_in_turn(rest: Sequence[float], now: Sequence[float]) -> str | None:
    """Return the order of a quaternion's numbers in which a turn is one; None before the turn."""
    turns = {}
    for order in ("wxyz", "xyzw"):
        before, after = (up_vector(in_order(numbers, order)) for numbers in (rest, now))
        turns[order] = angle_between(before, after)
    order = max(turns, key=turns.__getitem__)
    return order if turns[order] > math.radians(TWIST_DEG) else None


def quaternion_of(reading: Reading) -> tuple[float, float, float, float]:
    """Return the quaternion of a reading; a missing real part is positive."""
    x, y, z = (reading[name] for name in QUATERNION[1:])
    return reading.get("qw", math.sqrt(max(0.0, 1.0 - x * x - y * y - z * z))), x, y, z


class QuaternionAngle:
    """Roll from a quaternion that turns the sensor's axes to the earth's, with z up."""

    detects_taps = False

    def __init__(self, sensor: Sensor, counters: Counters) -> None:
        """Start with a calibration at rest, as an `InertialAngle` does."""
        self._sensor = sensor
        self._counters = counters
        self._first: list[tuple[float, Sequence[float]]] = []
        self._order = sensor.values["quaternion.order"]
        self._level: Rotation | None = None
        self._last: float | None = None
        self.roll = Roll()
        self.status = CALIBRATING

    def step(self, time_s: float, reading: Reading) -> AngleSample | None:
        """Return the angle at a reading; None while it isn't known."""
        if not has(reading, QUATERNION[1:]):
            return None
        numbers = quaternion_of(reading)
        if abs(math.hypot(*numbers) - 1.0) > LENGTH_TOLERANCE:
            self._counters.implausible += 1
            return None
        if self._level is None:
            seconds = self._sensor.number("calibration.seconds")
            if not self._first or time_s - self._first[0][0] <= seconds:
                self._first.append((time_s, numbers))
            if time_s - self._first[0][0] < seconds:
                return None
            if self._order == DETECT:
                self.status = "which of its four numbers is w? turn it once, face down and back"
                rest = self._first[len(self._first) // 2][1]
                self._order = order_in_turn(rest, numbers) or DETECT
                if self._order == DETECT:
                    return None
            self._level = self._calibrate(seconds)
        elapsed = 0.0 if self._last is None else max(0.0, time_s - self._last)
        self._last = time_s
        theta2 = self.roll.step(elapsed, rotate(self._level, self._up(numbers)))
        reliable = not self.roll.steep
        return AngleSample(time_s, theta2, touch=touch_state(reading), reliable=reliable)

    def _up(self, numbers: Sequence[float]) -> Vector:
        return to_device_axes(self._sensor.axes, up_vector(in_order(numbers, str(self._order))))

    def _calibrate(self, seconds: float) -> Rotation:
        x, y, z = (sum(axis) for axis in zip(*(self._up(one) for _, one in self._first),
                                             strict=True))  # fmt: skip
        rate = len(self._first) / max(seconds, 1e-3)
        level, note = level_by(unit((x, y, z)), self._sensor)
        self.status = f"{rate:.3g} Hz, from its quaternion" + (f"; {note}" if note else "")
        return level


class ThreeAngles:
    """Theta2 from the one of three angles that turns; makers order the angles differently.

    The angles at the start are 0. `angles.twist` of a profile selects the angle.
    """

    detects_taps = False

    def __init__(self, sensor: Sensor) -> None:
        chosen = sensor.values["angles.twist"]
        self.twist: int | None = None if chosen == DETECT else int(str(chosen)) - 1
        self._scale = math.degrees(1.0) if sensor.values["angles.unit"] == "rad" else 1.0
        self._rest: tuple[float, ...] | None = None
        self._most = [0.0, 0.0, 0.0]
        self._last: tuple[float, ...] = ()
        self.status = (
            "which of its angles is the twist? turn it once, face down and back"
            if self.twist is None
            else f"angle {self.twist + 1} of three is the twist"
        )

    def step(self, time_s: float, reading: Reading) -> AngleSample | None:
        """Return the angle at a reading; None before the first turn; InputError if it folds."""
        if not has(reading, ANGLES):
            return None
        angles = tuple(reading[name] * self._scale for name in ANGLES)
        if self._rest is None:
            self._rest = self._last = angles
        moved = _differences(angles, self._rest)
        self._most = [max(pair) for pair in zip(moved, self._most, strict=True)]
        jumped = [step > FOLDED_DEG for step in _differences(angles, self._last)]
        self._last = angles
        if self.twist is None:
            most = max(range(3), key=moved.__getitem__)
            others = max(self._most[n] for n in range(3) if n != most)
            if moved[most] < TWIST_DEG or others >= OTHERS * moved[most]:
                return None
            if self._is_vector(angles, most):
                self.status = (
                    "its three numbers keep their length in a turn: a magnetic field, or an "
                    "acceleration of unknown unit (acceleration.scale), not angles"
                )
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
        theta2 = math.radians(moved[self.twist])
        return AngleSample(time_s, theta2, touch=touch_state(reading))

    def _is_vector(self, angles: tuple[float, ...], twist: int) -> bool:
        """Return whether the length of all three stays although one of them changes."""
        rest = self._rest or angles
        now = [a + math.remainder(b - a, 360.0) for a, b in zip(rest, angles, strict=True)]
        squares = [b * b - a * a for a, b in zip(rest, now, strict=True)]
        return abs(sum(squares)) < 0.5 * abs(squares[twist])


def _differences(angles: Sequence[float], others: Sequence[float]) -> list[float]:
    return [abs(math.remainder(a - b, 360.0)) for a, b in zip(angles, others, strict=True)]
