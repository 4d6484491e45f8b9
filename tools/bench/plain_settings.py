"""An engine's parameters and surface as plain_voice.c takes them: in radians and seconds."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable

import numpy as np

from overview_dsp.kernels import layout
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.kernels.derive import APPROACH_S, TEXTURE_LEVEL_S
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.units import HALF_TURN

# in the C struct's order: a parameter of the preset, a coefficient's column, or what makes it
_SETTINGS: dict[str, str | int | Callable[[Engine], float]] = {
    "dt": lambda engine: 1.0 / engine.sample_rate,
    "inertia": "disk.inertia",
    "k1": "disk.k1",
    "k2": "disk.k2",
    "smoothing": layout.C_SMOOTH,
    "full_torque": lambda engine: 1.0 / engine.memory[layout.C_TORQUE],
    "gate": layout.C_GATE,
    "compression": layout.C_EXPONENT,
    "decay": layout.C_DECAY,
    "rise": layout.C_RISE,
    "carrier_hz": "tactor.frequency_hz",
    "tactor_gain": layout.C_TACTOR_GAIN,
    "strike_torque": lambda engine: 1.0 / engine.memory[layout.C_STRIKE_TORQUE],
    "strike_compression": layout.C_STRIKE_EXPONENT,
    "approach_s": lambda engine: APPROACH_S,
    "click_gain": layout.C_CLICK_GAIN,
    "texture_gain": layout.C_TEXTURE_GAIN,
    "brightness_hz": "texture.brightness_hz",
    "grain_s": lambda engine: TEXTURE_LEVEL_S,
    "ceiling": layout.C_CEILING,
    "dc_pole": layout.C_DC_POLE,
}
SETTINGS = tuple(_SETTINGS)
"""Names of a C version's settings, in their order."""


class Settings(ctypes.Structure):
    """`Settings` of plain_voice.c."""

    _fields_ = [(name, ctypes.c_double) for name in SETTINGS]


class Scene(ctypes.Structure):
    """`Scene` of plain_voice.c; `kept` holds its arrays alive."""

    _fields_ = [
        ("friction", ctypes.c_void_p),
        ("events", ctypes.c_int64),
        *((name, ctypes.c_void_p) for name in ("place", "release", "kind", "first")),
        *((name, ctypes.c_void_p) for name in ("frequency_hz", "decay_s", "gain")),
    ]
    kept: tuple[np.ndarray, ...]


def plain_settings(engine: Engine) -> Settings:
    """A prepared engine's parameters."""

    def value(of: str | int | Callable[[Engine], float]) -> float:
        if isinstance(of, str):
            return engine.preset.number(of)
        return float(engine.memory[of]) if isinstance(of, int) else of(engine)

    return Settings(*(value(of) for of in _SETTINGS.values()))


def plain_scene(engine: Engine) -> Scene:
    """A prepared engine's surface."""
    surface = engine.surface
    modes = [mode for kind in surface.kind_modes for mode in kind]
    first = np.concatenate([[0], np.cumsum([len(kind) for kind in surface.kind_modes])])
    arrays = (
        np.ascontiguousarray(surface.friction),
        surface.position * HALF_TURN,
        np.ascontiguousarray(surface.release),
        np.ascontiguousarray(surface.kind),
        np.append(first, first[-1]).astype(np.int64),  # an empty kind ends the list
        np.array([mode.frequency_hz for mode in modes]),
        np.array([mode.decay_ms * 1e-3 for mode in modes]),
        np.array([gain_of_db(mode.gain_db) for mode in modes]),
    )
    assert math.isclose(arrays[1][-1], surface.position[-1] * math.pi)
    addresses = [array.ctypes.data for array in arrays]
    scene = Scene(addresses[0], len(surface.position), *addresses[1:])
    scene.kept = arrays
    return scene
