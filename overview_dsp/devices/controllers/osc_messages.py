"""What OSC messages to this program mean.

/overview/theta2 1.57        the angle (rad, 0 to pi)
/overview/theta2 1.57 1      the angle, and whether the hand holds on
/overview/touch 1            whether the hand holds on (0 or 1)
/overview/tactor/gain_db -6  a parameter by its id; a dot may stand for the stroke
/overview/record 1           begin a take (0: end it; nothing: the other)
/overview/replay 1           play the last take again and again (0: stop)
/overview/preset football    change to a preset by its name; 1 or 2: to one of two
/overview/window 0 2700      show a part of the timeline, s

Other addresses are those of a list (`osc_map`), or nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from overview_dsp.devices.controllers.control_messages import (
    Asked,
    Command,
    Counters,
    Dialled,
    Move,
    PositionControl,
    theta2_at,
)
from overview_dsp.devices.controllers.midi_map import THETA2, TOUCH
from overview_dsp.devices.controllers.osc_device import OscDevice
from overview_dsp.devices.controllers.osc_map import SENSED, OscControl
from overview_dsp.devices.controllers.osc_packets import decode_packet
from overview_dsp.errors import InputError
from overview_dsp.units import HALF_TURN

PREFIX = "/overview/"
COMMANDS = ("record", "replay", "preset", "window")
"""What asks for something that is neither movement nor parameter."""

ROUNDED = 1e-4
"""Beyond an end by so much (rad) is the end in single precision, and no mistake."""


class OscReader:
    """Datagrams in, moves out.

    Attributes
    ----------
    counters : Counters
    """

    def __init__(
        self, counters: Counters | None = None, controls: tuple[OscControl, ...] = ()
    ) -> None:
        """Nothing has come yet; `controls` are those of other programs."""
        self.counters = Counters() if counters is None else counters
        self._position = PositionControl("theta2")
        self._controls = controls
        self._positions = {
            one: PositionControl(one.address) for one in controls if one.to == THETA2
        }
        self._device = OscDevice(tuple(one for one in controls if one.to in SENSED))
        self._said: list[str] = []
        self._said_of_it = {""}

    def read(self, data: bytes, time_s: float) -> list[Move]:
        """The moves of a datagram; what is wrong with it is counted."""
        try:
            messages = decode_packet(data)
        except InputError as error:
            self._refuse(str(error))
            return []
        return [move for address, values in messages for move in self._of(address, values, time_s)]

    def tick(self, time_s: float) -> list[Move]:
        """What time alone does: nothing."""
        return []

    def take_messages(self) -> list[str]:
        """What a person should know, new since the last call."""
        said, self._said = self._said, []
        return said

    def _of(self, address: str, values: Sequence[Any], time_s: float) -> list[Move]:
        heard = [one for one in self._controls if one.hears(address)]
        if not heard and not address.startswith(PREFIX):
            self.counters.unknown += 1
            return []
        try:
            if heard:
                moves = [move for one in heard for move in self._by(one, values, time_s)]
            else:
                moves = self._named(address.removeprefix(PREFIX), values)
        except InputError as error:
            self._refuse(f"{address}: {error}")
            return []
        self.counters.messages += 1
        return moves

    def _named(self, name: str, values: Sequence[Any]) -> list[Move]:
        if name == "theta2":
            if len(values) not in (1, 2):
                raise InputError("it takes an angle, and may take a touch")
            angle = self._angle(values[0])
            if len(values) == 2:
                return self._position.both(angle, _flag(values[1]))
            return self._position.turn(angle)
        if name in COMMANDS:
            return [Command((name, *map(_word, values)))]
        if len(values) != 1:
            raise InputError(f"it takes one value; {len(values)} came")
        if name == "touch":
            return self._position.touch(_flag(values[0]))
        if not isinstance(values[0], bool | int | float | str):
            raise InputError("it takes a number, a text, true or false")
        return [Asked(name.replace("/", "."), values[0])]

    def _by(self, control: OscControl, values: Sequence[Any], time_s: float) -> Sequence[Move]:
        """What one of another program's messages means."""
        if control.to in SENSED:
            turns = self._device.step(control, [_number(one) for one in values], time_s)
            if self._device.words not in self._said_of_it:
                self._said_of_it.add(self._device.words)
                self._said.append(self._device.words)
            return turns
        if len(values) < control.value:
            raise InputError(f"value {control.value} of it is meant; {len(values)} came")
        first, last = control.sends
        part = (_number(values[control.value - 1]) - first) / (last - first)
        kept = min(max(part, 0.0), 1.0)
        self.counters.clamped += abs(kept - part) > ROUNDED
        if control.to == TOUCH:
            return [
                one for position in self._positions.values() for one in position.touch(kept >= 0.5)
            ]
        if control.to == THETA2:
            return self._positions[control].turn(theta2_at(kept, control.low, control.high))
        return [Dialled(control.to, kept, control.low, control.high)]

    def _angle(self, value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError("an angle is a number")
        if not math.isfinite(value):
            raise InputError(f"an angle is 0 to {HALF_TURN:.4f} rad, not {value}")
        kept = min(max(float(value), 0.0), HALF_TURN)
        if abs(kept - value) > ROUNDED:
            if not self.counters.clamped:
                self._said.append(
                    f"{PREFIX}theta2 {value:.4g} is beyond an end; it is 0 to {HALF_TURN:.4f} rad, "
                    "and the end is taken (counted on)"
                )
            self.counters.clamped += 1
        return kept

    def _refuse(self, why: str) -> None:
        if not self.counters.refused:
            self._said.append(f"{why} (the first of them; counted on)")
        self.counters.refused += 1


def _number(value: object) -> float:
    if not isinstance(value, bool | int | float) or not math.isfinite(value):
        raise InputError("its values are finite numbers")
    return float(value)


def _word(value: object) -> str:
    """A value of a command as it would be typed."""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    if isinstance(value, int | float | str):
        return str(value)
    raise InputError("it takes numbers and texts")


def _flag(value: object) -> bool:
    if isinstance(value, bool | int | float) and value in (0, 1):
        return bool(value)
    raise InputError("a touch is 0 or 1")
