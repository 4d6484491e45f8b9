"""Materials: modes of a struck material from its pitch.

The frequency ratios of a small solid depend on its shape. Each mode decays by the material's
friction tan(phi), by which listeners recognise materials (Wildes and Richards 1988; Klatzky, Pai
and Krotkov 2000):

    decay to -60 dB = ln 1000 / (pi * frequency * tan(phi))

| material | shape, its ratios | tan(phi) |
|---|---|---|
| glass | a wine glass, struck at its rim (Fletcher and Rossing 1998) | 0.003 |
| wood | a free bar (Euler and Bernoulli) | 0.02 |
| metal | a free round plate | 0.0012 |
| plastic | a free bar, hollow: nearer together | 0.06 |
| card | a sheet held at its edge: a membrane | 0.25 |

The ratios are those of ideal shapes; card's tan(phi) is chosen by ear, below all plastics' ringing.
"""

from __future__ import annotations

import math
from typing import Any

from overview_dsp.design.presets.model import ClickMode
from overview_dsp.design.presets.parameters import MODE_PARAMETERS
from overview_dsp.files.toml import load_toml

_MATERIALS: dict[str, dict[str, Any]] = load_toml(__file__, "materials.toml")


def modes_of(material: str, pitch_hz: float, decay_scale: float = 1.0) -> tuple[ClickMode, ...]:
    """Return the modes of a material with a lowest mode of `pitch_hz`; none for "none".

    `decay_scale` scales the decay times: a held object is damped more than a free one.
    """
    made_of = _MATERIALS.get(material)
    if made_of is None:
        return ()
    frequency, decay = MODE_PARAMETERS["frequency_hz"], MODE_PARAMETERS["decay_ms"]
    found = []
    for index, ratio in enumerate(made_of["ratios"]):
        hz = pitch_hz * ratio
        if hz <= frequency.high:
            ms = decay_scale * 1000.0 * math.log(1000.0) / (math.pi * hz * made_of["loss"])
            ms = min(max(ms, decay.low), decay.high)
            found.append(ClickMode(hz, ms, made_of["fall_db"] * index))
    return tuple(found)


def louder(modes: tuple[ClickMode, ...], gain_db: float) -> tuple[ClickMode, ...]:
    """Return modes with raised levels."""
    return tuple(
        ClickMode(mode.frequency_hz, mode.decay_ms, mode.gain_db + gain_db) for mode in modes
    )
