"""Files that say what a controller's controls do: TOML, `schema = 1`, a table for each control."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from overview_dsp.errors import InputError, did_you_mean, shown
from overview_dsp.files.toml import parse_toml, read_text

SCHEMA = 1

Control = TypeVar("Control")
Entry = Mapping[str, Any]


def map_text(path: str | os.PathLike[str], learn: str) -> str:
    """A file's text; InputError, which names the command `learn`, if there is none."""
    if not os.path.isfile(path):
        raise InputError(f"{os.fspath(path)}: no such file; `{learn}` writes one")
    return read_text(Path(path))


def read_controls(
    text: str,
    source: str,
    fields: Collection[str],
    make: Callable[[Entry], Control],
    name: Callable[[Control], Hashable],
) -> tuple[Control, ...]:
    """The controls of a file's text, each made of its table by `make` and called by `name`.

    Raises
    ------
    InputError
        It isn't one: names file, entry, key and what is allowed.
    """
    data = parse_toml(text, source)
    try:
        return _controls(data, fields, make, name)
    except InputError as error:
        raise InputError(f"{source}: {error}") from None


def _controls(
    data: Entry,
    fields: Collection[str],
    make: Callable[[Entry], Control],
    name: Callable[[Control], Hashable],
) -> tuple[Control, ...]:
    _require_known(data, ("schema", "control"))
    if data.get("schema") != SCHEMA or isinstance(data["schema"], bool):
        raise InputError(f"schema = {shown(data.get('schema'))}; this reads {SCHEMA}")
    entries = data.get("control", [])
    if not isinstance(entries, list) or not entries:
        raise InputError("no control is in it; each is a table: [[control]]")
    controls: list[Control] = []
    for number, entry in enumerate(entries, 1):
        try:
            if not isinstance(entry, dict):
                raise InputError("it is a table: [[control]]")
            _require_known(entry, fields)
            controls.append(make(entry))
        except InputError as error:
            raise InputError(f"control {number}: {error}") from None
    names = [name(one) for one in controls]
    for index, one in enumerate(names):
        if one in names[:index]:
            raise InputError(f"control {index + 1}: {_words(one)} is there twice")
    return tuple(controls)


def _require_known(table: Entry, known: Collection[str]) -> None:
    for key in table:
        if key not in known:
            raise InputError(f"{key!r}: unknown key{did_you_mean(key, known)}")


def _words(name: Hashable) -> str:
    return repr(name[0] if isinstance(name, tuple) else name)


def text_in(entry: Entry, key: str) -> str:
    """A text that must be there; InputError."""
    value = entry.get(key)
    if not isinstance(value, str):
        raise InputError(f"{key} = {shown(value)}; it is a text")
    return value


def number_in(entry: Entry, key: str, default: float | None = None) -> float | None:
    """A number that may be there; InputError."""
    value = entry.get(key, default)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{key} = {shown(value)} is no number")
    return float(value)


def ends_in(
    entry: Entry, of_the_timeline: bool, has_ends: bool
) -> tuple[float | None, float | None]:
    """What a control's two ends are, `low` and `high`; InputError."""
    low, high = (number_in(entry, key) for key in ("low", "high"))
    for key, value in (("low", low), ("high", high)):
        if value is None:
            continue
        # written so that NaN fails
        if of_the_timeline and not 0.0 <= value <= 1.0:
            raise InputError(f"{key} = {value:g}; of the timeline it is 0 to 1")
        if not has_ends:
            raise InputError(f"{key} is for what has a range, and a touch has none")
    return low, high


def write_controls(entries: Iterable[Mapping[str, object]]) -> str:
    """The text of a file of these tables; what is None is left out."""
    lines = [f"schema = {SCHEMA}"]
    for entry in entries:
        lines += ["", "[[control]]"]
        lines += [f"{key} = {_toml(value)}" for key, value in entry.items() if value is not None]
    return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, str):
        # a basic string of TOML escapes as JSON does
        import json

        return json.dumps(value, ensure_ascii=False)
    return repr(value)
