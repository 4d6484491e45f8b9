"""MIDI messages to controller messages, by a list of controls.

A spring holds a pitch bend wheel in its middle, as a wrist rests face up. Bent either way it is
away from rest, its end is the end of the timeline, and released it is back at rest. A control
change is a fader from 0 to 1. It has 14 bits where its fine half (number + 32) occurs, else 7. A
relative control changes its value by steps and stays at its ends. Keys tap: each touches its
position on the timeline while it is down.
"""

from __future__ import annotations

from overview_dsp.devices.controllers.control_map import DEFAULT, TAPS, THETA2, TOUCH, Control
from overview_dsp.devices.controllers.control_messages import (
    AssignedControls,
    Counters,
    Message,
    StepParameter,
    TouchEnded,
    TouchStarted,
    theta2_at,
)

FINE = 32  # offset from the number of a control change (below this) to the number of its fine half
FINE_WITHIN_S = 0.005  # longest time from a coarse half to its fine half

SOUND_OFF, NOTES_OFF = 120, 123
BEND_MIDDLE = 8192


class MidiReader:
    """Converts MIDI messages."""

    def __init__(
        self, controls: tuple[Control, ...] = DEFAULT, counters: Counters | None = None
    ) -> None:
        """Convert the messages of `controls`; `counters` may be those of an earlier reader."""
        self.counters = Counters() if counters is None else counters
        self._controls = controls
        # the channels are inputs of their own, unless the map names one or has a control for touch,
        # which may be on another channel than theta2
        self._by_channel = not any(one.channel or one.to == TOUCH for one in controls)
        self._assigned: dict[int, AssignedControls] = {}
        self._coarse: dict[tuple[int, int], int] = {}
        self._fine: set[tuple[int, int]] = set()
        self._pending: dict[tuple[int, int], float] = {}
        self._relative_positions: dict[tuple[Control, int], float] = {}

    def read(self, data: bytes, time_s: float) -> list[Message]:
        """Return the controller messages of one whole MIDI message."""
        kind = data[0] & 0xF0 if data else 0
        if kind == 0xF0:  # clocks and dumps
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
            return self._moved("bend", 0, channel, min(1.0, abs(bent) / (BEND_MIDDLE - 1)))
        if kind == 0xD0:
            return self._moved("pressure", 0, channel, data[1] / 127.0)
        return self._unknown()

    def tick(self, time_s: float) -> list[Message]:
        """Return the messages of coarse halves whose fine half, which is then 0, is overdue."""
        overdue = [one for one, since in self._pending.items() if time_s - since > FINE_WITHIN_S]
        messages = []
        for channel, number in overdue:
            del self._pending[channel, number]
            messages += self._moved(
                "cc", number, channel, (self._coarse[channel, number] << 7) / 16383.0
            )
        return messages

    def take_messages(self) -> tuple[str, ...]:
        """Return no messages to the user: MIDI has none."""
        return ()

    def _matching(self, kind: str, number: int, channel: int) -> list[Control]:
        return [one for one in self._controls if one.matches(kind, number, channel)]

    def _assigned_to(self, channel: int) -> AssignedControls:
        """Return the controls of a channel (1 to 16), or of all channels together."""
        owner = channel if self._by_channel else 0
        if owner not in self._assigned:
            self._assigned[owner] = AssignedControls(
                {one: f"{one.name}/{one.channel or owner}" for one in self._controls}
            )
        return self._assigned[owner]

    def _unknown(self) -> list[Message]:
        self.counters.unknown += 1
        return []

    def _note(self, number: int, down: bool, channel: int) -> list[Message]:
        controls = self._matching("note", number, channel)
        if not controls:
            return self._unknown()
        messages: list[Message] = []
        for one in controls:
            if one.to != TAPS:
                messages += self._assigned_to(channel).messages(one, float(down))
                continue
            name = f"key {channel}/{number}"
            position = (number - one.number) / (one.highest - one.number)
            theta2 = theta2_at(position, one.low, one.high)
            messages.append(TouchStarted(name, theta2) if down else TouchEnded(name))
        return messages

    def _change(self, number: int, value: int, channel: int, time_s: float) -> list[Message]:
        if number >= SOUND_OFF:
            return [TouchEnded()] if number in (SOUND_OFF, NOTES_OFF) else self._unknown()
        controls = self._matching("cc", number, channel)
        if any(one.relative for one in controls):
            return [message for one in controls for message in self._stepped(one, value, channel)]
        if controls:
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
            position = (self._coarse[key] << 7 | value) / 16383.0
            return self._moved("cc", number - FINE, channel, position)
        return self._unknown()

    def _moved(self, kind: str, number: int, channel: int, position: float) -> list[Message]:
        controls = self._matching(kind, number, channel)
        if not controls:
            return self._unknown()
        assigned = self._assigned_to(channel)
        return [message for one in controls for message in assigned.messages(one, position)]

    def _stepped(self, control: Control, value: int, channel: int) -> list[Message]:
        """Return the messages of a control whose value is a step since the previous message."""
        if not control.relative:
            return self._assigned_to(channel).messages(control, value / 127.0)
        step = step_of(value, control.relative) / control.steps
        step = -step if control.reverse else step
        if control.to != THETA2:
            return [StepParameter(control.to, step, control.low, control.high)]
        at = (control, channel if self._by_channel else 0)
        position = min(max(self._relative_positions.get(at, 0.0) + step, 0.0), 1.0)
        self._relative_positions[at] = position
        return self._assigned_to(channel).messages(control, position)


def step_of(value: int, relative: str) -> int:
    """Return the steps of a relative control change, -64 to 63; to the right is positive."""
    if relative == "offset":
        return value - 64
    if relative == "signed":
        return -(value & 0x3F) if value & 0x40 else value
    return value - 128 if value > 63 else value
