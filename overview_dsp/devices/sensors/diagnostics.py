"""What is wrong with a stream, in words, each said once."""

from __future__ import annotations

from overview_dsp.devices.sensors.reading import Counters

LINES = {
    "damaged": "frames or lines come damaged: a loose cable, noise or another speed (--baud)?",
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
