"""What the controls of a MIDI controller do: a list, by default or of a TOML file.

schema = 1

[[control]]
control = "cc 7"            # bend, pressure, cc NUMBER, note NUMBER, keys LOW-HIGH
to = "tactor.gain_db"       # theta2, touch, taps or a parameter's id
channel = 1                 # 1 to 16; any if left out
low = -24.0                 # what its two ends are: of theta2 and taps parts of the timeline
high = 0.0                  # (0 and 1), of a parameter values (its range)
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from overview_dsp.errors import InputError, did_you_mean, shown
from overview_dsp.files.toml import parse_toml, read_text

SCHEMA = 1
THETA2, TOUCH, TAPS = "theta2", "touch", "taps"
KEYS = (36, 96)
"""Five octaves about the middle c: the keys of most keyboards."""

_FIELDS = ("control", "to", "channel", "low", "high")
_FORMS = "bend, pressure, cc 0 to cc 119, note 0 to note 127, or keys LOW-HIGH"
_NUMBERED = re.compile(r"(cc|note) (\d{1,3})")
_RANGE = re.compile(r"keys (\d{1,3})-(\d{1,3})")


@dataclass(frozen=True)
class Control:
    """One control: its `kind` (bend, pressure, cc, note, keys), its number (of keys: the lowest),
    its channel (1 to 16, 0 = any), what it does, and what its ends are (None = all of it)."""

    kind: str
    number: int = 0
    highest: int = 0
    channel: int = 0
    to: str = THETA2
    low: float | None = None
    high: float | None = None

    @property
    def name(self) -> str:
        """As a file names it."""
        if self.kind == "keys":
            return f"keys {self.number}-{self.highest}"
        return f"{self.kind} {self.number}" if self.kind in ("cc", "note") else self.kind

    def hears(self, kind: str, number: int, channel: int) -> bool:
        """Whether a message (channel 1 to 16) is this control's."""
        if self.channel not in (0, channel):
            return False
        if self.kind == "keys":
            return kind == "note" and self.number <= number <= self.highest
        return kind == self.kind and number == self.number


DEFAULT = (
    Control("bend"),
    Control("cc", 1),
    Control("keys", *KEYS, to=TAPS),
)
"""Pitch bend and modulation wheel turn, keys tap."""


def control_named(name: str) -> Control:
    """A control by its name in a file; InputError if there is none."""
    if name in ("bend", "pressure"):
        return Control(name)
    numbered, keys = _NUMBERED.fullmatch(name), _RANGE.fullmatch(name)
    if numbered:
        kind, number = numbered[1], int(numbered[2])
        if number <= (119 if kind == "cc" else 127):
            return Control(kind, number)
    if keys and int(keys[1]) < int(keys[2]) <= 127:
        return Control("keys", int(keys[1]), int(keys[2]))
    raise InputError(f"control = {shown(name)} is none; it is {_FORMS}")


def load_map(path: str | os.PathLike[str]) -> tuple[Control, ...]:
    """The controls of a file; InputError as `parse_map`, or if it can't be read."""
    if not os.path.isfile(path):
        raise InputError(f"{os.fspath(path)}: no such file; `overview midi learn` writes one")
    return parse_map(read_text(Path(path)), os.fspath(path))


def parse_map(text: str, source: str) -> tuple[Control, ...]:
    """The controls of a file's text.

    Raises
    ------
    InputError
        It isn't one: names file, entry, key and what is allowed.
    """
    data = parse_toml(text, source)
    try:
        return _controls(data)
    except InputError as error:
        raise InputError(f"{source}: {error}") from None


def _controls(data: dict[str, Any]) -> tuple[Control, ...]:
    for key in data:
        if key not in ("schema", "control"):
            raise InputError(f"{key!r}: unknown key{did_you_mean(key, ('schema', 'control'))}")
    if data.get("schema") != SCHEMA or isinstance(data["schema"], bool):
        raise InputError(f"schema = {shown(data.get('schema'))}; this reads {SCHEMA}")
    entries = data.get("control", [])
    if not isinstance(entries, list) or not entries:
        raise InputError("no control is in it; each is a table: [[control]]")
    controls = []
    for number, entry in enumerate(entries, 1):
        try:
            controls.append(_control(entry))
        except InputError as error:
            raise InputError(f"control {number}: {error}") from None
    for index, one in enumerate(controls):
        if any((one.name, one.channel) == (two.name, two.channel) for two in controls[:index]):
            raise InputError(f"control {index + 1}: {one.name!r} is there twice")
    return tuple(controls)


def _control(entry: object) -> Control:
    if not isinstance(entry, dict):
        raise InputError("it is a table: [[control]]")
    for key in entry:
        if key not in _FIELDS:
            raise InputError(f"{key!r}: unknown key{did_you_mean(key, _FIELDS)}")
    for key in ("control", "to"):
        if not isinstance(entry.get(key), str):
            raise InputError(f"{key} = {shown(entry.get(key))}; it is a text")
    named = control_named(entry["control"])
    channel = entry.get("channel", 0)
    if isinstance(channel, bool) or not isinstance(channel, int) or not 0 <= channel <= 16:
        raise InputError(f"channel = {shown(channel)}; it is 1 to 16, or left out for any")
    to = entry["to"]
    ends = _ends(entry, to)
    if (to == TAPS) != (named.kind == "keys"):
        raise InputError(f"{named.name!r} can't be {to!r}: keys are {TAPS!r}, and nothing else is")
    if to == THETA2 and named.kind == "note":
        raise InputError(f"{named.name!r} is down or up, and no {THETA2}; make it {TOUCH!r}")
    return Control(named.kind, named.number, named.highest, channel, to, *ends)


def _ends(entry: dict[str, Any], to: str) -> tuple[float | None, float | None]:
    ends = []
    for key in ("low", "high"):
        value = entry.get(key)
        if value is not None and (isinstance(value, bool) or not isinstance(value, int | float)):
            raise InputError(f"{key} = {shown(value)} is no number")
        if value is not None and to in (THETA2, TAPS) and not 0.0 <= value <= 1.0:
            raise InputError(f"{key} = {value:g}; of the timeline it is 0 to 1")
        if value is not None and to == TOUCH:
            raise InputError(f"{key} is for what has a range, and a touch has none")
        ends.append(None if value is None else float(value))
    return ends[0], ends[1]


def write_map(controls: tuple[Control, ...]) -> str:
    """The text of a file that says these controls."""
    lines = [f"schema = {SCHEMA}"]
    for one in controls:
        lines += ["", "[[control]]", f'control = "{one.name}"', f'to = "{one.to}"']
        if one.channel:
            lines.append(f"channel = {one.channel}")
        lines += [
            f"{key} = {value!r}"
            for key, value in (("low", one.low), ("high", one.high))
            if value is not None
        ]
    return "\n".join(lines) + "\n"
