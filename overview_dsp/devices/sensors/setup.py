"""A sensor's file from two twists: which axis is turned, which way is up, what the numbers are."""

from __future__ import annotations

import math
import statistics

from overview_dsp.devices.sensors.orientation import unit
from overview_dsp.devices.sensors.orientation_angles import up_of
from overview_dsp.devices.sensors.profile import SCHEMA, Sensor, parse_sensor
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    ANGULAR_VELOCITY,
    QUATERNION,
    Counters,
    Reading,
)
from overview_dsp.devices.sensors.stream import Sample, Stream
from overview_dsp.devices.sensors.units import Vector, raw_of
from overview_dsp.errors import InputError

TWISTS = 2
REST_S = 1.0
STILL_DEG = 15.0
"""What turns further within that isn't held still."""

NAMES_S = 1.5
"""Lines of one number may still say its name: boards of the kit do so once a second."""

AWAY_DEG, BACK_DEG = 90.0, 25.0
"""A twist goes so far, and comes back so near."""

STRAIGHT = 0.8
"""Part of a direction that one axis has; less, and the device lies or turns aslant."""

SMOOTH_S = 0.05
"""Of gravity, before its direction is taken."""

RANGES = (131.0, 65.5, 32.8, 16.4)
"""Counts of 1 deg/s of common gyroscopes, of 250 to 2000 deg/s."""

RANGE_NEAR = 0.25
LEAST_SPAN = 8.0
"""A knob's numbers go over more than that."""

_KNOB = ("pot",)


class Setup:
    """Bytes in, a sensor's file out.

    Attributes
    ----------
    ask : str
        What a person is to do now.
    problem : str
        Why nothing can be read; empty if nothing is wrong.
    done : bool
        Two twists were seen.
    """

    def __init__(self) -> None:
        """Nothing has come."""
        self._stream = Stream(Sensor(), Counters())
        self._samples: list[Sample] = []
        self._smooth: Vector | None = None
        self._rest: Vector | None = None
        self._ways: list[tuple[float, Vector]] = []
        self._away = False
        self._knob = False
        self.twists = 0
        self._unnamed: list[tuple[bytes, float]] = []
        self.ask = "leave it still: a sensor face up, a knob at one end"
        self.problem = ""

    @property
    def done(self) -> bool:
        """Whether it was twisted often enough."""
        return self.twists >= TWISTS

    def feed(self, data: bytes, arrival_s: float) -> None:
        """Watch; `arrival_s` is of any clock that goes forward."""
        samples = self._stream.feed(data, arrival_s)
        if not self._knob and self._stream.detected is None:
            self._unnamed.append((data, arrival_s))
        if self._stream.problem and not self._knob and "one number" in self._stream.problem:
            if arrival_s - self._unnamed[0][1] < NAMES_S:
                return
            # a knob's number may be anything: its two ends are seen when it is turned
            self._knob = True
            self._stream = Stream(Sensor(columns=_KNOB), Counters())
            for came, at_s in self._unnamed:
                self.feed(came, at_s)
            return
        self.problem = self._stream.problem
        for sample in samples:
            if not self.done:
                self._watch(sample)

    def _watch(self, sample: Sample) -> None:
        time_s, reading = sample
        way = _way(reading)
        if way is None:
            return
        last = self._samples[-1][0] if self._samples else time_s
        part = 1.0 - math.exp(-max(0.0, time_s - last) / SMOOTH_S)
        inertial = all(name in reading for name in ACCELERATION)
        if self._smooth is None or not inertial:
            self._smooth = way
        else:
            x, y, z = (a + (b - a) * part for a, b in zip(self._smooth, way, strict=True))
            self._smooth = (x, y, z)
        self._samples.append(sample)
        self._ways.append((time_s, self._smooth))
        if self._rest is None and self._turned(self._ways[0][1], self._smooth) > STILL_DEG:
            self._samples, self._ways = self._samples[-1:], self._ways[-1:]
        if time_s - self._samples[0][0] < REST_S:
            return
        if self._rest is None:
            x, y, z = (statistics.median(axis) for axis in
                       zip(*(one for _, one in self._ways), strict=True))  # fmt: skip
            self._rest = (x, y, z)
            self._say()
        away = self._turned(self._rest, self._smooth)
        if not self._away and away > AWAY_DEG:
            self._away = True
        elif self._away and away < BACK_DEG:
            self._away = False
            self.twists += 1
            self._say()

    def _say(self) -> None:
        left = TWISTS - self.twists
        reading = self._samples[-1][1]
        knob = "pot" in reading or "count" in reading
        how = "from one end to the other" if knob else "face down"
        times = f"{left} time{'s' if left > 1 else ''}"
        self.ask = f"now turn it {how} and back, {times}" if left else "that is all"

    def _turned(self, rest: Vector, way: Vector) -> float:
        """Degrees away from rest; of a knob, of its span so far, which is taken for 180."""
        reading = self._samples[-1][1]
        if _directed(reading):
            a, b = unit(rest), unit(way)
            cosine = sum(p * q for p, q in zip(a, b, strict=True))
            return math.degrees(math.acos(max(-1.0, min(1.0, cosine))))
        moved = [abs(p - q) for p, q in zip(rest, way, strict=True)]
        if all(name in reading for name in ANGLES) or "roll_deg" in reading:
            return max(abs(math.remainder(one, 360.0)) for one in moved)
        span = max(abs(rest[0] - one[0]) for _, one in self._ways)
        return 0.0 if span < LEAST_SPAN else 180.0 * moved[0] / span

    def toml(self) -> str:
        """The file.

        Raises
        ------
        InputError
            It lay or was turned aslant, so that no axis can be named.
        """
        assert self._rest is not None
        reading = self._samples[-1][1]
        detected = self._stream.detected
        lines = [f"schema = {SCHEMA}", 'title = "my sensor"']
        if detected is not None and detected.format == "text":
            names = ", ".join(f'"{name}"' for name in detected.columns)
            lines += ["", "[stream]", f"columns = [{names}]"]
        if _directed(reading):
            lines += self._units(reading) + self._axes()
        elif all(name in reading for name in ANGLES):
            lines += ["", "[angles]", f'twist = "{1 + self._most_moved()}"']
        elif "pot" in reading:
            ends = [one[0] for _, one in self._ways]
            low = self._rest[0]
            high = max(ends, key=lambda end: abs(end - low))
            lines += ["", "[potentiometer]", f"low = {low:g}", f"high = {high:g}"]
        elif "count" in reading:
            span = max((one[0] - self._rest[0] for _, one in self._ways), key=abs)
            lines += ["", "[encoder]", f"counts = {abs(span):g}"]
            lines += ["reverse = true"] if span < 0.0 else []
        text = "\n".join(lines) + "\n"
        parse_sensor(text, "setup", "setup")
        return text

    def _most_moved(self) -> int:
        assert self._rest is not None
        return max(
            range(3),
            key=lambda n: statistics.fmean(
                abs(math.remainder(way[n] - self._rest[n], 360.0))  # type: ignore[index]
                for _, way in self._ways
            ),
        )

    def _axes(self) -> list[str]:
        """x is the axis it was turned about, z the one that was up; y makes them right-handed."""
        assert self._rest is not None
        up = unit(self._rest)
        z = max(range(3), key=lambda n: abs(up[n]))
        if abs(up[z]) < STRAIGHT:
            raise InputError(
                "it lay aslant: no axis of the sensor was up; lay it down face up and begin again"
            )
        about = [0.0, 0.0, 0.0]
        for _, way in self._ways:
            a, b = up, unit(way)
            for n in range(3):
                i, j = (n + 1) % 3, (n + 2) % 3
                about[n] += abs(a[i] * b[j] - a[j] * b[i])
        x = max((n for n in range(3) if n != z), key=lambda n: about[n])
        if about[x] < STRAIGHT * math.hypot(*about):
            raise InputError(
                "it was turned about no axis of the sensor: fix the board straight along the "
                "wrist, turn it about that, and begin again"
            )
        y = 3 - x - z
        sign_z = 1.0 if up[z] > 0.0 else -1.0
        # y = z cross x
        sign_y = sign_z * (1.0 if (z, x) in ((0, 1), (1, 2), (2, 0)) else -1.0)
        named = {"x": "xyz"[x], "y": _signed(sign_y, y), "z": _signed(sign_z, z)}
        return ["", "[axes]", *(f'{name} = "{axis}"' for name, axis in named.items())]

    def _units(self, reading: Reading) -> list[str]:
        """What the counts of a bare sensor are; nothing for one whose unit gravity tells."""
        assert self._rest is not None
        detected = self._stream.detected
        if detected is None or detected.format == "frames" or detected.values:
            return []
        counts = raw_of(math.hypot(*self._rest))
        if counts is None or not all(name in reading for name in ACCELERATION):
            return []
        lines = ["", "[acceleration]", 'unit = "g"', f"scale = {1.0 / counts:.10g}"]
        if all(name in reading for name in ANGULAR_VELOCITY):
            lines += ["", "[angular_velocity]"]
            per_degree = self._per_degree()
            lines += (
                ["use = false"]
                if per_degree is None
                else ['unit = "deg/s"', f"scale = {1.0 / per_degree:.10g}"]
            )
        return lines

    def _per_degree(self) -> float | None:
        """Counts of a gyroscope's 1 deg/s: its path over gravity's, snapped to a common range."""
        path = turned = 0.0
        bias = [
            statistics.median(one[name] for at, one in self._samples
                              if at - self._samples[0][0] < REST_S)
            for name in ANGULAR_VELOCITY
        ]  # fmt: skip
        for n in range(1, len(self._samples)):
            (before, _), (at, reading) = self._samples[n - 1], self._samples[n]
            a, b = unit(self._ways[n - 1][1]), unit(self._ways[n][1])
            chord = math.dist(a, b)
            if chord / max(at - before, 1e-6) < math.radians(20.0):
                continue  # what hardly turns is noise
            turned += math.degrees(chord)
            speed = (reading[name] - b for name, b in zip(ANGULAR_VELOCITY, bias, strict=True))
            path += math.hypot(*speed) * (at - before)
        if turned == 0.0:
            return None
        found = path / turned
        nearest = min(RANGES, key=lambda one: abs(math.log(max(found, 1e-9) / one)))
        return nearest if abs(found / nearest - 1.0) <= RANGE_NEAR else None


def _signed(sign: float, axis: int) -> str:
    return ("-" if sign < 0.0 else "") + "xyz"[axis]


def _directed(reading: Reading) -> bool:
    """Whether it says which way is up."""
    return all(name in reading for name in ACCELERATION) or "qx" in reading


def _way(reading: Reading) -> Vector | None:
    """What a twist moves: up in the sensor's axes, three angles, or one number; None if none."""
    if all(name in reading for name in ACCELERATION):
        x, y, z = (reading[name] for name in ACCELERATION)
        return x, y, z
    return _up(reading) or _plain(reading)


def _up(reading: Reading) -> Vector | None:
    if not all(name in reading for name in QUATERNION[1:]):
        return None
    x, y, z = (reading[name] for name in QUATERNION[1:])
    return up_of((reading.get("qw", math.sqrt(max(0.0, 1.0 - x * x - y * y - z * z))), x, y, z))


def _plain(reading: Reading) -> Vector | None:
    if all(name in reading for name in ANGLES):
        x, y, z = (reading[name] for name in ANGLES)
        return x, y, z
    for name in ("roll_deg", "pot", "count"):
        if name in reading:
            return reading[name], 0.0, 0.0
    return None
