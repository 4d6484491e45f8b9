"""Messages that MIDI and OSC controllers have in common, and the parameters that they set."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameter import Parameter, Value
from overview_dsp.design.presets.parameters import KIND_PARAMETERS, PARAMETERS
from overview_dsp.devices.controllers.control_map import (
    MARK,
    SWITCHES,
    TAPS,
    THETA2,
    TOUCH,
    Control,
    OscControl,
)
from overview_dsp.errors import InputError, did_you_mean
from overview_dsp.units import HALF_TURN
from overview_dsp.validation import prefix_errors


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


Movement = AngleChanged | TouchStarted | TouchEnded


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


@dataclass(frozen=True)
class Scheduled:
    """A movement that applies at a time, s of the monotonic clock."""

    time_s: float
    movement: Movement


Message = Movement | SetParameter | ScaleParameter | StepParameter | Command | Scheduled


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
    `touching` is None before it.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._theta2 = 0.0
        self.touching: bool | None = None

    def set_angle(self, theta2: float) -> list[Message]:
        """Return the messages of a change to theta2 (rad)."""
        self._theta2 = theta2
        if self.touching is None:
            return [AngleChanged(self._name, theta2)]
        return [TouchStarted(self._name, theta2)] if self.touching else []

    def set_touching(self, touching: bool) -> list[Message]:
        """Return the messages of a touch or a release."""
        before, self.touching = self.touching, touching
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
        self._pressed: set[Control | OscControl] = set()  # of those that set marks

    def messages(self, control: Control | OscControl, position: float) -> list[Message]:
        """Return the messages of a control that is at `position`, 0 to 1."""
        if control.to == THETA2:
            theta2 = theta2_at(position, control.low, control.high)
            return self._positions[control].set_angle(theta2)
        if control.to == TOUCH:
            touching = position >= 0.5
            positions = self._positions.values()
            return [message for one in positions for message in one.set_touching(touching)]
        if control.to == MARK:
            was_pressed = control in self._pressed
            (self._pressed.add if position >= 0.5 else self._pressed.discard)(control)
            return [Command(("mark",))] if position >= 0.5 and not was_pressed else []
        return [ScaleParameter(control.to, position, control.low, control.high)]


NEAR = 1.0 / 64.0
"""Distance, as a share of the range, at which a control has reached the parameter's value."""


def find_parameter(preset: Preset, id: str) -> tuple[Parameter, Value | None]:
    """Return the parameter of an id, and its value in a preset; InputError for an unknown id."""
    if id in PARAMETERS:
        return PARAMETERS[id], preset.values[id]
    section, _, rest = id.partition(".")
    kind, _, key = rest.partition(".")
    if section == "kinds" and kind in preset.kinds and key in KIND_PARAMETERS:
        return KIND_PARAMETERS[key], getattr(preset.kinds[kind], key, None)
    of_kinds = (f"kinds.{one}.{key}" for one in preset.kinds for key in KIND_PARAMETERS)
    raise InputError(f"no parameter is called {id!r}{did_you_mean(id, (*PARAMETERS, *of_kinds))}")


def require_parameters(controls: Iterable[Control], preset: Preset) -> None:
    """Raise InputError unless the controls' parameters exist and their ends are in range."""
    for one in controls:
        if one.to not in (THETA2, TAPS, *SWITCHES):
            with prefix_errors(f"MIDI {one.name!r}: "):
                known, _ = find_parameter(preset, one.to)
                for end in (one.low, one.high):
                    if end is not None:
                        known.check(end)


def coerce_value(known: Parameter, value: Value) -> Value:
    """Return a value from another program, which may be 0 or 1 instead of false or true."""
    if known.choices and isinstance(known.choices[0], bool) and value in (0, 1):
        return bool(value)
    return value


def _ends(known: Parameter, scale: ScaleParameter) -> tuple[float, float]:
    return (
        known.low if scale.low is None else scale.low,
        known.high if scale.high is None else scale.high,
    )


def scaled_value(known: Parameter, scale: ScaleParameter) -> Value:
    """Return the value at a position in the range, which is logarithmic for such a parameter."""
    if known.choices:
        index = int(scale.position * len(known.choices))
        return known.choices[min(index, len(known.choices) - 1)]
    low, high = _ends(known, scale)
    if known.scale == "log" and low > 0.0 and high > 0.0:
        value = low * math.exp(scale.position * math.log(high / low))
    else:
        value = low + (high - low) * scale.position
    return min(max(value, min(low, high)), max(low, high))


def position_of_value(known: Parameter, scale: ScaleParameter, value: Value | None) -> float | None:
    """Return the position of a value in the control's range; None for a value without one."""
    if known.choices or value is None or isinstance(value, str):
        return None
    low, high = _ends(known, scale)
    if low == high:
        return None
    if known.scale == "log" and min(low, high, value) > 0.0:
        return math.log(value / low) / math.log(high / low)
    return (float(value) - low) / (high - low)


def stepped_value(known: Parameter, by: StepParameter, value: Value | None) -> Value:
    """Return the value one step further in the control's range, up to its end."""
    if known.choices:
        at = known.choices.index(value) + (1 if by.step > 0.0 else -1)
        return known.choices[min(max(at, 0), len(known.choices) - 1)]
    scale = ScaleParameter(by.id, 0.0, by.low, by.high)
    position = (position_of_value(known, scale, value) or 0.0) + by.step
    return scaled_value(known, replace(scale, position=min(max(position, 0.0), 1.0)))


class SoftTakeover:
    """Soft takeover: a control acts only after it has reached the parameter's value.

    A change of the parameter by another source (a file, another controller) requires that again.
    """

    def __init__(self) -> None:
        self._before: float | None = None
        self._set: Value | None = None

    def value(self, preset: Preset, scale: ScaleParameter) -> Value | None:
        """Return the value to set, None before the control has reached it; InputError."""
        known, present = find_parameter(preset, scale.id)
        target = position_of_value(known, scale, present)
        before, self._before = self._before, scale.position
        value = known.check(scaled_value(known, scale))
        reached = (
            target is None
            or present == self._set
            or abs(scale.position - target) <= NEAR
            or (before is not None and (before - target) * (scale.position - target) <= 0.0)
        )
        if not reached:
            return None
        self._set = value
        return value
