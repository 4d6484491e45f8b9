"""Bytes to samples with their times: detected, decoded, checked, stamped.

Samples that are missing or came twice, by their sequence numbers.
"""

from __future__ import annotations

from collections.abc import Iterable

from overview_dsp.devices.sensors.app_json import LONGEST
from overview_dsp.devices.sensors.clock import ArrivalClock, StampClock
from overview_dsp.devices.sensors.decoders import DetectedFormat, detect, detect_columns
from overview_dsp.devices.sensors.profile import DETECT, MOTOR_COLUMNS, Sensor
from overview_dsp.devices.sensors.reading import STAMPS, Counters, Decoder, Reading

MODULO = 1 << 16


class SequenceCheck:
    """Counts what is missing and drops what came twice; readings without a number pass."""

    def __init__(self, counters: Counters) -> None:
        """Counts in `counters`."""
        self._counters = counters
        self._last: int | None = None

    def pass_on(self, readings: Iterable[Reading]) -> list[Reading]:
        """The readings that are new."""
        return [reading for reading in readings if self._is_new(reading)]

    def _is_new(self, reading: Reading) -> bool:
        if "sequence" not in reading:
            return True
        number = int(reading["sequence"]) % MODULO
        last, self._last = self._last, number
        if last is None:
            return True
        step = (number - last) % MODULO
        if step == 0:
            self._counters.repeated += 1
            return False
        # half way round is no gap but a device that began again
        if step < MODULO // 2:
            self._counters.lost += step - 1
        return True


PATIENCE_S = 1.5
"""After so long without anything understood, a person is told what came."""

AGAIN_S = 0.2
"""What can't be detected is tried again so often, while more comes."""

Sample = tuple[float, Reading]
"""Time, s, and what was said then."""


class Stream:
    """What one sensor sends.

    Attributes
    ----------
    detected : DetectedFormat or None
        What it is, once that is known.
    problem : str
        Why it can't be detected; one line, empty if nothing is wrong.
    """

    def __init__(self, sensor: Sensor, counters: Counters) -> None:
        """Nothing has come yet; `counters` counts what is wrong."""
        self._counters = counters
        self._pending = bytearray()
        self._decoder: Decoder | None = None
        self._clock: StampClock | ArrivalClock | None = None
        self._sequence = SequenceCheck(counters)
        self._columns = sensor.columns
        self._began: float | None = None
        self._tried = -1e300
        self._accelerates = sensor.values["acceleration.unit"] != DETECT or (
            sensor.number("acceleration.scale") != 1.0
        )
        self.detected: DetectedFormat | None = None
        self.problem = ""
        form = sensor.values["stream.format"]
        # a motor's board speaks lines, or frames if it runs the surface itself
        if form == DETECT and self._columns and self._columns != MOTOR_COLUMNS:
            form = "text"
        if form != DETECT:
            self._know(DetectedFormat(form, self._columns))  # type: ignore[arg-type]

    def _know(self, detected: DetectedFormat) -> Decoder:
        self.detected = detected
        self.problem = ""
        self._decoder = detected.decoder(self._counters)
        return self._decoder

    def feed(self, data: bytes, arrival_s: float) -> list[Sample]:
        """The samples that these bytes complete; `arrival_s` is of any clock that goes forward."""
        if self._decoder is None:
            self._pending += data
            del self._pending[: -2 * LONGEST]
            self._began = arrival_s if self._began is None else self._began
            if self.problem and arrival_s - self._tried < AGAIN_S:
                self._counters.received_bytes += len(data)
                return []
            self._tried = arrival_s
            over = arrival_s - self._began >= PATIENCE_S
            found = (
                detect_columns(bytes(self._pending), self._columns, over)
                if self._columns
                else detect(bytes(self._pending), over, self._accelerates)
            )
            if not isinstance(found, DetectedFormat):
                self._counters.received_bytes += len(data)
                # said once: the next one would only show a later line
                self.problem = self.problem or found or ""
                return []
            self._counters.received_bytes -= len(self._pending) - len(data)
            readings = self._know(found).feed(bytes(self._pending))
            self._pending.clear()
            if readings and not any(name in readings[-1] for name in STAMPS):
                readings = readings[-1:]  # when the earlier ones came isn't known
        else:
            readings = self._decoder.feed(data)
        return self._timed(self._sequence.pass_on(readings), arrival_s)

    def _timed(self, readings: list[Reading], arrival_s: float) -> list[Sample]:
        if not readings:
            return []
        if self._clock is None:
            stamped = any(name in readings[0] for name in STAMPS)
            self._clock = StampClock(self._counters) if stamped else ArrivalClock()
        times = self._clock.times(readings, arrival_s)
        return [(at, one) for at, one in zip(times, readings, strict=True) if at is not None]
