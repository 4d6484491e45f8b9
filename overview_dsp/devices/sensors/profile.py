"""Sensor profiles: format, units, axes and mounting of a sensor, read from TOML files.

`parameters.toml` declares all keys, as for presets. Errors name file, line, key and range.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from overview_dsp.design.presets.parameter import Parameter, Value, read_parameters
from overview_dsp.devices.sensors.lines import WORD
from overview_dsp.devices.sensors.reading import COLUMNS, SKIPPED
from overview_dsp.errors import InputError, did_you_mean, quoted
from overview_dsp.files import toml
from overview_dsp.files.library import Library

DETECT = "auto"  # value of a key whose setting is detected from the data
MOTOR_COLUMNS = ("motor_target", "shaft_rad")  # columns that a motor reports

SENSOR_PARAMETERS: Mapping[str, Parameter] = MappingProxyType(
    read_parameters(Path(__file__).with_name("parameters.toml"))
)
"""All keys of a profile, by id."""


@dataclass(frozen=True)
class Sensor:
    """A sensor's profile.

    `values`: values by the ids of `SENSOR_PARAMETERS`; a missing one gets its default.
    `columns`: columns of its text lines, of `reading.COLUMNS`; empty = detected from the data.
    `source`: its file.
    """

    name: str = DETECT
    title: str = ""
    description: str = ""
    values: Mapping[str, Value] = field(default_factory=dict)
    columns: tuple[str, ...] = ()
    source: str = ""

    def __post_init__(self) -> None:
        """Validate the values; the message of an InputError begins with the key."""
        values = {known.id: known.default for known in SENSOR_PARAMETERS.values()}
        for id, value in self.values.items():
            if id not in SENSOR_PARAMETERS:
                raise InputError(f"{id}: unknown key{did_you_mean(id, SENSOR_PARAMETERS)}")
            values[id] = SENSOR_PARAMETERS[id].check(value)
        object.__setattr__(self, "values", values)
        for id in ("acceleration.scale", "angular_velocity.scale"):
            if self.number(id) == 0.0:
                raise InputError(f"{id} = 0 is not allowed; must be any other number")
        if self.number("potentiometer.low") == self.number("potentiometer.high"):
            raise InputError("potentiometer.low equals potentiometer.high; must be its two ends")
        order, signs = zip(*self.axes, strict=True)
        parity = 1.0 if (order[1] - order[0]) % 3 == 1 else -1.0
        if sorted(order) != [0, 1, 2] or math.prod(signs) != parity:
            raise InputError(
                f"axes.x = {self.values['axes.x']!r}, y = {self.values['axes.y']!r}, "
                f"z = {self.values['axes.z']!r} is not a rotation; x, y and z must be three "
                "different axes, right-handed (change the sign of one)"
            )
        self._check_columns()
        self._check_motor()

    def _check_columns(self) -> None:
        for name in self.columns:
            if name not in COLUMNS and name != SKIPPED and not name.startswith(WORD):
                raise InputError(f"stream.columns: {name!r}{did_you_mean(name, COLUMNS)}; known: "
                                 f"{', '.join(COLUMNS)}; {SKIPPED} skips a column, {WORD}TEXT is a "
                                 "word of the lines to read")  # fmt: skip
        read = [name for name in self.columns if name != SKIPPED and not name.startswith(WORD)]
        if self.columns and not read:
            raise InputError("stream.columns skips all columns (_); name at least one")
        if len(set(read)) != len(read):
            raise InputError("stream.columns names a column twice")
        if self.columns and self.values["stream.format"] not in (DETECT, "text"):
            raise InputError('stream.columns is only for stream.format = "text"')
        if self.values["stream.format"] == "text" and not self.columns:
            raise InputError(
                'stream.columns is missing; must be a list of names for text: ["ax", "ay", …]'
            )

    def _check_motor(self) -> None:
        if self.values["motor.protocol"] == "none":
            return
        if self.number("motor.nm_per_unit") == 0.0:
            raise InputError(
                "motor.nm_per_unit is missing; must be the torque (N·m) of 1 A, or of 1 V in "
                "voltage mode: 8.27 / KV for 1 A, and that over the phase resistance for 1 V"
            )
        if self.columns != MOTOR_COLUMNS:
            names = ", ".join(f'"{name}"' for name in MOTOR_COLUMNS)
            raise InputError(f"stream.columns must be [{names}] for a motor")

    def with_defaults(self, values: Mapping[str, Value]) -> Sensor:
        """Return this sensor with `values` in place of its default values."""
        changed = {id: value for id, value in values.items()
                   if self.values[id] == SENSOR_PARAMETERS[id].default}  # fmt: skip
        return replace(self, values={**self.values, **changed}) if changed else self

    def number(self, id: str) -> float:
        """Return a numeric value by its id."""
        value = self.values[id]
        assert not isinstance(value, str)
        return float(value)

    @property
    def axes(self) -> tuple[tuple[int, float], ...]:
        """Index (0 to 2) and sign of the sensor's axis for each of the device's x, y and z."""
        named = (str(self.values[f"axes.{name}"]) for name in "xyz")
        return tuple(("xyz".index(name[-1]), -1.0 if name[0] == "-" else 1.0) for name in named)


SCHEMA = 3
LIBRARY = Library("sensors", "a sensor")
_COLUMNS = "stream.columns"
_OLD_MOTOR_KEYS = {
    1: {"letter": "command_letter"},
    2: {"impact_gain": "knock", "recoil_gain": "home"},
}
"""Present keys of `[motor]` for those of an earlier schema."""
_SCHEMA_1_DETECT = "told"


def load_sensor(name: str | Path) -> Sensor:
    """Return a sensor by a bundled name (`potentiometer`) or a TOML file; InputError."""
    path = LIBRARY.path(name)
    return parse_sensor(toml.read_text(path), path.stem, str(path))


def parse_sensor(text: str, name: str, source: str) -> Sensor:
    """Return a sensor from a file's text; InputError as `load_sensor`."""
    data = _migrated(toml.parse_toml(text, source))
    with toml.faults_at_their_line(text, source):
        toml.check_head(data, toml.sections_of(SENSOR_PARAMETERS), SCHEMA, needs_texts=False)
        values = toml.values_in(data, (*SENSOR_PARAMETERS, _COLUMNS))
        columns = values.pop(_COLUMNS) if _COLUMNS in values else None
        is_list = isinstance(columns, list) and columns
        if columns is not None and not (is_list and all(isinstance(one, str) for one in columns)):
            raise InputError(f'{_COLUMNS} = {quoted(columns)} must be a list of names: ["ax", …]')
        title, description = (data.get(key, "") for key in toml.TEXTS)
        return Sensor(name, title, description, values, tuple(columns or ()), source)


def _migrated(data: dict[str, Any]) -> dict[str, Any]:
    """Return the data of a file of an earlier schema in terms of the present one."""
    version = data.get("schema")
    if version not in _OLD_MOTOR_KEYS or isinstance(version, bool):
        return data
    migrated = {**data, "schema": SCHEMA}
    for section, table in data.items():
        if isinstance(table, dict):
            new_keys = _OLD_MOTOR_KEYS[version] if section == "motor" else {}
            migrated[section] = {
                new_keys.get(key, key): DETECT
                if version == 1 and value == _SCHEMA_1_DETECT
                else value
                for key, value in table.items()
            }
    return migrated
