"""Setup of a sensor's profile from two twists: axis of the twist, direction of up, units."""

from __future__ import annotations

import math
import statistics

import numpy as np

from overview_dsp.devices.sensors.orientation_angles import quaternion_of, up_vector
from overview_dsp.devices.sensors.profile import SCHEMA, Sensor, parse_sensor
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    ANGULAR_VELOCITY,
    QUATERNION,
    Counters,
    Reading,
    has,
)
from overview_dsp.devices.sensors.stream import Sample, Stream
from overview_dsp.devices.sensors.units import Vector, angle_between, counts_per_g, mix, unit
from overview_dsp.errors import InputError

TWISTS = 2
REST_S = 1.0
STILL_DEG = 15.0  # largest turn during the rest at the start

NAMES_S = 1.5
"""Time to wait for the names of single numbers; boards of the kit print them once per second."""

AWAY_DEG, BACK_DEG = 90.0, 25.0  # a twist turns at least so far, and returns at least so close

STRAIGHT = 0.8
"""Smallest share of one axis in a direction; with a smaller one, the device is not aligned."""

SMOOTH_S = 0.05  # time constant for gravity, before its direction is used

COUNTS_PER_DEG_S = (131.0, 65.5, 32.8, 16.4)
"""Counts of common gyroscopes at 1 deg/s, for ranges of 250 to 2000 deg/s."""

COUNTS_TOLERANCE = 0.25
SMALLEST_SPAN = 8.0  # range that a knob's numbers must exceed
KNOB_COLUMNS = ("pot",)


class Setup:
    """Makes a sensor's profile from its stream while a user twists the device.

    `instruction` is for the user. `problem`: why nothing can be read, or empty. `twists`: their
    number.
    """

    def __init__(self) -> None:
        self._stream = Stream(Sensor(), Counters())
        self._samples: list[Sample] = []
        self._smooth: Vector | None = None
        self._rest: Vector = (0.0, 0.0, 1.0)
        self._rested = False
        self._track: list[tuple[float, Vector]] = []
        self._away = False
        self._is_knob = False
        self.twists = 0
        self._undetected: list[tuple[bytes, float]] = []
        self.instruction = "keep it at rest: a sensor face up, a knob at one end"
        self.problem = ""

    @property
    def done(self) -> bool:
        """True once the device was twisted twice."""
        return self.twists >= TWISTS

    def feed(self, data: bytes, arrival_s: float) -> None:
        """Process received bytes; `arrival_s` is of any monotonic clock."""
        samples = self._stream.feed(data, arrival_s)
        if not self._is_knob and self._stream.detected is None:
            self._undetected.append((data, arrival_s))
        if "one number" in self._stream.problem and not self._is_knob:
            if arrival_s - self._undetected[0][1] < NAMES_S:
                return
            # any single number may be a knob's: the turn shows its two ends
            self._is_knob = True
            self._stream = Stream(Sensor(columns=KNOB_COLUMNS), Counters())
            for received, at_s in self._undetected:
                self.feed(received, at_s)
            return
        self.problem = self._stream.problem
        for sample in samples:
            if not self.done:
                self._process(sample)

    def _process(self, sample: Sample) -> None:
        time_s, reading = sample
        vector = _tracked_vector(reading)
        if vector is None:
            return
        last = self._samples[-1][0] if self._samples else time_s
        if self._smooth is None or not has(reading, ACCELERATION):
            self._smooth = vector
        else:
            share = 1.0 - math.exp(-max(0.0, time_s - last) / SMOOTH_S)
            self._smooth = mix(self._smooth, vector, share)
        self._samples.append(sample)
        self._track.append((time_s, self._smooth))
        if not self._rested and self._turn_deg(self._track[0][1], self._smooth) > STILL_DEG:
            self._samples, self._track = self._samples[-1:], self._track[-1:]
        if time_s - self._samples[0][0] < REST_S:
            return
        if not self._rested:
            x, y, z = (statistics.median(axis) for axis in
                       zip(*(one for _, one in self._track), strict=True))  # fmt: skip
            self._rest, self._rested = (x, y, z), True
            self._instruct()
        turn = self._turn_deg(self._rest, self._smooth)
        if not self._away and turn > AWAY_DEG:
            self._away = True
        elif self._away and turn < BACK_DEG:
            self._away = False
            self.twists += 1
            self._instruct()

    def _instruct(self) -> None:
        left = TWISTS - self.twists
        reading = self._samples[-1][1]
        knob = "pot" in reading or "count" in reading
        how = "from one end to the other" if knob else "face down"
        times = f"{left} time{'s' if left > 1 else ''}"
        self.instruction = f"now turn it {how} and back, {times}" if left else "setup is complete"

    def _turn_deg(self, rest: Vector, vector: Vector) -> float:
        """Return the turn from rest, degrees; a knob's span so far counts as 180."""
        reading = self._samples[-1][1]
        if _shows_up(reading):
            return math.degrees(angle_between(unit(rest), unit(vector)))
        moved = [abs(p - q) for p, q in zip(rest, vector, strict=True)]
        if has(reading, ANGLES) or "roll_deg" in reading:
            return max(abs(math.remainder(one, 360.0)) for one in moved)
        span = max(abs(rest[0] - one[0]) for _, one in self._track)
        return 0.0 if span < SMALLEST_SPAN else 180.0 * moved[0] / span

    def toml(self) -> str:
        """Return the text of the profile; InputError if the device was tilted."""
        reading = self._samples[-1][1]
        detected = self._stream.detected
        lines = [f"schema = {SCHEMA}", 'title = "my sensor"']
        if detected is not None and detected.format == "text":
            names = ", ".join(f'"{name}"' for name in detected.columns)
            lines += ["", "[stream]", f"columns = [{names}]"]
        if _shows_up(reading):
            lines += self._units(reading) + self._axes()
        elif has(reading, ANGLES):
            moved = [
                statistics.fmean(abs(math.remainder(one[n] - self._rest[n], 360.0))
                                 for _, one in self._track)
                for n in range(3)
            ]  # fmt: skip
            lines += ["", "[angles]", f'twist = "{1 + moved.index(max(moved))}"']
        else:
            # from the start to the furthest number
            low = self._rest[0]
            high = max((one[0] for _, one in self._track), key=lambda end: abs(end - low))
            if "pot" in reading:
                lines += ["", "[potentiometer]", f"low = {low:g}", f"high = {high:g}"]
            elif "count" in reading:
                lines += ["", "[encoder]", f"counts = {abs(high - low):g}"]
                lines += ["reverse = true"] if high < low else []
        text = "\n".join(lines) + "\n"
        parse_sensor(text, "setup", "setup")
        return text

    def _axes(self) -> list[str]:
        """Return x as the axis of the turn, z as the axis that was up, and y right-handed."""
        up = unit(self._rest)
        z = max(range(3), key=lambda n: abs(up[n]))
        if abs(up[z]) < STRAIGHT:
            raise InputError(
                "the sensor was tilted: no axis pointed up; put it down face up and start again"
            )
        directions = [unit(vector) for _, vector in self._track]
        about = np.abs(np.cross(up, directions)).sum(axis=0).tolist()
        x = max((n for n in range(3) if n != z), key=lambda n: about[n])
        if about[x] < STRAIGHT * math.hypot(*about):
            raise InputError(
                "the turn was about no axis of the sensor: mount the board straight along the "
                "wrist, turn it about that, and start again"
            )
        y = 3 - x - z
        sign_z = 1.0 if up[z] > 0.0 else -1.0
        # y = z cross x
        sign_y = sign_z * (1.0 if (z, x) in ((0, 1), (1, 2), (2, 0)) else -1.0)
        named = (("x", 1.0, x), ("y", sign_y, y), ("z", sign_z, z))
        return ["", "[axes]", *(f'{name} = "{"-" if sign < 0.0 else ""}{"xyz"[axis]}"'
                                for name, sign, axis in named)]  # fmt: skip

    def _units(self, reading: Reading) -> list[str]:
        """Return the units of an unscaled sensor; nothing where gravity shows the unit."""
        detected = self._stream.detected
        if detected is None or detected.format == "frames" or detected.values:
            return []
        counts = counts_per_g(math.hypot(*self._rest))
        if counts is None or not has(reading, ACCELERATION):
            return []
        lines = ["", "[acceleration]", 'unit = "g"', f"scale = {1.0 / counts:.10g}"]
        if has(reading, ANGULAR_VELOCITY):
            lines += ["", "[angular_velocity]"]
            counts = self._counts_per_deg_s()
            scale = [] if counts is None else ['unit = "deg/s"', f"scale = {1.0 / counts:.10g}"]
            lines += scale or ["use = false"]
        return lines

    def _counts_per_deg_s(self) -> float | None:
        """Return the counts at 1 deg/s: the gyroscope's path over gravity's, as a common range."""
        path = turned = 0.0
        bias = [
            statistics.median(one[name] for at, one in self._samples
                              if at - self._samples[0][0] < REST_S)
            for name in ANGULAR_VELOCITY
        ]  # fmt: skip
        for n in range(1, len(self._samples)):
            (before, _), (at, reading) = self._samples[n - 1], self._samples[n]
            chord = math.dist(unit(self._track[n - 1][1]), unit(self._track[n][1]))
            if chord / max(at - before, 1e-6) < math.radians(20.0):
                continue  # a slow turn is mostly noise
            turned += math.degrees(chord)
            speed = (reading[name] - b for name, b in zip(ANGULAR_VELOCITY, bias, strict=True))
            path += math.hypot(*speed) * (at - before)
        if turned == 0.0:
            return None
        found = path / turned
        nearest = min(COUNTS_PER_DEG_S, key=lambda one: abs(math.log(max(found, 1e-9) / one)))
        return nearest if abs(found / nearest - 1.0) <= COUNTS_TOLERANCE else None


def _shows_up(reading: Reading) -> bool:
    """Return whether a reading shows the direction of up."""
    return has(reading, ACCELERATION) or "qx" in reading


def _tracked_vector(reading: Reading) -> Vector | None:
    """Return what a twist changes: up in the sensor's axes, three angles, or one number."""
    for names in (ACCELERATION, QUATERNION[1:], ANGLES):
        if has(reading, names):
            if "qx" in names and (up := up_vector(quaternion_of(reading))) is not None:
                return up
            if "qx" not in names:
                x, y, z = (reading[name] for name in names)
                return x, y, z
    name = next((name for name in ("roll_deg", "pot", "count") if name in reading), None)
    return None if name is None else (reading[name], 0.0, 0.0)
