"""HJIF, the interchange form of MPEG haptics (ISO/IEC 23090-31): JSON with two perceptions.

- *Vibrotactile*: a channel with the vibration (a wave whose amplitude has keyframes) and one with
  the strikes (short waves), for a C2-like voice coil.
- *Friction*: B(phi) itself, for a device that can brake: one linear curve over the half turn, a
  tick a hundredth of a degree, 1 = the surface's highest friction (in the description).

The timescale is 1000 and every count a whole number: the reference reader drops others, and takes a
millisecond a tick whatever the timescale says. A Transient band is 22 ms at 91 Hz there, whatever
is asked of it; so strikes are waves, under which the vibration's is silent.

What is wrong with an HJIF document: the reference parser's checks, and what it won't play.

The MPEG haptics reference decoder (ISO/IEC 23090-31), for what HJIF documents hold.

Channels and effects are summed as signals: what has one frequency adds by its phase, which counts
from the effect's position; different frequencies add in energy. A wave's amplitude is linear
between keyframes. A transient is 22 ms of 90.9 Hz (two cycles), whatever is asked of it. Gains
multiply.
"""

from __future__ import annotations

import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.kernels.layout import CELLS
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

STRIKE_MS = 12
"""Of a strike's wave: three cycles of a C-2."""

TICKS_PER_TURN = 18_000
"""Of the friction curve: half a turn in hundredths of a degree."""

FRICTION_POINTS = 2000
_TACTOR = 0
_RIGHT_HAND = 0  # no body part is asked for
_LOW_HZ, _HIGH_HZ = 50, 500


def document(clip: Clip, budget: int) -> dict[str, Any]:
    """The clip as an HJIF document."""
    hz = round(clip.frequency_hz)
    level, corners = clip.under_strikes(lambda strike: STRIKE_MS)
    places = breakpoints(level, max(budget, 3) + len(corners), corners)
    vibration = [
        {
            "relative_position": place,
            "amplitude_modulation": round(float(level[place]), 4),
            "frequency_modulation": hz,
        }
        for place in places.tolist()
    ]
    strikes = [
        _wave(
            round(strike.time_s * LEVELS_PER_S),
            [
                {
                    "relative_position": at,
                    "amplitude_modulation": round(strike.amplitude, 4),
                    "frequency_modulation": hz,
                }
                for at in (0, STRIKE_MS // 2, STRIKE_MS - 1)
            ],
        )
        for strike in clip.transients
    ]
    channels = [_waves(0, "vibration", [_wave(0, vibration)])]
    if strikes:
        channels.append(_waves(1, "strikes", strikes))
    highest = float(clip.surface.resistance.max())
    return {
        "version": "2023",
        "profile": "Main",
        "level": 1,
        "date": datetime.date.today().isoformat(),
        "description": f"overView DSP: {clip.title}",
        "timescale": LEVELS_PER_S,
        "perceptions": [
            {
                "id": 0,
                "avatar_id": 0,
                "description": "vibration of the tactor",
                "perception_modality": "Vibrotactile",
                "reference_devices": [_c2(hz)],
                "channels": channels,
                "effect_library": [],
            },
            {
                "id": 1,
                "avatar_id": 0,
                "description": f"friction over the half turn; 1 is {highest:.6g} N m s/rad, a tick "
                "0.01 degree",
                "perception_modality": "Friction",
                "channels": [_friction(clip, highest)],
                "effect_library": [],
            },
        ],
        "avatars": [],
        "syncs": [],
    }


def _channel(number: int, name: str, band: dict[str, Any], **device: int) -> dict[str, Any]:
    return {
        "id": number,
        "description": name,
        "gain": 1.0,
        "mixing_coefficient": 1.0,
        "body_part_mask": _RIGHT_HAND,
        **device,
        "bands": [band],
    }


def _waves(number: int, name: str, effects: list[dict[str, Any]]) -> dict[str, Any]:
    band = {
        "band_type": "VectorialWave",
        "lower_frequency_limit": _LOW_HZ,
        "upper_frequency_limit": _HIGH_HZ,
        "effects": effects,
    }
    return _channel(number, name, band, reference_device_id=_TACTOR)


def _wave(position: int, keyframes: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "effect_type": "Basis",
        "position": position,
        "phase": 0.0,
        "base_signal": "Sine",
        "keyframes": keyframes,
    }


def _friction(clip: Clip, highest: float) -> dict[str, Any]:
    table = clip.surface.resistance / highest
    ticks = np.arange(TICKS_PER_TURN + 1)
    # the highest cell around each tick: no event falls between two
    edges = np.clip(np.rint((ticks - 0.5) / TICKS_PER_TURN * CELLS), 0, CELLS).astype(np.int64)
    curve = np.maximum.reduceat(table, edges)
    # a goal is hundreds of bare surfaces high: no level is too faint
    places = breakpoints(curve / curve.min(), FRICTION_POINTS)
    keyframes = [
        {"relative_position": place, "amplitude_modulation": round(float(curve[place]), 6)}
        for place in places.tolist()
    ]
    if len(keyframes) == 2:  # the reference reader plays a curve of two points as silence
        middle = TICKS_PER_TURN // 2
        keyframes.insert(
            1, {"relative_position": middle, "amplitude_modulation": round(float(curve[middle]), 6)}
        )
    band = {
        "band_type": "Curve",
        "curve_type": "Linear",
        "lower_frequency_limit": 0,
        "upper_frequency_limit": _HIGH_HZ,
        "effects": [_wave(0, keyframes)],
    }
    return _channel(2, "B over phi", band)


def _c2(hz: int) -> dict[str, Any]:
    return {
        "id": _TACTOR,
        "name": "C2 tactor",
        "type": "VCA",
        "minimum_frequency": float(_LOW_HZ),
        "resonance_frequency": float(hz),
        "maximum_frequency": float(_HIGH_HZ),
    }


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


TRANSIENT_MS, TRANSIENT_HZ = 22, 1000.0 / 11.0


def played(hjif: dict[str, Any]) -> NDArray[np.float64]:
    """The amplitude of a document's vibrotactile perceptions; a tick is a millisecond."""
    parts = [
        part
        for perception in hjif["perceptions"]
        if perception["perception_modality"] == "Vibrotactile"
        for channel in perception["channels"]
        for band in channel["bands"]
        for effect in band["effects"]
        for part in _parts(band["band_type"], effect, channel["gain"])
    ]
    count = max((start + len(amplitude) for start, amplitude, _, _ in parts), default=1)
    phasors: dict[float, NDArray[np.complex128]] = {}
    for start, amplitude, hz, phase in parts:
        summed = phasors.setdefault(hz, np.zeros(count, np.complex128))
        turn = phase - 2.0 * np.pi * hz * start / LEVELS_PER_S
        summed[start : start + len(amplitude)] += amplitude * np.exp(1j * turn)
    energy = np.zeros(count)
    for summed in phasors.values():
        energy += np.abs(summed) ** 2
    return np.asarray(np.sqrt(energy))


def _parts(
    band: str, effect: dict[str, Any], gain: float
) -> list[tuple[int, NDArray[np.float64], float, float]]:
    """(start, amplitude at each millisecond, Hz, phase) of an effect's waves."""
    frames, position = effect["keyframes"], effect["position"]
    if band == "Transient":
        return [
            (
                position + frame["relative_position"],
                np.full(TRANSIENT_MS, gain * frame["amplitude_modulation"]),
                TRANSIENT_HZ,
                0.0,
            )
            for frame in frames
        ]
    at = [frame["relative_position"] for frame in frames]
    amplitude = np.interp(
        np.arange(at[-1] + 1), at, [gain * frame["amplitude_modulation"] for frame in frames]
    )
    return [(position, amplitude, frames[0]["frequency_modulation"], effect["phase"])]
