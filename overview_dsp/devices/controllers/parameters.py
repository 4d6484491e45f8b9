"""Parameters as controllers set them: by id, by a part of the range, picked up where they are."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameter import Parameter, Value
from overview_dsp.design.presets.parameters import KIND_PARAMETERS, PARAMETERS
from overview_dsp.devices.controllers.control_map import TAPS, THETA2, TOUCH, Control
from overview_dsp.devices.controllers.control_messages import ScaleParameter, StepParameter
from overview_dsp.errors import InputError, did_you_mean

NEAR = 1.0 / 64.0
"""Of its way: a control this close to where the parameter is has picked it up."""


def find_parameter(preset: Preset, id: str) -> tuple[Parameter, Value | None]:
    """The parameter of that id, and its value in a preset.

    Raises
    ------
    InputError
        There is none in this preset.
    """
    if id in PARAMETERS:
        return PARAMETERS[id], preset.values[id]
    section, _, rest = id.partition(".")
    kind, _, key = rest.partition(".")
    if section == "kinds" and kind in preset.kinds and key in KIND_PARAMETERS:
        return KIND_PARAMETERS[key], getattr(preset.kinds[kind], key, None)
    known = (
        *PARAMETERS,
        *(f"kinds.{one}.{key}" for one in preset.kinds for key in KIND_PARAMETERS),
    )
    raise InputError(f"no parameter is called {id!r}{did_you_mean(id, known)}")


def require_parameters(controls: Iterable[Control], preset: Preset) -> None:
    """Raise InputError unless each control's parameter is one, and its ends are in its range."""
    for one in controls:
        if one.to not in (THETA2, TOUCH, TAPS):
            try:
                known, _ = find_parameter(preset, one.to)
                for end in (one.low, one.high):
                    if end is not None:
                        known.check(end)
            except InputError as error:
                raise InputError(f"MIDI {one.name!r}: {error}") from None


def coerce_value(known: Parameter, value: Value) -> Value:
    """A value as another program writes it: 0 and 1 also for false and true."""
    if known.choices and isinstance(known.choices[0], bool) and value in (0, 1):
        return bool(value)
    return value


def scaled_value(known: Parameter, dialled: ScaleParameter) -> Value:
    """The value at a part of the way: evenly, by ratio where the range is one of ratios."""
    part = dialled.part
    if known.choices:
        return known.choices[min(int(part * len(known.choices)), len(known.choices) - 1)]
    low = known.low if dialled.low is None else dialled.low
    high = known.high if dialled.high is None else dialled.high
    if known.scale == "log" and low > 0.0 and high > 0.0:
        return _between(low * math.exp(part * math.log(high / low)), low, high)
    return _between(low + (high - low) * part, low, high)


def _between(value: float, one: float, other: float) -> float:
    return min(max(value, min(one, other)), max(one, other))


def position_of_value(
    known: Parameter, dialled: ScaleParameter, value: Value | None
) -> float | None:
    """Where on the control's way a value is, 0 to 1 within its ends; None for what has no way."""
    if known.choices or value is None or isinstance(value, str):
        return None
    low = known.low if dialled.low is None else dialled.low
    high = known.high if dialled.high is None else dialled.high
    if low == high:
        return None
    if known.scale == "log" and min(low, high, value) > 0.0:
        return math.log(value / low) / math.log(high / low)
    return (float(value) - low) / (high - low)


def stepped_value(known: Parameter, by: StepParameter, value: Value | None) -> Value:
    """The value a step further on the control's way, no further than its end."""
    dialled = ScaleParameter(by.id, 0.0, by.low, by.high)
    if known.choices:
        at = known.choices.index(value) + (1 if by.step > 0.0 else -1)
        return known.choices[min(max(at, 0), len(known.choices) - 1)]
    part = position_of_value(known, dialled, value)
    return scaled_value(known, replace(dialled, part=min(max((part or 0.0) + by.step, 0.0), 1.0)))


class SoftTakeover:
    """Takes a parameter over without a jump: a control acts from where it has met the parameter.

    What sets the parameter elsewhere meanwhile (a file, another controller) lets it go again.
    """

    def __init__(self) -> None:
        self._before: float | None = None
        self._set: Value | None = None

    def value(self, preset: Preset, dialled: ScaleParameter) -> Value | None:
        """The value to set; None while the control hasn't met the parameter.

        Raises
        ------
        InputError
            No such parameter, or a value that it can't have.
        """
        known, present = find_parameter(preset, dialled.id)
        there = position_of_value(known, dialled, present)
        before, self._before = self._before, dialled.part
        value = known.check(scaled_value(known, dialled))
        met = (
            there is None
            or present == self._set
            or abs(dialled.part - there) <= NEAR
            or (before is not None and (before - there) * (dialled.part - there) <= 0.0)
        )
        if not met:
            return None
        self._set = value
        return value
