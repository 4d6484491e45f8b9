"""A sensor's file to its profile, and where such files are; errors name file, line, key, range."""

from __future__ import annotations

from pathlib import Path

from overview_dsp.devices.sensors.profile import SENSOR_PARAMETERS, Sensor
from overview_dsp.errors import InputError, shown
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
