"""Monotonic times of samples, in seconds."""

from __future__ import annotations

import math
from collections.abc import Sequence

from overview_dsp.devices.sensors.reading import STAMPS, Counters, Reading

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
