"""Input from one sensor: received bytes become control events; opens no device.

Faults of the stream are reported as text, each once.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from overview_dsp.devices.messages import Messages
from overview_dsp.devices.sensors.angles import Angle, InertialAngle, make_angle
from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.reading import AngleSample, Counters
from overview_dsp.devices.sensors.stream import Sample, Stream
from overview_dsp.devices.sensors.touch_detection import (
    FREE_DISK,
    DiskState,
    Event,
    TouchRules,
    TwistTouch,
)
from overview_dsp.errors import InputError
from overview_dsp.files.toml import load_toml
from overview_dsp.units import HALF_TURN

FOLLOW_GAIN = 2.0
"""Gain by which the disk here follows the disk on a knob's own board. Theta2 is the rest position
of that disk's spring, plus this gain for each radian that the disk here lies behind. So both disks
pass an event at the same time, and sound and force agree. A higher gain lets a stiff disk swing."""

SHORTEST_S = 0.9e-3  # events closer together than a millisecond don't change the disk's movement


class SensorSource(Messages):
    """One sensor.

    `counters` has received data and faults, `angle` is the latest, `samples` are those fed last.
    `rules`, by which it touches and releases the disk, may be replaced at any time.
    """

    def __init__(self, sensor: Sensor, rules: TouchRules, counters: Counters | None = None) -> None:
        """Start without data; `counters` may be those of an earlier connection."""
        super().__init__()
        self.counters = Counters() if counters is None else counters
        self.angle: AngleSample | None = None
        self.samples: tuple[Sample, ...] = ()
        self._sensor = sensor
        self._stream = Stream(sensor, self.counters)
        self.rules = rules
        self._touch = TwistTouch(rules)
        self._converter: Angle | None = None
        self._status = ""
        self._stopped = False
        self._board_moves_disk = False
        self._event_at = -1e300

    @property
    def holding(self) -> bool:
        """True while it holds the disk."""
        return self._touch.holding

    def feed(self, data: bytes, arrival_s: float, disk: DiskState = FREE_DISK) -> list[Event]:
        """Return the control events that these bytes make.

        `arrival_s` is of any monotonic clock. Events have the time of the sensor's clock, or of
        this one.
        """
        self.samples = tuple(self._stream.feed(data, arrival_s))
        events = [self._event(sample, disk) for sample in self.samples]
        if self._stream.problem:
            self.say_once(self._stream.problem)
        return [event for event in events if event is not None]

    def release(self) -> Event | None:
        """Release the disk, for example because the sensor is disconnected."""
        return self._touch.release(self.angle.time_s if self.angle is not None else 0.0)

    def report(self) -> dict[str, Any]:
        """Return format, status, angle and all counters."""
        angle, detected = self.angle, self._stream.detected
        return {
            "format": None if detected is None else str(detected),
            "state": self._status,
            "theta2_rad": None if angle is None else round(angle.theta2, 6),
            "holding": self.holding,
            **vars(self.counters),
        }

    def _event(self, sample: Sample, disk: DiskState) -> Event | None:
        time_s, reading = sample
        self._board_moves_disk = reading.get("knob_level", self._board_moves_disk) > 0.0
        if self._stopped:
            return None
        try:
            if self._converter is None:
                detected = self._stream.detected
                binary = detected is not None and detected.format == "frames"
                values = {} if detected is None else detected.values
                sensor = self._sensor.with_defaults(values)
                self._converter = make_angle(sensor, binary, reading, self.counters)
                if self._converter is None:
                    return None
            angle = self._converter.step(time_s, reading)
        except InputError as error:
            self._stopped = True
            self.say_once(str(error))
            return None
        self._report_faults(self._converter)
        if angle is None:
            return None
        self.angle = angle
        if isinstance(self._converter, InertialAngle) and self._converter.frozen:
            return self._touch.release(time_s)
        was = self._touch.holding
        self._touch.rules = self.rules
        event = self._touch.step(angle, disk)
        if event is None:
            return None
        if was == event.touching and not event.retouch and time_s - self._event_at < SHORTEST_S:
            return None
        self._event_at = time_s
        follows = self._board_moves_disk and "surface_rad" in reading
        if follows and event.touching and disk.elsewhere is None:
            surface = reading["surface_rad"]
            rest = surface + reading["stretch_rad"] + FOLLOW_GAIN * (surface - disk.position)
            return replace(event, theta2=max(0.0, min(HALF_TURN, rest)))
        return event

    def _report_faults(self, converter: Angle) -> None:
        if converter.status != self._status:
            self._status = converter.status
            self.say_once(self._status)
        if not converter.detects_taps and not self.rules.by_rest:
            self.say_once('this sensor cannot detect taps: choose twist.release = "rest"')
        if not isinstance(converter, InertialAngle):
            return
        if converter.gyroscope_fault:
            self.say_once(converter.gyroscope_fault)
        if converter.frozen:
            self.say_once("the sensor's readings have not changed for 2 s: it has stopped; the "
                         "disk is released")  # fmt: skip
        elif converter.roll.steep:
            self.say_once("the device points up or down, where the roll is unknown: the position "
                         "is held until the device is flatter")  # fmt: skip


FAULTS: dict[str, str] = load_toml(__file__, "faults.toml")
"""Messages by counter; the other counters need no action."""
