"""Live measurements of this machine in one report: load test, control latency, sessions.

Each run has its own process, `python -m tools.bench.live.table RUN`. RUN is one JSON
object, and the process prints its result as one JSON object. PortAudio and the interpreter start
fresh. The runs of a round are interleaved, so that the machine's drift affects all of them.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from overview_dsp.errors import InputError, OverviewError
from overview_dsp.live.output.devices import devices
from tools.bench.live.latency import LatencyResult, measure_latency, probe_engine
from tools.bench.live.load import RATE, LoadResult, measure_load
from tools.bench.live.session import (
    SessionRow,
    can_measure,
    measure_session,
    session_table,
)

ROOT = Path(__file__).parents[3]

BLOCK = 256
BLOCKS = (64, 128, 256, 512, 1024)
START_WITHIN_S = 120.0
"""Time allowed for a run besides its window: import, a first compile, PortAudio's start."""

SESSIONS = ((False, False), (True, False), (True, True))  # pairs: with a screen, moving

SHORTEST_S = 3.0
"""Shortest window of a session, as the system counts processor time in units of 10 ms."""

LOAD_CASES = (("native", False), ("python", False), ("native", True), ("python", True))


@dataclass(frozen=True)
class LoadRow:
    """Results of a callback, idle or loaded, over all rounds.

    Medians over rounds, except `late` and `underflows` (sums), `max_us` (the largest) and the
    range of frames lost. Fields as `LoadResult`.
    """

    callback: str
    loaded: bool
    p50_us: float
    p99_us: float
    max_us: float
    callbacks: int
    late: int
    underflows: int
    lost_percent: float
    lost_low: float
    lost_high: float


@dataclass(frozen=True)
class Report:
    """Results of `overview bench --live`.

    `lost_ratio`: frames lost under load, Python's / native's. If native lost less than a block, one
    block is used instead, and `lost_ratio_at_least` is true. `smoothing_frames`: delay that the
    input smoother adds to a movement (it adds none to a tap). `sessions`: empty where that can't be
    measured.
    """

    sample_rate: int
    block_size: int
    seconds: float
    rounds: int
    load: list[LoadRow]
    lost_ratio: float
    lost_ratio_at_least: bool
    latency: list[LatencyResult]
    smoothing_frames: int
    sessions: list[SessionRow]


def measure_live(
    device: int | str | None = None,
    seconds: float = 60.0,
    rounds: int = 5,
    progress: Callable[[float], None] | None = None,
) -> Report:
    """Run the load test `rounds` times, and the latency test once for each block size.

    Each load test takes `seconds`. The latency test takes a fifth of that for each block size, and
    each session a third (at least 3 s). InputError if there is no output device, or it does not
    allow these settings; OverviewError if a run failed, or the device stopped calling.
    """
    done = 0.0
    sessions_run = SESSIONS if can_measure() else ()
    total = rounds * len(LOAD_CASES) * seconds + seconds + seconds * bool(sessions_run)

    def run(window: float, **what: Any) -> dict[str, Any]:
        nonlocal done
        result = _in_own_process({"device": device, "seconds": window, **what})
        done += window
        if progress:
            progress(min(done / total, 1.0))
        return result

    latency = [
        LatencyResult(**run(seconds / len(BLOCKS), block_size=block_size, test="latency"))
        for block_size in BLOCKS
    ]
    found: dict[tuple[str, bool], list[LoadResult]] = {cell: [] for cell in LOAD_CASES}
    for _ in range(rounds):
        for callback, loaded in LOAD_CASES:
            result = run(seconds, test="load", callback=callback, loaded=loaded, block_size=BLOCK)
            found[callback, loaded].append(LoadResult(**result))
    sessions = []
    for screen, moving in sessions_run:
        window = max(seconds / len(sessions_run), SHORTEST_S)
        sessions.append(SessionRow(**run(window, test="session", screen=screen, moving=moving)))
    rows = [_row(*cell, results) for cell, results in found.items()]
    lost, smoothing = lost_ratio(rows, seconds), probe_engine().latency_samples
    return Report(RATE, BLOCK, seconds, rounds, rows, *lost, latency, smoothing, sessions)


def _row(callback: str, loaded: bool, results: list[LoadResult]) -> LoadRow:
    middle = statistics.median
    lost = [result.lost_percent for result in results]
    return LoadRow(
        callback,
        loaded,
        p50_us=middle(result.p50_us for result in results),
        p99_us=middle(result.p99_us for result in results),
        max_us=max(result.max_us for result in results),
        callbacks=sum(result.callbacks for result in results),
        late=sum(result.late for result in results),
        underflows=sum(result.underflows for result in results),
        lost_percent=middle(lost), lost_low=min(lost), lost_high=max(lost),
    )  # fmt: skip


def lost_ratio(rows: list[LoadRow], seconds: float) -> tuple[float, bool]:
    """Return frames lost under load, Python's / native's, and whether that is a lower bound."""
    lost = {row.callback: row.lost_percent for row in rows if row.loaded}
    block = 100.0 * BLOCK / (RATE * seconds)
    return max(lost["python"], 0.0) / max(lost["native"], block), lost["native"] < block


def lines(report: Report) -> list[str]:
    """Return the report as lines of text."""
    sessions = ["", *session_table(report.sessions)] if report.sessions else []
    return [*load_table(report), "", *latency_table(report), *sessions]


def load_table(report: Report) -> list[str]:
    """Return the load test as lines of text."""
    lines = [
        f"{report.block_size} frames at {report.sample_rate} Hz, {report.rounds} x "
        f"{report.seconds:g} s a row; times in us: p50 and p99 medians, max of all",
        f"{'callback':<18}{'p50':>9}{'p99':>10}{'max':>10}{'late':>12}"
        f"{'frames lost % (lowest to highest)':>36}",
    ]
    for row in report.load:
        name = f"{row.callback}, {'load' if row.loaded else 'idle'}"
        late = f"{row.late}/{row.callbacks}"
        lost = f"{row.lost_percent:.3f} ({row.lost_low:.3f} to {row.lost_high:.3f})"
        lines.append(
            f"{name:<18}{row.p50_us:>9.1f}{row.p99_us:>10.1f}{row.max_us:>10.1f}{late:>12}{lost:>36}"
        )
    least = "at least " if report.lost_ratio_at_least else ""
    lines.append(f"frames lost under load, python / native: {least}{report.lost_ratio:.3g}")
    return lines


def latency_table(report: Report) -> list[str]:
    """Return the control latency as lines of text."""
    lines = [
        "from engine.control to the callback that makes the first changed sample (a tap)",
        f"{'block':<7}{'ms':>8}{'taps':>8}{'median ms':>12}{'worst ms':>11}{'median fr.':>12}"
        f"{'worst fr.':>11}{'beyond':>8}{'PortAudio ms':>14}",
    ]
    lines += [
        f"{row.block_size:<7}{1e3 * row.block_size / report.sample_rate:>8.2f}{row.taps:>8}"
        f"{row.median_ms:>12.2f}{row.worst_ms:>11.2f}{row.median_frames:>12.0f}"
        f"{row.worst_frames:>11.0f}{row.beyond:>8}{row.output_ms:>14.2f}"
        for row in report.latency
    ]
    lines.append(
        f"a movement: {report.smoothing_frames} frames "
        f"({1e3 * report.smoothing_frames / report.sample_rate:.1f} ms) more, by smoothing"
    )
    return lines


def _in_own_process(what: dict[str, Any]) -> dict[str, Any]:
    limit = START_WITHIN_S + 3.0 * what["seconds"]
    command = [sys.executable, "-m", "tools.bench.live.table", json.dumps(what)]
    try:
        done = subprocess.run(
            command, cwd=ROOT, capture_output=True, text=True, timeout=limit, check=False
        )
    except subprocess.TimeoutExpired:
        raise OverviewError(f"a run did not end within {limit:.0f} s: {json.dumps(what)}") from None
    if done.returncode != 0:
        last = done.stderr.strip().splitlines()[-1:] or [f"exit code {done.returncode}"]
        kind = InputError if done.returncode == InputError.exit_code else OverviewError
        raise kind(last[0])
    return dict(json.loads(done.stdout.splitlines()[-1]))


def _run(what: dict[str, Any]) -> LoadResult | LatencyResult | SessionRow:
    if not devices():
        raise InputError(
            "no audio output: plug in a sound card or start a sound server (PipeWire, PulseAudio, "
            "JACK); `overview devices` lists the outputs"
        )
    test = what.pop("test")
    if test == "session":
        return measure_session(**what)
    return measure_load(**what) if test == "load" else measure_latency(**what)


def _main() -> int:
    try:
        print(json.dumps(asdict(_run(json.loads(sys.argv[1])))))
    except OverviewError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(_main())
