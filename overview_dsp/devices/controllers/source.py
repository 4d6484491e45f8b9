"""A controller as a source: its messages in, control events of one source out.

Takeover, the one rule: **the last to touch holds the disk, until it lets go or another touches.**

- What feels a touch (a finger, a key) steps to its position: a tap doesn't depend on the disk's.
- What doesn't (a device turned, a fader, a wheel) touches by being turned, and never jumps: it
  begins where the disk is held and goes over to its own position (`sensors.touching`).
- A fader that lies still holds on; turning another one, or a device, takes over from it.
- Whoever lets go gives the disk back to the last one that still holds on; where none does, it
  arrives at the last target and recoils.
"""

from __future__ import annotations

from overview_dsp.devices.controllers.control_messages import AngleChanged, TouchEnded, TouchStarted
from overview_dsp.devices.sensors.angles import Turn
from overview_dsp.devices.sensors.touch_detection import Event, TouchRules, TwistTouch


class ControllerSource:
    """All fingers and all controls of one controller.

    Attributes
    ----------
    rules : TouchRules
        When a control without a touch holds on.
    """

    def __init__(self, rules: TouchRules) -> None:
        """Nothing has come yet."""
        self._rules = rules
        self._touches: dict[str, TwistTouch] = {}
        self._turns: dict[str, Turn] = {}
        self._fingers: dict[str, float] = {}
        self._holding: list[str] = []  # the last to touch is last
        self._theta2 = 0.0
        self._reported: float | None = None

    @property
    def rules(self) -> TouchRules:
        """When a control without a touch holds on."""
        return self._rules

    @rules.setter
    def rules(self, rules: TouchRules) -> None:
        self._rules = rules
        for touch in self._touches.values():
            touch.rules = rules

    @property
    def holding(self) -> bool:
        """Whether it holds on: then `tick` is to be called often."""
        return bool(self._holding)

    @property
    def theta2(self) -> float:
        """Where it holds or held last, rad."""
        return self._theta2

    def move(
        self,
        move: AngleChanged | TouchStarted | TouchEnded,
        time_s: float,
        elsewhere: float | None = None,
        position: float = 0.0,
        yields: bool = False,
    ) -> list[Event]:
        """The events of a move; `elsewhere`, `position` and `yields` as `TwistTouch.step`."""
        if isinstance(move, TouchStarted):
            return self._touch(move.finger, move.theta2, time_s)
        if isinstance(move, TouchEnded):
            names = list(self._fingers) if move.finger is None else [move.finger]
            return [
                event
                for name in names
                if name in self._holding
                for event in self._lift(name, time_s)
            ]
        turn = Turn(time_s, move.theta2)
        if move.control not in self._touches:
            self._touches[move.control] = TwistTouch(self._rules)
        self._turns[move.control] = turn
        return self._step(move.control, turn, elsewhere, position, yields)

    def tick(
        self,
        time_s: float,
        elsewhere: float | None = None,
        position: float = 0.0,
        yields: bool = False,
    ) -> list[Event]:
        """What time alone does: joining, following, letting go at rest."""
        events = []
        for name in [name for name in self._holding if name not in self._fingers]:
            turn = Turn(time_s, self._turns[name].theta2)
            events += self._step(name, turn, elsewhere, position, yields)
        return events

    def release(self, time_s: float) -> Event | None:
        """All let go: the controller is lost, say."""
        held = self.holding
        for touch in self._touches.values():
            touch.release(time_s)
        self._holding.clear()
        self._fingers.clear()
        self._reported = None
        return Event(time_s, self._theta2, False) if held else None

    # --- inside -----------------------------------------------------------------------------------

    def _touch(self, name: str, theta2: float, time_s: float) -> list[Event]:
        fresh = name not in self._fingers
        again = fresh and self.holding
        if fresh:
            self._forget(name)  # it has begun to say when it is touched
            self._holding.append(name)
        self._fingers[name] = theta2
        return self._at(theta2, time_s, again) if self._holding[-1] == name else []

    def _forget(self, name: str) -> None:
        """As a control it is no more."""
        if name in self._touches:
            del self._touches[name], self._turns[name]
        if name in self._holding:
            self._holding.remove(name)

    def _lift(self, name: str, time_s: float) -> list[Event]:
        self._fingers.pop(name, None)
        if name in self._touches:
            # once released by its message, a control that turns must engage anew
            self._touches[name].release(time_s)
        return self._leave(name, time_s)

    def _leave(self, name: str, time_s: float) -> list[Event]:
        """One lets go; the last that still holds on takes over."""
        was_last = self._holding[-1] == name
        self._holding.remove(name)
        if not self._holding:
            self._reported = None
            return [Event(time_s, self._theta2, False)]
        heir = self._holding[-1]
        # a control follows where the disk was, and joins its own position at the next tick
        return self._at(self._fingers.get(heir, self._theta2), time_s) if was_last else []

    def _step(
        self, name: str, turn: Turn, elsewhere: float | None, position: float, yields: bool
    ) -> list[Event]:
        others = [one for one in self._holding if one != name]
        inside = elsewhere is None and bool(others) and self._holding[-1] != name
        if inside:
            elsewhere, yields = self._theta2, others[-1] not in self._fingers
        touch = self._touches[name]
        was = touch.holding
        event = touch.step(turn, elsewhere, position, yields)
        if event is None:
            return []
        if not event.touching:
            return self._leave(name, turn.time_s)
        again = False
        if not was or event.retouch:
            # inside, the source holds on already
            again = not inside and (event.retouch or bool(others))
            self._holding = [*others, name]
        if self._holding[-1] != name:
            return []
        return self._at(event.theta2, turn.time_s, again)

    def _at(self, theta2: float, time_s: float, again: bool = False) -> list[Event]:
        if theta2 == self._reported and not again:
            return []
        self._theta2 = self._reported = theta2
        return [Event(time_s, theta2, True, again)]
