"""Contenders in turn, round after round, so that ratios hold although the machine's speed drifts.

Times are the thread's own (CPU time), so that other work on the machine counts as little as it can;
but for what uses several cores.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

VOICE = "the full voice"
DISK = "the disk alone"
CORES = "many voices, wall clock"
BARE_CORES = "the kernel alone, wall clock"


@dataclass(frozen=True)
class Contender:
    """A way to do the work of a group; `run` returns seconds of sound made in one second."""

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


def timed(seconds: float, work: Callable[[], object]) -> float:
    """Run `work`, which makes `seconds` of sound; seconds of sound in one second."""
    started = time.thread_time()
    work()
    return seconds / (time.thread_time() - started)


def interleaved(
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
    first = {contender.group: i for i, contender in reversed([*enumerate(contenders)])}
    rows = []
    for contender, speeds in zip(contenders, found, strict=True):
        base = found[first[contender.group]]
        ratios = [speed / other for speed, other in zip(speeds, base, strict=True)]
        rows.append(
            Row(
                contender.group,
                contender.name,
                statistics.median(speeds),
                min(speeds),
                max(speeds),
                statistics.median(ratios),
                min(ratios),
                max(ratios),
            )
        )
    return rows
