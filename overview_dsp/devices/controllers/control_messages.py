"""Messages that MIDI and OSC controllers have in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from overview_dsp.design.presets.parameter import Value
from overview_dsp.devices.controllers.control_map import THETA2, TOUCH, Control, OscControl
from overview_dsp.units import HALF_TURN


@dataclass(frozen=True)
class AngleChanged:
    """`control`, which doesn't detect touch, is at theta2 (rad)."""

    control: str
    theta2: float


@dataclass(frozen=True)
class TouchStarted:
    """Touch `touch_id` is at theta2 (rad): a new touch steps there, a continued one moves there."""

    touch_id: str
    theta2: float


@dataclass(frozen=True)
class TouchEnded:
    """Touch `touch_id` ends; None: all touches end."""

    touch_id: str | None = None


@dataclass(frozen=True)
class SetParameter:
    """Request to set the parameter `id` to `value`."""

    id: str
    value: Value


@dataclass(frozen=True)
class ScaleParameter:
    """A control is at `position` (0 to 1) of the range of the parameter `id`.

    `low` and `high` are the ends of the range (None: those of the parameter). The control acts once
    it has passed the parameter's value.
    """

    id: str
    position: float
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class StepParameter:
    """A control moves the parameter `id` by `step` (1 = the range from `low` to `high`)."""

    id: str
    step: float
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class Command:
    """A request to the session that is neither movement nor parameter: a name and its arguments."""

    arguments: tuple[str, ...]


Message = (
    AngleChanged
    | TouchStarted
    | TouchEnded
    | SetParameter
    | ScaleParameter
    | StepParameter
    | Command
)


@dataclass
class Counters:
    """Counts of received messages and their faults; no fault ends a session.

    `messages`: valid messages.
    `rejected`: invalid messages, or messages with invalid values.
    `unknown`: valid messages without an assignment.
    `clamped`: angles beyond an end of the timeline, set to that end.
    `overrun`: messages dropped because they arrived faster than they were read.
    """

    messages: int = 0
    rejected: int = 0
    unknown: int = 0
    clamped: int = 0
    overrun: int = 0


def theta2_at(position: float, low: float | None, high: float | None) -> float:
    """Return the angle (rad) of a control's position between two positions on the timeline."""
    first, last = 0.0 if low is None else low, 1.0 if high is None else high
    return HALF_TURN * (first + (last - first) * position)


class PositionControl:
    """A control for a position on the timeline, with an optional touch message.

    Before the first touch message it sends `AngleChanged`; afterwards the touch alone decides.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._theta2 = 0.0
        self._touching: bool | None = None

    def set_angle(self, theta2: float) -> list[Message]:
        """Return the messages of a change to theta2 (rad)."""
        self._theta2 = theta2
        if self._touching is None:
            return [AngleChanged(self._name, theta2)]
        return [TouchStarted(self._name, theta2)] if self._touching else []

    def set_touching(self, touching: bool) -> list[Message]:
        """Return the messages of a touch or a release."""
        before, self._touching = self._touching, touching
        if touching:
            return [] if before else [TouchStarted(self._name, self._theta2)]
        return [] if before is False else [TouchEnded(self._name)]

    def set_both(self, theta2: float, touching: bool) -> list[Message]:
        """Return the messages of theta2 (rad) with a touch or a release there."""
        self._theta2 = theta2
        return self.set_touching(touching) or self.set_angle(theta2)


class AssignedControls:
    """The controls of a map, with the names of those that set theta2."""

    def __init__(self, names: Mapping[Control | OscControl, str]) -> None:
        named = names.items()
        self._positions = {one: PositionControl(name) for one, name in named if one.to == THETA2}

    def messages(self, control: Control | OscControl, position: float) -> list[Message]:
        """Return the messages of a control that is at `position`, 0 to 1."""
        if control.to == THETA2:
            theta2 = theta2_at(position, control.low, control.high)
            return self._positions[control].set_angle(theta2)
        if control.to == TOUCH:
            touching = position >= 0.5
            positions = self._positions.values()
            return [message for one in positions for message in one.set_touching(touching)]
        return [ScaleParameter(control.to, position, control.low, control.high)]
