"""Stream under load: callback times, late callbacks, frames that were never delivered.

The load is the worst case of a program around the engine. Two threads compute, one makes cyclic
garbage and collects it, and one encodes JSON in long C calls. Run it in its own process, as `table`
does, so that PortAudio and the interpreter start fresh.
"""

from __future__ import annotations

import gc
import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from typing import Any

import numpy as np

from overview_dsp.data.readers import bundled_timeline
from overview_dsp.design.presets.library import load_preset
from overview_dsp.errors import OverviewError
from overview_dsp.live.output.portaudio_stream import CallbackKind, OutputStream
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.units import HALF_TURN

RATE = 48_000
MAX_BLOCK = 8192
SETTLE_S = 1.0
"""A stream's first callbacks come in bursts on some sound servers; they aren't counted as lost."""

POLL_S = 2e-4
NEAR_S = 1e-3
EDGES_TRIED = 50
SILENT_S = 3.0
CONTROL_EVERY_S = 0.01
SWEEP_S = 4.0


@dataclass(frozen=True)
class LoadResult:
    """Result of one run.

    `seconds` counted, `callbacks` and `frames` in them, `lost_percent` (frames not delivered, of
    rate x seconds), `underflows` reported, `late` (callbacks longer than their own frames last),
    `p50_us`, `p99_us`, `max_us` (callback time; the native callback's first two are exact to a
    fifth), `latency_ms` (reported by PortAudio). A Python callback's time includes its wait for the
    interpreter (in whole frames on a JACK server, whose clock counts frames). The last six values
    are since the start of the stream.
    """

    seconds: float
    callbacks: int
    frames: int
    lost_percent: float
    underflows: int
    late: int
    p50_us: float
    p99_us: float
    max_us: float
    latency_ms: float


class TimedStream(OutputStream):
    """Stream that times its Python callback from PortAudio's call, not from taking the GIL."""

    def __init__(self, engine: Engine, **options: Any) -> None:
        self.times_s: list[float] = []
        self.late = 0
        self._ended = 0.0
        super().__init__(engine, **options)

    def _python_callback(self, out: Any, frames: int, when: Any, status: Any) -> None:
        started = time.perf_counter()
        try:
            super()._python_callback(out, frames, when, status)
        finally:
            # one host buffer may take several callbacks, all with the same time
            called = max(when.currentTime, self._ended)
            self._ended = self._stream.time
            # some sound servers report no time
            seconds = max(self._ended - called, time.perf_counter() - started)
            self.times_s.append(seconds)
            self.late += seconds * self._engine.sample_rate > frames


def measure_load(
    device: int | str | None,
    callback: CallbackKind,
    loaded: bool,
    seconds: float,
    block_size: int = 256,
) -> LoadResult:
    """Play the bundled match with a sweeping input, also under load; errors as `measure_live`."""
    engine = Engine(load_preset("football"), bundled_timeline())
    engine.prepare(RATE, MAX_BLOCK)
    stream = TimedStream(engine, device=device, block_size=block_size, callback=callback)
    with stream:
        _sweep_for(engine, SETTLE_S)
        began, first = counter_edge(stream, block_size)
        before = stream.meters.callbacks
        with load() if loaded else nullcontext():
            _sweep_for(engine, seconds)
        ended, last = counter_edge(stream, block_size)
        meters = stream.meters
    due = (ended - began) * RATE
    p50, p99, longest, late = meters.median_s, meters.p99_s, meters.longest_s, meters.late
    if callback == "python":
        p50, p99, longest = np.quantile(stream.times_s, [0.5, 0.99, 1.0]).tolist()
        late = stream.late
    return LoadResult(
        seconds=ended - began,
        callbacks=meters.callbacks - before,
        frames=last - first,
        lost_percent=100.0 * (due - (last - first)) / due,
        underflows=meters.underflows,
        late=late,
        p50_us=p50 * 1e6,
        p99_us=p99 * 1e6,
        max_us=longest * 1e6,
        latency_ms=meters.latency_s * 1e3,
    )


def counter_edge(stream: OutputStream, block_size: int) -> tuple[float, int]:
    """Return a time (s, monotonic) just after the frame counter changed, and the counter.

    A window between two such times contains whole blocks. At any other time the counter may be up
    to a block behind. The time is exact to 1 ms if this thread runs often enough. OverviewError if
    the counter does not change.
    """
    best = (float("inf"), 0.0, 0)
    for _ in range(EDGES_TRIED):
        frames, looked = stream.meters.frames, time.monotonic()
        until = looked + SILENT_S
        while True:
            time.sleep(POLL_S)
            found, now = stream.meters.frames, time.monotonic()
            if found != frames:
                break
            if now > until:
                raise OverviewError(
                    f"the output has not called for {SILENT_S:g} s; see `overview devices`"
                )
            looked = now
        # a server whose own period is longer asks for several blocks in a row
        time.sleep(min(NEAR_S, 0.25 * block_size / RATE))
        best = min(best, (now - looked, now, stream.meters.frames))
        if best[0] <= NEAR_S:
            break
    return best[1], best[2]


def _sweep_for(engine: Engine, seconds: float) -> None:
    """Move the input back and forth over the match, from this thread, as an application would."""
    started = time.monotonic()
    while (elapsed := time.monotonic() - started) < seconds:
        engine.control(HALF_TURN * (1.0 - abs(1.0 - elapsed / SWEEP_S % 2.0)), True)
        time.sleep(CONTROL_EVERY_S)


@contextmanager
def load() -> Iterator[None]:
    """Run two busy threads, a garbage collector's load and JSON encoding during the body."""
    stop = threading.Event()
    work = [_compute, _compute, _make_garbage, _encode]
    threads = [threading.Thread(target=each, args=(stop,), daemon=True) for each in work]
    for thread in threads:
        thread.start()
    try:
        yield
    finally:
        stop.set()
        for thread in threads:
            thread.join()


def _compute(stop: threading.Event) -> None:
    total = 0
    while not stop.is_set():
        for number in range(5_000):
            total = (total * 31 + number) % 1_000_003


def _make_garbage(stop: threading.Event) -> None:
    while not stop.is_set():
        for _ in range(50_000):
            ring: list[Any] = []
            ring.append(ring)
        gc.collect()


def _encode(stop: threading.Event) -> None:
    row = {"time_s": 12.5, "kind": "foul", "row": [1, 1 / 3, 1 / 7]}
    while not stop.is_set():
        json.dumps([row] * 9_000)
