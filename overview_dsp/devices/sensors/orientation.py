"""Direction of up in the device's axes, from its acceleration and its angular velocity."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from overview_dsp.devices.sensors.units import GRAVITY, Vector, mix, unit
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
            gyr = self._angular_velocity + (speed_now - self._angular_velocity) * (
                (n - HALF_WAY) / steps
            )
            acc = self._acceleration + (now - self._acceleration) * (n / steps)
            self._filter.update(gyr * stretch, acc)
        self._acceleration, self._angular_velocity = now, speed_now
        w, x, y, z = self._filter.getQuat6D().tolist()
        return 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
