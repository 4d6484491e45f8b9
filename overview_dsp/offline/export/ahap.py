"""AHAP, Apple's haptic pattern (Core Haptics): JSON, two files that play together.

One holds the vibration (continuous events of up to 30 s with an intensity curve), one the strikes
(transient events): a pattern's curves also modulate its transients, so they are kept apart. The
vibration is silent while a transient is taken to last (`players.core_haptics`).

Laws: intensity = sqrt(amplitude), as Meta's exporter has it (perceived strength); sharpness =
(frequency - 65 Hz)/235 Hz, as the MPEG encoder reads it. A control point's time counts from its
curve's own. `HapticIntensityControl` multiplies.

What is wrong with an AHAP document.

Apple's Core Haptics, as far as it can be told: an assumption, stated.

Apple publishes no waveform of a transient. It is taken as a burst of constant amplitude of 6 to 22
ms (12 ms in between: Meta's sharpest emphasis; 22 ms: the MPEG reference's transient), that adds to
the continuous vibration in energy. Amplitude is intensity squared, the inverse of what exporters
write (Meta's: intensity = sqrt(amplitude)).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.offline.export.breakpoints import (
    Shape,
    ascending,
    breakpoints,
    flag,
    many,
    number,
    one_of,
    record,
    text,
)
from overview_dsp.offline.export.clip import LEVELS_PER_S, Clip

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


LONGEST_EVENT_S = 30.0
DULLEST_HZ, SHARPEST_HZ = 65.0, 300.0


def sharpness_of(frequency_hz: float) -> float:
    """Sharpness of a vibration, 0..1; beyond the range its end."""
    part = (frequency_hz - DULLEST_HZ) / (SHARPEST_HZ - DULLEST_HZ)
    return round(min(max(part, 0.0), 1.0), 4)


def vibration_pattern(clip: Clip, budget: int) -> dict[str, Any]:
    """The continuous part: an event and a curve for each 30 s."""
    joints = list(range(0, len(clip.level) - 1, round(LONGEST_EVENT_S * LEVELS_PER_S)))
    level, corners = clip.under_strikes(lambda strike: TRANSIENTS_MS[0])
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


_UNIT, _SIGNED, _SECONDS = number(0.0, 1.0), number(-1.0, 1.0), number(0.0)
_EVENT_IDS = (
    *("HapticIntensity", "HapticSharpness", "AttackTime", "DecayTime", "ReleaseTime", "Sustained"),
    *("AudioVolume", "AudioPitch", "AudioPan", "AudioBrightness"),
)
_CONTROLS = (
    *("HapticIntensityControl", "HapticSharpnessControl", "HapticAttackTimeControl"),
    *("HapticDecayTimeControl", "HapticReleaseTimeControl", "AudioVolumeControl"),
    *("AudioPanControl", "AudioBrightnessControl", "AudioPitchControl"),
    *("AudioAttackTimeControl", "AudioDecayTimeControl", "AudioReleaseTimeControl"),
)
_OWN_UNIT = ("HapticIntensity", "HapticSharpness", "Sustained", "AudioVolume")
_BY_MILLISECOND = 0.0015


def _parameter(value: Any, place: str, faults: list[str]) -> None:
    record({"ParameterID": one_of(*_EVENT_IDS), "ParameterValue": _SIGNED})(value, place, faults)
    if isinstance(value, dict) and value.get("ParameterID") in _OWN_UNIT:
        _UNIT(value.get("ParameterValue"), f"{place}.ParameterValue", faults)


def _control(value: Any, place: str, faults: list[str], id: Any) -> None:
    (_UNIT if id == "HapticIntensityControl" else _SIGNED)(value, place, faults)


_COMMON: dict[str, Shape] = {"Time": _SECONDS, "EventParameters": many(_parameter)}
_EVENTS: dict[str, Shape] = {
    "HapticTransient": record({**_COMMON, "EventType": text()}, {"EventDuration": _SECONDS}),
    "HapticContinuous": record(
        {**_COMMON, "EventType": text(), "EventDuration": number(0.0, LONGEST_EVENT_S, above=0.0)},
    ),
    "AudioCustom": record(
        {**_COMMON, "EventType": text(), "EventWaveformPath": text()},
        {
            "EventDuration": _SECONDS,
            "EventWaveformLoopEnabled": flag,
            "EventWaveformUseVolumeEnvelope": flag,
        },
    ),
    "AudioContinuous": record({**_COMMON, "EventType": text(), "EventDuration": _SECONDS}),
}


def _event(value: Any, place: str, faults: list[str]) -> None:
    kind = value.get("EventType") if isinstance(value, dict) else None
    if not isinstance(kind, str) or kind not in _EVENTS:
        one_of(*_EVENTS)(kind, f"{place}.EventType", faults)
        return
    _EVENTS[kind](value, place, faults)


def _curve(value: Any, place: str, faults: list[str]) -> None:
    id = value.get("ParameterID") if isinstance(value, dict) else None

    def level(value: Any, place: str, faults: list[str]) -> None:
        _control(value, place, faults, id)

    points = many(record({"Time": _SECONDS, "ParameterValue": level}), 1)
    record(
        {
            "ParameterID": one_of(*_CONTROLS),
            "Time": _SECONDS,
            "ParameterCurveControlPoints": points,
        }
    )(value, place, faults)


def _step(value: Any, place: str, faults: list[str]) -> None:
    record({"ParameterID": one_of(*_CONTROLS), "Time": _SECONDS, "ParameterValue": _SIGNED})(
        value, place, faults
    )


def _entry(value: Any, place: str, faults: list[str]) -> None:
    kinds: dict[str, Shape] = {"Event": _event, "ParameterCurve": _curve, "Parameter": _step}
    if not isinstance(value, dict) or len(value) != 1 or next(iter(value)) not in kinds:
        faults.append(f"{place} isn't an object with one of {', '.join(kinds)}")
        return
    ((kind, inner),) = value.items()
    kinds[kind](inner, f"{place}.{kind}", faults)


_METADATA = record({}, {name: text() for name in ("Project", "Created", "Description")})
_DOCUMENT = record({"Version": one_of(1, 1.0), "Pattern": many(_entry, 1)}, {"Metadata": _METADATA})


def faults_of(document: Any) -> list[str]:
    """Every fault of an AHAP document, a line each."""
    faults: list[str] = []
    _DOCUMENT(document, "", faults)
    if faults:
        return faults
    pattern = document["Pattern"]
    events = [entry["Event"] for entry in pattern if "Event" in entry]
    if not events:
        return ["Pattern has no event: it plays nothing"]
    end = max(event["Time"] + event.get("EventDuration", 0.0) for event in events)
    for k, entry in enumerate(pattern):
        curve = entry.get("ParameterCurve")
        if curve is None:
            continue
        place = f"Pattern[{k}].ParameterCurve.ParameterCurveControlPoints"
        times = [point["Time"] for point in curve["ParameterCurveControlPoints"]]
        ascending(times, place, faults)
        if curve["Time"] + times[-1] > end + _BY_MILLISECOND:
            faults.append(
                f"{place} end at {curve['Time'] + times[-1]:g} s, after all events ({end:g} s); "
                "a point's time counts from its curve's"
            )
    vibrating = sorted(
        (event["Time"], event["Time"] + event["EventDuration"])
        for event in events
        if event["EventType"] == "HapticContinuous"
    )
    covered = 0.0
    for start, stop in vibrating:
        if start < covered - _BY_MILLISECOND:
            faults.append(f"a continuous event at {start:g} s begins before the last one's end")
        covered = max(covered, stop)
    return faults
