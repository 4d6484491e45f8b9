"""Setup of a sensor's profile from two twists: axis of the twist, direction of up, units."""

from __future__ import annotations

import json
import math

import numpy as np

from overview_dsp.devices.sensors.decoders import AMBIGUOUS
from overview_dsp.devices.sensors.lines import LineSplitter, parse_header
from overview_dsp.devices.sensors.number_meaning import (
    AWAY_DEG,
    REST_ROWS,
    Meaning,
    NumberLearner,
    Table,
    are_turns,
    axes_in_turn,
    explain,
    find_named,
    from_rest,
)
from overview_dsp.devices.sensors.orientation_angles import quaternion_of
from overview_dsp.devices.sensors.profile import SCHEMA, Sensor, parse_sensor
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    ANGULAR_VELOCITY,
    INERTIAL,
    QUATERNION,
    Counters,
    Reading,
    has,
)
from overview_dsp.devices.sensors.stream import Sample, Stream
from overview_dsp.devices.sensors.units import counts_per_g, is_unit_of_gravity

REST_S = 1.0
RETRY_SAMPLES = 10  # samples between attempts to find the turns

NAMES_S = 1.5
"""Time to wait for the names of single numbers; boards of the kit print them once per second."""

SMOOTHED = np.ones(5) / 5.0  # weights of the samples that smooth gravity
SLOW_DEG_S = 20.0  # a slower turn is mostly noise
COUNTS_RAD_S = math.pi / 180.0
COUNTS_PER_DEG_S = (131.0, 65.5, 32.8, 16.4, 1.0, COUNTS_RAD_S)
"""Counts of common gyroscopes at 1 deg/s, for ranges of 250 to 2000 deg/s; deg/s, and rad/s."""

COUNTS_TOLERANCE = 0.25
SMALLEST_SPAN = 8.0  # range that a knob's numbers must exceed
KNOBS = ("roll_deg", "pot", "count")


class Setup:
    """Makes a sensor's profile from its stream while a user twists the device.

    `instruction` is for the user. `problem`: why nothing can be read, or empty. `done`: whether
    the turns were found.
    """

    def __init__(self) -> None:
        self._stream = Stream(Sensor(), Counters())
        self._received: list[tuple[bytes, float]] = []
        self._samples: list[Sample] = []
        self._has_columns = False
        self._learner: NumberLearner | None = None
        self._meaning: Meaning | None = None
        self._tried = 0
        self.done = False
        self.instruction = "keep it at rest: a sensor face up, a knob at one end"
        self.problem = ""

    def feed(self, data: bytes, arrival_s: float) -> None:
        """Process received bytes; `arrival_s` is of any monotonic clock."""
        if self._learner is not None and not self._has_columns:
            self._learn(data, arrival_s)
            return
        was_detected = self._stream.detected is not None
        samples = self._stream.feed(data, arrival_s)
        if not self._has_columns and not was_detected:
            self._received.append((data, arrival_s))
            if "one number" in self._stream.problem:
                # any single number may be a knob's: the turn shows its two ends
                if arrival_s - self._received[0][1] >= NAMES_S:
                    self._use_columns(("pot",))
                return
            if AMBIGUOUS in self._stream.problem or self._has_bare_numbers():
                self._learner = NumberLearner()
                self._instruct(False)
                received, self._received = self._received, []
                for one, at_s in received:
                    self._learn(one, at_s)
                return
        self.problem = self._stream.problem
        if not self.done:
            self._samples += samples
            self._find()

    @property
    def failure(self) -> str:
        """Reason why there is no profile yet."""
        reason = self.problem or self.instruction
        if self._learner is not None and not self._has_columns:
            reason = self._learner.explanation
        elif self._samples and self._samples[-1][0] - self._samples[0][0] >= REST_S:
            reason = explain(self._table())
        return f"no two twists ({reason})"

    def _has_bare_numbers(self) -> bool:
        """Return whether nothing but the numbers at rest tells the columns of the lines."""
        detected = self._stream.detected
        if detected is None or detected.format != "text" or len(detected.columns) < 3:
            return False
        lines = LineSplitter(Counters()).feed(b"".join(data for data, _ in self._received))
        return not any(map(parse_header, lines))

    def _learn(self, data: bytes, arrival_s: float) -> None:
        """Find out from the turn what the numbers are."""
        assert self._learner is not None
        self._received.append((data, arrival_s))
        columns = self._learner.feed(data, arrival_s)
        if columns:
            self._use_columns(columns)

    def _use_columns(self, columns: tuple[str, ...]) -> None:
        """Read everything again as lines of `columns`."""
        self._has_columns = True
        self._stream = Stream(Sensor(columns=columns), Counters())
        for received, at_s in self._received:
            self.feed(received, at_s)

    def _instruct(self, knob: bool) -> None:
        how = "from one end to the other" if knob else "face down"
        self.instruction = f"now turn it {how} and back, 2 times"

    def _names(self) -> tuple[str, ...]:
        """Return the columns that show the turn."""
        reading = self._samples[-1][1]
        known = (INERTIAL, ACCELERATION, QUATERNION[1:], ANGLES, *((name,) for name in KNOBS))
        return next((names for names in known if has(reading, names)), ())

    def _table(self) -> Table:
        names = self._names()
        rows = [quaternion_of(one) if names == QUATERNION[1:] else [one[name] for name in names]
                for _, one in self._samples if has(one, names)]  # fmt: skip
        table: Table = np.array(rows, dtype=float)
        return table

    def _find(self) -> None:
        if len(self._samples) < self._tried + RETRY_SAMPLES:
            return
        self._tried = len(self._samples)
        names = self._names()
        if not names or self._samples[-1][0] - self._samples[0][0] < REST_S:
            return
        knob = names[0] in KNOBS
        self._instruct(knob and names[0] != "roll_deg")
        table = self._table()
        start = from_rest(table)
        self._samples, table = self._samples[start:], table[start:]
        self._tried -= start
        if knob:
            moved = table[:, 0] - table[0, 0]
            span = 180.0 if names[0] == "roll_deg" else float(np.abs(moved).max())
            self.done = span > SMALLEST_SPAN and are_turns(moved * 180.0 / span, AWAY_DEG)
        else:
            detected = self._stream.detected
            unordered = detected is not None and "quaternion.order" in detected.values
            quantity = {"qx": "quaternion", ANGLES[0]: "angles"}.get(names[0], "acceleration")
            self._meaning = find_named(table, quantity, unordered)
            self.done = self._meaning is not None
        if self.done:
            self.instruction = "setup is complete"

    def toml(self) -> str:
        """Return the text of the profile; InputError if the device was tilted."""
        reading, meaning, detected = self._samples[-1][1], self._meaning, self._stream.detected
        lines = [f"schema = {SCHEMA}", 'title = "my sensor"']
        if detected is not None and detected.format == "text":
            # a basic string of TOML has the escapes of JSON
            lines += ["", "[stream]", f"columns = {json.dumps(detected.columns)}"]
        table = self._table()
        if meaning is not None and meaning.ups is not None:
            lines += self._units(reading, meaning.ups)
            x, y, z = np.median(meaning.ups[:REST_ROWS], axis=0)
            axes = zip("xyz", axes_in_turn((x, y, z), meaning.ups), strict=True)
            lines += ["", "[axes]", *(f'{name} = "{axis}"' for name, axis in axes)]
            if meaning.order == "xyzw":
                lines += ["", "[quaternion]", 'order = "xyzw"']
        elif meaning is not None:
            lines += ["", "[angles]", f'twist = "{1 + meaning.twist}"']
            lines += ['unit = "rad"'] if meaning.radians else []
        else:
            # from the start to the furthest number
            low = float(np.median(table[:REST_ROWS, 0]))
            high = float(table[np.argmax(np.abs(table[:, 0] - low)), 0])
            if "pot" in reading:
                lines += ["", "[potentiometer]", f"low = {low:g}", f"high = {high:g}"]
            elif "count" in reading:
                lines += ["", "[encoder]", f"counts = {abs(high - low):g}"]
                lines += ["reverse = true"] if high < low else []
        text = "\n".join(lines) + "\n"
        parse_sensor(text, "setup", "setup")
        return text

    def _units(self, reading: Reading, ups: Table) -> list[str]:
        """Return the units of an unscaled sensor; nothing where gravity shows the unit."""
        detected = self._stream.detected
        if detected is None or detected.format == "frames" or detected.values:
            return []
        if not has(reading, ACCELERATION):
            return []
        size = float(np.median(np.linalg.norm(self._table()[:REST_ROWS, :3], axis=1)))
        counts, lines = counts_per_g(size), []
        if counts is not None:
            lines = ["", "[acceleration]", 'unit = "g"', f"scale = {1.0 / counts:.10g}"]
        if not has(reading, ANGULAR_VELOCITY):
            return lines
        found = self._counts_per_deg_s(ups)
        default = COUNTS_RAD_S if is_unit_of_gravity(size, 1.0) else 1.0
        if found in (1.0, COUNTS_RAD_S):
            unit = "deg/s" if found == 1.0 else "rad/s"
            scale = [] if counts is None and found == default else [f'unit = "{unit}"']
        elif found is not None:
            scale = ['unit = "deg/s"', f"scale = {1.0 / found:.10g}"]
        else:
            scale = [] if counts is None else ["use = false"]
        return lines + (["", "[angular_velocity]", *scale] if scale else [])

    def _counts_per_deg_s(self, ups: Table) -> float | None:
        """Return the counts at 1 deg/s: the gyroscope's path over gravity's, as a common range."""
        smooth = np.stack([np.convolve(axis, SMOOTHED, "same") for axis in ups.T], axis=1)
        smooth /= np.linalg.norm(smooth, axis=1, keepdims=True)
        elapsed = np.maximum(np.diff([at for at, _ in self._samples]), 1e-6)
        chord = np.degrees(np.linalg.norm(np.diff(smooth, axis=0), axis=1))
        fast = chord / elapsed > SLOW_DEG_S
        speed = self._table()[:, 3:]
        speed = np.linalg.norm(speed - np.median(speed[:REST_ROWS], axis=0), axis=1)[1:]
        if not fast.any():
            return None
        found = max(float((speed * elapsed)[fast].sum() / chord[fast].sum()), 1e-9)
        nearest = min(COUNTS_PER_DEG_S, key=lambda one: abs(math.log(found / one)))
        return nearest if abs(found / nearest - 1.0) <= COUNTS_TOLERANCE else None
