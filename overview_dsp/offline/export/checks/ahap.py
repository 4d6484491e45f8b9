"""What is wrong with an AHAP document."""

from __future__ import annotations

from typing import Any

from overview_dsp.offline.export.ahap import LONGEST_EVENT_S
from overview_dsp.offline.export.shapes import (
    Shape,
    ascending,
    flag,
    many,
    number,
    one_of,
    record,
    text,
)

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
