"""What is wrong with a `.haptic` document, by Meta's strict validator and its renderer."""

from __future__ import annotations

from typing import Any

from overview_dsp.offline.export.shapes import (
    Shape,
    ascending,
    many,
    number,
    one_of,
    record,
    text,
    whole,
)

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
