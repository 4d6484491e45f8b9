"""What is wrong with an Android document: JSON, and the platform's XML."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

from overview_dsp.offline.export.android import MAX_POINTS, POINT_MS
from overview_dsp.offline.export.shapes import many, number, one_of, record, text, whole

_HZ = number(0.0, above=0.0)
_POINT = record({"amplitude": number(0.0, 1.0), "frequencyHz": _HZ, "durationMs": whole(*POINT_MS)})
_EFFECT = record(
    {
        "startMs": whole(0),
        "initialFrequencyHz": _HZ,
        "controlPoints": many(_POINT, 1, MAX_POINTS),
    }
)
_DOCUMENT = record(
    {
        "description": text(),
        "waveform": record(
            {
                "timings": many(whole(1), 1),
                # 0 would switch the motor off inside the clip
                "amplitudes": many(whole(1, 255), 1),
                "repeat": one_of(-1),
            }
        ),
        "envelopeEffects": many(_EFFECT),
    }
)


def faults_of(document: Any) -> list[str]:
    """Every fault of a document of an Android export, a line each."""
    faults: list[str] = []
    _DOCUMENT(document, "", faults)
    if faults:
        return faults
    wave = document["waveform"]
    if len(wave["timings"]) != len(wave["amplitudes"]):
        faults.append(
            f"waveform: {len(wave['timings'])} timings and {len(wave['amplitudes'])} amplitudes"
        )
    end = 0
    for k, effect in enumerate(document["envelopeEffects"]):
        if effect["startMs"] < end:
            faults.append(f"envelopeEffects[{k}].startMs is before the last effect's end ({end})")
        points = effect["controlPoints"]
        end = effect["startMs"] + sum(point["durationMs"] for point in points)
        if points[-1]["amplitude"] != 0.0:
            faults.append(f"envelopeEffects[{k}] doesn't end in silence: the next one would click")
    return faults


def xml_faults_of(root: ElementTree.Element) -> list[str]:
    """Every fault of the XML of a waveform, a line each."""
    if root.tag != "vibration-effect" or [child.tag for child in root] != ["waveform-effect"]:
        return ["it isn't a vibration-effect with a waveform-effect"]
    entries = list(root[0])
    faults = [] if entries else ["waveform-effect is empty"]
    for k, entry in enumerate(entries):
        place = f"waveform-effect[{k}]"
        if entry.tag != "waveform-entry" or set(entry.keys()) != {"durationMs", "amplitude"}:
            faults.append(f"{place} isn't a waveform-entry with durationMs and amplitude")
            continue
        for key, low, high in (("durationMs", 1, float("inf")), ("amplitude", 1, 255)):
            value = entry.get(key, "")
            if not (value.isascii() and value.isdigit() and low <= int(value[:12]) <= high):
                faults.append(f"{place}.{key} = {value[:20]!r}; it is {low} to {high:g}")
    return faults
