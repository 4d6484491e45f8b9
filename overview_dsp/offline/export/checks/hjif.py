"""What is wrong with an HJIF document: the reference parser's checks, and what it won't play."""

from __future__ import annotations

import datetime
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

_ANY = number()
MODALITIES = (
    *("Other", "Pressure", "Acceleration", "Velocity", "Position", "Temperature", "Vibrotactile"),
    *("Water", "Wind", "Force", "Vibrotactile Texture", "Stiffness", "Friction", "Electrotactile"),
)
_KEYFRAME = record(
    {"relative_position": whole(0), "amplitude_modulation": number(-1.0, 1.0)},
    {"frequency_modulation": whole(0)},
)
_EFFECT = record(
    {
        "effect_type": one_of("Basis", "Reference", "Composite"),
        "position": whole(0),
        "phase": _ANY,
        "base_signal": one_of("Sine", "Square", "Triangle", "SawToothUp", "SawToothDown"),
        "keyframes": many(_KEYFRAME, 1),
    },
    {"id": whole(0)},
)
_BAND = record(
    {
        "band_type": one_of("Transient", "Curve", "VectorialWave", "WaveletWave"),
        "lower_frequency_limit": whole(0),
        "upper_frequency_limit": whole(0),
        "effects": many(_EFFECT, 1),
    },
    {"curve_type": one_of("Linear", "Cubic", "Akima", "Bezier", "Bspline", "Unknown")},
)
_CHANNEL = record(
    {
        "id": whole(0),
        "description": text(),
        "gain": _ANY,
        "mixing_coefficient": _ANY,
        "body_part_mask": whole(0),
        "bands": many(_BAND, 1, 7),
    },
    {"reference_device_id": whole(0)},
)
_DEVICE = record(
    {"id": whole(0), "name": text()},
    {
        "type": one_of("Unknown", "LRA", "VCA", "ERM", "Piezo"),
        "minimum_frequency": number(0.0),
        "resonance_frequency": number(0.0),
        "maximum_frequency": number(0.0),
    },
)
_PERCEPTION = record(
    {
        "id": whole(0),
        "avatar_id": whole(0),
        "description": text(),
        "perception_modality": one_of(*MODALITIES),
        "channels": many(_CHANNEL, 1, 127),
        "effect_library": many(record({})),
    },
    {"reference_devices": many(_DEVICE)},
)


def _date(value: Any, place: str, faults: list[str]) -> None:
    try:
        datetime.date.fromisoformat(value)
    except (TypeError, ValueError):
        faults.append(f"{place} isn't a date like 2026-07-01")


_DOCUMENT: Shape = record(
    {
        "version": text(r"(202[3-9]|20[3-9][0-9]|2[1-9][0-9]{2}|[3-9][0-9]{3})(-[0-9])?"),
        "profile": one_of("Main", "Simple Parametric"),
        "level": one_of(1, 2),
        "date": _date,
        "description": text(),
        # others play with the wrong phase
        "timescale": one_of(1000),
        "perceptions": many(_PERCEPTION, 1),
        "avatars": many(record({})),
        "syncs": many(record({})),
    }
)


def faults_of(document: Any) -> list[str]:
    """Every fault of an HJIF document, a line each."""
    faults: list[str] = []
    _DOCUMENT(document, "", faults)
    if faults:
        return faults
    perceptions = document["perceptions"]
    _unique([one["id"] for one in perceptions], "perceptions", faults)
    channels = [channel for one in perceptions for channel in one["channels"]]
    _unique([one["id"] for one in channels], "channels", faults)
    for p, perception in enumerate(perceptions):
        place = f"perceptions[{p}]"
        devices = perception.get("reference_devices", [])
        for k, device in enumerate(devices):
            _device(device, f"{place}.reference_devices[{k}]", faults)
        for c, channel in enumerate(perception["channels"]):
            here = f"{place}.channels[{c}]"
            wanted = channel.get("reference_device_id")
            if wanted is not None and wanted not in [device["id"] for device in devices]:
                faults.append(f"{here}.reference_device_id = {wanted} names no device")
            for b, band in enumerate(channel["bands"]):
                _band(band, f"{here}.bands[{b}]", faults)
    return faults


def _unique(ids: list[int], place: str, faults: list[str]) -> None:
    if len(set(ids)) < len(ids):
        faults.append(f"{place}: an id is there twice")


def _device(device: dict[str, Any], place: str, faults: list[str]) -> None:
    names = ("minimum_frequency", "resonance_frequency", "maximum_frequency")
    given = [device[name] for name in names if name in device]
    if given != sorted(given):
        faults.append(f"{place}: minimum, resonance and maximum frequency aren't in this order")


def _band(band: dict[str, Any], place: str, faults: list[str]) -> None:
    if band["upper_frequency_limit"] < band["lower_frequency_limit"]:
        faults.append(f"{place}: its upper frequency limit is below the lower one")
    curve = band["band_type"] == "Curve"
    if curve and "curve_type" not in band:
        faults.append(f"{place}.curve_type is missing")
    for e, effect in enumerate(band["effects"]):
        here = f"{place}.effects[{e}]"
        frames = effect["keyframes"]
        ascending([frame["relative_position"] for frame in frames], f"{here}.keyframes", faults)
        if curve and (len(frames) < 3 or effect["position"]):
            faults.append(f"{here}: a curve has 3 keyframes or more and begins at 0, or is silent")
        if band["band_type"] == "VectorialWave":
            faults += [
                f"{here}.keyframes[{k}].frequency_modulation is missing"
                for k, frame in enumerate(frames)
                if "frequency_modulation" not in frame
            ]
    ascending([effect["position"] for effect in band["effects"]], f"{place}.effects", faults)
