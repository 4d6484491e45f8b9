"""Touch detection for devices without a touch sensor: when a twist holds and releases the disk.

- A turn away from rest touches. Rest is face up, or a knob's angle at the start.
- A short time back at rest releases, or a tap-tap does (`twist.release`).
- After a tap-tap, another tap-tap touches at the present angle. A turn does so only after a rest.

Where one input takes the disk over from another, the disk never jumps. Theta2 starts where the disk
(or the input that holds it) is, and moves to the device's own angle within `twist.blend_ms`. While
another input holds the disk, the device follows that input, so that it can take over at its
position. It takes over when that input releases. An input without a touch sensor may never release:
from such an input it also takes over when the device is turned further away from rest, by as much
as a touch needs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from overview_dsp.design.presets.model import Preset
from overview_dsp.devices.sensors.reading import AngleSample
from overview_dsp.units import HALF_TURN


@dataclass(frozen=True)
class TouchRules:
    """Rules of a preset's `twist` section: angles in rad, times in s."""

    by_rest: bool
    by_tap: bool
    rest: float
    turn: float
    rest_s: float
    join_s: float

    @classmethod
    def of(cls, preset: Preset) -> TouchRules:
        """Return the rules of a preset."""
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

    `retouch`: the disk is released and touched at once, which makes this the latest of several
    inputs. `scheduled_s`: time at which it applies, s of the monotonic clock; None: by `time_s`.
    """

    time_s: float
    theta2: float
    touching: bool
    retouch: bool = False
    scheduled_s: float | None = None


class DiskState(NamedTuple):
    """Disk as one source sees it.

    `elsewhere` is theta2 (rad) of another source that touches the disk, or None. `position` is the
    disk's position as theta2 (rad). `yields` is whether a turn takes the disk over from the other
    source.
    """

    elsewhere: float | None = None
    position: float = 0.0
    yields: bool = False


FREE_DISK = DiskState()


class TwistTouch:
    """Control events from the angles of one device.

    `rules` may be replaced at any time. `holding`: whether the device holds the disk.
    """

    def __init__(self, rules: TouchRules) -> None:
        self.rules = rules
        self.holding = False
        self._rest: float | None = None
        self._armed = True
        self._rest_since: float | None = None
        self._theta2 = 0.0
        self._from = 0.0
        self._joined_at = 0.0
        self._following = False
        self._follow_from = 0.0

    def step(self, angle: AngleSample, disk: DiskState) -> Event | None:
        """Return the control event of an angle, if any."""
        if self._rest is None:
            self._rest = angle.theta2
        at_rest = angle.theta2 <= self.rules.rest
        if at_rest:
            self._rest = 0.0
            self._armed = True
        if not self.holding:
            if not self._touches(angle, self._rest):
                return None
            self.holding = True
            self._rest_since = None
            self._start_from(angle, disk.position if disk.elsewhere is None else disk.elsewhere)
        elif self._releases(angle, at_rest):
            return self.release(angle.time_s)
        retouch = False
        if disk.elsewhere is not None:
            # a turn back towards rest moves the start of the next takeover
            self._follow_from = (
                min(self._follow_from, angle.theta2) if self._following else angle.theta2
            )
            self._following, self._theta2 = True, disk.elsewhere
            retouch = disk.yields and self._turned(angle, self._follow_from)
            if retouch:
                self._start_from(angle, disk.elsewhere)
        else:
            if self._following:
                self._start_from(angle, self._theta2)
            remaining = self._remaining(angle.time_s)
            self._theta2 = angle.theta2 + (self._from - angle.theta2) * remaining
        return Event(angle.time_s, self._theta2, True, retouch)

    def release(self, time_s: float) -> Event | None:
        """Release the disk without regard to the rules; None if the device doesn't hold it."""
        if not self.holding:
            return None
        self.holding = False
        self._following = False
        return Event(time_s, self._theta2, False)

    def _touches(self, angle: AngleSample, rest: float) -> bool:
        if angle.touch is not None:
            return angle.touch
        if angle.tapped and self.rules.by_tap:
            return True
        return self._armed and self._turned(angle, rest)

    def _turned(self, angle: AngleSample, since: float) -> bool:
        return angle.reliable and abs(angle.theta2 - since) > self.rules.rest + self.rules.turn

    def _releases(self, angle: AngleSample, at_rest: bool) -> bool:
        if angle.touch is not None:
            return not angle.touch
        if angle.tapped and self.rules.by_tap:
            self._armed = False
            return True
        if not (at_rest and self.rules.by_rest):
            self._rest_since = None
            return False
        if self._rest_since is None:
            self._rest_since = angle.time_s
        return angle.time_s - self._rest_since >= self.rules.rest_s

    def _start_from(self, angle: AngleSample, theta2: float) -> None:
        self._following = False
        self._from = max(0.0, min(HALF_TURN, theta2))
        self._joined_at = angle.time_s

    def _remaining(self, time_s: float) -> float:
        """Return the remaining share of the way from the start to the device's own angle."""
        since = time_s - self._joined_at
        if since >= self.rules.join_s:
            return 0.0
        done = since / self.rules.join_s
        return 1.0 - done * done * (3.0 - 2.0 * done)
