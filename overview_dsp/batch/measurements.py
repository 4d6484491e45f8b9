"""Measurements of a render: length, levels, felt events and hashes."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from overview_dsp.arrays import SampleArray
from overview_dsp.data.analysis.loudness import MIN_RATE, StepMeter
from overview_dsp.measure.perceived_level import event_levels
from overview_dsp.offline.rendering.many import RenderedJob
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.units import gain_to_db

MEASURED_COLUMNS = ("engaged", "cursor")
"""Columns of the trace that the measurements need."""


def measure_render(result: RenderedJob[Trace | None], data: bytes) -> dict[str, Any]:
    """Measure a render (with its trace) that is stored as `data`."""
    return {
        "frames": len(result.samples),
        "duration_s": len(result.samples) / result.sample_rate,
        "peak_click_dbfs": _peak_db(result.samples[:, 0]),
        "peak_tactor_dbfs": _peak_db(result.samples[:, 1]),
        "loudness_lufs": _loudness(result.samples[:, :1], result.sample_rate),
        "strikes": len(result.strikes),
        "felt": _felt(result),
        "bytes": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
        "samples_sha256": hashlib.sha256(
            np.ascontiguousarray(result.samples, "<f4").data
        ).hexdigest(),
    }


def _peak_db(signal: SampleArray) -> float | None:
    peak = float(np.abs(signal).max(initial=0.0))
    return gain_to_db(peak) if peak > 0.0 else None


def _loudness(click: SampleArray, sample_rate: float) -> float | None:
    """Return the integrated loudness of the clicks (BS.1770), LUFS; None below 4000 Hz."""
    if sample_rate < MIN_RATE or not len(click):
        return None
    meter = StepMeter(int(sample_rate), (1.0,))
    for first in range(0, len(click), meter.block_frames):
        meter.feed(click[first : first + meter.block_frames])
    return meter.finish().integrated()


def _felt(result: RenderedJob[Trace | None]) -> list[dict[str, Any]]:
    """Return the events that the disk passed, in the order of their positions."""
    assert result.trace is not None
    surface, events = result.surface, result.job.timeline.events
    levels = event_levels(surface, result.trace, result.samples[:, 1], result.sample_rate)
    felt = np.isfinite(levels)
    return [
        {"event": event, "kind": events[event].kind, "level_db": level}
        for event, level in zip(surface.event[felt].tolist(), levels[felt].tolist(), strict=True)
    ]
