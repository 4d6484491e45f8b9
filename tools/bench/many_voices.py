"""Rows of many voices at once on all cores."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

from overview_dsp.data.readers import bundled_timeline
from overview_dsp.design.gestures import sweep
from overview_dsp.design.presets.library import load_preset
from overview_dsp.kernels.simd.vector import SIMD_WIDTH
from overview_dsp.measure.bench import (
    RATE,
    SECONDS,
    Contender,
    Lanes,
    feed_all,
    filled,
    play,
)
from overview_dsp.offline.rendering.many import render_jobs, render_many, usable_cores

CORES, BARE_CORES = "many voices, wall clock", "the kernel alone, wall clock"
SEEDS = 256
SWEEP_S = 1.5


def rendered(threads: int) -> float:
    """Return the seconds of sound that `render_many` makes in one second of the wall clock."""
    gesture = sweep(SWEEP_S)
    jobs = render_jobs([bundled_timeline()], [load_preset("football")], [gesture], range(SEEDS))
    started = time.perf_counter()
    done = sum(1 for _ in render_many(list(jobs), RATE, tail="none", threads=threads))
    return done * gesture.duration_s / (time.perf_counter() - started)


def in_threads(full: list[Lanes]) -> float:
    """Process the whole work once in each of these lanes, with one thread per lane."""
    for _, engines in full:
        feed_all(engines)
    with ThreadPoolExecutor(len(full)) as pool:
        started = time.perf_counter()
        list(pool.map(lambda lanes: play(*lanes), full))
        return len(full) * SIMD_WIDTH * SECONDS / (time.perf_counter() - started)


def contenders() -> list[Contender]:
    """Return rows of several cores."""
    cores = usable_cores()
    full = [filled() for _ in range(cores)]
    return [
        Contender(CORES, "render_many, 1 thread", lambda: rendered(1)),
        Contender(CORES, f"render_many, {cores} threads", lambda: rendered(cores)),
        Contender(BARE_CORES, "side by side, 1 thread", lambda: in_threads(full[:1])),
        Contender(BARE_CORES, f"side by side, {cores} threads", lambda: in_threads(full)),
    ]
