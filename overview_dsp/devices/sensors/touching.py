"""Touching by twist: when a device without a touch sensor holds the disk, and when it lets go.

- A turn away from rest engages. Rest is face up, or where a knob lay at the start.
- Back at rest for a while releases, or a tap-tap does (`twist.release`).
- After a tap-tap, another tap-tap engages again where it is; so does a turn once it was at rest.

Where the modalities change over, the disk is led and never thrown: theta2 begins where the disk (or
the hand that holds it) is, and goes over to the device's own angle within `twist.blend_ms`. While
another hand holds the disk, the device follows it, so that it can take over where that hand was.
It does when that hand lets go; and if that hand feels no touch either, and so may never let go, as
soon as the device is turned on, away from rest, as far as it takes to engage.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from overview_dsp.design.presets.model import Preset
from overview_dsp.devices.sensors.angles import Turn
from overview_dsp.units import HALF_TURN


@dataclass(frozen=True)
class TouchRules:
    """When a twist holds the disk: angles in rad, times in s, as the preset's `twist` section."""

    by_rest: bool
    by_tap: bool
    rest: float
    turn: float
    rest_s: float
    join_s: float

    @classmethod
    def of(cls, preset: Preset) -> TouchRules:
        """A preset's."""
        release = preset.values["twist.release"]
        return cls(
            release in ("rest", "either"),
            release in ("tap", "either"),
            math.radians(preset.number("twist.rest_deg")),
            math.radians(preset.number("twist.engage_deg")),
            preset.number("twist.rest_ms") * 1e-3,
            preset.number("twist.blend_ms") * 1e-3,
        )


@dataclass(frozen=True)
class Event:
    """A control event: time (s), theta2 (rad), touching.

    `again`: the disk is let go and touched in one, so that of several hands this is the last one.
    """

    time_s: float
    theta2: float
    touching: bool
    again: bool = False


class TwistTouch:
    """Turns in, control events out.

    Attributes
    ----------
    holding : bool
        Whether the device holds on.
    """

    def __init__(self, rules: TouchRules) -> None:
        """At rest; `rules` may be replaced at any time."""
        self.rules = rules
        self.holding = False
        self._rest: float | None = None
        self._armed = True
        self._rest_since: float | None = None
        self._theta2 = 0.0
        self._from = 0.0
        self._joined_at = 0.0
        self._led = False
        self._led_at = 0.0

    def step(
        self, turn: Turn, elsewhere: float | None, position: float, yields: bool = False
    ) -> Event | None:
        """The event of a turn, or None.

        `elsewhere`: theta2 of another hand that holds the disk, rad, and whether it `yields` to a
        turn; `position`: where the disk is, as theta2, rad.
        """
        if self._rest is None:
            self._rest = turn.theta2
        at_rest = turn.theta2 <= self.rules.rest
        if at_rest:
            self._rest = 0.0
            self._armed = True
        if not self.holding:
            if not self._engages(turn):
                return None
            self.holding = True
            self._rest_since = None
            self._begin(turn, position if elsewhere is None else elsewhere)
        elif self._releases(turn, at_rest):
            return self.release(turn.time_s)
        again = False
        if elsewhere is not None:
            # back towards rest is letting go, as a wheel's spring does
            self._led_at = min(self._led_at, turn.theta2) if self._led else turn.theta2
            self._led, self._theta2 = True, elsewhere
            again = yields and self._turned(turn, self._led_at)
            if again:
                self._begin(turn, elsewhere)
        else:
            if self._led:
                self._begin(turn, self._theta2)
            self._theta2 = turn.theta2 + (self._from - turn.theta2) * self._left(turn.time_s)
        return Event(turn.time_s, self._theta2, True, again)

    def release(self, time_s: float) -> Event | None:
        """Let go, whatever the rules say; None if nothing is held."""
        if not self.holding:
            return None
        self.holding = False
        self._led = False
        return Event(time_s, self._theta2, False)

    def _engages(self, turn: Turn) -> bool:
        if turn.touch is not None:
            return turn.touch
        assert self._rest is not None
        if turn.tapped and self.rules.by_tap:
            return True
        return self._armed and self._turned(turn, self._rest)

    def _turned(self, turn: Turn, since: float) -> bool:
        return turn.sure and abs(turn.theta2 - since) > self.rules.rest + self.rules.turn

    def _releases(self, turn: Turn, at_rest: bool) -> bool:
        if turn.touch is not None:
            return not turn.touch
        if turn.tapped and self.rules.by_tap:
            self._armed = False
            return True
        if not (at_rest and self.rules.by_rest):
            self._rest_since = None
            return False
        if self._rest_since is None:
            self._rest_since = turn.time_s
        return turn.time_s - self._rest_since >= self.rules.rest_s

    def _begin(self, turn: Turn, position: float) -> None:
        self._led = False
        self._from = max(0.0, min(HALF_TURN, position))
        self._joined_at = turn.time_s

    def _left(self, time_s: float) -> float:
        """Part of the way that is left between where it began and the device's angle."""
        since = time_s - self._joined_at
        if since >= self.rules.join_s:
            return 0.0
        done = since / self.rules.join_s
        return 1.0 - done * done * (3.0 - 2.0 * done)
