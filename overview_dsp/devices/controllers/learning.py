"""Assignment of a MIDI or OSC control by moving it."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

import numpy as np

from overview_dsp.devices.controllers.control_map import (
    PHONE,
    RELATIVE,
    SWITCHES,
    TAPS,
    THETA2,
    Control,
    OscControl,
)
from overview_dsp.devices.controllers.midi_messages import step_of
from overview_dsp.devices.controllers.osc_messages import decode_packet
from overview_dsp.devices.sensors import number_meaning
from overview_dsp.devices.sensors.units import is_gravity
from overview_dsp.errors import InputError

MIN_VALUES = 6  # smallest number of different values of the moved control
MIN_SPAN = 0.25  # smallest share of its range that the moved control covers

REPEATED = 3
"""Smallest number of equal consecutive steps of an endless knob; a fader never repeats a value."""

MAX_HISTORY = 256
LARGEST_STEP = 12  # largest step of an endless knob, turned fast


class Learner:
    """Finds the moved MIDI control.

    Taps need two keys, the lowest and the highest. A touch or a mark needs a pressed key or pedal.
    Other targets need a turned control. A coarse control change identifies a fine one. The steps of
    an endless knob, first to the right, then to the left, identify its code.
    """

    def __init__(self, to: str) -> None:
        """Find a control for the target `to`, as in a map file."""
        self._to = to
        self._values: dict[Control, set[int]] = {}
        self._keys: list[int] = []
        self._history: dict[Control, list[int]] = {}

    @property
    def instruction(self) -> str:
        """Instruction to the user."""
        if self._to == TAPS:
            return "press the lowest key, then the highest"
        if self._to in SWITCHES:
            return "press the key or the pedal"
        return "turn it to the right, then back to the left"

    @property
    def failure(self) -> str:
        """Reason why there is no control yet."""
        return f"no control for {self._to!r} was moved"

    def control_of(self, messages: list[bytes], time_s: float) -> Control | None:
        """Return the control, once these messages identify it."""
        return next(filter(None, map(self.read, messages)), None)

    def read(self, data: bytes) -> Control | None:
        """Return the control, once it is known."""
        if len(data) < 2 or not 0x80 <= data[0] < 0xF0 or max(data[1:]) > 0x7F:
            return None
        kind, channel = data[0] & 0xF0, (data[0] & 0x0F) + 1
        if kind == 0x90 and len(data) == 3 and data[2] > 0:
            return self._note(data[1], channel)
        if kind == 0xB0 and len(data) == 3 and data[1] < 120 and self._to != TAPS:
            return self._changed(Control("cc", data[1], channel=channel), data[2])
        if self._to in (TAPS, *SWITCHES):
            return None
        if kind == 0xE0 and len(data) == 3:
            return self._changed(Control("bend", channel=channel), data[2])
        if kind == 0xD0:
            return self._changed(Control("pressure", channel=channel), data[1])
        return None

    def _note(self, number: int, channel: int) -> Control | None:
        if self._to == THETA2:
            return None
        if self._to != TAPS:
            return Control("note", number, channel=channel, to=self._to)
        self._keys.append(number)
        low, high = min(self._keys), max(self._keys)
        return Control("keys", low, high, channel=channel, to=TAPS) if low < high else None

    def _changed(self, control: Control, value: int) -> Control | None:
        if self._to in SWITCHES:
            return replace(control, to=self._to) if value >= 64 else None
        if control.kind == "cc":
            history = self._history.setdefault(control, [])
            history.append(value)
            code = endless_knob(history[-MAX_HISTORY:])
            if code is not None:
                return replace(control, to=self._to, relative=code[0], reverse=code[1])
        values = self._values.setdefault(control, set())
        values.add(value)
        if len(values) < MIN_VALUES or max(values) - min(values) < MIN_SPAN * 127:
            return None
        if control.kind == "cc" and any(_are_steps(values, relative) for relative in RELATIVE):
            return None  # a fader also sends values that can't be steps
        # a fine half passes all its values while its coarse half moves by one step
        coarse = replace(control, number=control.number - 32)
        is_fine = control.kind == "cc" and coarse in self._values
        return replace(coarse if is_fine else control, to=self._to)


def endless_knob(values: list[int]) -> tuple[str, bool] | None:
    """Return the code of an endless knob's steps and whether it is reversed; None for others.

    The knob was turned to the right first. Both directions occur, in steps that are small and
    repeated.
    """
    for relative in RELATIVE:
        if not _are_steps(values, relative):
            continue
        directions = [step_of(value, relative) > 0 for value in values]
        first = directions[0]
        turn = directions.index(not first) if (not first) in directions else len(directions)
        halves = values[:turn], values[turn:]
        if all(sum(a == b for a, b in pairwise(half)) >= REPEATED for half in halves):
            return relative, not first
    return None


def _are_steps(values: Iterable[int], relative: str) -> bool:
    return all(0 < abs(step_of(value, relative)) <= LARGEST_STEP for value in values)


DEVICE = "device"  # target for a device that is turned and sends its orientation
RETURN = 0.5  # smallest share of its span by which a moved control has returned from its last end
SETTLED_S = 1.0  # time without a new end after which a control is found
LISTEN_S = 1.5  # time to wait for messages of a device about its orientation

MAX_VALUES = 2
"""Maximum number of values in a control's message; longer ones are about an orientation."""

MAX_CONTROLS = 1000

GRAVITY = ("gravity", "grav", "accxyz", "accelerometer")
"""Ends of a phone's addresses for an acceleration; one with gravity is used without a turn."""

MAX_ROWS = 20_000  # of a device, per address
RETRY_S = 0.2  # time between attempts to find the meaning of a device's numbers
_TOLERANCE = 0.02


class _ValueRange:
    """Range and history of one value."""

    def __init__(self, value: float, time_s: float) -> None:
        self.seen = {value}
        self.low = self.high = self.value = value
        self.since_s = time_s
        self._last_end = value

    def add(self, value: float, time_s: float) -> None:
        """Add the present value."""
        if value < self.low or value > self.high:
            self.low, self.high = min(value, self.low), max(value, self.high)
            self.since_s, self._last_end = time_s, value
        self.value = value
        if len(self.seen) < MIN_VALUES:
            self.seen.add(value)

    def is_done(self, time_s: float) -> bool:
        """Return whether the control was moved from end to end and back."""
        span = self.high - self.low
        returned = abs(self.value - self._last_end) >= RETURN * span
        return len(self.seen) >= MIN_VALUES and returned and time_s - self.since_s >= SETTLED_S

    @property
    def ends(self) -> tuple[float, float]:
        """Values at its ends; 0 and 1 for a fader that was moved almost to those."""
        if abs(self.low) <= _TOLERANCE and abs(self.high - 1.0) <= _TOLERANCE:
            return 0.0, 1.0
        return self.low, self.high


class OscLearner:
    """Finds the moved OSC control."""

    def __init__(self, to: str) -> None:
        """Find a control for the target `to`, as in a map file, or `DEVICE`."""
        self._to = to
        self._ranges: dict[tuple[str, int], _ValueRange] = {}
        self._counts: dict[str, int] = {}
        self._rows: dict[str, list[tuple[float, ...]]] = {}
        self._tried_s = -1e300
        self._started_s: float | None = None

    @property
    def instruction(self) -> str:
        """Instruction to the user."""
        if self._to == DEVICE:
            return "put the device down, face up; then turn it face down and back, 2 times"
        if self._to in SWITCHES:
            return "press it"
        return "move it from one end to the other and back, then leave it"

    @property
    def failure(self) -> str:
        """Reason why there is no control yet: the addresses with their number of values."""
        counted = ", ".join(f"{address} ({count})" for address, count in self._counts.items())
        received = f"received: {counted}" if counted else "nothing received"
        reason = f"; {self.explanation}" if self.explanation else ""
        return f"no message for {self._to!r} ({received}{reason})"

    def control_of(self, messages: list[bytes], time_s: float) -> OscControl | None:
        """Return the control, once these messages and earlier ones identify it."""
        for data in messages:
            self.read(data, time_s)
        return self.found(time_s)

    def read(self, data: bytes, time_s: float) -> None:
        """Process a datagram; an invalid one is ignored."""
        self._started_s = time_s if self._started_s is None else self._started_s
        try:
            messages = decode_packet(data)
        except InputError:
            return
        for address, values, _ in messages:
            if len(self._counts) < MAX_CONTROLS:
                self._counts[address] = len(values)
            if self._to == DEVICE and address in self._counts and all(map(_is_number, values)):
                rows = self._rows.setdefault(address, [])
                if (not rows or len(rows[0]) == len(values)) and len(rows) < MAX_ROWS:
                    rows.append(tuple(map(float, values)))
            if len(values) > MAX_VALUES or len(self._ranges) > MAX_CONTROLS:
                continue
            for index, value in enumerate(values, 1):
                if _is_number(value):
                    new = _ValueRange(float(value), time_s)
                    self._ranges.setdefault((address, index), new).add(float(value), time_s)

    def found(self, time_s: float) -> OscControl | None:
        """Return the control, once it is known."""
        if self._to == DEVICE:
            return self._device(time_s)
        for (address, index), seen in self._ranges.items():
            if self._to in SWITCHES:
                if seen.high >= 1.0 and seen.seen <= {0.0, seen.high} and seen.value == seen.high:
                    return OscControl(address, self._to, index, (0.0, seen.high))
            elif seen.is_done(time_s):
                return OscControl(address, self._to, index, seen.ends)
        return None

    def _device(self, time_s: float) -> OscControl | None:
        if self._started_s is None or time_s - self._started_s < LISTEN_S:
            return None
        for suffix in GRAVITY:
            for address, rows in self._rows.items():
                is_tail = address.lower().endswith(f"/{suffix}") and len(rows[0]) == 3
                if is_tail and is_gravity(statistics.median(math.hypot(*one) for one in rows)):
                    return OscControl(address, "acceleration", axes=PHONE)
        if time_s - self._tried_s < RETRY_S:
            return None
        self._tried_s = time_s
        found = number_meaning.best_meaning(self._rows)
        if not found:
            return None
        address, meaning = found[0]
        control = OscControl(address, meaning.quantity, meaning.at + 1)
        if meaning.quantity == "quaternion":
            control = replace(control, order=meaning.order)
        if meaning.ups is None:
            return replace(control, scale=math.degrees(1.0) if meaning.radians else 1.0)
        x, y, z = np.median(meaning.ups[: number_meaning.REST_ROWS], axis=0)
        return replace(control, axes=number_meaning.axes_in_turn((x, y, z), meaning.ups))

    @property
    def explanation(self) -> str:
        """Reason why no device is found in the received messages, or empty."""
        if self._to != DEVICE or not self._rows:
            return ""
        address, rows = max(self._rows.items(), key=lambda one: (len(one[1][0]) >= 3, len(one[1])))
        if len(rows[0]) < 3:
            return (
                "each axis comes in a message of its own: choose theta2 instead of device, and "
                "turn the device"
            )
        return f"{address}: {number_meaning.explain(rows)}"


def _is_number(value: object) -> bool:
    return isinstance(value, bool | int | float) and abs(value) < 1e9
