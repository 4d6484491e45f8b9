"""Cost of a second of sound as the work grows: duration, events, table, rate; and memory.

Each series is compared with its first entry, in rounds in turn.
"""

from __future__ import annotations

import itertools
import re
import resource
import statistics
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.design.gestures import sweep
from overview_dsp.design.presets.library import load_preset
from overview_dsp.errors import OverviewWarning
from overview_dsp.measure.bench import feed, prepared
from overview_dsp.signal.engine.engine import Engine
from tools.bench.disk import Disk
from tools.bench.table_sizes import SIZES, TableOf

ROOT = Path(__file__).resolve().parents[2]
BLOCK = 4096
SWEEP_S = 4.0
DURATIONS = (1, 15, 150, 900)
"""Numbers of sweeps of `SWEEP_S`, each with the rest at its end: 4 s to an hour."""
WARM_REPEATS = 100
MEASURED_S = 100.0
"""Least duration of sound for one figure."""

EVENTS = (10, 100, 1_000, 10_000, 100_000)
RATES = (8_000, 24_000, 48_000, 96_000, 192_000)
EVENTS_SWEEP_S = 8.0


@dataclass(frozen=True)
class Cost:
    """Cost of a second of sound, relative to the series' first entry: median, lowest, highest.

    `strikes` is the number of strikes of the surface, if there is one.
    """

    series: str
    entry: str
    ratio: float
    low: float
    high: float
    strikes: int


@dataclass(frozen=True)
class Case:
    """Entry of a series; `run` returns the CPU time (s) for one second of sound."""

    entry: str
    run: Callable[[], float]
    strikes: int = 0
    warmed: bool = True
    """Whether it runs once before; a long entry needs no warm-up."""

    @classmethod
    def of(cls, entry: str, engine: Engine, sweep_s: float, repeats: int = 1) -> Case:
        """Return a case that measures the median cost of an engine's sweeps."""
        times = max(1, round(MEASURED_S / (repeats * sweep_s)))

        def run() -> float:
            found = (costs_of(engine, sweep_s, repeats) for _ in range(times))
            return statistics.median(itertools.chain.from_iterable(found))

        return cls(entry, run, len(engine.surface.position), repeats < WARM_REPEATS)


def costs_of(engine: Engine, sweep_s: float, repeats: int = 1) -> list[float]:
    """Return the CPU time (s) for one second of each of `repeats` sweeps over the timeline."""
    gesture = sweep(sweep_s)
    out = np.zeros((BLOCK, 2), dtype=np.float32)
    blocks = round(gesture.duration_s * engine.sample_rate / BLOCK)
    engine.reset()
    found = []
    for _ in range(repeats):
        feed(engine, gesture)
        started = time.thread_time()
        for _ in range(blocks):
            engine.process(out)
        found.append((time.thread_time() - started) / (blocks * BLOCK / engine.sample_rate))
    return found


def evenly(count: int) -> Timeline:
    """Return a timeline with fouls at even distances."""
    times = (np.arange(count) + 0.5) * (5_400.0 / count)
    events = tuple(Event(float(time), "foul") for time in times)
    return Timeline(f"{count} events", 5_400.0, events)


def series(name: str, cases: list[Case], rounds: int, step: Callable[[], None]) -> list[Cost]:
    """Measure the cases in turn, round after round."""
    found: list[list[float]] = [[] for _ in cases]
    for round_ in range(rounds + 1):
        for case, spent in zip(cases, found, strict=True):
            if round_ > 0:
                spent.append(case.run())
            elif case.warmed:
                case.run()
            step()
    costs = []
    for case, spent in zip(cases, found, strict=True):
        ratios = [one / other for one, other in zip(spent, found[0], strict=True)]
        middle = statistics.median(ratios)
        costs.append(Cost(name, case.entry, middle, min(ratios), max(ratios), case.strikes))
    return costs


def measure(
    rounds: int, longest_s: float = 3600.0, progress: Callable[[float], None] | None = None
) -> list[Cost]:
    """Measure all series, with durations up to `longest_s`."""
    engine = prepared(frames=BLOCK)
    durations = [
        Case.of(f"{count * SWEEP_S:g} s", engine, SWEEP_S, count)
        for count in DURATIONS
        if count * SWEEP_S <= longest_s
    ]
    crowded = []
    for count in EVENTS:
        with warnings.catch_warnings():
            # that strikes are merged is stated in the table
            warnings.simplefilter("ignore", OverviewWarning)
            engine_of_events = prepared(evenly(count), load_preset("football"), frames=BLOCK)
        crowded.append(Case.of(f"{count} events", engine_of_events, EVENTS_SWEEP_S))
    rates = [Case.of(f"{rate} Hz", prepared(rate=rate, frames=BLOCK), 4.0) for rate in RATES]
    disk = Disk.of(engine)
    tables = [Case(f"{n} cells", TableOf(n, engine, disk).cost) for n in SIZES]
    done, steps = 0, (rounds + 1) * sum(map(len, (durations, crowded, rates, tables)))

    def step() -> None:
        nonlocal done
        done += 1
        if progress:
            progress(done / steps)

    return [
        *series("duration", durations, rounds, step),
        *series("events", crowded, rounds, step),
        *series("the disk on a table of", tables, rounds, step),
        *_per_sample(series("cost of a sample at", rates, rounds, step)),
    ]


def _per_sample(costs: list[Cost]) -> list[Cost]:
    """Convert costs of a second to costs of a sample, for the series of sample rates."""
    return [
        replace(cost, ratio=cost.ratio * part, low=cost.low * part, high=cost.high * part)
        for cost, part in zip(costs, (RATES[0] / rate for rate in RATES), strict=True)
    ]


@dataclass(frozen=True)
class Memory:
    """Highest resident memory (MB): with an engine ready, and after streaming for `seconds`."""

    ready_mb: float
    seconds: float
    streamed_mb: float


def memory(seconds: float) -> Memory:
    """Stream sweeps in blocks, in a new process, so that only the stream uses its memory."""
    command = [sys.executable, "-m", "tools.bench.scaling", str(seconds)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    ready, streamed = map(float, done.stdout.split())
    return Memory(ready, seconds, streamed)


def stream(seconds: float) -> tuple[float, float]:
    """Return the highest resident memory (MB) before and after a stream."""
    engine = prepared(frames=BLOCK)
    costs_of(engine, SWEEP_S)
    ready = peak_mb()
    costs_of(engine, SWEEP_S, max(1, round(seconds / SWEEP_S)))
    return ready, peak_mb()


def peak_mb() -> float:
    """Return the process's highest resident memory so far, MB."""
    status = Path("/proc/self/status")
    if status.exists():
        # getrusage may report the parent's memory, from before this program was loaded
        found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text())
        if found:
            return int(found[1]) * 1024 / 1e6
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


if __name__ == "__main__":
    print(*stream(float(sys.argv[1])))
