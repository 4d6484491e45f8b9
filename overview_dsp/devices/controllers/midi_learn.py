"""Which control is being moved: that one is meant."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

from overview_dsp.devices.controllers.midi_map import RELATIVE, TAPS, THETA2, TOUCH, Control
from overview_dsp.devices.controllers.midi_messages import step_of

FEWEST = 6
SPAN = 0.25
"""A control is meant when it has been at so many positions, over so much of its way."""


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
