"""What a page sounds with: a window's bytes for one sample rate, and what differs at others.

``sound/N.packed`` are `browser_memory`'s bytes, packed (`packing`), for the first rate, of the
whole's memory (N = 0) or of a change to window N (N = ``back``: to the whole again).
``sound/N-RATE.patch`` makes those of another rate of them, little-endian::

    uint32 1 (replace all) or 0, uint32 number of runs; then, if 1, the bytes themselves, else runs:
    uint32 column (of 8 bytes), uint32 columns, the columns

Only coefficients and clicks depend on the rate, not the half megabyte of friction.
"""

from __future__ import annotations

import numpy as np

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.live.output_settings import OutputSettings
from overview_dsp.offline.export.browser_memory import encode_change, encode_engine
from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.surface.model import Surface

BLOCK = 128
"""Frames of a browser's block."""


def whole_bytes(
    timeline: Timeline, preset: Preset, rate: int, seed: int, actuator: Actuator | None
) -> bytes:
    """The memory of an engine that is ready at a sample rate (Hz)."""
    engine = Engine(preset, timeline, seed=seed)
    engine.prepare(rate, BLOCK)
    return encode_engine(engine, OutputSettings(actuator=actuator))


def window_bytes(surface: Surface, preset: Preset, rate: int) -> bytes:
    """A change to a window's surface at a sample rate (Hz)."""
    return encode_change(preset, preset, rate, surface)


def patch_of(base: bytes, wanted: bytes) -> bytes:
    """What makes `wanted` of `base`."""
    if len(base) != len(wanted):
        return np.array([1, 0], "<u4").tobytes() + wanted
    different = np.flatnonzero(np.frombuffer(base, "<u8") != np.frombuffer(wanted, "<u8"))
    runs = np.split(different, np.flatnonzero(np.diff(different) > 1) + 1) if len(different) else []
    parts = [np.array([0, len(runs)], "<u4").tobytes()]
    for run in runs:
        first, count = int(run[0]), len(run)
        parts.append(np.array([first, count], "<u4").tobytes())
        parts.append(wanted[8 * first : 8 * (first + count)])
    return b"".join(parts)
