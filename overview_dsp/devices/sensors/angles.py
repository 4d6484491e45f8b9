"""From what a sensor says to the input angle theta2.

Tap-tap: two short pulses on the device.

Whether a gyroscope and gravity show the same turning; if not, what is wrong with the file.

Over a third of a second gravity's direction turns by an angle that the accelerometer shows, and
the gyroscope's path across gravity can't be shorter. Degrees taken for radians make it 57 times as
long, radians taken for degrees 57 times too short, a wrong axis or sign leads elsewhere.
"""

from __future__ import annotations

import math
import statistics
from collections import deque
from dataclasses import dataclass, replace
from typing import Protocol

from overview_dsp.devices.sensors.calibration import Calibration, RawSample, calibrate
from overview_dsp.devices.sensors.orientation import (
    LONGEST_GAP_S,
    ByGravity,
    ByTurning,
    Orientation,
    unit,
)
from overview_dsp.devices.sensors.orientation_angles import QuaternionAngle, Roll, ThreeAngles
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    ANGULAR_VELOCITY,
    QUATERNION,
    Counters,
    Reading,
)
from overview_dsp.devices.sensors.units import GRAVITY, Vector
from overview_dsp.units import HALF_TURN

PULSE = 10.0
"""m/s² beyond gravity that is a pulse: a hand that turns fast stays below 5."""

ONE_S = 0.08
"""A pulse rings so long."""

APART_S = 0.5
"""Two pulses within this are a tap-tap."""


class TapTap:
    """Finds tap-taps in the size of the acceleration."""

    def __init__(self) -> None:
        """Nothing has been hit."""
        self._ringing_until = self._first = -1e300

    def step(self, time_s: float, beyond_gravity: float) -> bool:
        """Whether a tap-tap is complete; `beyond_gravity` is |a| - g, m/s², of any sign."""
        if abs(beyond_gravity) < PULSE:
            return False
        begins = time_s > self._ringing_until
        self._ringing_until = time_s + ONE_S
        if not begins:
            return False
        if time_s - self._first <= APART_S:
            self._first = -1e300
            return True
        self._first = time_s
        return False


WINDOW_S = 0.3
LEAST = math.radians(20.0)
"""Less may be a push: a hand's own acceleration tilts what looks like gravity."""

CALM = 0.1
"""Accelerations that differ from gravity by more of it say nothing of up, and end the window."""

WINDOWS = 7
FAR_TOO_LONG, FAR_TOO_SHORT = 15.0, 0.2
ELSEWHERE = 0.8
"""Of the angle that gravity turned: a sensor that is right is off by a few hundredths of it."""


class GyroscopeCheck:
    """Samples in, a complaint out, if there is one."""

    def __init__(self) -> None:
        """Nothing has turned."""
        self._start: Vector | None = None
        self._led: Vector = (0.0, 0.0, 1.0)
        self._path = self._since = 0.0
        self._time = 0.0
        self._ratios: deque[float] = deque(maxlen=WINDOWS)
        self._misses: deque[float] = deque(maxlen=WINDOWS)

    def step(self, time_s: float, acceleration: Vector, turning: Vector) -> str:
        """What is wrong, in words, or nothing."""
        elapsed_s, self._time = time_s - self._time, time_s
        calm = abs(math.hypot(*acceleration) / GRAVITY - 1.0) < CALM
        if self._start is None or not calm or elapsed_s > WINDOW_S:
            self._begin(acceleration if calm else None)
            return ""
        x, y, z = self._led
        p, q, r = turning
        step = (q * z - r * y, r * x - p * z, p * y - q * x)
        self._led = unit(
            (x - step[0] * elapsed_s, y - step[1] * elapsed_s, z - step[2] * elapsed_s)
        )
        self._path += math.hypot(*step) * elapsed_s
        self._since += elapsed_s
        if self._since < WINDOW_S:
            return ""
        self._compare(unit(acceleration))
        self._begin(acceleration)
        return self._verdict()

    def _begin(self, acceleration: Vector | None) -> None:
        self._start = None if acceleration is None else unit(acceleration)
        self._led = self._start or (0.0, 0.0, 1.0)
        self._path = self._since = 0.0

    def _compare(self, end: Vector) -> None:
        assert self._start is not None
        angle = _between(self._start, end)
        if angle > LEAST:
            self._ratios.append(self._path / angle)
            self._misses.append(_between(self._led, end) / angle)

    def _verdict(self) -> str:
        if len(self._ratios) < WINDOWS:
            return ""
        if min(self._ratios) > FAR_TOO_LONG:
            return "the gyroscope turns far more than gravity does: is it in deg/s, not rad/s?"
        if max(self._ratios) < FAR_TOO_SHORT:
            return "the gyroscope turns far less than gravity does: is it in rad/s, not deg/s?"
        if statistics.median(self._misses) > ELSEWHERE:
            return "the gyroscope turns another way than gravity does: is an axis or a sign wrong?"
        return ""


def _between(a: Vector, b: Vector) -> float:
    """The angle between two unit vectors, rad."""
    cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return math.acos(max(-1.0, min(1.0, cosine)))


HARDEST = 100.0 * GRAVITY
FASTEST = math.radians(5000.0)
"""What no hand does: such a sample is wrong."""

FROZEN_S = 2.0
"""A gyroscope that says the very same for so long has stopped."""

FEWEST, MOST = 10, 25_000
"""Samples of a calibration; more, and its clock stands still."""


@dataclass(frozen=True)
class Turn:
    """An instant: time (s), theta2 (rad), whether a tap-tap ended there, touch if it is said.

    `sure` is False where theta2 is held because it isn't known.
    """

    time_s: float
    theta2: float
    tapped: bool = False
    touch: bool | None = None
    sure: bool = True


class Angle(Protocol):
    """Samples in, turns out."""

    taps: bool
    """Whether it feels pulses."""

    @property
    def words(self) -> str:
        """How it stands, for a person."""

    def step(self, time_s: float, reading: Reading) -> Turn | None:
        """The turn at a sample; None while there is none. InputError if it can't be read."""


def touch_of(reading: Reading) -> bool | None:
    """Whether the hand holds on, if the sensor says it."""
    return reading["touch"] > 0.5 if "touch" in reading else None


class InertialAngle:
    """Roll by acceleration, and angular velocity if there is any; begins with a calibration.

    Attributes
    ----------
    roll : Roll
        Roll and pitch as they are known.
    frozen : bool
        It says the very same, again and again.
    complaint : str
        What is wrong with the gyroscope's unit or axes, if anything.
    """

    taps = True

    def __init__(self, sensor: Sensor, binary: bool, counters: Counters) -> None:
        """`binary`: the numbers are of binary frames."""
        self._sensor = sensor
        self._binary = binary
        self._counters = counters
        self._first: list[RawSample] = []
        self._found: Calibration | None = None
        self._orientation: Orientation | None = None
        self._last: RawSample | None = None
        self._said_at = -math.inf
        self._tap_tap = TapTap()
        self._gyroscope = GyroscopeCheck()
        self.roll = Roll()
        self.frozen = False
        self.complaint = ""
        self.words = "calibrating: hold it still, face up"

    def step(self, time_s: float, reading: Reading) -> Turn | None:
        """As `Angle.step`."""
        if not all(name in reading for name in ACCELERATION):
            return None
        use = self._sensor.values["angular_velocity.use"]
        turning = (
            tuple(reading[name] for name in ANGULAR_VELOCITY)
            if use and all(name in reading for name in ANGULAR_VELOCITY)
            else None
        )
        sample = RawSample(time_s, tuple(reading[name] for name in ACCELERATION), turning)
        if self._found is None:
            self._calibrate(sample)
            return None
        return self._turn(sample, touch_of(reading))

    def _calibrate(self, sample: RawSample) -> None:
        first = self._first
        first.append(sample)
        enough = sample.time_s - first[0].time_s >= self._sensor.number("calibration.seconds")
        if (not enough or len(first) < FEWEST) and len(first) < MOST:
            return
        self._first = []
        found = calibrate(self._sensor, self._binary, first)
        gyroscope = sample.turning is not None and found.units.turning_known
        self._orientation = ByTurning(found.period_s, found.bias) if gyroscope else ByGravity()
        self._found = found
        self.words = found.words
        for one in first:
            self._turn(one, None)

    def _turn(self, sample: RawSample, touch: bool | None) -> Turn | None:
        assert self._found is not None
        assert self._orientation is not None
        units, last = self._found.units, self._last
        if not units.turning_known:
            sample = replace(sample, turning=None)
        elapsed = self._found.period_s if last is None else sample.time_s - last.time_s
        acceleration = units.acceleration_of(sample.acceleration)
        turning = units.angular_velocity_of(sample.turning or (0.0, 0.0, 0.0))
        size = math.hypot(*acceleration)
        if sample.turning is not None:
            complaint = self._gyroscope.step(sample.time_s, acceleration, turning)
            self.complaint = complaint or self.complaint
        if size > HARDEST or math.hypot(*turning) > FASTEST or elapsed <= 0.0:
            self._counters.implausible += 1
            return None
        if elapsed > LONGEST_GAP_S:
            self.roll.jumped()
        self._watch(sample)
        self._last = sample
        x, y, z = self._orientation.step(elapsed, acceleration, turning)
        x, y, z = (a * x + b * y + c * z for a, b, c in self._found.level)
        theta2 = self.roll.step(elapsed, (x, y, z))
        tapped = self._tap_tap.step(sample.time_s, size - GRAVITY)
        return Turn(sample.time_s, theta2, tapped, touch, not self.roll.steep)

    def _watch(self, sample: RawSample) -> None:
        last = self._last
        same = (
            last is not None
            and sample.turning is not None
            and (sample.acceleration, sample.turning) == (last.acceleration, last.turning)
        )
        if not same:
            self._said_at = sample.time_s
        self.frozen = sample.time_s - self._said_at > FROZEN_S


_PLAIN = {
    "roll_deg": "roll in degrees",
    "count": "encoder",
    "shaft_rad": "motor knob",
    "theta2_rad": "motor knob with the surface on its board",
    "pot": "potentiometer",
}


class PlainAngle:
    """Roll in degrees, an encoder's count, a motor's shaft, a potentiometer's wiper, or theta2."""

    taps = False

    def __init__(self, sensor: Sensor, column: str) -> None:
        """`column`: one of `_PLAIN`."""
        self._column = column
        self._low = sensor.number("potentiometer.low")
        self._span = sensor.number("potentiometer.high") - self._low
        self._per_count = HALF_TURN / sensor.number("encoder.counts")
        self._wrap = sensor.number("encoder.wrap")
        reverse = sensor.values["encoder.reverse"]
        if column == "shaft_rad":
            self._per_count = HALF_TURN / math.radians(sensor.number("motor.turn_deg"))
            self._wrap, reverse = 0.0, sensor.values["motor.reverse"]
        if reverse:
            self._per_count = -self._per_count
        self._count: float | None = None
        self._theta2 = 0.0
        self.words = _PLAIN[column]

    def step(self, time_s: float, reading: Reading) -> Turn | None:
        """As `Angle.step`."""
        if self._column not in reading:
            return None
        value = reading[self._column]
        if self._column == "roll_deg":
            self._theta2 = abs(math.remainder(math.radians(value), 2.0 * HALF_TURN))
        elif self._column in ("count", "shaft_rad"):
            self._theta2 = self._counted(value)
        elif self._column == "theta2_rad":
            self._theta2 = max(0.0, min(HALF_TURN, value))
        else:
            part = (value - self._low) / self._span
            self._theta2 = HALF_TURN * max(0.0, min(1.0, part))
        return Turn(time_s, self._theta2, touch=touch_of(reading))

    def _counted(self, count: float) -> float:
        # beyond an end the timeline stays there, and begins to move as soon as the knob turns back
        step = 0.0 if self._count is None else count - self._count
        if self._wrap:
            step = math.remainder(step, self._wrap)
        self._count = count
        return max(0.0, min(HALF_TURN, self._theta2 + step * self._per_count))


class FusedAngle:
    """What the sensor has fused itself: a quaternion or three angles."""

    taps = False

    def __init__(self, fused: QuaternionAngle | ThreeAngles) -> None:
        """`fused` makes theta2."""
        self._fused = fused

    @property
    def words(self) -> str:
        """As `Angle.words`."""
        return self._fused.words

    def step(self, time_s: float, reading: Reading) -> Turn | None:
        """As `Angle.step`."""
        theta2 = self._fused.theta2(time_s, reading)
        if theta2 is None:
            return None
        sure = not (isinstance(self._fused, QuaternionAngle) and self._fused.roll.steep)
        return Turn(time_s, theta2, touch=touch_of(reading), sure=sure)


def angle_of(sensor: Sensor, binary: bool, reading: Reading, counters: Counters) -> Angle | None:
    """What makes an angle of such readings; None if nothing in this one does."""
    if all(name in reading for name in ACCELERATION):
        return InertialAngle(sensor, binary, counters)
    if all(name in reading for name in QUATERNION[1:]):
        return FusedAngle(QuaternionAngle(sensor, counters))
    if all(name in reading for name in ANGLES):
        return FusedAngle(ThreeAngles(sensor))
    for column in _PLAIN:
        if column in reading:
            return PlainAngle(sensor, column)
    return None
