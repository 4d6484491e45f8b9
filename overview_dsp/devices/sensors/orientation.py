"""Which way is up, in the device's own axes, from its acceleration and its angular velocity."""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np

from overview_dsp.devices.sensors.units import GRAVITY, Vector
from overview_dsp.errors import InputError
from overview_dsp.installation import install_command

GRAVITY_TAU_S = 0.02
"""Each of the two poles that smooth gravity where there is no gyroscope."""

TRUSTED = 0.2
"""Accelerations that differ from gravity by so much of it count for 1/e."""

LONGEST_GAP_S = 0.5
"""Turning is not guessed over a longer silence: gravity is looked for anew."""

HALF_WAY = 0.5
"""Between two samples the gyroscope's speed is that half way. Taken as a sample's own (0) it lags
by half a sample less, which is no gain here (tests/devices/sensors/test_optical.py prints both)."""

HIGHEST_BIAS_DEG_S = 10.0
"""A gyroscope at rest that says more is turning."""


class Orientation(Protocol):
    """Samples in, up out."""

    def step(self, elapsed_s: float, acceleration: Vector, turning: Vector) -> Vector:
        """Up after `elapsed_s` more: a unit vector along the device's x, y and z."""


class ByGravity:
    """Up is where the acceleration points, smoothed; a shaken hand is half believed."""

    def __init__(self) -> None:
        """Up isn't known yet."""
        self._one: Vector | None = None
        self._two: Vector = (0.0, 0.0, 1.0)

    def step(self, elapsed_s: float, acceleration: Vector, turning: Vector) -> Vector:
        """As `Orientation.step`; `turning` isn't used."""
        if self._one is None or elapsed_s > LONGEST_GAP_S:
            self._one = self._two = acceleration
        off = (math.hypot(*acceleration) / GRAVITY - 1.0) / TRUSTED
        part = (1.0 - math.exp(-elapsed_s / GRAVITY_TAU_S)) * math.exp(-min(off * off, 100.0))
        self._one = _towards(self._one, acceleration, part)
        self._two = _towards(self._two, self._one, 1.0 - math.exp(-elapsed_s / GRAVITY_TAU_S))
        return unit(self._two)


class ByTurning:
    """VQF: the gyroscope integrated, held upright by gravity, its bias found while it rests.

    D. Laidig, T. Seel, "VQF: Highly Accurate IMU Orientation Estimation with Bias Estimation and
    Magnetic Disturbance Rejection", Information Fusion 91, 2023. Samples that are missing are
    filled in on a straight line.
    """

    def __init__(self, period_s: float, bias: Vector) -> None:
        """For samples every `period_s`; `bias` (rad/s) is what the gyroscope says at rest.

        Raises
        ------
        InputError
            The package isn't installed.
        """
        try:
            from vqf import VQF
        except ImportError:
            raise InputError(
                f"a gyroscope needs the filter VQF: {install_command('sensors')}, or give "
                "sensor=FILE.toml with angular_velocity.use = false to go by gravity alone"
            ) from None
        self._filter: Any = VQF(period_s, biasClip=HIGHEST_BIAS_DEG_S)
        self._period = period_s
        self._bias = np.array(bias)
        self._acceleration: np.ndarray[Any, Any] | None = None
        self._turning = np.zeros(3)

    def step(self, elapsed_s: float, acceleration: Vector, turning: Vector) -> Vector:
        """As `Orientation.step`."""
        now, turned = np.array(acceleration), np.array(turning) - self._bias
        if self._acceleration is None or elapsed_s > LONGEST_GAP_S:
            found, _ = self._filter.getBiasEstimate()
            self._filter.resetState()
            self._filter.setBiasEstimate(found)
            self._acceleration, self._turning = now, turned
            elapsed_s = self._period
        steps = max(1, round(elapsed_s / self._period))
        # a sample that came a little early or late turned a little less or more
        stretch = elapsed_s / (steps * self._period)
        for n in range(1, steps + 1):
            # what it turned since the step before: its speed half way
            gyr = self._turning + (turned - self._turning) * ((n - HALF_WAY) / steps)
            acc = self._acceleration + (now - self._acceleration) * (n / steps)
            self._filter.update(gyr * stretch, acc)
        self._acceleration, self._turning = now, turned
        w, x, y, z = self._filter.getQuat6D().tolist()
        return 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)


def unit(vector: Vector) -> Vector:
    """The vector's direction; upwards of nothing is z."""
    length = math.hypot(*vector)
    if length == 0.0:
        return (0.0, 0.0, 1.0)
    return vector[0] / length, vector[1] / length, vector[2] / length


def _towards(a: Vector, b: Vector, part: float) -> Vector:
    x, y, z = (p + (q - p) * part for p, q in zip(a, b, strict=True))
    return x, y, z
