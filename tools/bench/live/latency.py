"""Control latency of each block size, from `engine.control` to the first changed sample.

A tap is pushed at random moments on a disk at rest. Its first changed sample is the sample at
which the kernel applied it, since the surface here is rough enough to sound at once. That sample is
known without a recorder: the tap passes the only event a fixed number of samples later. The strike
log has the time of the event, to a fraction of a sample.
"""

from __future__ import annotations

import random
import statistics
import time
from dataclasses import dataclass

import numpy as np

from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.design.presets.library import load_preset
from overview_dsp.errors import OverviewError
from overview_dsp.live.output.portaudio_stream import OutputStream
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.units import HALF_TURN
from tools.bench.live.load import MAX_BLOCK, RATE, SETTLE_S, SILENT_S

HOLD = 4800  # duration of a tap, in samples
BACK_S = 0.3  # the disk returns to rest within this time after a tap
TAP_POSITION = 0.8


def probe_engine() -> Engine:
    """Return an engine whose disk follows a tap within 25 ms and returns after it.

    It sounds from its first sample, is prepared at `RATE` and has one event, at the middle.
    """
    preset = load_preset("football").with_changes(
        {
            "clutch.max_speed_ratio": 0.0,
            "disk.k1": 0.05,
            "disk.k2": 0.05,
            "surface.friction": 2e-3,
            "tactor.threshold_db": -140.0,
            "texture.gain_db": 0.0,
        }
    )
    engine = Engine(preset, Timeline("one event", 10.0, (Event(5.0, "foul"),)))
    engine.prepare(RATE, MAX_BLOCK)
    return engine


def strike_delay() -> float:
    """Return the number of samples from a tap of the probe engine to its strike."""
    engine = probe_engine()
    out = np.zeros((HOLD, 2), dtype=np.float32)
    engine.process(out)
    engine.control(TAP_POSITION * HALF_TURN, True, HOLD)
    engine.process(out)
    return float(engine.pop_strikes().time_s[0]) * RATE - HOLD


@dataclass(frozen=True)
class Tap:
    """Times of one tap.

    `before`, `after`: the engine's clock (samples) just before and after the push. `applied`: its
    first changed sample. `wait_s`: time from the push until the kernel applied it.
    """

    before: int
    after: int
    applied: int
    wait_s: float


@dataclass(frozen=True)
class LatencyResult:
    """Results of one block size.

    `median_ms`, `worst_ms` (and the same in frames) over the `taps`: time from `engine.control` to
    the callback that makes the first changed sample. `beyond`: taps whose first changed sample was
    more than a block after the engine's clock at the push (expected: none). `output_ms`: time from
    the callback to the ear, as PortAudio reports it.
    """

    block_size: int
    taps: int
    median_ms: float
    worst_ms: float
    median_frames: float
    worst_frames: float
    beyond: int
    output_ms: float


def tap_while_playing(engine: Engine, delay: float) -> Tap:
    """Tap the resting engine that a stream plays, hold for `HOLD` samples, wait until it is back.

    `delay` is the result of `strike_delay`. OverviewError if the stream stopped or nothing was
    struck.
    """
    engine.pop_strikes()
    before = engine.sample_time
    pushed = time.monotonic()
    engine.control(TAP_POSITION * HALF_TURN, True)
    after = engine.sample_time
    until = pushed + SILENT_S
    while not engine.meters.touching:
        time.sleep(0)  # other threads may run; this one continues at once
        if time.monotonic() > until:
            raise OverviewError(f"the output has not called for {SILENT_S:g} s")
    applied_s = time.monotonic()
    engine.control(TAP_POSITION * HALF_TURN, False, after + HOLD)
    while engine.sample_time < after + HOLD + BACK_S * RATE:
        if time.monotonic() > until + BACK_S:
            raise OverviewError(f"the output has not called for {SILENT_S:g} s")
        time.sleep(0.005)
    strikes = engine.pop_strikes()
    if not len(strikes):
        raise OverviewError("a tap caused no strike: the output dropped it")
    applied = round(float(strikes.time_s[0]) * RATE - delay)
    return Tap(before, after, applied, applied_s - pushed)


def measure_latency(
    device: int | str | None, block_size: int, seconds: float, seed: int = 0
) -> LatencyResult:
    """Tap at random moments for about `seconds`, at least three times; errors as `measure_live`."""
    rng = random.Random(seed)
    delay = strike_delay()
    engine = probe_engine()
    taps: list[Tap] = []
    with OutputStream(engine, device=device, block_size=block_size) as stream:
        time.sleep(SETTLE_S)
        until = time.monotonic() + seconds
        while len(taps) < 3 or time.monotonic() < until:
            time.sleep(rng.uniform(0.0, 2.0 * block_size / RATE))
            taps.append(tap_while_playing(engine, delay))
        output_s = stream.meters.latency_s
    waits = [tap.wait_s for tap in taps]
    median, worst = statistics.median(waits), max(waits)
    beyond = sum(tap.applied > tap.after + block_size for tap in taps)
    ms, frames = (1e3 * median, 1e3 * worst), (RATE * median, RATE * worst)
    return LatencyResult(block_size, len(taps), *ms, *frames, beyond, 1e3 * output_s)
