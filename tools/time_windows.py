"""Measure the processor time from windows of a long series to surfaces: median and longest.

python tools/time_windows.py [SAMPLES, 1e8 if left out]

A sine with noise and one peak, float32, evenly sampled, kept in a temporary file; 300 events, and
those that rules find in each window.
"""

from __future__ import annotations

import sys
import time
from datetime import datetime

import numpy as np

import overview_dsp as ov
from overview_dsp.data.analysis.extrema import Thinner
from overview_dsp.data.analysis.series_events import Calendar, Series, WindowRules
from overview_dsp.data.timeline.curve_builder import CurveBuilder
from overview_dsp.data.timeline.minmax_pyramid import CHUNK

STEP_S = 1e-3
ROUNDS = 21


def long_timeline(count: int) -> ov.Timeline:
    random = np.random.default_rng(1)
    builder, thinner = CurveBuilder(np.float32), Thinner()
    for start in range(0, count, CHUNK):
        index = np.arange(start, min(start + CHUNK, count))
        value = np.sin(index * (10.0 * np.pi / count)) + 0.1 * random.standard_normal(len(index))
        value[index == count // 3] = 5.0
        builder.append(value)
        thinner.add(index * STEP_S, value, np.diff(value, prepend=np.nan))
    duration_s = count * STEP_S
    events = tuple(
        ov.Event(float(at), "week" if i % 3 else "record_high", str(i))
        for i, at in enumerate(np.sort(random.uniform(0.0, duration_s, 300)))
    )
    curve, begin = builder.finish(STEP_S, unit="°C"), datetime(2020, 1, 1)
    series = Series(*thinner.finish(), False, "°C", Calendar(begin, False), every=False)
    rules = WindowRules(series, 0.0, duration_s, curve)
    return ov.Timeline("a long series", duration_s, events, curve, start=begin, rules=rules)


def main(count: int) -> None:
    began = time.perf_counter()
    timeline = long_timeline(count)
    print(f"{count} samples made and taken in: {time.perf_counter() - began:.1f} s")
    preset = ov.load_preset("series")
    ov.build_surface(timeline, preset)
    random = np.random.default_rng(2)
    print("   samples  events  window + surface: median and longest, ms of processor time")
    for part in (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 5e-3, 2e-3, 1e-3, 5e-4, 1e-4, 1e-5, 1e-6):
        width = timeline.duration_s * part
        times, events = [], []
        for _ in range(ROUNDS):
            start = random.uniform(0.0, timeline.duration_s - width)
            began = time.process_time()
            window = timeline.window(start, start + width)
            ov.build_surface(window, preset)
            times.append((time.process_time() - began) * 1e3)
            events.append(len(window.events))
        print(
            f"{count * part:10.0f} {np.median(events):7.0f} {np.median(times):12.2f} "
            f"{max(times):8.2f}"
        )


if __name__ == "__main__":
    main(int(float(sys.argv[1])) if len(sys.argv) > 1 else 100_000_000)
