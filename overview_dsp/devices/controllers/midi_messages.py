"""What MIDI messages mean, by a list of controls.

A spring holds a pitch bend wheel in its middle, as a wrist lies face up: bent either way is turned
away, its end is the end of the timeline, and let go it is back at rest. A control change is a fader
from 0 to 1; where its fine half (number + 32) is seen it has 14 bits, else 7. One that the list
says to be relative goes on by steps, and stays at its ends. Keys tap: each holds
on at its position on the timeline until it is let go.
"""

from __future__ import annotations

from overview_dsp.devices.controllers.control_map import DEFAULT, TAPS, THETA2, TOUCH, Control
from overview_dsp.devices.controllers.control_messages import (
    Counters,
    Move,
    PositionControl,
    ScaleParameter,
    StepParameter,
    TouchEnded,
    TouchStarted,
    theta2_at,
)

FINE = 32
"""A control change below this has its lower 7 bits so many numbers above."""

FINE_WITHIN_S = 0.005
"""The fine half comes at once after the coarse one, or not at all."""

SOUND_OFF, NOTES_OFF = 120, 123
BEND_MIDDLE = 8192


class MidiReader:
    """Messages in, moves out.

    Attributes
    ----------
    counters : Counters
    """

    def __init__(
        self, controls: tuple[Control, ...] = DEFAULT, counters: Counters | None = None
    ) -> None:
        """Nothing has come yet."""
        self.counters = Counters() if counters is None else counters
        self._controls = controls
        self._positions = {
            one: PositionControl(f"{one.name}/{one.channel}")
            for one in controls
            if one.to == THETA2
        }
        self._coarse: dict[tuple[int, int], int] = {}
        self._fine: set[tuple[int, int]] = set()
        self._pending: dict[tuple[int, int], float] = {}
        self._parts: dict[Control, float] = {}

    def read(self, data: bytes, time_s: float) -> list[Move]:
        """The moves of one whole message."""
        kind = data[0] & 0xF0 if data else 0
        if kind == 0xF0:  # clocks, dumps: nothing to a hand
            return []
        length = 2 if kind in (0xC0, 0xD0) else 3
        if kind < 0x80 or len(data) != length or any(byte > 0x7F for byte in data[1:]):
            self.counters.rejected += 1
            return []
        channel = (data[0] & 0x0F) + 1
        self.counters.messages += 1
        if kind in (0x80, 0x90):
            return self._note(data[1], kind == 0x90 and data[2] > 0, channel)
        if kind == 0xB0:
            return self._change(data[1], data[2], channel, time_s)
        if kind == 0xE0:
            bent = (data[1] | data[2] << 7) - BEND_MIDDLE
            part = min(1.0, abs(bent) / (BEND_MIDDLE - 1))
            return self._moved("bend", 0, channel, part)
        if kind == 0xD0:
            return self._moved("pressure", 0, channel, data[1] / 127.0)
        return self._nothing()

    def tick(self, time_s: float) -> list[Move]:
        """Take what waits for its fine half for whole: that is 0, and was left out."""
        due = [one for one, since in self._pending.items() if time_s - since > FINE_WITHIN_S]
        moves = []
        for channel, number in due:
            del self._pending[channel, number]
            moves += self._moved(
                "cc", number, channel, (self._coarse[channel, number] << 7) / 16383.0
            )
        return moves

    @property
    def waiting(self) -> bool:
        """Whether `tick` is to be called soon."""
        return bool(self._pending)

    def take_messages(self) -> list[str]:
        """What a person should know, new since the last call: nothing."""
        return []

    # --- inside -----------------------------------------------------------------------------------

    def _heard(self, kind: str, number: int, channel: int) -> list[Control]:
        return [one for one in self._controls if one.matches(kind, number, channel)]

    def _nothing(self) -> list[Move]:
        self.counters.unknown += 1
        return []

    def _note(self, number: int, down: bool, channel: int) -> list[Move]:
        heard = self._heard("note", number, channel)
        if not heard:
            return self._nothing()
        moves: list[Move] = []
        for one in heard:
            if one.to == TAPS:
                name = f"key {channel}/{number}"
                part = (number - one.number) / (one.highest - one.number)
                moves.append(
                    TouchStarted(name, theta2_at(part, one.low, one.high))
                    if down
                    else TouchEnded(name)
                )
            else:
                moves += self._do(one, float(down))
        return moves

    def _change(self, number: int, value: int, channel: int, time_s: float) -> list[Move]:
        if number >= SOUND_OFF:
            return [TouchEnded()] if number in (SOUND_OFF, NOTES_OFF) else self._nothing()
        heard = self._heard("cc", number, channel)
        if any(one.relative for one in heard):
            return [move for one in heard for move in self._stepped(one, value)]
        if heard:
            key = (channel, number)
            self._coarse[key] = value
            if key in self._fine:
                self._pending[key] = time_s
                return []
            return self._moved("cc", number, channel, value / 127.0)
        key = (channel, number - FINE)
        if FINE <= number < 2 * FINE and key in self._coarse:
            self._fine.add(key)
            self._pending.pop(key, None)
            part = (self._coarse[key] << 7 | value) / 16383.0
            return self._moved("cc", number - FINE, channel, part)
        return self._nothing()

    def _moved(self, kind: str, number: int, channel: int, part: float) -> list[Move]:
        heard = self._heard(kind, number, channel)
        if not heard:
            return self._nothing()
        return [move for one in heard for move in self._do(one, part)]

    def _stepped(self, control: Control, value: int) -> list[Move]:
        """One whose value is how far it was turned since the message before."""
        if not control.relative:
            return self._do(control, value / 127.0)
        part = step_of(value, control.relative) / control.steps
        part = -part if control.reverse else part
        if control.to != THETA2:
            return [StepParameter(control.to, part, control.low, control.high)]
        self._parts[control] = min(max(self._parts.get(control, 0.0) + part, 0.0), 1.0)
        return self._do(control, self._parts[control])

    def _do(self, control: Control, part: float) -> list[Move]:
        if control.to == THETA2:
            return self._positions[control].turn(theta2_at(part, control.low, control.high))
        if control.to == TOUCH:
            touching = part >= 0.5
            return [move for one in self._positions.values() for move in one.touch(touching)]
        return [ScaleParameter(control.to, part, control.low, control.high)]


def step_of(value: int, relative: str) -> int:
    """The steps that a relative control change says, -64 to 63; to the right is positive."""
    if relative == "offset":
        return value - 64
    if relative == "signed":
        return -(value & 0x3F) if value & 0x40 else value
    return value - 128 if value > 63 else value
