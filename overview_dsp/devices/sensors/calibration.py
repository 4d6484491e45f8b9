"""Direction of up in the device's axes, and calibration at rest at the start: units, rate, bias."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.units import (
    GRAVITY,
    Units,
    Vector,
    angle_between,
    mix,
    unit,
    units_of,
)
from overview_dsp.errors import InputError
from overview_dsp.installation import install_command

GRAVITY_TAU_S = 0.02
"""Time constant of each of the two poles that smooth gravity where there is no gyroscope."""

GRAVITY_TOLERANCE = 0.2
"""Relative deviation from gravity at which an acceleration has the weight 1/e."""

LONGEST_GAP_S = 0.5
"""Longest gap over which rotation is interpolated; after a longer one gravity is measured again."""

HALF_WAY = 0.5
"""The gyroscope's speed between two samples is their mean. The sample's own speed (0) would lag by
half a sample less, without a gain here (tests/devices/sensors/test_optical.py prints both)."""

HIGHEST_BIAS_DEG_S = 10.0  # a gyroscope with a higher speed isn't at rest


class GravityTilt:
    """Smoothed direction of the acceleration; samples of a shaken device get a lower weight."""

    def __init__(self) -> None:
        self._first_pole: Vector | None = None
        self._second_pole: Vector = (0.0, 0.0, 1.0)

    def step(self, elapsed_s: float, acceleration: Vector, angular_velocity: Vector) -> Vector:
        """Return up after another `elapsed_s`: a unit vector along the device's x, y and z.

        `angular_velocity` isn't used.
        """
        if self._first_pole is None or elapsed_s > LONGEST_GAP_S:
            self._first_pole = self._second_pole = acceleration
        off = (math.hypot(*acceleration) / GRAVITY - 1.0) / GRAVITY_TOLERANCE
        share = 1.0 - math.exp(-elapsed_s / GRAVITY_TAU_S)
        weight = math.exp(-min(off * off, 100.0))
        self._first_pole = mix(self._first_pole, acceleration, share * weight)
        self._second_pole = mix(self._second_pole, self._first_pole, share)
        return unit(self._second_pole)


class GyroTilt:
    """VQF filter: integrates the gyroscope, corrects tilt by gravity and bias at rest.

    D. Laidig, T. Seel, "VQF: Highly Accurate IMU Orientation Estimation with Bias Estimation and
    Magnetic Disturbance Rejection", Information Fusion 91, 2023. Missing samples are interpolated
    linearly.
    """

    def __init__(self, period_s: float, bias: Vector) -> None:
        """Start a filter for a period and a bias (rad/s at rest); InputError without VQF."""
        try:
            from vqf import VQF
        except ImportError:
            raise InputError(
                "roll follows gravity alone, as the gyroscope needs the filter VQF: "
                f"{install_command('sensors')}"
            ) from None
        self._filter: Any = VQF(period_s, biasClip=HIGHEST_BIAS_DEG_S)
        self._period = period_s
        self._bias = np.array(bias)
        self._acceleration: np.ndarray[Any, Any] | None = None
        self._angular_velocity = np.zeros(3)

    def step(self, elapsed_s: float, acceleration: Vector, angular_velocity: Vector) -> Vector:
        """Return up, as `GravityTilt.step`."""
        now, speed_now = np.array(acceleration), np.array(angular_velocity) - self._bias
        if self._acceleration is None or elapsed_s > LONGEST_GAP_S:
            bias, _ = self._filter.getBiasEstimate()
            self._filter.resetState()
            self._filter.setBiasEstimate(bias)
            self._acceleration, self._angular_velocity = now, speed_now
            elapsed_s = self._period
        steps = max(1, round(elapsed_s / self._period))
        # an early or late sample covers a little less or more rotation
        stretch = elapsed_s / (steps * self._period)
        for n in range(1, steps + 1):
            # rotation since the previous step: the speed half way
            part = (n - HALF_WAY) / steps
            gyr = self._angular_velocity + (speed_now - self._angular_velocity) * part
            acc = self._acceleration + (now - self._acceleration) * (n / steps)
            self._filter.update(gyr * stretch, acc)
        self._acceleration, self._angular_velocity = now, speed_now
        w, x, y, z = self._filter.getQuat6D().tolist()
        return 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)


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
    bias, about_bias = _bias(units, samples)
    up = unit(_mean([units.acceleration_of(one.acceleration) for one in samples]))
    level, about_level = level_by(up, sensor)
    notes += filter(None, (about_bias, about_level))
    return Calibration(units, period, bias, level, "; ".join(notes))


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
    measured = (one.angular_velocity for one in samples)
    speeds = [units.angular_velocity_of(one) for one in measured if one]
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
