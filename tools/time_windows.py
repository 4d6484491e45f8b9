"""Time windows of a long series on their way to a surface: median and longest of each width.

python tools/time_windows.py [SAMPLES, 1e8 if left out]

A sine with noise and one peak, float32, evenly sampled, kept in a temporary file; 300 events.
"""

from __future__ import annotations

import sys
import time

import numpy as np

import overview_dsp as ov
from overview_dsp.timeline.curve_builder import CurveBuilder
from overview_dsp.timeline.minmax_pyramid import CHUNK

STEP_S = 1e-3
ROUNDS = 21


def long_timeline(count: int) -> ov.Timeline:
    random = np.random.default_rng(1)
    builder = CurveBuilder(np.float32)
    for start in range(0, count, CHUNK):
        index = np.arange(start, min(start + CHUNK, count))
        value = np.sin(index * (10.0 * np.pi / count)) + 0.1 * random.standard_normal(len(index))
        value[index == count // 3] = 5.0
        builder.append(value)
    duration_s = count * STEP_S
    events = tuple(
        ov.Event(float(at), "week" if i % 3 else "record_high", str(i))
        for i, at in enumerate(np.sort(random.uniform(0.0, duration_s, 300)))
    )
    return ov.Timeline("a long series", duration_s, events, builder.finish(STEP_S))


def main(count: int) -> None:
    began = time.perf_counter()
    timeline = long_timeline(count)
    print(f"{count} samples made and taken in: {time.perf_counter() - began:.1f} s")
    preset = ov.load_preset("series")
    ov.build_surface(timeline, preset)
    random = np.random.default_rng(2)
    print("   samples  events  window + surface: median and longest, ms")
    for part in (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 5e-3, 2e-3, 1e-3, 5e-4, 1e-4, 1e-5, 1e-6):
        width = timeline.duration_s * part
        times, events = [], []
        for _ in range(ROUNDS):
            start = random.uniform(0.0, timeline.duration_s - width)
            began = time.perf_counter()
            window = timeline.window(start, start + width)
            ov.build_surface(window, preset)
            times.append((time.perf_counter() - began) * 1e3)
            events.append(len(window.events))
        print(
            f"{count * part:10.0f} {np.median(events):7.0f} {np.median(times):12.2f} "
            f"{max(times):8.2f}"
        )


if __name__ == "__main__":
    main(int(float(sys.argv[1])) if len(sys.argv) > 1 else 100_000_000)
