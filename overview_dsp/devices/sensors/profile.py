"""What a sensor is: its format, units and axes, and how it lies on what is turned.

Everything a file may say stands in `parameters.toml`, as with presets.

A sensor's file to its profile, and where such files are; errors name file, line, key, range.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

from overview_dsp.design.presets.parameter import Parameter, Value, read_parameters
from overview_dsp.devices.sensors.reading import COLUMNS, SKIPPED
from overview_dsp.errors import InputError, did_you_mean, shown
from overview_dsp.files.library import Library
from overview_dsp.files.toml import (
    TEXTS,
    check_head,
    faults_at_their_line,
    parse_toml,
    read_text,
    sections_of,
    values_in,
)

DETECT = "told"
"""The value of a key whose setting is detected from the data, as profiles write it."""

MOTOR_COLUMNS = ("motor_target", "shaft_rad")
"""What a motor reports."""

SENSOR_PARAMETERS: Mapping[str, Parameter] = MappingProxyType(
    read_parameters(Path(__file__).with_name("parameters.toml"))
)
"""Everything a profile may say, by id."""


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
            if name not in COLUMNS and name != SKIPPED:
                raise InputError(f"stream.columns: {name!r}{did_you_mean(name, COLUMNS)}; known: "
                                 f"{', '.join(COLUMNS)}; {SKIPPED} is skipped")  # fmt: skip
        read = [name for name in self.columns if name != SKIPPED]
        if self.columns and not read:
            raise InputError("stream.columns reads none: all are skipped (_)")
        if len(set(read)) != len(read):
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

    def told(self, values: Mapping[str, Value]) -> Sensor:
        """This sensor with `values` where it leaves the default."""
        left = {id: value for id, value in values.items()
                if self.values[id] == SENSOR_PARAMETERS[id].default}  # fmt: skip
        return replace(self, values={**self.values, **left}) if left else self

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


SCHEMA = 1
LIBRARY = Library("sensors", "a sensor")
_COLUMNS = "stream.columns"


def load_sensor(name: str | Path) -> Sensor:
    """A sensor: a bundled name (`potentiometer`) or the path of a TOML file.

    Raises
    ------
    InputError
        No such profile, or one that is not valid: names file, line, key and range.
    """
    path = LIBRARY.path(name)
    return parse_sensor(read_text(path), path.stem, str(path))


def parse_sensor(text: str, name: str, source: str) -> Sensor:
    """A sensor from a file's text; InputError as `load_sensor`."""
    data = parse_toml(text, source)
    with faults_at_their_line(text, source):
        check_head(data, sections_of(SENSOR_PARAMETERS), SCHEMA, needs_texts=False)
        values = values_in(data, (*SENSOR_PARAMETERS, _COLUMNS))
        columns = _columns(values.pop(_COLUMNS)) if _COLUMNS in values else ()
        title, description = (data.get(key, "") for key in TEXTS)
        return Sensor(name, title, description, values, columns, source)


def _columns(value: object) -> tuple[str, ...]:
    if not isinstance(value, list) or not value or not all(isinstance(one, str) for one in value):
        raise InputError(f'stream.columns = {shown(value)} is not allowed; it is a list: ["ax", …]')
    return tuple(value)
