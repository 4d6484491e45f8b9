"""HJIF, the interchange form of MPEG haptics (ISO/IEC 23090-31): JSON with two perceptions.

- *Vibrotactile*: a channel with the vibration (a wave whose amplitude has keyframes) and one with
  the strikes (short waves), for a C2-like voice coil.
- *Friction*: B(phi) itself, for a device that can brake: one linear curve over the half turn, a
  tick a hundredth of a degree, 1 = the surface's highest friction (in the description).

The timescale is 1000 and every count a whole number: the reference reader drops others, and takes a
millisecond a tick whatever the timescale says. A Transient band is 22 ms at 91 Hz there, whatever
is asked of it; so strikes are waves, under which the vibration's is silent.
"""

from __future__ import annotations

import datetime
from typing import Any

import numpy as np

from overview_dsp.kernels.layout import CELLS
from overview_dsp.offline.export.breakpoints import breakpoints
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
