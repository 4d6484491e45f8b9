"""Theta2 from what a sensor has fused itself: a quaternion, or three angles.

Roll to theta2: face up 0, face down pi, by either wrist.

theta2 is the size of the roll angle, so that a turn to the left and one to the right go the same
way and nothing jumps where the angle's sign does. Where the device points up or down (pitch beyond
85 degrees) a small tilt is any roll: theta2 is held there, and joins the true one again, no faster
than 400 degrees a second, once it is flatter than 82.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from overview_dsp.devices.sensors.calibration import level_of
from overview_dsp.devices.sensors.orientation import unit
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.reading import ANGLES, QUATERNION, Counters, Reading
from overview_dsp.devices.sensors.units import Vector
from overview_dsp.errors import InputError

STEEP = math.cos(math.radians(85.0))
FLAT = math.cos(math.radians(82.0))
JOIN_RAD_S = math.radians(400.0)


class Roll:
    """theta2 from where up is.

    Attributes
    ----------
    roll : float
        rad, -pi to pi, right-handed about x; also while `theta2` is held.
    pitch : float
        rad; how far x points up.
    steep : bool
        theta2 is held.
    """

    def __init__(self) -> None:
        """Face up."""
        self.roll = self.pitch = 0.0
        self.steep = False
        self._theta2: float | None = None
        self._offset = 0.0

    def jumped(self) -> None:
        """The next angle may be elsewhere: join it slowly."""
        self.steep = True

    def step(self, elapsed_s: float, up: Vector) -> float:
        """theta2 (rad, 0 to pi) after `elapsed_s` more; `up` as `Orientation.step` says it."""
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
        most = JOIN_RAD_S * elapsed_s
        self._offset -= max(-most, min(most, self._offset))
        self._theta2 = max(0.0, min(math.pi, true + self._offset))
        return self._theta2


UNIT_LENGTH = 0.1
"""A quaternion's length may be off by so much."""

TURNED_DEG = 60.0
OTHERS = 0.5
"""The angle that is the twist turns by so much first, the two others by less than so much of it."""

FOLDED_DEG = 120.0
"""No hand turns so far from one sample to the next: the angles are folded over."""


def up_of(quaternion: Sequence[float]) -> Vector | None:
    """Up in the sensor's own axes; None if the quaternion's length isn't near 1."""
    w, x, y, z = quaternion
    length = math.hypot(w, x, y, z)
    if abs(length - 1.0) > UNIT_LENGTH:
        return None
    return unit((2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z))


class QuaternionAngle:
    """Roll by a quaternion from the sensor's axes to the earth's, of which z is up."""

    taps = False

    def __init__(self, sensor: Sensor, counters: Counters) -> None:
        """It lies still at first, as an `InertialAngle`."""
        self._axes = sensor.axes
        self._most_lean = sensor.number("calibration.level_deg")
        self._seconds = sensor.number("calibration.seconds")
        self._counters = counters
        self._first: list[Vector] = []
        self._began: float | None = None
        self._level: tuple[Vector, Vector, Vector] | None = None
        self._last = 0.0
        self.roll = Roll()
        self.words = "calibrating: hold it still, face up"

    def up(self, time_s: float, reading: Reading) -> tuple[float, Vector] | None:
        """Seconds since the last one, and up, level taken off; None while there is none."""
        if not all(name in reading for name in QUATERNION[1:]):
            return None
        x, y, z = (reading[name] for name in QUATERNION[1:])
        # a sensor that leaves out the real part makes it positive
        w = reading.get("qw", math.sqrt(max(0.0, 1.0 - x * x - y * y - z * z)))
        up = up_of((w, x, y, z))
        if up is None:
            self._counters.implausible += 1
            return None
        (i, a), (j, b), (k, c) = self._axes
        up = up[i] * a, up[j] * b, up[k] * c
        if self._began is None:
            self._began = self._last = time_s
        if self._level is None:
            self._first.append(up)
            if time_s - self._began < self._seconds:
                return None
            self._calibrate()
        assert self._level is not None
        elapsed, self._last = max(0.0, time_s - self._last), time_s
        p, q, r = (u * up[0] + v * up[1] + w * up[2] for u, v, w in self._level)
        return elapsed, (p, q, r)

    def theta2(self, time_s: float, reading: Reading) -> float | None:
        """rad, 0 to pi; None while it isn't known."""
        found = self.up(time_s, reading)
        return None if found is None else self.roll.step(*found)

    def _calibrate(self) -> None:
        x, y, z = (sum(axis) for axis in zip(*self._first, strict=True))
        up = unit((x, y, z))
        lean = math.degrees(math.acos(max(-1.0, min(1.0, up[2]))))
        rate = len(self._first) / max(self._seconds, 1e-3)
        self._first = []
        self.words = f"{rate:.3g} Hz, by its quaternion"
        if lean <= self._most_lean:
            self._level = level_of(up)
            self.words += f"; face up is {lean:.1f} degrees off its own axes"
        else:
            self._level = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
            self.words += f"; it began {lean:.0f} degrees from face up: its own axes are taken"


class ThreeAngles:
    """Of three angles, the one that turns: makers don't agree which is which.

    Where it lies at the start is 0. `angles.twist` of a profile says which one it is.
    """

    taps = False

    def __init__(self, sensor: Sensor) -> None:
        """Nothing has turned."""
        said = sensor.values["angles.twist"]
        self.twist: int | None = None if said == "told" else int(str(said)) - 1
        self._rest: tuple[float, ...] | None = None
        self._last: tuple[float, ...] = ()
        self.words = (
            "which of its angles is the twist? turn it once, face down and back"
            if self.twist is None
            else f"angle {self.twist + 1} of three is the twist"
        )

    def theta2(self, time_s: float, reading: Reading) -> float | None:
        """rad, 0 to pi; None until it was turned once. InputError if the twist's angle folds."""
        if not all(name in reading for name in ANGLES):
            return None
        angles = tuple(reading[name] for name in ANGLES)
        if self._rest is None:
            self._rest = self._last = angles
        moved = [abs(math.remainder(a - b, 360.0)) for a, b in zip(angles, self._rest, strict=True)]
        jumped = [abs(math.remainder(a - b, 360.0)) > FOLDED_DEG
                  for a, b in zip(angles, self._last, strict=True)]  # fmt: skip
        self._last = angles
        if self.twist is None:
            most = max(range(3), key=moved.__getitem__)
            others = max(moved[n] for n in range(3) if n != most)
            if moved[most] >= TURNED_DEG and others < OTHERS * moved[most]:
                self.twist = most
                self.words = (
                    f'angle {most + 1} of three is the twist (angles.twist = "{most + 1}" in '
                    "sensor=FILE.toml keeps it)"
                )
        if self.twist is None:
            return None
        others_jump = all(jumped[n] for n in range(3) if n != self.twist)
        if others_jump and not jumped[self.twist]:
            raise InputError(
                f"angle {self.twist + 1}, the twist, folds back at 90 degrees and the two others "
                "jump: turn the board by a quarter on what it is fixed to, or print its quaternion"
            )
        return math.radians(moved[self.twist])
