"""Input from one controller: control events of one source, made from its messages.

One rule decides on takeover: **the latest touch holds the disk until it ends or another begins.**

- A control that detects touch (a finger, a key) steps to its position: a tap doesn't depend on the
  disk's position.
- A control that doesn't (a turned device, a fader, a wheel) touches by a turn, and never jumps: it
  starts at the disk's position and moves to its own (`sensors.touch_detection`).
- A fader at rest keeps its touch; a turn of another fader or device takes over from it.
- A release gives the disk back to the latest touch that remains. Without one, the disk arrives at
  the last target and recoils.
"""

from __future__ import annotations

from overview_dsp.devices.controllers.control_messages import Movement, TouchEnded, TouchStarted
from overview_dsp.devices.sensors.reading import AngleSample
from overview_dsp.devices.sensors.touch_detection import (
    FREE_DISK,
    DiskState,
    Event,
    TouchRules,
    TwistTouch,
)


class ControllerSource:
    """All touches and controls of one controller.

    `rules`, for controls that don't detect touch, may be replaced at any time.
    """

    def __init__(self, rules: TouchRules) -> None:
        self.rules = rules
        self._turned: dict[str, TwistTouch] = {}
        self._angles: dict[str, AngleSample] = {}
        self._touches: dict[str, float] = {}
        self._holding: list[str] = []  # the latest touch is last
        self.theta2 = 0.0  # present or last theta2 of a touch, rad
        self._reported: float | None = None

    @property
    def holding(self) -> bool:
        """True while it holds the disk; `tick` should then be called often."""
        return bool(self._holding)

    @property
    def holder(self) -> str:
        """Name of the control or touch that holds the disk; empty if none does."""
        return self._holding[-1] if self._holding else ""

    def move(self, message: Movement, time_s: float, disk: DiskState = FREE_DISK) -> list[Event]:
        """Return the control events of a message."""
        if isinstance(message, TouchStarted):
            return self._touch(message.touch_id, message.theta2, time_s)
        if isinstance(message, TouchEnded):
            ended = [*self._touches] if message.touch_id is None else [message.touch_id]
            held = (name for name in ended if name in self._holding)
            return [event for name in held for event in self._end_touch(name, time_s)]
        angle = AngleSample(time_s, message.theta2)
        if message.control not in self._turned:
            self._turned[message.control] = TwistTouch(self.rules)
        self._angles[message.control] = angle
        return self._turn(message.control, angle, disk)

    def tick(self, time_s: float, disk: DiskState = FREE_DISK) -> list[Event]:
        """Return the control events that time causes: joining, following, release at rest."""
        events = []
        for name in [name for name in self._holding if name not in self._touches]:
            angle = AngleSample(time_s, self._angles[name].theta2)
            events += self._turn(name, angle, disk)
        return events

    def release(self, time_s: float) -> Event | None:
        """End all touches, for example because the controller is disconnected."""
        was_holding = self.holding
        for touch in self._turned.values():
            touch.release(time_s)
        self._holding.clear()
        self._touches.clear()
        self._reported = None
        return Event(time_s, self.theta2, False) if was_holding else None

    def _touch(self, name: str, theta2: float, time_s: float) -> list[Event]:
        is_new = name not in self._touches
        retouch = is_new and self.holding
        if is_new:
            # a control that sends touches no longer touches by a turn
            if self._turned.pop(name, None) is not None:
                del self._angles[name]
            if name in self._holding:
                self._holding.remove(name)
            self._holding.append(name)
        self._touches[name] = theta2
        return self._at(theta2, time_s, retouch) if self._holding[-1] == name else []

    def _end_touch(self, name: str, time_s: float) -> list[Event]:
        self._touches.pop(name, None)
        if name in self._turned:
            # after a release by message, a turned control must touch by a turn again
            self._turned[name].release(time_s)
        return self._leave(name, time_s)

    def _leave(self, name: str, time_s: float) -> list[Event]:
        """End one touch; the latest of the remaining touches takes over."""
        was_last = self._holding[-1] == name
        self._holding.remove(name)
        if not self._holding:
            self._reported = None
            return [Event(time_s, self.theta2, False)]
        # a turned control starts at the disk's position, and joins its own at the next tick
        theta2 = self._touches.get(self._holding[-1], self.theta2)
        return self._at(theta2, time_s) if was_last else []

    def _turn(self, name: str, angle: AngleSample, disk: DiskState) -> list[Event]:
        others = [one for one in self._holding if one != name]
        inside = disk.elsewhere is None and bool(others) and self._holding[-1] != name
        if inside:
            disk = DiskState(self.theta2, disk.position, others[-1] not in self._touches)
        touch = self._turned[name]
        touch.rules = self.rules
        was_holding = touch.holding
        event = touch.step(angle, disk)
        if event is None:
            return []
        if not event.touching:
            return self._leave(name, angle.time_s)
        retouch = False
        if not was_holding or event.retouch:
            # a takeover inside this source isn't a new touch of the disk
            retouch = not inside and (event.retouch or bool(others))
            self._holding = [*others, name]
        if self._holding[-1] != name:
            return []
        return self._at(event.theta2, angle.time_s, retouch)

    def _at(self, theta2: float, time_s: float, retouch: bool = False) -> list[Event]:
        if theta2 == self._reported and not retouch:
            return []
        self.theta2 = self._reported = theta2
        return [Event(time_s, theta2, True, retouch)]
