"""A haptic clip as a layer of a preset: its vibration as an event's friction, its strikes as modes.

The friction's course over the event is the clip's amplitude over its length; what was time becomes
the way over the event, so the hand plays the clip, as fast as it moves and backwards too. Strikes
become modes of the click: sharpness is pitch, strength is level.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np

from overview_dsp.design.presets.model import DEFAULT_KIND, ClickMode, EventKind, Preset
from overview_dsp.design.presets.parameters import MODE_PARAMETERS
from overview_dsp.errors import InputError
from overview_dsp.kernels.layout import MAX_MODES
from overview_dsp.offline.export.clip import Transient
from overview_dsp.offline.export.reading import PlayedClip
from overview_dsp.offline.export.strikes import DULL_HZ, SHARP_HZ

POINTS = 64
Layer = Literal["tactor", "click", "both"]

_DULL_MS, _SHARP_MS = 60.0, 12.0


def course(clip: PlayedClip, count: int = POINTS) -> tuple[float, ...]:
    """The clip's amplitude, strikes among it, at `count` positions, its highest 1."""
    level = clip.played
    edges = np.linspace(0, len(level), count + 1).astype(np.int64)
    edges = np.minimum(edges[:-1], len(level) - 1)
    highest = np.maximum.reduceat(level, edges)
    if highest.max() <= 0.0:
        raise InputError("the clip is silent")
    return tuple(round(float(value), 4) for value in highest / highest.max())


def modes(clip: PlayedClip) -> tuple[ClickMode, ...]:
    """The clip's strikes as modes, the strongest first, a pitch once."""
    found: list[Transient] = []
    for strike in sorted(clip.transients, key=lambda strike: -strike.amplitude):
        if strike.amplitude > 0.0 and all(
            abs(strike.sharpness - other.sharpness) > 0.02 for other in found
        ):
            found.append(strike)
    if not found:
        raise InputError("the clip has no strikes (transients, emphasis) to make a click of")
    return tuple(_mode(strike, found[0].amplitude) for strike in found[:MAX_MODES])


def _mode(strike: Transient, loudest: float) -> ClickMode:
    ratio = strike.sharpness
    hz = DULL_HZ * (SHARP_HZ / DULL_HZ) ** ratio
    decay = _DULL_MS * (_SHARP_MS / _DULL_MS) ** ratio
    lowest = MODE_PARAMETERS["gain_db"].low
    gain = max(lowest, 20.0 * math.log10(strike.amplitude / loudest))
    return ClickMode(round(hz, 1), round(decay, 1), round(gain, 1))


def with_layer(preset: Preset, kind: str, clip: PlayedClip, layer: Layer) -> Preset:
    """The preset with a clip laid into one of its kinds, which is made from `default` if new."""
    base: EventKind = replace(preset.kinds[preset.kind_for(kind) or DEFAULT_KIND], also=())
    if layer in ("tactor", "both"):
        base = replace(base, points=course(clip))
    # of both, a clip without strikes leaves the click as it is
    if layer == "click" or (layer == "both" and clip.transients):
        base = replace(base, modes=modes(clip))
    return replace(preset, kinds={**preset.kinds, kind: base})
