"""What messages of other programs do: a list, of a well-known app or of a TOML file.

schema = 1

[[control]]
address = "*/fader1"        # of the messages; after a * the end of it
to = "theta2"               # theta2, touch, a parameter's id; or what a device in the hand says of
                            # itself: acceleration, angular_velocity, quaternion, angles
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

import os
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Literal

from pydantic import Field

from overview_dsp.devices.controllers.map_file import (
    Entry,
    map_text,
    read_controls,
    write_controls,
)
from overview_dsp.devices.controllers.midi_map import THETA2, TOUCH
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.reading import ACCELERATION, ANGLES, ANGULAR_VELOCITY, QUATERNION
from overview_dsp.errors import InputError, shown
from overview_dsp.files.schema import Allowed

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

    def hears(self, address: str) -> bool:
        """Whether a message of that address is this control's."""
        if self.address.startswith("*"):
            return address.endswith(self.address[1:])
        return address == self.address


class _Entry(Entry):
    """A control's table."""

    address: str
    value: Annotated[int, Field(ge=1, le=64), Allowed("1 to 64")] = 1
    sends: Annotated[list[float], Allowed("two numbers, which are different")] = Field([0.0, 1.0])
    scale: float = 1.0
    axes: list[str] = Field(["x", "y", "z"])
    order: Annotated[Literal["xyzw", "wxyz"], Allowed(" or ".join(ORDERS))] = "xyzw"


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


def load_osc_map(name: str | os.PathLike[str]) -> tuple[OscControl, ...]:
    """The controls of an app of `APPS`, or of a file; InputError."""
    if os.fspath(name) in APPS:
        return APPS[os.fspath(name)]
    try:
        text = map_text(name, "overview osc learn")
    except InputError as error:
        raise InputError(f"{error}; the apps known by name are {', '.join(APPS)}") from None
    return parse_osc_map(text, os.fspath(name))


def parse_osc_map(text: str, source: str) -> tuple[OscControl, ...]:
    """The controls of a file's text; InputError as `read_controls`."""
    return read_controls(text, source, _Entry, _control, lambda one: (one.address, one.value))


def _control(entry: _Entry) -> OscControl:
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


def write_osc_map(controls: tuple[OscControl, ...]) -> str:
    """The text of a file that says these controls."""
    said = ("address", "to")
    return write_controls(
        {
            key: list(value) if isinstance(value, tuple) else value
            for key, value in vars(one).items()
            if key in said
            or (one.to == "quaternion" if key == "order" else value != getattr(OscControl, key))
        }
        for one in controls
    )
