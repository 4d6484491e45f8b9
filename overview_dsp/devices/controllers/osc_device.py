"""A device in the hand whose app says how it lies, message by message, as a control that turns."""

from __future__ import annotations

import math

from overview_dsp.devices.controllers.control_messages import Turned
from overview_dsp.devices.controllers.osc_map import SENSED, OscControl, sensor_of
from overview_dsp.devices.sensors.angles import Angle, angle_of
from overview_dsp.devices.sensors.reading import ACCELERATION, Counters
from overview_dsp.errors import InputError

NAME = "device"


class OscDevice:
    """Values of messages in, turns out; it begins lying still, face up.

    Attributes
    ----------
    words : str
        How it stands, for a person.
    """

    def __init__(self, controls: tuple[OscControl, ...]) -> None:
        """`controls`: those of a list that are sensed; the first but angular velocity leads."""
        leads = [one for one in controls if one.to != "angular_velocity"]
        self._leads = leads[0] if leads else None
        self._reading: dict[str, float] = {}
        self._angle: Angle | None = None
        self._counters = Counters()
        self._sign = 0.0
        self.words = ""

    def step(self, control: OscControl, values: list[float], time_s: float) -> list[Turned]:
        """The turns of a control's values; InputError if they are none, or can't be used."""
        columns = SENSED[control.to]
        if len(values) < len(columns):
            raise InputError(f"{control.to} is {len(columns)} numbers; {len(values)} came")
        numbers = [one * control.scale for one in values[: len(columns)]]
        if not all(math.isfinite(one) and abs(one) < 1e9 for one in numbers):
            raise InputError(f"{control.to} is of finite numbers")
        if control.to == "quaternion" and control.order == "xyzw":
            numbers = [numbers[3], *numbers[:3]]
        self._reading.update(zip(columns, numbers, strict=True))
        if self._leads is None or control.address != self._leads.address:
            return []
        if control.to == "acceleration":
            # the two makers of phones don't agree which way gravity points; face up it is up
            self._sign = self._sign or math.copysign(1.0, numbers[2])
            self._reading.update((name, self._reading[name] * self._sign) for name in ACCELERATION)
        if self._angle is None:
            self._angle = angle_of(sensor_of(control), False, self._reading, self._counters)
            assert self._angle is not None
        turn = self._angle.step(time_s, dict(self._reading))
        self.words = self._angle.words
        return [] if turn is None else [Turned(NAME, turn.theta2)]
