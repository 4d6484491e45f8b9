"""Which control is being moved: that one is meant, of a MIDI controller or of another program."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

from overview_dsp.devices.controllers.control_map import (
    PHONE,
    RELATIVE,
    TAPS,
    THETA2,
    TOUCH,
    Control,
    OscControl,
)
from overview_dsp.devices.controllers.midi_messages import step_of
from overview_dsp.devices.controllers.osc_messages import decode_packet
from overview_dsp.errors import InputError

FEWEST = 6
"""A control is meant when it has been at so many positions, ..."""

# --- MIDI -----------------------------------------------------------------------------------------

SPAN = 0.25
"""... over so much of its way; ..."""

REPEATED = 3
"""A knob without ends repeats a step so often on end, and a fader never says a place twice."""

MOST = 256
FASTEST_STEP = 12
"""What a knob without ends says at most, turned fast."""


class Learner:
    """Messages in, one control out.

    To tap: two keys, the lowest and the highest. To touch: a key or a pedal, pressed. All else:
    what is turned. A coarse control change is enough to know a fine one; a knob without ends is
    known by its steps, first to the right, then to the left.
    """

    def __init__(self, to: str) -> None:
        """`to`: what the control is to do, as in a file."""
        self._to = to
        self._seen: dict[Control, set[int]] = {}
        self._keys: list[int] = []
        self._said: dict[Control, list[int]] = {}

    @property
    def ask(self) -> str:
        """What the person is to do."""
        if self._to == TAPS:
            return "press the lowest key, then the highest"
        if self._to == TOUCH:
            return "press the key or the pedal"
        return "turn it to the right, then back to the left"

    def read(self, data: bytes) -> Control | None:
        """The control, once it is known."""
        if len(data) < 2 or not 0x80 <= data[0] < 0xF0 or max(data[1:]) > 0x7F:
            return None
        kind, channel = data[0] & 0xF0, (data[0] & 0x0F) + 1
        if kind == 0x90 and len(data) == 3 and data[2] > 0:
            return self._note(data[1], channel)
        if self._to == TAPS:
            return None
        if kind == 0xB0 and len(data) == 3 and data[1] < 120:
            return self._turned(Control("cc", data[1], channel=channel), data[2])
        if self._to == TOUCH:
            return None
        if kind == 0xE0 and len(data) == 3:
            return self._turned(Control("bend", channel=channel), data[2])
        if kind == 0xD0:
            return self._turned(Control("pressure", channel=channel), data[1])
        return None

    def _note(self, number: int, channel: int) -> Control | None:
        if self._to == THETA2:
            return None
        if self._to != TAPS:
            return Control("note", number, channel=channel, to=self._to)
        self._keys.append(number)
        low, high = min(self._keys), max(self._keys)
        if low == high:
            return None
        return Control("keys", low, high, channel=channel, to=TAPS)

    def _turned(self, control: Control, value: int) -> Control | None:
        if self._to == TOUCH:
            return replace(control, to=TOUCH) if value >= 64 else None
        if control.kind == "cc":
            said = self._said.setdefault(control, [])
            said.append(value)
            found = endless(said[-MOST:])
            if found is not None:
                relative, reverse = found
                return replace(control, to=self._to, relative=relative, reverse=reverse)
        seen = self._seen.setdefault(control, set())
        seen.add(value)
        if len(seen) < FEWEST or max(seen) - min(seen) < SPAN * 127:
            return None
        if control.kind == "cc" and any(_are_steps(seen, relative) for relative in RELATIVE):
            return None  # a fader passes what lies between
        # a fine half runs through all of its values while its coarse one moves by a step
        coarse = replace(control, number=control.number - 32)
        meant = coarse if control.kind == "cc" and coarse in self._seen else control
        return replace(meant, to=self._to)


def endless(values: list[int]) -> tuple[str, bool] | None:
    """How a knob without ends says its steps, and whether reversed; None if it isn't one.

    It was turned to the right first. Both ways were heard, in steps of a knob's size that were
    repeated.
    """
    for relative in RELATIVE:
        if not _are_steps(values, relative):
            continue
        ways = [step_of(value, relative) > 0 for value in values]
        turns = ways.index(not ways[0]) if (not ways[0]) in ways else len(ways)
        both = (values[:turns], values[turns:])
        if all(_repeats(half) >= REPEATED for half in both):
            return relative, not ways[0]
    return None


def _are_steps(values: Iterable[int], relative: str) -> bool:
    return all(0 < abs(step_of(value, relative)) <= FASTEST_STEP for value in values)


def _repeats(values: list[int]) -> int:
    return sum(a == b for a, b in pairwise(values))


# --- OSC ------------------------------------------------------------------------------------------

DEVICE = "device"
"""To learn: the device itself is turned, and says how it lies."""

BACK = 0.5
"""... over an OSC control's way from end to end, has come back by so much of it, ..."""

SETTLED_S = 1.0
"""... and has found no new end for so long, s."""

LISTENS_S = 1.5
"""What a device says of itself is listened to for so long, s."""

MOST_VALUES = 2
"""A message of more values is no control's, but what a device says of itself."""

TAILS = (
    ("gravity", "acceleration"), ("grav", "acceleration"), ("accxyz", "acceleration"),
    ("accelerometer", "acceleration"), ("quaternion", "quaternion"), ("quat", "quaternion"),
    ("attitude", "angles"), ("gyro", "angles"),
)  # fmt: skip
"""The end of an address, and what its values are; the first that is heard is taken."""

_COUNTS = {"acceleration": 3, "quaternion": 4, "angles": 3}
_TOLERANCE = 0.02


class _Way:
    """Where one value has been."""

    def __init__(self, value: float, time_s: float) -> None:
        self.seen = {value}
        self.low = self.high = self.value = value
        self.since_s = time_s
        self._furthest = value

    def add(self, value: float, time_s: float) -> None:
        """It is there now."""
        if value < self.low or value > self.high:
            self.low, self.high = min(value, self.low), max(value, self.high)
            self.since_s, self._furthest = time_s, value
        self.value = value
        if len(self.seen) < FEWEST:
            self.seen.add(value)

    def is_done(self, time_s: float) -> bool:
        """Whether it was moved from end to end and back."""
        span = self.high - self.low
        back = abs(self.value - self._furthest) >= BACK * span
        return len(self.seen) >= FEWEST and back and time_s - self.since_s >= SETTLED_S

    @property
    def ends(self) -> tuple[float, float]:
        """What came at its ends; those of a fader that wasn't quite pushed to them are 0 and 1."""
        if abs(self.low) <= _TOLERANCE and abs(self.high - 1.0) <= _TOLERANCE:
            return 0.0, 1.0
        return self.low, self.high


class OscLearner:
    """Datagrams in, one control out."""

    def __init__(self, to: str) -> None:
        """`to`: what the control is to do, as in a file, or `DEVICE`."""
        self._to = to
        self._ways: dict[tuple[str, int], _Way] = {}
        self._heard: dict[str, int] = {}
        self._began_s: float | None = None

    @property
    def ask(self) -> str:
        """What the person is to do."""
        if self._to == DEVICE:
            return "have the app send how the device lies (gravity, or a quaternion)"
        if self._to == TOUCH:
            return "press it"
        return "move it from one end to the other and back, and leave it"

    @property
    def heard(self) -> str:
        """The addresses that came, with how many values each, for a person."""
        return ", ".join(f"{address} ({count})" for address, count in self._heard.items())

    def read(self, data: bytes, time_s: float) -> None:
        """Take a datagram; what is none is left alone."""
        self._began_s = time_s if self._began_s is None else self._began_s
        try:
            messages = decode_packet(data)
        except InputError:
            return
        for address, values in messages:
            if len(self._heard) < 1000:
                self._heard[address] = len(values)
            self._take(address, values, time_s)

    def _take(self, address: str, values: Sequence[Any], time_s: float) -> None:
        if len(values) > MOST_VALUES or len(self._ways) > 1000:
            return
        for index, value in enumerate(values, 1):
            if not isinstance(value, bool | int | float) or not abs(value) < 1e9:
                continue
            number = float(value)
            way = self._ways.setdefault((address, index), _Way(number, time_s))
            way.add(number, time_s)

    def found(self, time_s: float) -> OscControl | None:
        """The control, once it is known."""
        if self._to == DEVICE:
            return self._device(time_s)
        for (address, index), way in self._ways.items():
            if self._to == TOUCH:
                if way.high >= 1.0 and way.seen <= {0.0, way.high} and way.value == way.high:
                    return OscControl(address, TOUCH, index, (0.0, way.high))
            elif way.is_done(time_s):
                return OscControl(address, self._to, index, way.ends)
        return None

    def _device(self, time_s: float) -> OscControl | None:
        if self._began_s is None or time_s - self._began_s < LISTENS_S:
            return None
        for tail, what in TAILS:
            for address, count in self._heard.items():
                if address.lower().endswith(f"/{tail}") and count == _COUNTS[what]:
                    return OscControl(
                        address, what, axes=PHONE if what != "angles" else ("x", "y", "z")
                    )
        return None
