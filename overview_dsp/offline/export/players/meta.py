"""Meta's renderer of `.haptic` clips (MIT, `core/renderer_c`), as the Quest's profile sets it.

Amplitudes ramp linearly from point to point. An emphasis has a constant amplitude for 36.4 ms
(frequency 0) to 12.1 ms (frequency 1), is added, and ducks the continuous part to a half while it
lasts; the next one takes its place. This is the renderer's amplitude curve; its sine that becomes a
square with an emphasis' frequency is up to 3 dB more energy.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.offline.export.clip import LEVELS_PER_S

DUCKING = 0.5
DULL_MS, SHARP_MS = 36.4, 12.1


def emphasis_ms(frequency: float) -> int:
    """How long an emphasis of this frequency (0 to 1) lasts."""
    return int(DULL_MS + (SHARP_MS - DULL_MS) * frequency)


def with_emphasis(
    level: NDArray[np.float64], struck: Iterable[tuple[float, float, float]]
) -> NDArray[np.float64]:
    """A continuous level with emphases in it: (time s, amplitude, frequency), in order of time."""
    emphasis = np.zeros(len(level))
    for time_s, amplitude, frequency in struck:
        start = round(time_s * LEVELS_PER_S)
        emphasis[start:] = 0.0
        emphasis[start : start + emphasis_ms(frequency)] = amplitude
    ducked = np.where(emphasis > 0.0, DUCKING, 1.0) * level
    return np.asarray(np.minimum(ducked + emphasis, 1.0))


def played(haptic: dict[str, Any]) -> NDArray[np.float64]:
    """The amplitude that a `.haptic` document gives."""
    points = haptic["signals"]["continuous"]["envelopes"]["amplitude"]
    times = [point["time"] for point in points]
    grid = np.arange(round(times[-1] * LEVELS_PER_S) + 1) / LEVELS_PER_S
    level = np.interp(grid, times, [point["amplitude"] for point in points])
    struck = [
        (point["time"], point["emphasis"]["amplitude"], point["emphasis"]["frequency"])
        for point in points
        if "emphasis" in point
    ]
    return with_emphasis(level, struck)
