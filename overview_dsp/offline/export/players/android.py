"""Android's vibrator: a waveform's steps, and envelope effects' straight lines.

A waveform holds each amplitude (of 255) for its time. An envelope effect starts from nothing and
ramps to each control point in turn; an application plays the effects one after the other.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def waveform_played(android: dict[str, Any]) -> NDArray[np.float64]:
    """The amplitude that a document's waveform gives."""
    wave = android["waveform"]
    level = np.repeat(np.array(wave["amplitudes"]) / 255.0, wave["timings"])
    return np.append(level, 0.0)


def envelopes_played(android: dict[str, Any]) -> NDArray[np.float64]:
    """The amplitude that a document's envelope effects give, each begun at its `startMs`."""
    times, values = [0.0], [0.0]
    for effect in android["envelopeEffects"]:
        at = float(effect["startMs"])
        times.append(at)
        values.append(0.0)
        for point in effect["controlPoints"]:
            at += point["durationMs"]
            times.append(at)
            values.append(point["amplitude"])
    return np.interp(np.arange(round(times[-1]) + 1), times, values)
