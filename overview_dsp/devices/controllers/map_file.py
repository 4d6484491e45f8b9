"""Files that say what a controller's controls do: TOML, `schema = 1`, a table for each control."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TypeVar

from overview_dsp.errors import InputError, shown
from overview_dsp.files.schema import Strict, checked
from overview_dsp.files.toml import parse_toml, read_text, require_known
from overview_dsp.validation import located

SCHEMA = 1

Control = TypeVar("Control")


def map_text(path: str | os.PathLike[str], learn: str) -> str:
    """A file's text; InputError, which names the command `learn`, if there is none."""
    if not os.path.isfile(path):
        raise InputError(f"{os.fspath(path)}: no such file; `{learn}` writes one")
    return read_text(Path(path))


class Entry(Strict):
    """What any control's table says: what it does, and what its two ends are."""

    to: str
    low: float | None = None
    high: float | None = None

    def ends(self, of_the_timeline: bool, has_ends: bool) -> tuple[float | None, float | None]:
        """`low` and `high`; InputError for what they can't be."""
        for key, value in (("low", self.low), ("high", self.high)):
            if value is not None and of_the_timeline and not 0.0 <= value <= 1.0:
                raise InputError(f"{key} = {value:g}; of the timeline it is 0 to 1")
            if value is not None and not has_ends:
                raise InputError(f"{key} is for what has a range, and a touch has none")
        return self.low, self.high


AnyEntry = TypeVar("AnyEntry", bound=Entry)


def read_controls(
    text: str,
    source: str,
    model: type[AnyEntry],
    make: Callable[[AnyEntry], Control],
    name: Callable[[Control], tuple[str, int]],
) -> tuple[Control, ...]:
    """The controls of a file's text, each made of its table by `make` and called by `name`.

    Raises
    ------
    InputError
        It isn't one: names file, entry, key and what is allowed.
    """
    data = parse_toml(text, source)
    controls: dict[tuple[str, int], Control] = {}
    with located(f"{source}: "):
        require_known(data, ("schema", "control"))
        if data.get("schema") != SCHEMA or isinstance(data["schema"], bool):
            raise InputError(f"schema = {shown(data.get('schema'))}; this reads {SCHEMA}")
        entries = data.get("control", [])
        if not isinstance(entries, list) or not entries:
            raise InputError("no control is in it; each is a table: [[control]]")
        for number, entry in enumerate(entries, 1):
            with located(f"control {number}: "):
                found = checked(model, entry)
                if isinstance(found, list):
                    raise InputError(found[0].words)
                control = make(found)
                if name(control) in controls:
                    raise InputError(f"{name(control)[0]!r} is there twice")
                controls[name(control)] = control
    return tuple(controls.values())


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
