"""A sensor's file to its profile, and where such files are; errors name file, line, key, range."""

from __future__ import annotations

import os
from pathlib import Path

from overview_dsp.errors import InputError, did_you_mean, shown
from overview_dsp.files.toml import (
    SUFFIX,
    TEXTS,
    check_head,
    faults_at_their_line,
    given_in,
    names_in,
    parse_toml,
    read_text,
)
from overview_dsp.presets.parameter import Value
from overview_dsp.sensors.profile import SENSOR_PARAMETERS, Sensor

SCHEMA = 1
_SECTIONS = tuple(dict.fromkeys(id.split(".")[0] for id in SENSOR_PARAMETERS))


def bundled_folder() -> Path:
    """The folder of bundled profiles: in the installed package, or the checkout's `sensors/`."""
    here = Path(__file__).resolve().parent
    installed = here / "bundled"
    return installed if installed.is_dir() else here.parent.parent / "sensors"


def sensor_names() -> tuple[str, ...]:
    """Names of the bundled profiles."""
    return names_in(bundled_folder())


def load_sensor(name: str | Path) -> Sensor:
    """A sensor: a bundled name (`potentiometer`) or the path of a TOML file.

    Raises
    ------
    InputError
        No such profile, or one that is not valid: names file, line, key and range.
    """
    text = str(name)
    if text in sensor_names():
        path = bundled_folder() / (text + SUFFIX)
    else:
        path = Path(text)
        if not os.path.isfile(path):
            if path.suffix == SUFFIX or path.parent != Path("."):
                raise InputError(f"{path}: no such file; give a sensor's .toml file or a name")
            raise InputError(
                f"no sensor is called {text!r}{did_you_mean(text, sensor_names())} "
                "(or give the path of a .toml file)"
            )
    return parse_sensor(read_text(path), path.stem, str(path))


def parse_sensor(text: str, name: str, source: str) -> Sensor:
    """A sensor from a file's text; InputError as `load_sensor`."""
    data = parse_toml(text, source)
    with faults_at_their_line(text, source):
        check_head(data, _SECTIONS, SCHEMA, needs_texts=False)
        columns: tuple[str, ...] = ()
        values: dict[str, Value] = {}
        for section in _SECTIONS:
            keys = [id.split(".")[1] for id in SENSOR_PARAMETERS if id.split(".")[0] == section]
            given = given_in(data, section, (*keys, *(["columns"] if section == "stream" else [])))
            for key, value in given.items():
                if (section, key) == ("stream", "columns"):
                    columns = _columns(value)
                else:
                    values[f"{section}.{key}"] = value
        title, description = (data.get(key, "") for key in TEXTS)
        return Sensor(name, title, description, values, columns, source)


def _columns(value: object) -> tuple[str, ...]:
    if not isinstance(value, list) or not value or not all(isinstance(one, str) for one in value):
        raise InputError(f'stream.columns = {shown(value)} is not allowed; it is a list: ["ax", …]')
    return tuple(value)
