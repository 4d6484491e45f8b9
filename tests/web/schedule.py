"""A session for any runner: drag, tap, release, another hand, parameters and a surface."""

from __future__ import annotations

import math

import numpy as np

import overview_dsp as ov
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import connect, run_block

RATE = 48_000
BLOCK = 128
FRAMES = 1_200 * BLOCK  # 3.2 s
RELEASE = 110_000

Event = tuple[int, float, bool, str]


def events() -> list[Event]:
    """Control events: sample, theta2 (rad), touching, source."""
    drag = [
        (200 + 400 * i, 0.2 + 2.6 * (i / 150.0) ** 1.5, True, "touch") for i in range(150)
    ]  # 60 000 samples
    tap = [(70_001, 0.4, True, "touch"), (80_000, 0.4, False, "touch")]
    twist = [(82_000 + 97 * i, 1.6 + 1.5 * math.sin(i / 20.0), True, "twist") for i in range(250)]
    return [*drag, (61_000, 2.8, False, "touch"), *tap, *twist, (RELEASE, 2.0, False, "twist")]


def engine(
    match: ov.Timeline,
    football: ov.Preset,
    hands: bool = True,
    settings: OutputSettings | None = None,
) -> ov.Engine:
    """A connected engine, with the hands' events waiting."""
    made = ov.Engine(football, match, seed=3)
    made.prepare(RATE, FRAMES)
    connect(made, settings)
    if hands:
        for sample, theta2, touching, source in events():
            made.control(theta2, touching, sample, source)
    return made


def change(made: ov.Engine) -> None:
    """Parameters and surfaces, stamped."""
    made.set("tactor.gain_db", -9.0, sample_time=13_333)
    made.set("disk.k2", 6e-3, sample_time=25_000)
    made.set("kinds.goal.height", 40.0, sample_time=40_961)


def played(made: ov.Engine, block: int = FRAMES) -> np.ndarray:
    """What an output gets, float32 (frames, 2)."""
    out = np.empty((FRAMES, 2), dtype=np.float32)
    for start in range(0, FRAMES, block):
        run_block(made, out[start : start + block])
    return out
