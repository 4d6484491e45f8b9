"""What a sensor is: its format, units and axes, and how it lies on what is turned.

Everything a file may say stands in one table, as with presets: id, unit, range, default, sentence.
"""

from __future__ import annotations

import string
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.presets.parameter import Parameter, Value
from overview_dsp.sensors.reading import COLUMNS

DETECT = "told"
"""The value of a key whose setting is detected from the data, as profiles write it."""

MOTOR_COLUMNS = ("motor_target", "shaft_rad")
"""What a motor reports."""

_AXES = ("x", "y", "z", "-x", "-y", "-z")


def _number(id: str, default: float, low: float, high: float, unit: str, doc: str) -> Parameter:
    return Parameter(id, default, low, high, unit, doc)


SENSOR_PARAMETERS: Mapping[str, Parameter] = MappingProxyType(
    {
        known.id: known
        for known in (
            Parameter("stream.format", DETECT, doc="How samples are written; told = by content.",
                      choices=(DETECT, "frames", "json", "text")),
            _number("stream.baud", 115_200.0, 300.0, 4e6, "bit/s",
                    "Speed of the port; a USB device takes any."),
            Parameter("acceleration.unit", DETECT, doc="told = by gravity at rest.",
                      choices=(DETECT, "m/s²", "g", "mg")),
            _number("acceleration.scale", 1.0, -1e6, 1e6, "",
                    "What 1 of the sensor is in that unit; negative if gravity shows downwards."),
            Parameter("angular_velocity.unit", DETECT,
                      doc="told = rad/s with m/s², else deg/s.",
                      choices=(DETECT, "rad/s", "deg/s")),
            _number("angular_velocity.scale", 1.0, -1e6, 1e6, "",
                    "What 1 of the sensor is in that unit."),
            Parameter("angular_velocity.use", True, doc="False: roll by gravity alone.",
                      choices=(False, True)),
            Parameter("axes.x", "x", doc="The sensor's axis along which the device is turned: "
                      "from the wrist to the fingers.", choices=_AXES),
            Parameter("axes.y", "y", doc="The sensor's axis to the left of that.", choices=_AXES),
            Parameter("axes.z", "z", doc="The sensor's axis out of the face.", choices=_AXES),
            _number("calibration.seconds", 1.0, 0.25, 10.0, "s",
                    "How long it must lie still at the start."),
            _number("calibration.level_deg", 20.0, 0.0, 60.0, "deg",
                    "How it lies at the start is face up if it is within this of it; 0 = its own "
                    "axes are."),
            _number("encoder.counts", 40.0, 1.0, 1e7, "counts", "Of the whole timeline."),
            _number("encoder.wrap", 0.0, 0.0, 4294967296.0, "counts",
                    "Where its count begins again; 0 = nowhere."),
            Parameter("encoder.reverse", False, doc="It counts down.", choices=(False, True)),
            _number("potentiometer.low", 0.0, -1e9, 1e9, "", "At the timeline's start."),
            _number("potentiometer.high", 1023.0, -1e9, 1e9, "", "At its end."),
            Parameter("motor.protocol", "none", doc="How a torque is sent to its motor.",
                      choices=("none", "simplefoc")),
            Parameter("motor.letter", "M", doc="The motor's in its Commander.",
                      choices=tuple(string.ascii_letters)),
            _number("motor.nm_per_unit", 0.0, 0.0, 100.0, "N·m",
                    "Torque of 1 of its target: of 1 A, or 1 V in voltage mode; with a motor it "
                    "must be said."),
            _number("motor.scale", 1.0, 0.0, 1000.0, "", "Torque at the knob for 1 of the disk's."),
            _number("motor.ceiling_nm", 0.02, 0.0, 10.0, "N·m", "Torque that is never passed."),
            _number("motor.inertia", 5e-5, 1e-7, 1.0, "kg·m²",
                    "Of rotor and knob: too small a value makes it weak, too large a one unquiet."),
            _number("motor.friction_nm", 1e-4, 1e-6, 1.0, "N·m",
                    "That the knob itself has at least, without power."),
            _number("motor.turn_deg", 180.0, 1.0, 36_000.0, "deg",
                    "Turn of the shaft for the whole timeline."),
            Parameter("motor.reverse", False, doc="Its angle falls as the timeline goes on.",
                      choices=(False, True)),
            _number("motor.resolution_deg", 0.1, 1e-4, 10.0, "deg",
                    "Its angle is right to this, either way: a step of its encoder, or its noise."),
            _number("motor.downsample", 10.0, 1.0, 100_000.0, "",
                    "It reports at every so manieth call of motor.monitor(); it is to be 200 times "
                    "a second or more."),
        )
    }
)  # fmt: skip


@dataclass(frozen=True)
class Sensor:
    """A sensor's profile.

    Attributes
    ----------
    name, title, description : str
    values : mapping
        By id, those of `SENSOR_PARAMETERS`; what is left out gets its default.
    columns : tuple of str
        Of its lines of text, names of `reading.COLUMNS`; empty = detected from the content.
    source : str
        Its file.
    """

    name: str = "told"
    title: str = ""
    description: str = ""
    values: Mapping[str, Value] = field(default_factory=dict)
    columns: tuple[str, ...] = ()
    source: str = ""

    def __post_init__(self) -> None:
        """InputError, which begins with the key, for a value that can't be, or not with another."""
        values = {known.id: known.default for known in SENSOR_PARAMETERS.values()}
        for id, value in self.values.items():
            if id not in SENSOR_PARAMETERS:
                raise InputError(f"{id}: unknown key{did_you_mean(id, SENSOR_PARAMETERS)}")
            values[id] = SENSOR_PARAMETERS[id].check(value)
        object.__setattr__(self, "values", values)
        for id in ("acceleration.scale", "angular_velocity.scale"):
            if self.number(id) == 0.0:
                raise InputError(f"{id} = 0 is not allowed; it is any other number")
        if self.number("potentiometer.low") == self.number("potentiometer.high"):
            raise InputError("potentiometer.low equals potentiometer.high; they are its two ends")
        if self._handedness() != 1:
            raise InputError(
                f"axes.x = {self.values['axes.x']!r}, y = {self.values['axes.y']!r}, "
                f"z = {self.values['axes.z']!r} is no rotation; x, y and z are three different "
                "axes, right-handed (turn the sign of one)"
            )
        for name in self.columns:
            if name not in COLUMNS:
                raise InputError(f"stream.columns: {name!r}{did_you_mean(name, COLUMNS)}; "
                                 f"known: {', '.join(COLUMNS)}")  # fmt: skip
        if len(set(self.columns)) != len(self.columns):
            raise InputError("stream.columns names a column twice")
        self._check_motor()
        if self.columns and self.values["stream.format"] not in (DETECT, "text"):
            raise InputError('stream.columns is for stream.format = "text"')
        if self.values["stream.format"] == "text" and not self.columns:
            raise InputError('stream.columns is missing; text has a list of names: ["ax", "ay", …]')

    def _check_motor(self) -> None:
        if self.values["motor.protocol"] == "none":
            return
        if self.number("motor.nm_per_unit") == 0.0:
            raise InputError(
                "motor.nm_per_unit is missing; it is the torque (N·m) of 1 A, or of 1 V in voltage "
                "mode: 8.27 / KV for 1 A, and that over the phase resistance for 1 V"
            )
        if self.columns != MOTOR_COLUMNS:
            names = ", ".join(f'"{name}"' for name in MOTOR_COLUMNS)
            raise InputError(f"stream.columns of a motor are what it is set to report: [{names}]")

    def number(self, id: str) -> float:
        """A numeric value by its id."""
        value = self.values[id]
        assert not isinstance(value, str)
        return float(value)

    @property
    def axes(self) -> tuple[tuple[int, float], ...]:
        """Of the device's x, y and z: which axis of the sensor (0 to 2), and its sign."""
        named = (str(self.values[f"axes.{name}"]) for name in "xyz")
        return tuple(("xyz".index(name[-1]), -1.0 if name[0] == "-" else 1.0) for name in named)

    def _handedness(self) -> int:
        order = [index for index, _ in self.axes]
        if sorted(order) != [0, 1, 2]:
            return 0
        swaps = sum(a > b for at, a in enumerate(order) for b in order[at + 1 :])
        sign = -1 if swaps % 2 else 1
        for _, one in self.axes:
            sign *= int(one)
        return sign
