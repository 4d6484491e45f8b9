"""An engine's parameters and surface as plain_voice.c takes them: in radians and seconds."""

from __future__ import annotations

import ctypes
import math

import numpy as np

from overview_dsp.engine.coefficients import APPROACH_S, GRAIN_S
from overview_dsp.engine.engine import Engine
from overview_dsp.kernels import layout
from overview_dsp.units import HALF_TURN, db_to_gain

_DOUBLES = [
    "dt",
    "inertia",
    "k1",
    "k2",
    "smoothing",
    "full_torque",
    "gate",
    "compression",
    "decay",
    "rise",
    "carrier_hz",
    "tactor_gain",
    "strike_torque",
    "strike_compression",
    "approach_s",
    "click_gain",
    "texture_gain",
    "brightness_hz",
    "grain_s",
    "ceiling",
    "dc_pole",
]


class Settings(ctypes.Structure):
    """`Settings` of plain_voice.c."""

    _fields_ = [(name, ctypes.c_double) for name in _DOUBLES]


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
    m = engine.memory
    number = engine.preset.number
    return Settings(
        dt=1.0 / engine.sample_rate,
        inertia=number("disk.inertia"),
        k1=number("disk.k1"),
        k2=number("disk.k2"),
        smoothing=m[layout.C_SMOOTH],
        full_torque=1.0 / m[layout.C_TORQUE],
        gate=m[layout.C_GATE],
        compression=m[layout.C_EXPONENT],
        decay=m[layout.C_DECAY],
        rise=m[layout.C_RISE],
        carrier_hz=number("tactor.frequency_hz"),
        tactor_gain=m[layout.C_TACTOR_GAIN],
        strike_torque=1.0 / m[layout.C_STRIKE_TORQUE],
        strike_compression=m[layout.C_STRIKE_EXPONENT],
        approach_s=APPROACH_S,
        click_gain=m[layout.C_CLICK_GAIN],
        texture_gain=m[layout.C_TEXTURE_GAIN],
        brightness_hz=number("texture.brightness_hz"),
        grain_s=GRAIN_S,
        ceiling=m[layout.C_CEILING],
        dc_pole=m[layout.C_DC_POLE],
    )


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
        np.array([db_to_gain(mode.gain_db) for mode in modes]),
    )
    assert math.isclose(arrays[1][-1], surface.position[-1] * math.pi)
    addresses = [array.ctypes.data for array in arrays]
    scene = Scene(addresses[0], len(surface.position), *addresses[1:])
    scene.kept = arrays
    return scene


def settings_names() -> list[str]:
    """The fields of `Settings`."""
    return list(_DOUBLES)
