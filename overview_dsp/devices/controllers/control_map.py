"""Control maps: TOML files (`schema = 1`) that assign a controller's controls, one table each.

The controls of a MIDI controller::

    [[control]]
    control = "cc 7"            # bend, pressure, cc NUMBER, note NUMBER, keys LOW-HIGH
    to = "tactor.gain_db"       # theta2, touch, taps, mark or a parameter's id
    channel = 1                 # 1 to 16; any channel without this key
    low = -24.0                 # values at its two ends: for theta2 and taps positions on the
    high = 0.0                  # timeline (0 and 1), for a parameter values (default: its range)
    relative = "twos"           # code of the steps of an endless knob (twos, offset, signed)
    reverse = false             # reverses the steps of an endless knob
    steps = 60                  # steps from one end to the other

The OSC messages of another program (`APPS` has the maps of well-known apps)::

    [[control]]
    address = "*/fader1"        # address of the messages; after a * the end of the address
    to = "theta2"               # theta2, touch, mark, a parameter's id, or a quantity that a device
                                # measures: acceleration, angular_velocity, quaternion, angles
    value = 1                   # which of the message's values; of a quantity, the first
    sends = [0.0, 1.0]          # values sent at its two ends
    low = 0.0                   # meaning of these ends: for theta2 positions on the timeline
    high = 1.0                  # (0 and 1), for a parameter values (default: its range)

    [[control]]
    address = "/accxyz"
    to = "acceleration"
    scale = 1.0                 # value of 1 count: rad/s for angular_velocity, degrees for angles
    axes = ["y", "-x", "z"]     # the device's x (wrist to fingers), y (left), z (out of the face)
    order = "xyzw"              # order of a quaternion
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field

from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.reading import ACCELERATION, ANGLES, ANGULAR_VELOCITY, QUATERNION
from overview_dsp.errors import InputError, quoted
from overview_dsp.files.schema import Allowed, Strict, checked
from overview_dsp.files.toml import load_toml, parse_toml, read_text, require_known
from overview_dsp.validation import prefix_errors

SCHEMA = 1

THETA2, TOUCH, TAPS, MARK = "theta2", "touch", "taps", "mark"
SWITCHES = (TOUCH, MARK)
"""Targets with two states: a touch, and a mark at the disk, which a press sets."""

KEYS = (36, 96)  # five octaves about middle C: the keys of most keyboards

RELATIVE = ("twos", "offset", "signed")
"""Codes of a step right and left: 1 and 127 (two's complement), 65 and 63, 1 and 65 (sign bit)."""

STEPS = 60.0  # steps from one end to the other: two and a half turns of a knob with 24 detents
_FORMS = "bend, pressure, cc 0 to cc 119, note 0 to note 127, or keys LOW-HIGH"
_NUMBERED = re.compile(r"(cc|note) (\d{1,3})")
_RANGE = re.compile(r"keys (\d{1,3})-(\d{1,3})")


SENSED: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "acceleration": ACCELERATION,
        "angular_velocity": ANGULAR_VELOCITY,
        "quaternion": QUATERNION,
        "angles": ANGLES,
    }
)
"""Quantities that a device measures, and their columns in a reading."""

PHONE = ("y", "-x", "z")  # axes of a phone in the hand: its y is its long side, towards the fingers
ORDERS = ("xyzw", "wxyz")


@dataclass(frozen=True)
class Control:
    """One MIDI control.

    `kind`: bend, pressure, cc, note or keys.
    `number`, `highest`: its number; for keys the lowest and the highest.
    `channel`: 1 to 16, 0 = any.
    `to`: its target.
    `low`, `high`: values at its ends; None = the whole range.
    `relative`: code of an endless knob's steps, one of `RELATIVE`; "" = it has ends.
    `reverse`, `steps`: direction of an endless knob, and its steps from end to end.
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
    def key(self) -> tuple[str, int]:
        """Identity of its messages, which a map may hold once."""
        return self.name, self.channel

    @property
    def name(self) -> str:
        """Name in a file."""
        if self.kind == "keys":
            return f"keys {self.number}-{self.highest}"
        return f"{self.kind} {self.number}" if self.kind in ("cc", "note") else self.kind

    def matches(self, kind: str, number: int, channel: int) -> bool:
        """Return whether a message (channel 1 to 16) belongs to this control."""
        if self.channel not in (0, channel):
            return False
        if self.kind == "keys":
            return kind == "note" and self.number <= number <= self.highest
        return kind == self.kind and number == self.number


@dataclass(frozen=True)
class OscControl:
    """One OSC control.

    `address`: address of its messages; after a * the end of the address.
    `to`: its target.
    `value`: which value of a message, from 1.
    `sends`: values sent at its two ends.
    `low`, `high`: meaning of these ends; None = the whole range.
    `scale`, `axes`, `order`: for measured quantities, value of 1 count, axes, order of a
        quaternion.
    """

    address: str
    to: str = THETA2
    value: int = 1
    sends: tuple[float, float] = (0.0, 1.0)
    low: float | None = None
    high: float | None = None
    scale: float = 1.0
    axes: tuple[str, ...] = ("x", "y", "z")
    order: str = ORDERS[0]

    @property
    def key(self) -> tuple[str, int]:
        """Identity of its messages, which a map may hold once."""
        return self.address, self.value

    def matches(self, address: str) -> bool:
        """Return whether a message with this address belongs to this control."""
        if self.address.startswith("*"):
            return address.endswith(self.address[1:])
        return address == self.address


DEFAULT = (Control("bend"), Control("cc", 1), Control("keys", *KEYS, to=TAPS))
"""Pitch bend and modulation wheel set theta2; keys tap."""


class _Entry(Strict):
    """Keys of every control's table: its target and its two ends."""

    to: str
    low: float | None = None
    high: float | None = None

    def ends(self) -> tuple[float | None, float | None]:
        """Return `low` and `high`; InputError if they don't fit the target."""
        for key, value in (("low", self.low), ("high", self.high)):
            if value is None:
                continue
            if self.to in (THETA2, TAPS) and not 0.0 <= value <= 1.0:
                raise InputError(f"{key} = {value:g}; a position on the timeline must be 0 to 1")
            if self.to in SWITCHES:
                raise InputError(f"{key} does not apply to a {self.to}, which has no range; "
                                 "remove it")  # fmt: skip
        return self.low, self.high


class _MidiEntry(_Entry):
    """Table of a MIDI control."""

    control: str
    channel: Annotated[
        int, Field(ge=0, le=16), Allowed("1 to 16; any channel without this key")
    ] = 0
    relative: Annotated[Literal["", "twos", "offset", "signed"], Allowed(", ".join(RELATIVE))] = ""
    reverse: Annotated[bool, Allowed("true or false")] = False
    steps: Annotated[float, Field(ge=1.0, le=1e6), Allowed("1 to 1000000")] = STEPS


class _OscEntry(_Entry):
    """Table of an OSC control."""

    address: str
    value: Annotated[int, Field(ge=1, le=64), Allowed("1 to 64")] = 1
    sends: Annotated[list[float], Allowed("two different numbers")] = Field([0.0, 1.0])
    scale: float = 1.0
    axes: list[str] = Field(["x", "y", "z"])
    order: Annotated[Literal["xyzw", "wxyz"], Allowed(" or ".join(ORDERS))] = "xyzw"


def control_named(name: str) -> Control:
    """Return a control by its name in a file; InputError if there is none of that name."""
    if name in ("bend", "pressure"):
        return Control(name)
    numbered, keys = _NUMBERED.fullmatch(name), _RANGE.fullmatch(name)
    if numbered:
        kind, number = numbered[1], int(numbered[2])
        if number <= (119 if kind == "cc" else 127):
            return Control(kind, number)
    if keys and int(keys[1]) < int(keys[2]) <= 127:
        return Control("keys", int(keys[1]), int(keys[2]))
    raise InputError(f"control = {quoted(name)} is unknown; must be {_FORMS}")


def load_map(path: str | os.PathLike[str]) -> tuple[Control, ...]:
    """Return the controls in a MIDI map file; InputError if it can't be read or is invalid."""
    return parse_map(_map_text(path, "overview midi learn"), os.fspath(path))


def load_osc_map(name: str | os.PathLike[str]) -> tuple[OscControl, ...]:
    """Return the controls of an app of `APPS` or of a map file; InputError as `load_map`."""
    if os.fspath(name) in APPS:
        return APPS[os.fspath(name)]
    apps = f"; apps with built-in maps: {', '.join(APPS)}"
    return parse_osc_map(_map_text(name, "overview osc learn", apps), os.fspath(name))


def parse_map(text: str, source: str) -> tuple[Control, ...]:
    """Return the controls in the text of a MIDI map file; InputError if the text is invalid."""
    return _read(text, source, _MidiEntry, _midi_control)


def parse_osc_map(text: str, source: str) -> tuple[OscControl, ...]:
    """Return the controls in the text of an OSC map file; InputError as `parse_map`."""
    return _read(text, source, _OscEntry, _osc_control)


def _map_text(path: str | os.PathLike[str], learn: str, note: str = "") -> str:
    if not os.path.isfile(path):
        raise InputError(f"{os.fspath(path)}: no such file; `{learn}` writes one{note}")
    try:
        return read_text(Path(path))
    except InputError as error:
        raise InputError(f"{error}{note}") from None


AnyControl = TypeVar("AnyControl", Control, OscControl)
AnyEntry = TypeVar("AnyEntry", bound=_Entry)


def _read(
    text: str, source: str, model: type[AnyEntry], make: Callable[[AnyEntry], AnyControl]
) -> tuple[AnyControl, ...]:
    """Return the controls in a file's text, each made from its table by `make`."""
    data = parse_toml(text, source)
    controls: dict[tuple[str, int], AnyControl] = {}
    with prefix_errors(f"{source}: "):
        require_known(data, ("schema", "control"))
        if data.get("schema") != SCHEMA or isinstance(data["schema"], bool):
            raise InputError(f"schema = {quoted(data.get('schema'))}; must be {SCHEMA}")
        entries = data.get("control", [])
        if not isinstance(entries, list) or not entries:
            raise InputError("the file defines no control; add a [[control]] table")
        for number, entry in enumerate(entries, 1):
            with prefix_errors(f"control {number}: "):
                found = checked(model, entry)
                if isinstance(found, list):
                    raise InputError(found[0].message)
                control = make(found)
                if (key := control.key) in controls:
                    raise InputError(f"{key[0]!r} is assigned twice; remove one of the tables")
                controls[key] = control
    return tuple(controls.values())


def _midi_control(entry: _MidiEntry) -> Control:
    named, to = control_named(entry.control), entry.to
    low, high = entry.ends()
    if (to == TAPS) != (named.kind == "keys"):
        raise InputError(f"{named.name!r} can't be {to!r}: only keys can be {TAPS!r}")
    if to == THETA2 and named.kind == "note":
        raise InputError(f"{named.name!r} has two states and can't be {THETA2!r}; use {TOUCH!r}")
    if not entry.relative and entry.model_fields_set & {"reverse", "steps"}:
        raise InputError(f"relative is missing; must be {', '.join(RELATIVE)}")
    if entry.relative and (named.kind != "cc" or to in SWITCHES):
        raise InputError(f"relative does not apply to {named.name!r} as {to!r}; must be a cc that "
                         "sets theta2 or a parameter")  # fmt: skip
    values = entry.model_dump(include={"channel", "to", "relative", "reverse", "steps"})
    return replace(named, **values, low=low, high=high)


def _osc_control(entry: _OscEntry) -> OscControl:
    address, sends, to = entry.address, entry.sends, entry.to
    if not address.startswith(("/", "*")) or len(address) < 2 or not address.isprintable():
        raise InputError(f"address = {quoted(address)}; must begin with / or *")
    for key in ("sends", "low", "high") if to in SENSED else ("scale", "axes", "order"):
        if key in entry.model_fields_set:
            raise InputError(f"{key} does not apply to a control that is {to!r}; remove it")
    if not 1e-9 <= abs(entry.scale) <= 1e9:
        raise InputError(f"scale = {entry.scale:g}; must be any number but 0")
    if len(sends) != 2 or not 0.0 < abs(sends[1] - sends[0]) < 1e300:
        raise InputError(f"sends = {quoted(sends)}; must be two different numbers")
    low, high = entry.ends()
    control = OscControl(
        *(address, to, entry.value, (sends[0], sends[1]), low, high),
        *(entry.scale, tuple(entry.axes), entry.order),
    )
    sensor_of(control)
    return control


def sensor_of(control: OscControl) -> Sensor:
    """Return the sensor profile for a measured control; InputError for invalid axes."""
    if len(control.axes) != 3:
        raise InputError(f"axes = {quoted(list(control.axes))}; must be three: x, y and z, or -x …")
    values = {f"axes.{name}": axis for name, axis in zip("xyz", control.axes, strict=True)}
    return Sensor(values={**values, "angular_velocity.unit": "rad/s"})


APPS: Mapping[str, tuple[OscControl, ...]] = {
    name: tuple(_osc_control(_OscEntry(**entry)) for entry in entries)
    for name, entries in load_toml(__file__, "apps.toml").items()
}
"""Maps of well-known apps, by name."""


def write_map(controls: Iterable[Control | OscControl]) -> str:
    """Return the text of a map file with these controls."""
    lines = [f"schema = {SCHEMA}"]
    for one in controls:
        named = {"control": one.name} if isinstance(one, Control) else {"address": one.address}
        lines += ["", "[[control]]"]
        table = {**named, **_written_fields(one)}
        lines += [f"{key} = {_toml(value)}" for key, value in table.items()]
    return "\n".join(lines) + "\n"


def _written_fields(control: Control | OscControl) -> dict[str, Any]:
    """Return the fields of a control's table: its target, and the fields without a default."""
    is_written = {
        **dict.fromkeys(("kind", "number", "highest", "address", "to"), False),
        "steps": getattr(control, "relative", "") != "",
        "order": control.to == "quaternion",
    }
    values = {one.name: (getattr(control, one.name), one.default) for one in fields(control)}
    return {"to": control.to} | {
        name: value
        for name, (value, default) in values.items()
        if is_written.get(name, value != default)
    }


def _toml(value: object) -> str:
    # TOML writes an infinite number as Python does, and all other values as JSON does
    return repr(value) if isinstance(value, float) else json.dumps(value, ensure_ascii=False)
