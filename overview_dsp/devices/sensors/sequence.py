"""Samples that are missing or came twice, by their sequence numbers."""

from __future__ import annotations

from collections.abc import Iterable

from overview_dsp.devices.sensors.reading import Counters, Reading

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
