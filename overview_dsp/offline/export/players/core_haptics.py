"""Apple's Core Haptics, as far as it can be told: an assumption, stated.

Apple publishes no waveform of a transient. It is taken as a burst of constant amplitude of 6 to 22
ms (12 ms in between: Meta's sharpest emphasis; 22 ms: the MPEG reference's transient), that adds to
the continuous vibration in energy. Amplitude is intensity squared, the inverse of what exporters
write (Meta's: intensity = sqrt(amplitude)).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.offline.export.clip import LEVELS_PER_S

TRANSIENTS_MS = (12, 6, 22)
"""Lengths a transient may have; the first is what exports are made for."""


def with_transients(
    level: NDArray[np.float64], struck: Sequence[tuple[float, float]], length_ms: int
) -> NDArray[np.float64]:
    """A continuous level with (time s, amplitude) transients in it."""
    starts = [round(time_s * LEVELS_PER_S) for time_s, _ in struck]
    count = max([len(level), *(start + length_ms for start in starts)])
    energy = np.pad(level, (0, count - len(level))) ** 2
    for start, (_, amplitude) in zip(starts, struck, strict=True):
        energy[start : start + length_ms] += amplitude**2
    return np.asarray(np.sqrt(energy))


def played(
    vibration: dict[str, Any], strikes: dict[str, Any], length_ms: int = TRANSIENTS_MS[0]
) -> NDArray[np.float64]:
    """The amplitude that two AHAP patterns give: one's intensity curves, the other's transients."""
    curves = [
        entry["ParameterCurve"] for entry in vibration["Pattern"] if "ParameterCurve" in entry
    ]
    points = [
        (curve["Time"] + point["Time"], point["ParameterValue"])
        for curve in curves
        for point in curve["ParameterCurveControlPoints"]
    ]
    times, values = np.array(points).T
    count = round(times[-1] * LEVELS_PER_S) + 1
    intensity = np.interp(np.arange(count) / LEVELS_PER_S, times, values)
    struck = [
        (
            entry["Event"]["Time"],
            entry["Event"]["EventParameters"][0]["ParameterValue"] ** 2,
        )
        for entry in strikes["Pattern"]
    ]
    return with_transients(intensity**2, struck, length_ms)
