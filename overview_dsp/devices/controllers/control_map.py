"""Files that say what a controller's controls do: TOML, `schema = 1`, a table for each control.

The controls of a MIDI controller::

    [[control]]
    control = "cc 7"            # bend, pressure, cc NUMBER, note NUMBER, keys LOW-HIGH
    to = "tactor.gain_db"       # theta2, touch, taps or a parameter's id
    channel = 1                 # 1 to 16; any if left out
    low = -24.0                 # what its two ends are: of theta2 and taps parts of the timeline
    high = 0.0                  # (0 and 1), of a parameter values (its range)
    relative = "twos"           # a knob without ends: how it says a step (twos, offset, signed)
    reverse = false             # its steps to the right are the ones to the left of others
    steps = 60                  # from one end to the other

The OSC messages of another program (those of well-known apps are in `APPS`)::

    [[control]]
    address = "*/fader1"        # of the messages; after a * the end of it
    to = "theta2"               # theta2, touch, a parameter's id; or what a device in the hand says
                                # of itself: acceleration, angular_velocity, quaternion, angles
    value = 1                   # which of the message's values
    sends = [0.0, 1.0]          # what comes at its two ends
    low = 0.0                   # what these are: of theta2 parts of the timeline (0 and 1), of a
    high = 1.0                  # parameter values (its range)

    [[control]]
    address = "/accxyz"
    to = "acceleration"
    scale = 1.0                 # what 1 is: of angular_velocity rad/s, of angles degrees
    axes = ["y", "-x", "z"]     # the device's x (wrist to fingers), y (left), z (out of the face)
    order = "xyzw"              # of a quaternion
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
from overview_dsp.errors import InputError, shown
from overview_dsp.files.schema import Allowed, Strict, checked
from overview_dsp.files.toml import parse_toml, read_text, require_known
from overview_dsp.validation import located

SCHEMA = 1

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


SENSED: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "acceleration": ACCELERATION,
        "angular_velocity": ANGULAR_VELOCITY,
        "quaternion": QUATERNION,
        "angles": ANGLES,
    }
)
"""What a device in the hand says, and the columns of a reading that are that."""

PHONE = ("y", "-x", "z")
"""A phone's axes in the hand: its y is its long side, towards the fingers."""

ORDERS = ("xyzw", "wxyz")


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
    def key(self) -> tuple[str, int]:
        """What it hears: each may be in a map once."""
        return self.name, self.channel

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


@dataclass(frozen=True)
class OscControl:
    """One control: its messages' `address` (after a * its end), what it does, which value of a
    message says it (from 1), what comes at its ends, what these are (None = all of it); of what is
    sensed the scale, the axes and a quaternion's order."""

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
        """What it hears: each may be in a map once."""
        return self.address, self.value

    def hears(self, address: str) -> bool:
        """Whether a message of that address is this control's."""
        if self.address.startswith("*"):
            return address.endswith(self.address[1:])
        return address == self.address


DEFAULT = (
    Control("bend"),
    Control("cc", 1),
    Control("keys", *KEYS, to=TAPS),
)
"""Pitch bend and modulation wheel turn, keys tap."""


_GRAVITY = "acceleration"

APPS: Mapping[str, tuple[OscControl, ...]] = MappingProxyType(
    {
        # what these send of their own accelerometer lacks gravity, so it isn't taken
        "gyrosc": (OscControl("/gyrosc/grav", _GRAVITY, axes=PHONE),),
        "zigsim": (OscControl("*/gravity", _GRAVITY, axes=PHONE),),
        "touchosc": (
            OscControl("/accxyz", _GRAVITY, axes=PHONE),
            OscControl("*/fader1"),
            OscControl("*/push1", TOUCH),
        ),
    }
)
"""The lists of well-known apps, by their names."""


# --- reading --------------------------------------------------------------------------------------


class _Entry(Strict):
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


class _MidiEntry(_Entry):
    """The table of a MIDI control."""

    control: str
    channel: Annotated[int, Field(ge=0, le=16), Allowed("1 to 16, or left out for any")] = 0
    relative: Annotated[Literal["", "twos", "offset", "signed"], Allowed(", ".join(RELATIVE))] = ""
    reverse: Annotated[bool, Allowed("true or false")] = False
    steps: Annotated[float, Field(ge=1.0, le=1e6), Allowed("1 to 1000000")] = STEPS


class _OscEntry(_Entry):
    """The table of an OSC control."""

    address: str
    value: Annotated[int, Field(ge=1, le=64), Allowed("1 to 64")] = 1
    sends: Annotated[list[float], Allowed("two numbers, which are different")] = Field([0.0, 1.0])
    scale: float = 1.0
    axes: list[str] = Field(["x", "y", "z"])
    order: Annotated[Literal["xyzw", "wxyz"], Allowed(" or ".join(ORDERS))] = "xyzw"


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
    """The controls of a MIDI controller's file; InputError, also if it can't be read."""
    return parse_map(_map_text(path, "overview midi learn"), os.fspath(path))


def load_osc_map(name: str | os.PathLike[str]) -> tuple[OscControl, ...]:
    """The controls of an app of `APPS`, or of a file; InputError."""
    if os.fspath(name) in APPS:
        return APPS[os.fspath(name)]
    also = f"; the apps known by name are {', '.join(APPS)}"
    return parse_osc_map(_map_text(name, "overview osc learn", also), os.fspath(name))


def parse_map(text: str, source: str) -> tuple[Control, ...]:
    """The controls of a MIDI controller's file's text.

    Raises
    ------
    InputError
        It isn't one: names file, entry, key and what is allowed.
    """
    return _read(text, source, _MidiEntry, _midi_control)


def parse_osc_map(text: str, source: str) -> tuple[OscControl, ...]:
    """The controls of another program's file's text; InputError as `parse_map`."""
    return _read(text, source, _OscEntry, _osc_control)


def _map_text(path: str | os.PathLike[str], learn: str, also: str = "") -> str:
    if not os.path.isfile(path):
        raise InputError(f"{os.fspath(path)}: no such file; `{learn}` writes one{also}")
    try:
        return read_text(Path(path))
    except InputError as error:
        raise InputError(f"{error}{also}") from None


AnyControl = TypeVar("AnyControl", Control, OscControl)
AnyEntry = TypeVar("AnyEntry", bound=_Entry)


def _read(
    text: str, source: str, model: type[AnyEntry], make: Callable[[AnyEntry], AnyControl]
) -> tuple[AnyControl, ...]:
    """The controls of a file's text, each made of its table by `make`."""
    data = parse_toml(text, source)
    controls: dict[tuple[str, int], AnyControl] = {}
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
                    raise InputError(found[0].message)
                control = make(found)
                if control.key in controls:
                    raise InputError(f"{control.key[0]!r} is there twice")
                controls[control.key] = control
    return tuple(controls.values())


def _midi_control(entry: _MidiEntry) -> Control:
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


def _osc_control(entry: _OscEntry) -> OscControl:
    address, sends, to = entry.address, entry.sends, entry.to
    if not address.startswith(("/", "*")) or len(address) < 2 or not address.isprintable():
        raise InputError(f"address = {shown(address)}; it begins with / or *")
    for key in ("value", "sends", "low", "high") if to in SENSED else ("scale", "axes", "order"):
        if key in entry.model_fields_set:
            raise InputError(f"{key} is nothing of a control that is {to!r}")
    if not 1e-9 <= abs(entry.scale) <= 1e9:
        raise InputError(f"scale = {entry.scale:g}; it is any number but 0")
    if len(sends) != 2 or not 0.0 < abs(sends[1] - sends[0]) < 1e300:
        raise InputError(f"sends = {shown(sends)}; it is two numbers, which are different")
    low, high = entry.ends(to == THETA2, to != TOUCH)
    control = OscControl(
        *(address, to, entry.value, (sends[0], sends[1]), low, high),
        *(entry.scale, tuple(entry.axes), entry.order),
    )
    sensor_of(control)
    return control


def sensor_of(control: OscControl) -> Sensor:
    """The profile of a device whose control it is; InputError if its axes are none."""
    if len(control.axes) != 3:
        raise InputError(f"axes = {shown(list(control.axes))}; it is three: x, y and z, or -x ...")
    values = {f"axes.{name}": axis for name, axis in zip("xyz", control.axes, strict=True)}
    return Sensor(values={**values, "angular_velocity.unit": "rad/s"})


# --- writing --------------------------------------------------------------------------------------


def write_map(controls: Iterable[Control | OscControl]) -> str:
    """The text of a file that says these controls."""
    lines = [f"schema = {SCHEMA}"]
    for one in controls:
        table = {"control": one.name} if isinstance(one, Control) else {"address": one.address}
        lines += ["", "[[control]]"]
        lines += [f"{key} = {_toml(value)}" for key, value in (table | _said(one)).items()]
    return "\n".join(lines) + "\n"


def _said(control: Control | OscControl) -> dict[str, Any]:
    """What a control's table says beside its name: what it does, and what isn't by default."""
    said = {
        **dict.fromkeys(("kind", "number", "highest", "address", "to"), False),
        "steps": getattr(control, "relative", "") != "",
        "order": control.to == "quaternion",
    }
    found: dict[str, Any] = {"to": control.to}
    for one in fields(control):
        value = getattr(control, one.name)
        if said.get(one.name, value != one.default):
            found[one.name] = value
    return found


def _toml(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, str):
        # a basic string of TOML escapes as JSON does
        return json.dumps(value, ensure_ascii=False)
    return repr(value)
