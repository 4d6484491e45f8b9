"""Meta's `.haptic` 1.0: JSON with an amplitude and a frequency envelope and emphasis points.

Amplitude is the signal's own; frequency 0..1 stands for 65..300 Hz, as in AHAP. Both envelopes
begin at 0 (Meta's renderer refuses a clip that doesn't). The amplitude envelope is silent while
Meta's renderer plays an emphasis; an emphasis is as strong as the envelope there or stronger.
"""

from __future__ import annotations

from typing import Any

from overview_dsp.offline.export.ahap import sharpness_of
from overview_dsp.offline.export.breakpoints import breakpoints
from overview_dsp.offline.export.clip import LEVELS_PER_S, Clip
from overview_dsp.offline.export.players.meta import emphasis_ms


def document(clip: Clip, budget: int) -> dict[str, Any]:
    """The clip as a `.haptic` document."""
    struck = {round(strike.time_s * LEVELS_PER_S): strike for strike in clip.transients}
    continuous, corners = clip.under_strikes(lambda strike: emphasis_ms(strike.sharpness))
    places = breakpoints(continuous, budget + len(corners), corners)
    amplitude: list[dict[str, Any]] = []
    for place in places.tolist():
        level = round(float(continuous[place]), 4)
        point: dict[str, Any] = {"time": place / LEVELS_PER_S, "amplitude": level}
        strike = struck.get(place)
        if strike is not None:
            point["emphasis"] = {
                "amplitude": round(strike.amplitude, 4),
                "frequency": round(strike.sharpness, 4),
            }
        amplitude.append(point)
    frequency = sharpness_of(clip.frequency_hz)
    return {
        "version": {"major": 1, "minor": 0, "patch": 0},
        "metadata": {
            "editor": "overView DSP",
            "source": "",
            "project": clip.title,
            "tags": [],
            "author": "",
            "description": "a gesture over a timeline, by a model of friction",
        },
        "signals": {
            "continuous": {
                "envelopes": {
                    "amplitude": amplitude,
                    "frequency": [
                        {"time": 0.0, "frequency": frequency},
                        {"time": clip.duration_s, "frequency": frequency},
                    ],
                }
            }
        },
    }
