"""AHAP, Apple's haptic pattern (Core Haptics): JSON, two files that play together.

One holds the vibration (continuous events of up to 30 s with an intensity curve), one the strikes
(transient events): a pattern's curves also modulate its transients, so they are kept apart. The
vibration is silent while a transient is taken to last (`players.core_haptics`).

Laws: intensity = sqrt(amplitude), as Meta's exporter has it (perceived strength); sharpness =
(frequency - 65 Hz)/235 Hz, as the MPEG encoder reads it. A control point's time counts from its
curve's own. `HapticIntensityControl` multiplies.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

from overview_dsp.offline.export.breakpoints import breakpoints
from overview_dsp.offline.export.clip import LEVELS_PER_S, Clip
from overview_dsp.offline.export.players import core_haptics

LONGEST_EVENT_S = 30.0
DULLEST_HZ, SHARPEST_HZ = 65.0, 300.0


def sharpness_of(frequency_hz: float) -> float:
    """Sharpness of a vibration, 0..1; beyond the range its end."""
    part = (frequency_hz - DULLEST_HZ) / (SHARPEST_HZ - DULLEST_HZ)
    return round(min(max(part, 0.0), 1.0), 4)


def vibration_pattern(clip: Clip, budget: int) -> dict[str, Any]:
    """The continuous part: an event and a curve for each 30 s."""
    joints = list(range(0, len(clip.level) - 1, round(LONGEST_EVENT_S * LEVELS_PER_S)))
    level, corners = clip.under_strikes(lambda strike: core_haptics.TRANSIENTS_MS[0])
    places = breakpoints(level, budget + len(corners), [*joints, *corners])
    pattern: list[dict[str, Any]] = []
    bounds = [*joints, len(clip.level) - 1]
    for first, end in itertools.pairwise(bounds):
        start = first / LEVELS_PER_S
        event = {
            "EventType": "HapticContinuous",
            "Time": start,
            "EventDuration": (end - first) / LEVELS_PER_S,
            "EventParameters": [
                _value("HapticIntensity", 1.0),
                _value("HapticSharpness", sharpness_of(clip.frequency_hz)),
            ],
        }
        curve = {
            "ParameterID": "HapticIntensityControl",
            "Time": start,
            "ParameterCurveControlPoints": [
                {
                    "Time": round(int(place - first) / LEVELS_PER_S, 3),
                    "ParameterValue": _intensity(float(level[place])),
                }
                for place in places
                if first <= place <= end
            ],
        }
        pattern += [{"Event": event}, {"ParameterCurve": curve}]
    return _document(clip, "vibration", pattern)


def strikes_pattern(clip: Clip) -> dict[str, Any]:
    """The transients."""
    events = [
        {
            "Event": {
                "EventType": "HapticTransient",
                "Time": round(strike.time_s, 4),
                "EventParameters": [
                    _value("HapticIntensity", _intensity(strike.amplitude)),
                    _value("HapticSharpness", round(strike.sharpness, 4)),
                ],
            }
        }
        for strike in clip.transients
    ]
    return _document(clip, "strikes", events)


def _value(name: str, value: float) -> dict[str, Any]:
    return {"ParameterID": name, "ParameterValue": value}


def _intensity(amplitude: float) -> float:
    return round(math.sqrt(min(max(amplitude, 0.0), 1.0)), 4)


def _document(clip: Clip, part: str, pattern: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "Version": 1.0,
        "Metadata": {"Project": "overView DSP", "Description": f"{clip.title}: {part}"},
        "Pattern": pattern,
    }
