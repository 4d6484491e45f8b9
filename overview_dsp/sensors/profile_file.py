"""A sensor's file to its profile, and where such files are; errors name file, line, key, range."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any

from overview_dsp.errors import InputError, did_you_mean, shown
from overview_dsp.parameter import Value
from overview_dsp.presets.library import SUFFIX, preset_text
from overview_dsp.presets.validation import line_of
from overview_dsp.sensors.profile import SENSOR_PARAMETERS, Sensor

SCHEMA = 1
_TEXTS = ("title", "description")
_SECTIONS = tuple(dict.fromkeys(id.split(".")[0] for id in SENSOR_PARAMETERS))


def bundled_folder() -> Path:
    """The folder of bundled profiles: in the installed package, or the checkout's `sensors/`."""
    here = Path(__file__).resolve().parent
    installed = here / "bundled"
    return installed if installed.is_dir() else here.parent.parent / "sensors"


def sensor_names() -> tuple[str, ...]:
    """Names of the bundled profiles."""
    return tuple(sorted(path.stem for path in bundled_folder().glob("*" + SUFFIX)))


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
    return parse_sensor(preset_text(path), path.stem, str(path))


def parse_sensor(text: str, name: str, source: str) -> Sensor:
    """A sensor from a file's text; InputError as `load_sensor`."""
    try:
        data = tomllib.loads(text)
    # ValueError: not TOML, and an integer of thousands of digits
    except (ValueError, RecursionError) as error:
        raise InputError(f"{source}: not TOML: {error}") from None
    try:
        return _sensor(data, name, source)
    except InputError as error:
        path = str(error).split(maxsplit=1)[0].rstrip(":;,").split(".")
        line = line_of(text, path)
        place = f"{source}:{line}" if line else source
        raise InputError(f"{place}: {error}") from None


def _sensor(data: dict[str, Any], name: str, source: str) -> Sensor:
    """The profile; the message of an InputError begins with the key."""
    known = ("schema", *_TEXTS, *_SECTIONS)
    for key in data:
        if key not in known:
            raise InputError(f"{_key(key)}: unknown key{did_you_mean(key, known)}")
    if "schema" not in data:
        raise InputError(f"schema is missing; it is {SCHEMA}")
    if data["schema"] != SCHEMA or isinstance(data["schema"], bool):
        raise InputError(f"schema = {shown(data['schema'])} is not known; this reads {SCHEMA}")
    for key in _TEXTS:
        if not isinstance(data.get(key, ""), str):
            raise InputError(f"{key} = {shown(data[key])} is no text; it is a line in quotes")
    columns: tuple[str, ...] = ()
    values: dict[str, Value] = {}
    for section in _SECTIONS:
        given = data.get(section, {})
        if not isinstance(given, dict):
            raise InputError(
                f"{section} = {shown(given)} is not allowed; it is a table: [{section}]"
            )
        keys = tuple(id.split(".")[1] for id in SENSOR_PARAMETERS if id.split(".")[0] == section)
        for key, value in given.items():
            if (section, key) == ("stream", "columns"):
                columns = _columns(value)
            elif key in keys:
                values[f"{section}.{key}"] = value
            else:
                raise InputError(f"{section}.{_key(key)}: unknown key{did_you_mean(key, keys)}")
    return Sensor(name, data.get("title", ""), data.get("description", ""), values, columns, source)


def _columns(value: object) -> tuple[str, ...]:
    if not isinstance(value, list) or not value or not all(isinstance(one, str) for one in value):
        raise InputError(f'stream.columns = {shown(value)} is not allowed; it is a list: ["ax", …]')
    return tuple(value)


def _key(key: str) -> str:
    # a quoted key may hold anything
    return key if key.isprintable() and not any(c.isspace() for c in key) else repr(key)
