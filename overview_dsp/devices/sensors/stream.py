"""Received bytes to samples with times: detection, decoding, sequence check and clock."""

from __future__ import annotations

from overview_dsp.devices.sensors.app_json import LONGEST
from overview_dsp.devices.sensors.clock import ArrivalClock, StampClock
from overview_dsp.devices.sensors.decoders import DetectedFormat, detect, detect_columns
from overview_dsp.devices.sensors.profile import DETECT, MOTOR_COLUMNS, Sensor
from overview_dsp.devices.sensors.reading import STAMPS, Counters, Decoder, Reading

MODULO = 1 << 16


class SequenceCheck:
    """Counts missing samples and drops repeated ones; readings without a number pass."""

    def __init__(self, counters: Counters) -> None:
        self._counters = counters
        self._last: int | None = None

    def is_new(self, reading: Reading) -> bool:
        """Return whether a reading isn't a repetition; count the missing ones before it."""
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
        # a step of half the range or more means that the device has restarted
        if step < MODULO // 2:
            self._counters.lost += step - 1
        return True


TIMEOUT_S = 1.5  # time without valid data after which the stream is reported
RETRY_S = 0.2  # time between attempts to detect a stream that was reported
Sample = tuple[float, Reading]  # time, s, and reading


class Stream:
    """Decoder of one sensor's stream.

    `detected`: its format, once known. `problem`: why it can't be detected, in one line, or empty.
    """

    def __init__(self, sensor: Sensor, counters: Counters) -> None:
        """Decode data of `sensor` and count faults in `counters`."""
        self._counters = counters
        self._pending = bytearray()
        self._decoder: Decoder | None = None
        self._clock: StampClock | ArrivalClock | None = None
        self._sequence = SequenceCheck(counters)
        self._columns = sensor.columns
        self._began: float | None = None
        self._tried = -1e300
        self._acceleration_known = sensor.values["acceleration.unit"] != DETECT or (
            sensor.number("acceleration.scale") != 1.0
        )
        self.detected: DetectedFormat | None = None
        self.problem = ""
        form = sensor.values["stream.format"]
        # a motor's board sends lines, or frames if it runs the surface itself
        if form == DETECT and self._columns and self._columns != MOTOR_COLUMNS:
            form = "text"
        if form != DETECT:
            self._decode_as(DetectedFormat(str(form), self._columns))

    def _decode_as(self, detected: DetectedFormat) -> Decoder:
        self.detected = detected
        self.problem = ""
        self._decoder = detected.decoder(self._counters)
        return self._decoder

    def feed(self, data: bytes, arrival_s: float) -> list[Sample]:
        """Return the samples that these bytes complete; `arrival_s` is of any monotonic clock."""
        if self._decoder is None:
            readings = self._detect(data, arrival_s)
        else:
            readings = self._decoder.feed(data)
        readings = [reading for reading in readings if self._sequence.is_new(reading)]
        if not readings:
            return []
        if self._clock is None:
            stamped = any(name in readings[0] for name in STAMPS)
            self._clock = StampClock(self._counters) if stamped else ArrivalClock()
        times = self._clock.times(readings, arrival_s)
        return [(at, one) for at, one in zip(times, readings, strict=True) if at is not None]

    def _detect(self, data: bytes, arrival_s: float) -> list[Reading]:
        self._pending += data
        del self._pending[: -2 * LONGEST]
        self._began = arrival_s if self._began is None else self._began
        if self.problem and arrival_s - self._tried < RETRY_S:
            self._counters.received_bytes += len(data)
            return []
        self._tried = arrival_s
        timed_out = arrival_s - self._began >= TIMEOUT_S
        found = (
            detect_columns(bytes(self._pending), self._columns, timed_out)
            if self._columns
            else detect(bytes(self._pending), timed_out, self._acceleration_known)
        )
        if not isinstance(found, DetectedFormat):
            self._counters.received_bytes += len(data)
            # the first report stays: a later one would differ only in the line it quotes
            self.problem = self.problem or found or ""
            return []
        self._counters.received_bytes -= len(self._pending) - len(data)
        readings = self._decode_as(found).feed(bytes(self._pending))
        self._pending.clear()
        if readings and not any(name in readings[-1] for name in STAMPS):
            readings = readings[-1:]  # the arrival times of the earlier ones aren't known
        return readings
