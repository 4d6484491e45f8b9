"""What the controls of a MIDI controller do: a list, by default or of a TOML file.

schema = 1

[[control]]
control = "cc 7"            # bend, pressure, cc NUMBER, note NUMBER, keys LOW-HIGH
to = "tactor.gain_db"       # theta2, touch, taps or a parameter's id
channel = 1                 # 1 to 16; any if left out
low = -24.0                 # what its two ends are: of theta2 and taps parts of the timeline
high = 0.0                  # (0 and 1), of a parameter values (its range)
relative = "twos"           # a knob without ends: how it says a step (twos, offset, signed)
reverse = false             # its steps to the right are the ones to the left of others
steps = 60                  # from one end to the other
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, replace
from typing import Annotated, Literal

from pydantic import Field

from overview_dsp.devices.controllers.map_file import (
    Entry,
    map_text,
    read_controls,
    write_controls,
)
from overview_dsp.errors import InputError, shown
from overview_dsp.files.schema import Allowed

THETA2, TOUCH, TAPS = "theta2", "touch", "taps"
KEYS = (36, 96)
"""Five octaves about the middle c: the keys of most keyboards."""

RELATIVE = ("twos", "offset", "signed")
"""How a step is said: 1 and 127 (the complement of two), 65 and 63, 1 and 65 (bit 6 is minus)."""

STEPS = 60.0
"""From one end to the other: two turns and a half of a knob with 24 detents."""

_FORMS = "bend, pressure, cc 0 to cc 119, note 0 to note 127, or keys LOW-HIGH"
_NUMBERED = re.compile(r"(cc|note) (\d{1,3})")
_RANGE = re.compile(r"keys (\d{1,3})-(\d{1,3})")


@dataclass(frozen=True)
class Control:
    """One control: its `kind` (bend, pressure, cc, note, keys), its number (of keys: the lowest),
    its channel (1 to 16, 0 = any), what it does, and what its ends are (None = all of it).

    `relative`: how a knob without ends says its steps, one of `RELATIVE`; "" = it has ends.
    """

    kind: str
    number: int = 0
    highest: int = 0
    channel: int = 0
    to: str = THETA2
    low: float | None = None
    high: float | None = None
    relative: str = ""
    reverse: bool = False
    steps: float = STEPS

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


class _Entry(Entry):
    """A control's table."""

    control: str
    channel: Annotated[int, Field(ge=0, le=16), Allowed("1 to 16, or left out for any")] = 0
    relative: Annotated[Literal["", "twos", "offset", "signed"], Allowed(", ".join(RELATIVE))] = ""
    reverse: Annotated[bool, Allowed("true or false")] = False
    steps: Annotated[float, Field(ge=1.0, le=1e6), Allowed("1 to 1000000")] = STEPS


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
    return parse_map(map_text(path, "overview midi learn"), os.fspath(path))


def parse_map(text: str, source: str) -> tuple[Control, ...]:
    """The controls of a file's text; InputError as `read_controls`."""
    return read_controls(text, source, _Entry, _control, lambda one: (one.name, one.channel))


def _control(entry: _Entry) -> Control:
    named, to = control_named(entry.control), entry.to
    ends = entry.ends(to in (THETA2, TAPS), to != TOUCH)
    if (to == TAPS) != (named.kind == "keys"):
        raise InputError(f"{named.name!r} can't be {to!r}: keys are {TAPS!r}, and nothing else is")
    if to == THETA2 and named.kind == "note":
        raise InputError(f"{named.name!r} is down or up, and no {THETA2}; make it {TOUCH!r}")
    if not entry.relative and entry.model_fields_set & {"reverse", "steps"}:
        raise InputError(f"relative is missing; it is {', '.join(RELATIVE)}")
    if entry.relative and (named.kind != "cc" or to == TOUCH):
        raise InputError(f"relative is for a cc that turns something; {named.name!r} is {to!r}")
    return replace(
        named,
        **entry.model_dump(include={"channel", "to", "relative", "reverse", "steps"}),
        low=ends[0],
        high=ends[1],
    )


def write_map(controls: tuple[Control, ...]) -> str:
    """The text of a file that says these controls."""
    return write_controls(
        {
            "control": one.name,
            "to": one.to,
            "channel": one.channel or None,
            "low": one.low,
            "high": one.high,
            "relative": one.relative or None,
            "reverse": one.reverse or None,
            "steps": one.steps if one.relative else None,
        }
        for one in controls
    )
