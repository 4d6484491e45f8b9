"""Meta's `.haptic` 1.0: JSON with an amplitude and a frequency envelope and emphasis points.

Amplitude is the signal's own; frequency 0..1 stands for 65..300 Hz, as in AHAP. Both envelopes
begin at 0 (Meta's renderer refuses a clip that doesn't). The amplitude envelope is silent while
Meta's renderer plays an emphasis; an emphasis is as strong as the envelope there or stronger.

What is wrong with a `.haptic` document, by Meta's strict validator and its renderer.

Meta's renderer of `.haptic` clips (MIT, `core/renderer_c`), as the Quest's profile sets it.

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

from overview_dsp.offline.export.ahap import sharpness_of
from overview_dsp.offline.export.breakpoints import (
    Shape,
    ascending,
    breakpoints,
    many,
    number,
    one_of,
    record,
    text,
    whole,
)
from overview_dsp.offline.export.clip import LEVELS_PER_S, Clip

_UNIT, _SECONDS = number(0.0, 1.0), number(0.0)
_TEXTS = ("editor", "source", "project", "author", "description")
_METADATA: dict[str, Shape] = {**dict.fromkeys(_TEXTS, text()), "tags": many(text())}
_AMPLITUDE = record(
    {"time": _SECONDS, "amplitude": _UNIT},
    {"emphasis": record({"amplitude": _UNIT, "frequency": _UNIT})},
)
_ENVELOPES = record(
    {
        "amplitude": many(_AMPLITUDE, 2),
        "frequency": many(record({"time": _SECONDS, "frequency": _UNIT})),
    }
)
_DOCUMENT = record(
    {
        "version": record({"major": one_of(1), "minor": whole(0), "patch": whole(0)}),
        "metadata": record({}, _METADATA),
        "signals": record({"continuous": record({"envelopes": _ENVELOPES})}),
    }
)


def faults_of(document: Any) -> list[str]:
    """Every fault of a `.haptic` document, a line each."""
    faults: list[str] = []
    _DOCUMENT(document, "", faults)
    if faults:
        return faults
    envelopes = document["signals"]["continuous"]["envelopes"]
    times = {}
    for name in ("amplitude", "frequency"):
        times[name] = [point["time"] for point in envelopes[name]]
        ascending(times[name], f"{name} times", faults)
        if times[name] and times[name][0] != 0.0:
            faults.append(f"{name}[0].time = {times[name][0]:g}; Meta's renderer wants 0")
    end = times["amplitude"][-1]
    if end <= 0.0:
        faults.append("the clip has no length: its last amplitude is at 0")
    faults += [
        f"frequency[{k}].time = {time:g} is after the last amplitude ({end:g} s)"
        for k, time in enumerate(times["frequency"])
        if time > end
    ]
    faults += [
        f"amplitude[{k}].emphasis.amplitude = {point['emphasis']['amplitude']:g} is below the "
        f"envelope there ({point['amplitude']:g})"
        for k, point in enumerate(envelopes["amplitude"])
        if "emphasis" in point and point["emphasis"]["amplitude"] < point["amplitude"]
    ]
    return faults


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
