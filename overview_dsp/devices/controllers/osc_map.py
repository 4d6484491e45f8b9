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

from overview_dsp.devices.controllers.map_file import (
    Entry,
    ends_in,
    map_text,
    number_in,
    read_controls,
    text_in,
    write_controls,
)
from overview_dsp.devices.controllers.midi_map import THETA2, TOUCH
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.reading import ACCELERATION, ANGLES, ANGULAR_VELOCITY, QUATERNION
from overview_dsp.errors import InputError, shown

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
_FIELDS = ("address", "to", "value", "sends", "low", "high", "scale", "axes", "order")


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
    return read_controls(text, source, _FIELDS, _control, lambda one: (one.address, one.value))


def _control(entry: Entry) -> OscControl:
    address, to = text_in(entry, "address"), text_in(entry, "to")
    if not address.startswith(("/", "*")) or len(address) < 2 or not address.isprintable():
        raise InputError(f"address = {shown(address)}; it begins with / or *")
    for key in ("value", "sends", "low", "high") if to in SENSED else ("scale", "axes", "order"):
        if key in entry:
            raise InputError(f"{key} is nothing of a control that is {to!r}")
    value = entry.get("value", 1)
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 64:
        raise InputError(f"value = {shown(value)}; it is 1 to 64")
    order = entry.get("order", ORDERS[0])
    if order not in ORDERS:
        raise InputError(f"order = {shown(order)}; it is {' or '.join(ORDERS)}")
    scale = number_in(entry, "scale", 1.0)
    assert scale is not None
    # written so that NaN fails
    if not 1e-9 <= abs(scale) <= 1e9:
        raise InputError(f"scale = {scale:g}; it is any number but 0")
    ends = ends_in(entry, to == THETA2, to != TOUCH)
    axes = _texts(entry.get("axes", ["x", "y", "z"]), "axes")
    control = OscControl(address, to, value, _sends(entry), *ends, scale, axes, order)
    sensor_of(control)
    return control


def _sends(entry: Entry) -> tuple[float, float]:
    given = entry.get("sends", [0.0, 1.0])
    if not isinstance(given, list) or len(given) != 2:
        raise InputError(f"sends = {shown(given)}; it is two numbers")
    first, last = (number_in({"sends": one}, "sends") for one in given)
    assert first is not None
    assert last is not None
    if not 0.0 < abs(last - first) < 1e300:
        raise InputError(f"sends = {shown(given)}; the two are different numbers")
    return first, last


def _texts(given: object, key: str) -> tuple[str, ...]:
    if not isinstance(given, list) or not all(isinstance(one, str) for one in given):
        raise InputError(f"{key} = {shown(given)}; it is a list of texts")
    return tuple(given)


def sensor_of(control: OscControl) -> Sensor:
    """The profile of a device whose control it is; InputError if its axes are none."""
    if len(control.axes) != 3:
        raise InputError(f"axes = {shown(list(control.axes))}; it is three: x, y and z, or -x ...")
    values = {f"axes.{name}": axis for name, axis in zip("xyz", control.axes, strict=True)}
    return Sensor(values={**values, "angular_velocity.unit": "rad/s"})


def write_osc_map(controls: tuple[OscControl, ...]) -> str:
    """The text of a file that says these controls."""
    return write_controls(
        {
            "address": one.address,
            "to": one.to,
            "value": one.value if one.value != 1 else None,
            "sends": list(one.sends) if one.sends != (0.0, 1.0) else None,
            "low": one.low,
            "high": one.high,
            "scale": one.scale if one.scale != 1.0 else None,
            "axes": list(one.axes) if one.axes != ("x", "y", "z") else None,
            "order": one.order if one.to == "quaternion" else None,
        }
        for one in controls
    )
