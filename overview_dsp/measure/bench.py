"""Speed of the engine on this machine: seconds of sound that one second of processor time makes.

The work is the bundled match under a sweep of 4 s, with its recoil. Contenders run in turn, round
after round, so that ratios hold although the machine's speed drifts. Times are the thread's own
(CPU time), so that other work on the machine counts as little as it can.
"""

from __future__ import annotations

import os
import platform
import re
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np

from overview_dsp.arrays import FloatArray
from overview_dsp.data.readers import bundled_timeline
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture, sweep
from overview_dsp.design.presets.library import load_preset
from overview_dsp.design.presets.model import Preset
from overview_dsp.kernels import layout
from overview_dsp.kernels.simd.vector import SIMD_WIDTH
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.offline.rendering.many import usable_cores
from overview_dsp.public import counted
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.engine.simd_batch import EngineBatch

RATE = 48_000
SWEEP_S = 4.0
SECONDS = 8.0  # duration of the sound of one run of the full voice
BLOCK = 64
LANE_BLOCK = 16384
INTERPRETED_S = 0.1
LINKS = 2_000_000  # length of a chain of dependent steps, which takes some milliseconds
CHAINS = 9  # chains that are timed; the fastest gives the clock rate
VOICE, DISK = "the full voice", "the disk alone"


@dataclass(frozen=True)
class Contender:
    """A program that is timed; all of a `group` do the same work. `run` returns its speed."""

    group: str
    name: str
    run: Callable[[], float]


@dataclass(frozen=True)
class Row:
    """A contender's speed (x realtime) and its ratio to the first of its group, round by round.

    Medians over rounds, each with the lowest and highest.
    """

    group: str
    name: str
    speed: float
    low: float
    high: float
    ratio: float
    ratio_low: float
    ratio_high: float


@dataclass(frozen=True)
class Report:
    """Rows of the contenders. `ghz`: the processor's clock."""

    rounds: int
    rows: list[Row]
    ghz: float


def measure(rounds: int = 7, progress: Callable[[float], None] | None = None) -> Report:
    """Measure the speed of the engine itself, without the programs it is compared with."""
    return Report(rounds, run_in_turn(contenders(), rounds, progress), clock_ghz())


def timed(seconds: float, work: Callable[[], object]) -> float:
    """Run `work`, which makes `seconds` of sound; return seconds of sound in one second."""
    started = time.thread_time()
    work()
    return seconds / (time.thread_time() - started)


def run_in_turn(
    contenders: Sequence[Contender], rounds: int, progress: Callable[[float], None] | None = None
) -> list[Row]:
    """Run every contender once to warm up, then `rounds` times in turn."""
    found: list[list[float]] = [[] for _ in contenders]
    for round_ in range(rounds + 1):
        for contender, speeds in zip(contenders, found, strict=True):
            speed = contender.run()
            if round_ > 0:
                speeds.append(speed)
        if progress:
            progress((round_ + 1) / (rounds + 1))
    first: dict[str, list[float]] = {}
    rows = []
    for contender, speeds in zip(contenders, found, strict=True):
        base = first.setdefault(contender.group, speeds)
        ratios = [speed / other for speed, other in zip(speeds, base, strict=True)]
        summaries = statistics.median, min, max
        figures = (summary(each) for each in (speeds, ratios) for summary in summaries)
        rows.append(Row(contender.group, contender.name, *figures))
    return rows


def prepared(
    timeline: Timeline | None = None,
    preset: Preset | None = None,
    rate: float = RATE,
    frames: int = round(SECONDS * RATE),
    memory: FloatArray | None = None,
) -> Engine:
    """Return an engine ready for blocks of up to `frames`."""
    engine = Engine(preset or load_preset("football"), timeline or bundled_timeline())
    engine.prepare(rate, frames, memory=memory)
    return engine


def feed(engine: Engine, gesture: Gesture) -> None:
    """Queue a gesture's control events; the gesture starts at the present sample."""
    now = engine.sample_time
    for stamp, theta2, touching in zip(
        gesture.stamps(engine.sample_rate), gesture.theta2, gesture.touching, strict=True
    ):
        engine.control(float(theta2), bool(touching), now + int(stamp))


def reset_and_feed(engine: Engine) -> Engine:
    """Reset an engine, queue the events of the measured sweep, and return the engine."""
    engine.reset()
    feed(engine, sweep(SWEEP_S))
    return engine


def contenders() -> list[Contender]:
    """Return ways to run the engine; the first of a group is what the others are compared with."""
    engine, full = prepared(), filled()
    samples = round(SWEEP_S * RATE)
    cells = np.linspace(0.0, layout.CELLS, samples, endpoint=False) + 0.5 * layout.CELLS / samples
    torque = np.empty(samples)
    out = np.zeros((round(SECONDS * RATE), 2), dtype=np.float32)
    trace = np.zeros((len(out), len(layout.TRACE_COLUMNS)))

    def one_call(trace: FloatArray | None = None) -> float:
        reset_and_feed(engine)
        return timed(SECONDS, lambda: engine.process(out, trace))

    def in_blocks() -> None:
        for start in range(0, len(out), BLOCK):
            engine.process(out[start : start + BLOCK])

    def python_calls() -> float:
        reset_and_feed(engine)
        return timed(SECONDS, in_blocks)

    return [
        Contender(VOICE, "overView, one call", one_call),
        Contender(VOICE, "overView, one call with trace", lambda: one_call(trace)),
        Contender(VOICE, f"overView, {BLOCK}-frame native calls", lambda: native_calls(engine)),
        Contender(VOICE, f"overView, {BLOCK}-frame Python calls", python_calls),
        Contender(
            VOICE, f"overView, {SIMD_WIDTH} voices side by side", lambda: side_by_side(*full)
        ),
        Contender(VOICE, "the same source as plain Python", interpreted),
        Contender(
            DISK, "overView, one call", lambda: timed(SWEEP_S, lambda: disk(engine, cells, torque))
        ),
    ]


Lanes = tuple[EngineBatch, list[Engine]]


def filled() -> Lanes:
    """Return lanes with an engine in each."""
    lanes = EngineBatch(LANE_BLOCK)
    places = map(lanes.memory, range(SIMD_WIDTH))
    return lanes, [prepared(frames=LANE_BLOCK, memory=memory) for memory in places]


def feed_all(engines: Sequence[Engine]) -> None:
    """Queue the whole work on every lane's engine; this is Python's work, not the kernel's."""
    for engine in engines:
        reset_and_feed(engine)


def play(lanes: EngineBatch, engines: Sequence[Engine]) -> None:
    """Process the whole work once in every lane."""
    frames = round(SECONDS * RATE)
    for start in range(0, frames, LANE_BLOCK):
        lanes.process(engines, min(LANE_BLOCK, frames - start), False)


def side_by_side(lanes: EngineBatch, engines: Sequence[Engine]) -> float:
    """Return the speed of the whole work once in every lane."""
    feed_all(engines)
    return timed(SIMD_WIDTH * SECONDS, lambda: play(lanes, engines))


def native_calls(engine: Engine) -> float:
    """Time PortAudio's native callback in blocks of 64 frames; it also applies output settings.

    The loop over blocks is compiled too, as PortAudio's is.
    """
    from overview_dsp.kernels.device.callback import repeated_callback

    run = repeated_callback()
    memory = reset_and_feed(engine).memory
    memory.view(np.int64)[layout.L_CHANNELS] = 2
    OutputSettings().write(memory, RATE, at_once=True)
    out = np.zeros(2 * BLOCK, dtype=np.float32)
    return timed(SECONDS, lambda: run(memory, out, BLOCK, round(SECONDS * RATE) // BLOCK))


def disk(engine: Engine, cells: FloatArray, torque: FloatArray) -> None:
    """Compute the torque of the held disk alone; `cells` are the input angles, in table cells."""
    from overview_dsp.kernels.disk_alone import disk_alone

    disk_alone(engine.memory, layout.SURFACES + layout.SLOT_TABLE, cells, torque)


def interpreted() -> float:
    """Time the same source as plain Python, in a process of its own."""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-m", "overview_dsp.measure.bench"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout)


def clock_ghz() -> float:
    """Return the present clock rate of the processor, GHz."""
    from overview_dsp.kernels.cycle_counter import CYCLES_PER_LINK, chain

    word = np.uint64(1)
    chain(word, 1)
    work = 1e-9 * CYCLES_PER_LINK * LINKS
    return max(timed(work, lambda: chain(word, LINKS)) for _ in range(CHAINS))


def lines(report: Report) -> list[str]:
    """Return the report as lines of text, with a table for each group."""
    rounds = report.rounds
    found = [f"medians of {rounds} interleaved rounds (lowest to highest), CPU time of one core"]
    for group in dict.fromkeys(row.group for row in report.rows):
        rows = [row for row in report.rows if row.group == group]
        width = max(len(row.name) for row in rows)
        found += ["", f"{group:<{width}}  {'x realtime':>10}  {'':<18}  of the first"]
        for row in rows:
            spread = f"({row.low:.4g} to {row.high:.4g})"
            ratios = f"{row.ratio:.3g} ({row.ratio_low:.3g} to {row.ratio_high:.3g})"
            found.append(f"{row.name:<{width}}  {row.speed:>10.4g}  {spread:<18}  {ratios}")
        if group == VOICE:
            found += ["", cycles(rows, report.ghz)]
    return found


def cycles(rows: Sequence[Row], ghz: float) -> str:
    """Return the cycles per sample of this package's rows; the clock rate doesn't change them."""
    each = (
        f"{row.name.removeprefix('overView, ')} {1e9 * ghz / (row.speed * RATE):.0f}"
        for row in rows
        if row.name.startswith("overView")
    )
    return f"cycles per voice and sample, at {ghz:.2f} GHz: {', '.join(each)}"


def this_machine() -> str:
    """Return a description: `AMD EPYC 7763, 2 cores, Linux, Python 3.11.7, numba 0.61.0`."""
    known = Path("/proc/cpuinfo")
    text = known.read_text() if known.exists() else ""
    found = re.search(r"^model name\s*: (.+)$", text, re.MULTILINE)
    processor = found[1] if found else platform.processor() or platform.machine()
    return (
        f"{' '.join(processor.split())}, {counted(usable_cores(), 'core')}, {platform.system()}, "
        f"Python {platform.python_version()}, numba {version('numba')}"
    )


if __name__ == "__main__":
    import warnings

    warnings.simplefilter("ignore", RuntimeWarning)  # wrapping integers, as in machine code
    plain = reset_and_feed(prepared())
    sound = np.zeros((round(INTERPRETED_S * RATE), 2), dtype=np.float32)
    print(timed(INTERPRETED_S, lambda: plain.process(sound)))
