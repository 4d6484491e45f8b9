"""An actuator file's text to an Actuator; errors name file, line, key and range."""

from __future__ import annotations

import tomllib
from typing import Any

from overview_dsp.actuators.model import ACTUATOR_PARAMETERS, Actuator
from overview_dsp.errors import InputError, did_you_mean, shown
from overview_dsp.parameter import Value
from overview_dsp.presets.validation import line_of

SCHEMA = 1
_TEXTS = ("title", "description")
_SECTIONS = tuple(dict.fromkeys(id.split(".")[0] for id in ACTUATOR_PARAMETERS))


def parse_actuator(text: str, name: str, source: str) -> Actuator:
    """An actuator from a file's text.

    Raises
    ------
    InputError
        Not TOML, an unknown key, a wrong type, a value out of range or one that doesn't fit the
        others: names file, line, key and range.
    """
    try:
        data = tomllib.loads(text)
    # ValueError: not TOML, and an integer of thousands of digits
    except (ValueError, RecursionError) as error:
        raise InputError(f"{source}: not TOML: {error}") from None
    try:
        values = _values(data)
        return Actuator(name, data["title"], data["description"], values, source)
    except InputError as error:
        path = str(error).split(maxsplit=1)[0].rstrip(":;,").split(".")
        line = line_of(text, path)
        place = f"{source}:{line}" if line else source
        raise InputError(f"{place}: {error}") from None


def _values(data: dict[str, Any]) -> dict[str, Value]:
    """The values by id; the message of an InputError begins with the key."""
    known = ("schema", *_TEXTS, *_SECTIONS)
    for key in data:
        if key not in known:
            raise InputError(f"{_key(key)}: unknown key{did_you_mean(key, known)}")
    if "schema" not in data:
        raise InputError(f"schema is missing; it is {SCHEMA}")
    if data["schema"] != SCHEMA or isinstance(data["schema"], bool):
        raise InputError(f"schema = {shown(data['schema'])} is not known; this reads {SCHEMA}")
    for key in _TEXTS:
        if not isinstance(data.get(key), str):
            state = f"= {shown(data[key])} is no text" if key in data else "is missing"
            raise InputError(f"{key} {state}; it is a line of text in quotes")
    found: dict[str, Value] = {}
    for section in _SECTIONS:
        _read_section(section, data.get(section, {}), found)
    return found


def _read_section(section: str, given: object, found: dict[str, Value]) -> None:
    if not isinstance(given, dict):
        raise InputError(f"{section} = {shown(given)} is not allowed; it is a table: [{section}]")
    keys = [id.split(".")[1] for id in ACTUATOR_PARAMETERS if id.split(".")[0] == section]
    for key in given:
        if key not in keys:
            raise InputError(f"{section}.{_key(key)}: unknown key{did_you_mean(key, tuple(keys))}")
        found[f"{section}.{key}"] = given[key]


def _key(key: str) -> str:
    # a quoted key may hold anything
    return key if key.isprintable() and not any(c.isspace() for c in key) else repr(key)
