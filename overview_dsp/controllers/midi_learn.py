"""Which control is being moved: that one is meant."""

from __future__ import annotations

from dataclasses import replace

from overview_dsp.controllers.midi_map import TAPS, THETA2, TOUCH, Control

FEWEST = 6
SPAN = 0.25
"""A control is meant when it has been at so many positions, over so much of its way."""


class Learner:
    """Messages in, one control out.

    To tap: two keys, the lowest and the highest. To touch: a key or a pedal, pressed. All else:
    what is turned. A coarse control change is enough to know a fine one.
    """

    def __init__(self, to: str) -> None:
        """`to`: what the control is to do, as in a file."""
        self._to = to
        self._seen: dict[Control, set[int]] = {}
        self._keys: list[int] = []

    @property
    def ask(self) -> str:
        """What the person is to do."""
        if self._to == TAPS:
            return "press the lowest key, then the highest"
        if self._to == TOUCH:
            return "press the key or the pedal"
        return "turn it to and fro"

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
        seen = self._seen.setdefault(control, set())
        seen.add(value)
        if len(seen) < FEWEST or max(seen) - min(seen) < SPAN * 127:
            return None
        # a fine half runs through all of its values while its coarse one moves by a step
        coarse = replace(control, number=control.number - 32)
        meant = coarse if control.kind == "cc" and coarse in self._seen else control
        return replace(meant, to=self._to)
