"""What OSC messages to this program mean.

/overview/theta2 1.57        the angle (rad, 0 to pi)
/overview/theta2 1.57 1      the angle, and whether the hand holds on
/overview/touch 1            whether the hand holds on (0 or 1)
/overview/tactor/gain_db -6  a parameter by its id; a dot may stand for the stroke
/overview/record 1           begin a take (0: end it; nothing: the other)
/overview/replay 1           play the last take again and again (0: stop)
/overview/preset football    change to a preset by its name; 1 or 2: to one of two
/overview/window 0 2700      show a part of the timeline, s

Other addresses are those of a list (`control_map`), or nothing.

A device in the hand whose app says how it lies, message by message, as a control that turns.

OSC datagrams to messages and back, by python-osc, which is imported here alone, and late.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from typing import Any

from overview_dsp.devices.controllers.control_map import (
    SENSED,
    THETA2,
    TOUCH,
    OscControl,
    sensor_of,
)
from overview_dsp.devices.controllers.control_messages import (
    Asked,
    Command,
    Counters,
    Dialled,
    Move,
    PositionControl,
    Turned,
    theta2_at,
)
from overview_dsp.devices.sensors.angles import Angle, angle_of
from overview_dsp.devices.sensors.reading import ACCELERATION
from overview_dsp.devices.sensors.reading import Counters as SensorCounters
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.installation import install_command
from overview_dsp.units import HALF_TURN

NAME = "device"


class OscDevice:
    """Values of messages in, turns out; it begins lying still, face up.

    Attributes
    ----------
    words : str
        How it stands, for a person.
    """

    def __init__(self, controls: tuple[OscControl, ...]) -> None:
        """`controls`: those of a list that are sensed; the first but angular velocity leads."""
        leads = [one for one in controls if one.to != "angular_velocity"]
        self._leads = leads[0] if leads else None
        self._reading: dict[str, float] = {}
        self._angle: Angle | None = None
        self._counters = SensorCounters()
        self._sign = 0.0
        self.words = ""

    def step(self, control: OscControl, values: list[float], time_s: float) -> list[Turned]:
        """The turns of a control's values; InputError if they are none, or can't be used."""
        columns = SENSED[control.to]
        if len(values) < len(columns):
            raise InputError(f"{control.to} is {len(columns)} numbers; {len(values)} came")
        numbers = [one * control.scale for one in values[: len(columns)]]
        if not all(math.isfinite(one) and abs(one) < 1e9 for one in numbers):
            raise InputError(f"{control.to} is of finite numbers")
        if control.to == "quaternion" and control.order == "xyzw":
            numbers = [numbers[3], *numbers[:3]]
        self._reading.update(zip(columns, numbers, strict=True))
        if self._leads is None or control.address != self._leads.address:
            return []
        if control.to == "acceleration":
            # the two makers of phones don't agree which way gravity points; face up it is up
            self._sign = self._sign or math.copysign(1.0, numbers[2])
            self._reading.update((name, self._reading[name] * self._sign) for name in ACCELERATION)
        if self._angle is None:
            self._angle = angle_of(sensor_of(control), False, self._reading, self._counters)
            assert self._angle is not None
        turn = self._angle.step(time_s, dict(self._reading))
        self.words = self._angle.words
        return [] if turn is None else [Turned(NAME, turn.theta2)]


def require_osc() -> None:
    """Raise OverviewError, which says what to install, if there is no python-osc.

    From here on it is also kept from writing to the terminal about each type it doesn't know.
    """
    try:
        import pythonosc  # noqa: F401
    except ImportError:
        raise OverviewError(f"OSC needs python-osc: {install_command('osc')}") from None
    root = logging.getLogger()
    if _is_ours not in root.filters:
        root.addFilter(_is_ours)


def _is_ours(record: logging.LogRecord) -> bool:
    return "pythonosc" not in record.pathname


def decode_packet(data: bytes) -> list[tuple[str, Sequence[Any]]]:
    """The messages (address, values) of a datagram, those of its bundles in order of their times.

    Raises
    ------
    InputError
        It is none.
    """
    from pythonosc.osc_packet import OscPacket

    if len(data) % 4:  # python-osc fills a cut number up with zeros
        raise InputError(f"{len(data)} bytes that are no OSC (its packets are whole fours)")
    try:
        return [(one.message.address, one.message.params) for one in OscPacket(data).messages]
    # what else a damaged one makes of the decoder: of texts, of nested bundles, of sizes
    except Exception as error:
        raise InputError(f"{len(data)} bytes that are no OSC ({_first_line(error)})") from None


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0][:80]


def encode_message(address: str, values: Sequence[bool | int | float | str]) -> bytes:
    """A datagram with one message: numbers in single precision, texts in UTF-8."""
    from pythonosc.osc_message_builder import OscMessageBuilder

    builder = OscMessageBuilder(address=address)
    for value in values:
        builder.add_arg(value)
    return bytes(builder.build().dgram)


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
