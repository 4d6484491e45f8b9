"""What a sensor is like while it lies still at the start: units, rate, bias, which way is up."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from overview_dsp.devices.sensors.orientation import HIGHEST_BIAS_DEG_S, unit
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.units import Units, Vector, units_of
from overview_dsp.errors import InputError

STILL_DEG_S = 3.0
"""Spread of a gyroscope that lies still, standard deviation."""

SLOWEST_HZ, FASTEST_HZ = 25.0, 2000.0
IMPOSSIBLE_HZ, IMPOSSIBLE_S = 50_000.0, 0.5


@dataclass(frozen=True)
class RawSample:
    """One sample as sent: time (s), acceleration, angular velocity if there is any."""

    time_s: float
    acceleration: tuple[float, ...]
    turning: tuple[float, ...] | None


@dataclass(frozen=True)
class Calibration:
    """What was found.

    `bias` rad/s; `level` three rows of a rotation that makes what was up face up; `words` for a
    person.
    """

    units: Units
    period_s: float
    bias: Vector
    level: tuple[Vector, Vector, Vector]
    words: str


def calibrate(sensor: Sensor, binary: bool, samples: Sequence[RawSample]) -> Calibration:
    """What the first samples say; InputError if gravity or the clock is of no known unit."""
    units = units_of(sensor, binary, [one.acceleration for one in samples])
    steps = [b.time_s - a.time_s for a, b in pairwise(samples)]
    period = statistics.median(steps)
    if not 1.0 / IMPOSSIBLE_HZ <= period <= IMPOSSIBLE_S:
        raise InputError(
            f"samples {period:.3g} s apart can't be; they come {SLOWEST_HZ:g} to {FASTEST_HZ:g} "
            "times a second: is the unit of its stamps (t_us, t_ms, t_s) right, and is there a "
            "delay(...) in the sketch that is to be 10 or less?"
        )
    rate = 1.0 / period
    turning = samples[0].turning
    notes = [f"{rate:.4g} Hz, {units.words if turning else units.words.split(',')[0]}"]
    if not 0.95 * SLOWEST_HZ <= rate <= 1.05 * FASTEST_HZ:
        notes.append(f"made for {SLOWEST_HZ:g} to {FASTEST_HZ:g} Hz")
    if rate < 0.95 * SLOWEST_HZ:
        notes.append("make the delay(...) in the sketch's loop() 10 or less")
    bias, note = _bias(units, samples)
    notes.append(note)
    up = unit(_mean([units.acceleration_of(one.acceleration) for one in samples]))
    lean = math.degrees(math.acos(max(-1.0, min(1.0, up[2]))))
    levelled = lean <= sensor.number("calibration.level_deg")
    level = level_of(up) if levelled else ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    if levelled:
        notes.append(f"face up is {lean:.1f} degrees off its own axes")
    elif sensor.number("calibration.level_deg") > 0.0:
        notes.append(f"it began {lean:.0f} degrees from face up: its own axes are taken")
    return Calibration(units, period, bias, level, "; ".join(note for note in notes if note))


def _mean(vectors: Sequence[Vector]) -> Vector:
    x, y, z = (statistics.fmean(axis) for axis in zip(*vectors, strict=True))
    return x, y, z


def _bias(units: Units, samples: Sequence[RawSample]) -> tuple[Vector, str]:
    """The gyroscope's, if it lay still; and what to say if it did not."""
    turning = [units.angular_velocity_of(one.turning) for one in samples if one.turning]
    if not units.turning_known:
        return (0.0, 0.0, 0.0), ""
    if not turning:
        return (0.0, 0.0, 0.0), "no gyroscope: by gravity alone"
    bias = _mean(turning)
    spread = max(statistics.pstdev(axis) for axis in zip(*turning, strict=True))
    still = math.degrees(spread) <= STILL_DEG_S
    if not still or math.degrees(math.hypot(*bias)) > HIGHEST_BIAS_DEG_S:
        return (0.0, 0.0, 0.0), "it moved at the start: its bias is found when it rests"
    return bias, ""


def level_of(up: Vector) -> tuple[Vector, Vector, Vector]:
    """The smallest rotation that turns `up` to z (Rodrigues; up[2] > 0)."""
    x, y, z = up
    k = 1.0 / (1.0 + z)
    return (1.0 - k * x * x, -k * x * y, -x), (-k * x * y, 1.0 - k * y * y, -y), (x, y, z)
