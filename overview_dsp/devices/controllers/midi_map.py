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
from dataclasses import dataclass

from overview_dsp.devices.controllers.map_file import (
    Entry,
    ends_in,
    map_text,
    number_in,
    read_controls,
    text_in,
    write_controls,
)
from overview_dsp.errors import InputError, shown

THETA2, TOUCH, TAPS = "theta2", "touch", "taps"
KEYS = (36, 96)
"""Five octaves about the middle c: the keys of most keyboards."""

RELATIVE = ("twos", "offset", "signed")
"""How a step is said: 1 and 127 (the complement of two), 65 and 63, 1 and 65 (bit 6 is minus)."""

STEPS = 60.0
"""From one end to the other: two turns and a half of a knob with 24 detents."""

_FIELDS = ("control", "to", "channel", "low", "high", "relative", "reverse", "steps")
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
    return read_controls(text, source, _FIELDS, _control, lambda one: (one.name, one.channel))


def _control(entry: Entry) -> Control:
    named = control_named(text_in(entry, "control"))
    to = text_in(entry, "to")
    channel = entry.get("channel", 0)
    if isinstance(channel, bool) or not isinstance(channel, int) or not 0 <= channel <= 16:
        raise InputError(f"channel = {shown(channel)}; it is 1 to 16, or left out for any")
    ends = ends_in(entry, to in (THETA2, TAPS), to != TOUCH)
    if (to == TAPS) != (named.kind == "keys"):
        raise InputError(f"{named.name!r} can't be {to!r}: keys are {TAPS!r}, and nothing else is")
    if to == THETA2 and named.kind == "note":
        raise InputError(f"{named.name!r} is down or up, and no {THETA2}; make it {TOUCH!r}")
    relative, reverse, steps = _relative(entry, named, to)
    return Control(
        named.kind, named.number, named.highest, channel, to, *ends, relative, reverse, steps
    )


def _relative(entry: Entry, named: Control, to: str) -> tuple[str, bool, float]:
    relative, reverse = entry.get("relative", ""), entry.get("reverse", False)
    steps = number_in(entry, "steps", STEPS)
    assert steps is not None
    if not relative and not reverse and "steps" not in entry:
        return "", False, STEPS
    if relative not in RELATIVE:
        raise InputError(f"relative = {shown(relative)}; it is {', '.join(RELATIVE)}")
    if named.kind != "cc" or to == TOUCH:
        raise InputError(f"relative is for a cc that turns something; {named.name!r} is {to!r}")
    if not isinstance(reverse, bool):
        raise InputError(f"reverse = {shown(reverse)}; it is true or false")
    if not 1.0 <= steps <= 1e6:
        raise InputError(f"steps = {steps:g}; it is 1 to 1000000")
    return relative, reverse, steps


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
