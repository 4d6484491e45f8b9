"""Received bytes to samples with times: detection, decoding, sequence check and clock."""

from __future__ import annotations

import math
from collections.abc import Sequence

from overview_dsp.devices.sensors.app_json import LONGEST
from overview_dsp.devices.sensors.decoders import DetectedFormat, detect, detect_columns
from overview_dsp.devices.sensors.profile import DETECT, MOTOR_COLUMNS, Sensor
from overview_dsp.devices.sensors.reading import STAMPS, Counters, Decoder, Reading

UNITS_S = {"t_us": 1e-6, "t_ms": 1e-3, "t_s": 1.0}
WRAP = 1 << 32  # a clock in micro- or milliseconds wraps to 0 at this count

LONGEST_GAP_S = 10.0
"""A longer step of a sensor's clock, or a step back, means that the device has restarted."""

LEARNING_S = 0.5
LEARNING_SAMPLES = 8
LOOP_HZ = 0.5  # bandwidth of the loop that removes the jitter of arrival times
LATE_S = 0.25  # a delay beyond this is an interruption, not jitter


class StampClock:
    """The sensor's own clock, unwrapped.

    A stamp slightly before the previous one belongs to a sample out of order, which is dropped. A
    stamp far before or far after it means that the device has restarted; the time then continues.
    """

    def __init__(self, counters: Counters) -> None:
        """Count wraps, restarts and samples out of order in `counters`."""
        self._counters = counters
        self._last: float | None = None
        self._time = 0.0

    def times(self, readings: Sequence[Reading], arrival_s: float) -> list[float | None]:
        """Return the time of each reading, s from the first; None for one to drop."""
        return [self._next(reading) for reading in readings]

    def _next(self, reading: Reading) -> float | None:
        name = next((name for name in STAMPS if name in reading), None)
        if name is None:  # a JSON line may lack its stamp
            return None
        raw, unit = reading[name], UNITS_S[name]
        if self._last is None:
            self._last = raw
            return 0.0
        step = raw - self._last
        if name != "t_s" and step < -WRAP / 2:
            step += WRAP
            self._counters.clock_wraps += 1
        seconds = step * unit
        if seconds == 0.0:
            self._counters.repeated += 1
            return None
        if -1.0 < seconds < 0.0 and raw > 1.0 / unit:
            self._counters.disordered += 1
            return None
        self._last = raw
        if not 0.0 < seconds <= LONGEST_GAP_S:
            self._counters.clock_restarts += 1
            seconds = 0.0
        # a time never repeats
        self._time = max(self._time + seconds, math.nextafter(self._time, math.inf))
        return self._time


class ArrivalClock:
    """Times of samples without a stamp: a delay-locked loop on their arrival times.

    Samples that arrive together are taken as evenly spaced. After half a second their rate is
    known, and a second-order loop of 0.5 Hz follows it (F. Adriaensen, "Using a DLL to filter
    time", 2005).
    """

    def __init__(self) -> None:
        self._first: float | None = None
        self._count = 0
        self._time = 0.0
        self._period: float | None = None

    def times(self, readings: Sequence[Reading], arrival_s: float) -> list[float | None]:
        """Return the time of each reading, s of the clock of `arrival_s`."""
        count = len(readings)
        if not count:
            return []
        before = self._time
        if self._first is None:
            self._first = self._time = before = arrival_s
        elif self._period is None:
            self._count += count
            self._time = max(arrival_s, before)
            since = self._time - self._first
            if since >= LEARNING_S and self._count >= LEARNING_SAMPLES:
                self._period = since / self._count
        else:
            self._time = self._follow(count, self._period, arrival_s)
            # delayed samples were taken shortly before the last one
            before = max(before, self._time - count * self._period)
        step = (self._time - before) / count
        return [min(before + step * n, self._time) for n in range(1, count + 1)]

    def _follow(self, count: int, period: float, arrival_s: float) -> float:
        elapsed = count * period
        expected = self._time + elapsed
        error = arrival_s - expected
        if abs(error) > LATE_S:
            return max(arrival_s, self._time)
        gain = min(2.0 * math.pi * LOOP_HZ * elapsed, 0.5)
        self._period = period + gain * gain * error / count
        return max(expected + math.sqrt(2.0) * gain * error, self._time + 0.1 * elapsed)


MODULO = 1 << 16  # of a sequence number
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
        self._number: int | None = None
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
        readings = [reading for reading in readings if self._is_new(reading)]
        if not readings:
            return []
        if self._clock is None:
            stamped = any(name in readings[0] for name in STAMPS)
            self._clock = StampClock(self._counters) if stamped else ArrivalClock()
        times = self._clock.times(readings, arrival_s)
        return [(at, one) for at, one in zip(times, readings, strict=True) if at is not None]

    def _is_new(self, reading: Reading) -> bool:
        """Return whether a reading isn't a repetition; count the missing ones before it."""
        if "sequence" not in reading:
            return True
        last, self._number = self._number, int(reading["sequence"]) % MODULO
        if last is None:
            return True
        step = (self._number - last) % MODULO
        if step == 0:
            self._counters.repeated += 1
            return False
        # a step of half the range or more means that the device has restarted
        if step < MODULO // 2:
            self._counters.lost += step - 1
        return True

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
