"""A sensor in a hand: bytes in, control events out; opens no device.

What is wrong with a stream, in words, each said once.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import Any

from overview_dsp.devices.sensors.angles import Angle, InertialAngle, Turn, angle_of
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.reading import Counters
from overview_dsp.devices.sensors.stream import Sample, Stream
from overview_dsp.devices.sensors.touching import Event, TouchRules, TwistTouch
from overview_dsp.errors import InputError
from overview_dsp.units import HALF_TURN

FOLLOWING = 6.0
"""Where a knob's own board moves the disk, the disk here is pulled as that one is: theta2 is where
its spring rests, and so much further for each radian that the disk here lies behind. Then both
cross an event together, and ear and hand agree."""

CLOSEST_S = 0.9e-3
"""Events closer together than a millisecond move the disk no differently."""


class SensorSource:
    """One sensor.

    Attributes
    ----------
    counters : Counters
        What came and what was wrong with it.
    turn : Turn or None
        The last one.
    heard : tuple of Sample
        What the bytes fed last said.
    """

    def __init__(self, sensor: Sensor, rules: TouchRules, counters: Counters | None = None) -> None:
        """Nothing has come yet; `counters` go on from those of a connection before."""
        self.counters = Counters() if counters is None else counters
        self.turn: Turn | None = None
        self.heard: tuple[Sample, ...] = ()
        self._sensor = sensor
        self._stream = Stream(sensor, self.counters)
        self._touch = TwistTouch(rules)
        self._angle: Angle | None = None
        self._messages: deque[str] = deque()
        self._said: set[str] = set()
        self._words = ""
        self._stopped = False
        self._follows = False  # a disk that a knob's own board moves
        self._event_at = -1e300

    @property
    def rules(self) -> TouchRules:
        """When it holds the disk."""
        return self._touch.rules

    @rules.setter
    def rules(self, rules: TouchRules) -> None:
        self._touch.rules = rules

    @property
    def holding(self) -> bool:
        """Whether it holds the disk."""
        return self._touch.holding

    def feed(
        self,
        data: bytes,
        arrival_s: float,
        elsewhere: float | None = None,
        position: float = 0.0,
        yields: bool = False,
    ) -> list[Event]:
        """The events that these bytes make.

        `arrival_s`: when they came, s of any clock that goes forward; `elsewhere`, `position` and
        `yields` as `TwistTouch.step`. Event times are of the sensor's clock, or of `arrival_s`'s
        where the sensor has none.
        """
        events = []
        self.heard = tuple(self._stream.feed(data, arrival_s))
        for sample in self.heard:
            event = self._event(sample, elsewhere, position, yields)
            if event is not None:
                events.append(event)
        if self._stream.problem:
            self._say(self._stream.problem)
        return events

    def release(self) -> Event | None:
        """Let go: the sensor is lost, say."""
        return self._touch.release(self.turn.time_s if self.turn is not None else 0.0)

    def take_messages(self) -> tuple[str, ...]:
        """What a person should know, new since the last call; each is said once."""
        messages = tuple(self._messages)
        self._messages.clear()
        return messages

    def report(self) -> dict[str, Any]:
        """How it stands: what it is, its angle, every counter."""
        turn = self.turn
        return {
            "told": str(self._stream.detected) if self._stream.detected is not None else None,
            "state": self._words,
            "theta2_rad": None if turn is None else round(turn.theta2, 6),
            "holding": self.holding,
            **vars(self.counters),
        }

    def _event(
        self, sample: Sample, elsewhere: float | None, position: float, yields: bool
    ) -> Event | None:
        time_s, reading = sample
        self._follows = reading.get("knob_level", self._follows) > 0.0
        if self._stopped:
            return None
        try:
            if self._angle is None:
                detected = self._stream.detected
                binary = detected is not None and detected.format == "frames"
                sensor = self._sensor if detected is None else self._sensor.told(detected.values)
                self._angle = angle_of(sensor, binary, reading, self.counters)
                if self._angle is None:
                    return None
            turn = self._angle.step(time_s, reading)
        except InputError as error:
            self._stopped = True
            self._say(str(error))
            return None
        self._watch(self._angle)
        if turn is None:
            return None
        self.turn = turn
        if isinstance(self._angle, InertialAngle) and self._angle.frozen:
            return self._touch.release(time_s)
        was = self._touch.holding
        event = self._touch.step(turn, elsewhere, position, yields)
        if event is None:
            return None
        if was == event.touching and not event.again and time_s - self._event_at < CLOSEST_S:
            return None
        self._event_at = time_s
        if self._follows and "surface_rad" in reading and event.touching and elsewhere is None:
            surface = reading["surface_rad"]
            rest = surface + reading["stretch_rad"] + FOLLOWING * (surface - position)
            return replace(event, theta2=max(0.0, min(HALF_TURN, rest)))
        return event

    def _watch(self, angle: Angle) -> None:
        if angle.words != self._words:
            self._words = angle.words
            self._say(self._words)
        if not angle.taps and not self.rules.by_rest:
            self._say('this sensor feels no taps: choose twist.release = "rest"')
        if isinstance(angle, InertialAngle):
            if angle.complaint:
                self._say(f"{angle.complaint} (sensor=FILE.toml, [angular_velocity], [axes])")
            if angle.frozen:
                self._say(
                    "the sensor says the very same for 2 s: it has stopped; the disk is let go"
                )
            elif angle.roll.steep:
                self._say("the device points up or down, where a roll can't be known: "
                          "the position is held until it is flatter")  # fmt: skip

    def _say(self, message: str) -> None:
        if message not in self._said:
            self._said.add(message)
            self._messages.append(message)


LINES = {
    "damaged": "frames or lines come damaged: a loose cable, noise or another speed (baud=)?",
    "lost": "samples are missing by their numbers: the device or its port is overloaded",
    "implausible": "samples beyond what a hand does were dropped",
    "disordered": "samples came out of order and were dropped",
    "repeated": "samples came twice; each was taken once",
    "clock_restarts": "the device's clock began again",
    "overrun_bytes": "more comes than can be read; the oldest is given up",
}
"""By counter; the rest of them is nothing to mend."""


class Diagnostics:
    """Reports each fault that counters show, once."""

    def __init__(self) -> None:
        self._said: set[str] = set()

    def new(self, counters: Counters) -> list[str]:
        """A line for each counter of `LINES` that has left zero since the last call."""
        new = [name for name in LINES if name not in self._said and getattr(counters, name)]
        self._said.update(new)
        return [f"{LINES[name]} (counted on)" for name in new]
