"""Conversion of a sensor's readings to the input angle theta2, and detection of tap-taps.

A tap-tap is two short pulses on the device.

The gyroscope check compares the turns that gyroscope and gravity show. In a third of a second the
direction of gravity turns by an angle that the accelerometer shows. The gyroscope's path across
gravity can't be shorter. Degrees read as radians make the path 57 times as long, radians read as
degrees 57 times too short, and a wrong axis or sign leads to another direction.
"""

from __future__ import annotations

import math
import statistics
from collections import deque
from dataclasses import replace

from overview_dsp.devices.sensors.calibration import (
    CALIBRATING,
    LONGEST_GAP_S,
    Calibration,
    GravityTilt,
    GyroTilt,
    RawSample,
    calibrate,
)
from overview_dsp.devices.sensors.orientation_angles import QuaternionAngle, Roll, ThreeAngles
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    ANGULAR_VELOCITY,
    QUATERNION,
    AngleSample,
    Counters,
    Reading,
    has,
    touch_state,
)
from overview_dsp.devices.sensors.units import GRAVITY, Vector, angle_between, rotate, unit
from overview_dsp.errors import InputError
from overview_dsp.units import HALF_TURN

PULSE = 10.0  # acceleration beyond gravity of a pulse, m/s²; a fast twist stays below 5
PULSE_S = 0.08  # duration of the ringing of one pulse
TAP_TAP_S = 0.5  # longest time between the two pulses of a tap-tap


class TapTap:
    """Detector of tap-taps in the size of the acceleration."""

    def __init__(self) -> None:
        self._ringing_until = self._first = -1e300

    def step(self, time_s: float, beyond_gravity: float) -> bool:
        """Return whether a tap-tap is complete; `beyond_gravity` is |a| - g, m/s², signed."""
        if abs(beyond_gravity) < PULSE:
            return False
        new_pulse = time_s > self._ringing_until
        self._ringing_until = time_s + PULSE_S
        if not new_pulse:
            return False
        complete = time_s - self._first <= TAP_TAP_S
        self._first = -1e300 if complete else time_s
        return complete


WINDOW_S = 0.3
SMALLEST_TURN = math.radians(20.0)
"""A smaller turn may be a push: the device's own acceleration tilts the apparent gravity."""

CALM = 0.1
"""Largest relative deviation from gravity at which an acceleration shows the direction of up; a
larger one ends the window."""

WINDOWS, FEW_WINDOWS = 7, 3  # for a wrong axis, and for a wrong unit
FAR_TOO_LONG, FAR_TOO_SHORT = 15.0, 0.2
ELSEWHERE = 0.8
"""Error of the gyroscope's direction relative to gravity's turn; a correct sensor has a few
hundredths."""


class GyroscopeCheck:
    """Comparison of the turns that gyroscope and gravity show."""

    def __init__(self) -> None:
        self._start: Vector | None = None
        self._predicted: Vector = (0.0, 0.0, 1.0)
        self._path = self._since = 0.0
        self._time = 0.0
        self._ratios: deque[float] = deque(maxlen=WINDOWS)
        self._errors: deque[float] = deque(maxlen=WINDOWS)

    def step(self, time_s: float, acceleration: Vector, angular_velocity: Vector) -> str:
        """Return a message about a wrong gyroscope; empty without a fault."""
        elapsed_s, self._time = time_s - self._time, time_s
        calm = abs(math.hypot(*acceleration) / GRAVITY - 1.0) < CALM
        if self._start is None or not calm or elapsed_s > WINDOW_S:
            self._begin(acceleration if calm else None)
            return ""
        x, y, z = self._predicted
        p, q, r = angular_velocity
        step = (q * z - r * y, r * x - p * z, p * y - q * x)
        self._predicted = unit(
            (x - step[0] * elapsed_s, y - step[1] * elapsed_s, z - step[2] * elapsed_s)
        )
        self._path += math.hypot(*step) * elapsed_s
        self._since += elapsed_s
        if self._since < WINDOW_S:
            return ""
        end = unit(acceleration)
        angle = angle_between(self._start, end)
        if angle > SMALLEST_TURN:
            self._ratios.append(self._path / angle)
            self._errors.append(angle_between(self._predicted, end) / angle)
        self._begin(acceleration)
        return self._message()

    def _begin(self, acceleration: Vector | None) -> None:
        self._start = None if acceleration is None else unit(acceleration)
        self._predicted = self._start or (0.0, 0.0, 1.0)
        self._path = self._since = 0.0

    def _message(self) -> str:
        if len(self._ratios) < FEW_WINDOWS:
            return ""
        if min(self._ratios) > FAR_TOO_LONG:
            return "the gyroscope turns far more than gravity does: is it in deg/s, not rad/s?"
        if max(self._ratios) < FAR_TOO_SHORT:
            return "the gyroscope turns far less than gravity does: is it in rad/s, not deg/s?"
        if len(self._errors) == WINDOWS and statistics.median(self._errors) > ELSEWHERE:
            return "the gyroscope turns another way than gravity does: is an axis or a sign wrong?"
        return ""


HIGHEST_ACCELERATION = 100.0 * GRAVITY
HIGHEST_SPEED = math.radians(5000.0)  # limits of a hand's movement; a sample beyond them is wrong
LONG, LONG_S, TURNED = 1.5, 0.5, math.radians(60.0)
"""Multiple of gravity and time beyond which numbers are no acceleration, until the first turn."""

FROZEN_S = 2.0  # time of identical readings after which a gyroscope counts as stopped

FEWEST, MOST = 10, 25_000
"""Number of samples of a calibration; at the maximum, the clock stands still."""


class InertialAngle:
    """Roll from acceleration and, if present, angular velocity; starts with a calibration.

    `roll` has the present roll. `frozen`: whether the readings have stopped changing.
    `gyroscope_fault`: a message about a wrong unit or axis of the gyroscope, or empty.
    """

    detects_taps = True  # whether tap-taps are detected

    def __init__(self, sensor: Sensor, binary: bool, counters: Counters) -> None:
        """Convert readings of `sensor`; `binary`: they come from binary frames."""
        self._sensor = sensor
        self._binary = binary
        self._counters = counters
        self._first: list[RawSample] = []
        self._calibration: Calibration | None = None
        self._orientation: GravityTilt | GyroTilt = GravityTilt()
        self._last: RawSample | None = None
        self._changed_at = -math.inf
        self._turned = False
        self._calm_at = math.inf
        self._tap_tap = TapTap()
        self._gyroscope = GyroscopeCheck()
        self.roll = Roll()
        self.frozen = False
        self.gyroscope_fault = ""
        self.status = CALIBRATING

    def step(self, time_s: float, reading: Reading) -> AngleSample | None:
        """Return the angle at a reading, None without one; InputError for readings of no angle."""
        if not has(reading, ACCELERATION):
            return None
        use = self._sensor.values["angular_velocity.use"] and has(reading, ANGULAR_VELOCITY)
        angular_velocity = tuple(reading[name] for name in ANGULAR_VELOCITY) if use else None
        acceleration = tuple(reading[name] for name in ACCELERATION)
        sample = RawSample(time_s, acceleration, angular_velocity)
        if self._calibration is None:
            self._calibrate(sample)
            return None
        return self._convert(self._calibration, sample, touch_state(reading))

    def _calibrate(self, sample: RawSample) -> None:
        first = self._first
        first.append(sample)
        enough = sample.time_s - first[0].time_s >= self._sensor.number("calibration.seconds")
        if (not enough or len(first) < FEWEST) and len(first) < MOST:
            return
        self._first = []
        found = calibrate(self._sensor, self._binary, first)
        self._calibration = found
        self.status = found.description
        if sample.angular_velocity is not None and found.units.gyroscope_known:
            try:
                self._orientation = GyroTilt(found.period_s, found.bias)
            except InputError as error:
                self.gyroscope_fault = str(error)
        for one in first:
            self._convert(found, one, None)

    def _convert(
        self, calibration: Calibration, sample: RawSample, touch: bool | None
    ) -> AngleSample | None:
        units, last = calibration.units, self._last
        if not units.gyroscope_known or self.gyroscope_fault:
            sample = replace(sample, angular_velocity=None)
        elapsed = calibration.period_s if last is None else sample.time_s - last.time_s
        acceleration = units.acceleration_of(sample.acceleration)
        speed = units.angular_velocity_of(sample.angular_velocity or (0.0, 0.0, 0.0))
        size = math.hypot(*acceleration)
        if sample.angular_velocity is not None:
            fault = self._gyroscope.step(sample.time_s, acceleration, speed)
            if fault and not self.gyroscope_fault:
                self.gyroscope_fault = (
                    f"{fault} (sensor=FILE.toml, [angular_velocity], [axes]); until then, roll "
                    "follows gravity alone"
                )
                self._orientation = GravityTilt()
        self._require_gravity(sample.time_s, size)
        if size > HIGHEST_ACCELERATION or math.hypot(*speed) > HIGHEST_SPEED or elapsed <= 0.0:
            self._counters.implausible += 1
            return None
        if elapsed > LONGEST_GAP_S:
            self.roll.steep = True  # the next angle may be far away: approach it slowly
        still = last is not None and replace(sample, time_s=last.time_s) == last
        if sample.angular_velocity is None or not still:
            self._changed_at = sample.time_s
        self.frozen = sample.time_s - self._changed_at > FROZEN_S
        self._last = sample
        up = self._orientation.step(elapsed, acceleration, speed)
        theta2 = self.roll.step(elapsed, rotate(calibration.level, up))
        self._turned = self._turned or (theta2 > TURNED and size < LONG * GRAVITY)
        tapped = self._tap_tap.step(sample.time_s, size - GRAVITY)
        return AngleSample(sample.time_s, theta2, tapped, touch, not self.roll.steep)

    def _require_gravity(self, time_s: float, size: float) -> None:
        """Check until the first turn that the acceleration keeps its length; InputError."""
        if self._turned or size < LONG * GRAVITY:
            self._calm_at = time_s
        elif time_s - self._calm_at > LONG_S:
            raise InputError(
                f"its acceleration is {size / GRAVITY:.3g} times gravity as it turns: are the "
                "numbers angles? `overview sensor setup` finds out"
            )


_SINGLE_VALUES = {
    "roll_deg": "roll in degrees",
    "count": "encoder",
    "shaft_rad": "motor knob",
    "theta2_rad": "motor knob with the surface on its board",
    "pot": "potentiometer",
}
"""Name of the sensor that sends a column."""


class SingleValueAngle:
    """Theta2 from roll in degrees, an encoder, a motor's shaft, a potentiometer, or theta2."""

    detects_taps = False

    def __init__(self, sensor: Sensor, column: str) -> None:
        """Convert `column`, one of `_SINGLE_VALUES`."""
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
        self.status = _SINGLE_VALUES[column]

    def step(self, time_s: float, reading: Reading) -> AngleSample | None:
        """Return the angle at a reading, None without one."""
        if self._column not in reading:
            return None
        value = reading[self._column]
        if self._column == "roll_deg":
            theta2 = abs(math.remainder(math.radians(value), 2.0 * HALF_TURN))
        elif self._column in ("count", "shaft_rad"):
            step = 0.0 if self._count is None else value - self._count
            self._count = value
            step = math.remainder(step, self._wrap) if self._wrap else step
            theta2 = self._theta2 + step * self._per_count
        elif self._column == "theta2_rad":
            theta2 = value
        else:
            theta2 = HALF_TURN * ((value - self._low) / self._span)
        # a count beyond an end is kept at the end, and moves as soon as the knob turns back
        self._theta2 = max(0.0, min(HALF_TURN, theta2))
        return AngleSample(time_s, self._theta2, touch=touch_state(reading))


Angle = InertialAngle | SingleValueAngle | QuaternionAngle | ThreeAngles
"""Conversion of one sensor's readings to theta2; `status` is a text for display."""


def make_angle(sensor: Sensor, binary: bool, reading: Reading, counters: Counters) -> Angle | None:
    """Return a converter for such readings; None if this one has nothing that gives an angle."""
    if has(reading, ACCELERATION):
        return InertialAngle(sensor, binary, counters)
    if has(reading, QUATERNION[1:]):
        return QuaternionAngle(sensor, counters)
    if has(reading, ANGLES):
        return ThreeAngles(sensor)
    column = next((name for name in _SINGLE_VALUES if name in reading), None)
    return None if column is None else SingleValueAngle(sensor, column)
