"""OSC messages to this program and about the disk, and datagrams to messages and back.

/overview/theta2 1.57        the angle (rad, 0 to pi)
/overview/theta2 1.57 1      the angle, and whether the disk is touched
/overview/touch 1            whether the disk is touched (0 or 1)
/overview/tactor/gain_db -6  a parameter by its id, with dots or slashes
/overview/record 1           begin a take (0: end it; no value: toggle)
/overview/replay 1           play the last take repeatedly (0: stop)
/overview/preset football    change to a preset by name; 1 or 2: to one of two
/overview/window 0 2700      show a window of the timeline, s

The meaning of other addresses is defined by a map (`control_map`). About the disk it sends:

/overview/cursor 0.41                    position on the timeline, 0 to 1
/overview/torque 0.0123                  N m, of the last block
/overview/touching 1
/overview/state running "by osc" ""      the session's state, its reason, and the last stop
/overview/event goal "1-0 Parris" 5340.0 0.8     a passed event: its kind, label, time (s) in the
                                         visible window, and the level of its strike (0 to 1)

A device whose app sends its orientation, message by message, is a control that sets theta2.

Only this module imports python-osc, and only when it is needed.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Iterable, Sequence
from typing import Any

from overview_dsp.data.timeline.event import Event
from overview_dsp.devices.controllers.control_map import SENSED, OscControl, sensor_of
from overview_dsp.devices.controllers.control_messages import (
    AngleChanged,
    AssignedControls,
    Command,
    Counters,
    Message,
    Movement,
    PositionControl,
    Scheduled,
    SetParameter,
)
from overview_dsp.devices.messages import Messages
from overview_dsp.devices.sensors.angles import Angle, make_angle
from overview_dsp.devices.sensors.reading import ACCELERATION
from overview_dsp.devices.sensors.reading import Counters as SensorCounters
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.installation import install_command
from overview_dsp.units import HALF_TURN

NAME = "device"


class OscDevice:
    """Theta2 from an app's messages about its orientation; starts at rest, face up.

    `status` is a text for display.
    """

    def __init__(self, controls: tuple[OscControl, ...]) -> None:
        """Use measured `controls`; each message of the main one gives an angle.

        The main control is the first that isn't an angular velocity.
        """
        self._main = next((one for one in controls if one.to != "angular_velocity"), None)
        self._reading: dict[str, float] = {}
        self._angle: Angle | None = None
        self._counters = SensorCounters()
        self._sign = 0.0
        self.status = ""

    def step(self, control: OscControl, values: list[float], time_s: float) -> list[AngleChanged]:
        """Return the angle for a control's values, if any; InputError for invalid values."""
        columns = SENSED[control.to]
        values = values[control.value - 1 :][: len(columns)]
        if len(values) < len(columns):
            raise InputError(f"{control.to} has {len(values)} values; must be {len(columns)}")
        numbers = [one * control.scale for one in values]
        if not all(math.isfinite(one) and abs(one) < 1e9 for one in numbers):
            raise InputError(f"{control.to} must be finite numbers")
        if control.to == "quaternion" and control.order == "xyzw":
            numbers = [numbers[3], *numbers[:3]]
        self._reading.update(zip(columns, numbers, strict=True))
        if self._main is None or control.address != self._main.address:
            return []
        if control.to == "acceleration":
            # the sign of gravity differs between makers of phones; face up it is positive
            self._sign = self._sign or math.copysign(1.0, numbers[2])
            self._reading.update((name, self._reading[name] * self._sign) for name in ACCELERATION)
        if self._angle is None:
            self._angle = make_angle(sensor_of(control), False, self._reading, self._counters)
            assert self._angle is not None
        angle = self._angle.step(time_s, dict(self._reading))
        self.status = self._angle.status
        return [] if angle is None else [AngleChanged(NAME, angle.theta2)]


def require_osc() -> None:
    """Raise OverviewError with the command to install python-osc if it is missing.

    This also keeps python-osc from logging each unknown type to the terminal.
    """
    try:
        import pythonosc  # noqa: F401
    except ImportError:
        raise OverviewError(f"OSC needs python-osc: {install_command('osc')}") from None
    root = logging.getLogger()
    if _not_from_osc not in root.filters:
        root.addFilter(_not_from_osc)


def _not_from_osc(record: logging.LogRecord) -> bool:
    return "pythonosc" not in record.pathname


def decode_packet(data: bytes) -> list[tuple[str, Sequence[Any], float]]:
    """Return the messages of a datagram in order of time; InputError.

    Each has an address, values, and the time at which it applies, s since 1970; 0: at once.
    """
    from pythonosc.osc_packet import OscPacket

    if len(data) % 4:  # python-osc would fill up a cut number with zeros
        raise InputError(f"{len(data)} bytes are not OSC; the length must be a multiple of 4")
    try:
        messages = OscPacket(data).messages
        return [
            (one.message.address, one.message.params, one.time if one.time > time.time() else 0.0)
            for one in messages
        ]
    # a damaged datagram makes the decoder raise many kinds of errors
    except Exception as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0][:80]
        raise InputError(f"{len(data)} bytes are not OSC ({reason})") from None


def encode_message(address: str, values: Sequence[bool | int | float | str]) -> bytes:
    """Return a datagram with one message: numbers in single precision, texts in UTF-8."""
    from pythonosc.osc_message_builder import OscMessageBuilder

    builder = OscMessageBuilder(address=address)
    for value in values:
        builder.add_arg(value)
    return bytes(builder.build().dgram)


PREFIX = "/overview/"
COMMANDS = ("record", "replay", "preset", "window", "mark", "unmark", "name-mark")
"""Names of requests that are neither movement nor parameter."""

CLOCK_STEP_S = 1e-3  # smaller changes of the offset are errors of its measurement
LATEST_S = 10.0  # longest time ahead of a time tag
SILENT_S = 5.0  # time without messages of a sender after which its touch ends
MAX_SENDERS = 32  # known senders; more forget the earliest

ROUNDING = 1e-4
"""Distance beyond an end that single precision may cause, rad; it isn't counted as clamped."""


class _Sender:
    """Controls of one sender, named by its address `host:port`; `latest` is its latest address.

    `repeated`: whether an address of it has sent twice, as a program with one socket does.
    """

    def __init__(self, address: str, controls: tuple[OscControl, ...]) -> None:
        self.latest = address
        self.repeated = False
        self.received_at_s = -math.inf
        self.position = PositionControl(f"theta2 {address}".strip())
        self.assigned = AssignedControls(
            {one: f"{one.address} {address}".strip() for one in controls}
        )


class OscReader(Messages):
    """Converts OSC datagrams. Each sender is an input of its own.

    Programs such as `oscsend` have a new address for each message. So an unknown address belongs to
    the latest sender of its host none of whose addresses has sent twice, unless it begins a second
    touch. A release by it ends all touches of such senders.
    """

    def __init__(
        self, counters: Counters | None = None, controls: tuple[OscControl, ...] = ()
    ) -> None:
        """Convert own messages and those of `controls`, which are of other programs."""
        super().__init__()
        self.counters = Counters() if counters is None else counters
        self._controls = controls
        self._clock_offset_s = 0.0  # from the monotonic clock to the time since 1970
        self._senders: list[_Sender] = []  # the latest is last
        self._device = OscDevice(tuple(one for one in controls if one.to in SENSED))

    def read(self, data: bytes, time_s: float) -> list[Message]:
        """Return the controller messages of a datagram; faults are counted."""
        try:
            messages = decode_packet(data)
        except InputError as error:
            self._reject(str(error))
            return []
        sender = getattr(data, "sender", "")
        return [
            self._scheduled(one, at_s)
            for address, values, at_s in messages
            for one in self._convert(address, values, time_s, sender)
        ]

    def _scheduled(self, message: Message, at_s: float) -> Message:
        """Return a message with the time of its bundle, s since 1970, if it is a movement."""
        if not at_s or not isinstance(message, Movement):
            return message
        offset_s = time.time() - time.monotonic()
        if abs(offset_s - self._clock_offset_s) > CLOCK_STEP_S:  # the system's clock was set
            self._clock_offset_s = offset_s
        if at_s - time.time() > LATEST_S:
            self.say_once(f"time tags more than {LATEST_S:g} s ahead apply at once")
            return message
        return Scheduled(at_s - self._clock_offset_s, message)

    def tick(self, time_s: float) -> list[Message]:
        """Return the ends of touches whose sender is silent: UDP has no connections."""
        ended: list[Message] = []
        for one in self._senders:
            if one.position.touching and time_s - one.received_at_s > SILENT_S:
                ended += one.position.set_touching(False)
                self.say(f"{one.latest}: no messages for {SILENT_S:g} s; its touch has ended")
        return ended

    def _sender(self, address: str, begins_touch: bool, time_s: float) -> _Sender:
        """Return the sender to whom an address belongs, and note that it has sent at `time_s`."""
        found = self._sender_at(address, begins_touch)
        found.latest, found.received_at_s = address, time_s
        return found

    def _sender_at(self, address: str, begins_touch: bool) -> _Sender:
        for one in self._senders:
            if one.latest == address:
                one.repeated = True
                return one
        host = address.rpartition(":")[0]
        known = [
            one
            for one in self._senders
            if not one.repeated and one.latest.rpartition(":")[0] == host
        ]
        touching = [one for one in known if one.position.touching]
        # of two touches each came from an address that has sent once: a third moves the latest one
        if known and not (begins_touch and len(touching) == 1):
            return (touching or known)[-1]
        if len(self._senders) == MAX_SENDERS:
            idle = (one for one in self._senders if not one.position.touching)
            self._senders.remove(next(idle, self._senders[0]))
        self._senders.append(_Sender(address, self._controls))
        return self._senders[-1]

    def _convert(
        self, address: str, values: Sequence[Any], time_s: float, sender: str
    ) -> list[Message]:
        controls = [one for one in self._controls if one.matches(address)]
        if not controls and not address.startswith(PREFIX):
            self.counters.unknown += 1
            return []
        try:
            if controls:
                assigned = self._sender(sender, False, time_s).assigned
                found = [
                    one
                    for control in controls
                    for one in self._by(control, values, time_s, assigned)
                ]
            else:
                found = self._own_message(address.removeprefix(PREFIX), values, sender, time_s)
        except InputError as error:
            self._reject(f"{address}: {error}")
            return []
        self.counters.messages += 1
        return found

    def _own_message(
        self, name: str, values: Sequence[Any], sender: str, time_s: float
    ) -> list[Message]:
        if name == "theta2":
            if len(values) not in (1, 2):
                raise InputError("must have an angle, and may have a touch")
            angle = self._angle(values[0])
            if len(values) == 2:
                return self._touch(_flag(values[1]), sender, time_s, angle)
            return self._sender(sender, False, time_s).position.set_angle(angle)
        if name in COMMANDS:
            return [Command((name, *map(_argument, values)))]
        if len(values) != 1:
            raise InputError(f"must have one value; {len(values)} were sent")
        if name == "touch":
            return self._touch(_flag(values[0]), sender, time_s)
        if not isinstance(values[0], bool | int | float | str):
            raise InputError("the value must be a number, a text, true or false")
        return [SetParameter(name.replace("/", "."), values[0])]

    def _touch(
        self, touching: bool, address: str, time_s: float, theta2: float | None = None
    ) -> list[Message]:
        sender = self._sender(address, touching, time_s)
        if theta2 is None:
            found = sender.position.set_touching(touching)
        else:
            found = sender.position.set_both(theta2, touching)
        if not (touching or sender.repeated):
            others = (one for one in self._senders if one.position.touching and not one.repeated)
            found += [message for one in others for message in one.position.set_touching(False)]
        return found

    def _by(
        self, control: OscControl, values: Sequence[Any], time_s: float, assigned: AssignedControls
    ) -> Sequence[Message]:
        """Return the messages for another program's control."""
        if control.to in SENSED:
            angles = self._device.step(control, [_number(one) for one in values], time_s)
            if self._device.status:
                self.say_once(self._device.status)
            return angles
        if len(values) < control.value:
            raise InputError(f"its control uses value {control.value}; {len(values)} were sent")
        first, last = control.sends
        position = (_number(values[control.value - 1]) - first) / (last - first)
        clamped = min(max(position, 0.0), 1.0)
        self.counters.clamped += abs(clamped - position) > ROUNDING
        return assigned.messages(control, clamped)

    def _angle(self, value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError("an angle must be a number")
        if not math.isfinite(value):
            raise InputError(f"the angle is {value}; must be 0 to {HALF_TURN:.4f} rad")
        clamped = min(max(float(value), 0.0), HALF_TURN)
        if abs(clamped - value) > ROUNDING:
            if not self.counters.clamped:
                self.say(
                    f"{PREFIX}theta2 {value:.4g} is beyond an end; must be 0 to {HALF_TURN:.4f} "
                    "rad, the end is used (later ones are only counted)"
                )
            self.counters.clamped += 1
        return clamped

    def _reject(self, reason: str) -> None:
        if not self.counters.rejected:
            self.say(f"{reason} (later ones are only counted)")
        self.counters.rejected += 1


def _number(value: object) -> float:
    if not isinstance(value, bool | int | float) or not math.isfinite(value):
        raise InputError("its values must be finite numbers")
    return float(value)


def _argument(value: object) -> str:
    """Return a value of a command as it would be typed."""
    if isinstance(value, bool) or (isinstance(value, float) and value.is_integer()):
        return str(int(value))
    if isinstance(value, int | float | str):
        return str(value)
    raise InputError("its values must be numbers and texts")


def _flag(value: object) -> bool:
    if isinstance(value, bool | int | float) and value in (0, 1):
        return bool(value)
    raise InputError("a touch must be 0 or 1")


REPEAT_S = 0.5  # time between messages without a change


class OscReport:
    """Sends changes of the disk as OSC datagrams."""

    def __init__(self) -> None:
        self._sent: tuple[object, ...] | None = None
        self._sent_at = 0.0

    def messages(
        self,
        now_s: float,
        cursor: float,
        torque: float,
        touching: bool,
        passed_events: Iterable[tuple[Event, float]],
        session_state: tuple[str, ...] = (),
    ) -> list[bytes]:
        """Return the datagrams to send at `now_s` (of any clock).

        `passed_events` are the events passed since the last call, each with its level.
        `session_state` has name, reason and last stop.
        """
        datagrams = [
            encode_message("/overview/event", [event.kind, event.label, event.time_s, level])
            for event, level in passed_events
        ]
        state = (cursor, torque, touching, session_state)
        if state != self._sent or now_s - self._sent_at >= REPEAT_S:
            self._sent, self._sent_at = state, now_s
            datagrams += [
                encode_message("/overview/cursor", [cursor]),
                encode_message("/overview/torque", [torque]),
                encode_message("/overview/touching", [int(touching)]),
            ]
            if session_state:
                datagrams.append(encode_message("/overview/state", [*session_state]))
        return datagrams
