"""Presets of every friction model, so that each part of the kernel is run."""

from __future__ import annotations

import overview_dsp as ov

CHANGES = {
    "football": {},
    "stadium": {
        "disk.inertia": 4e-5,
        "disk.k2": 1.2e-2,
        "surface.friction": 9e-4,
        "surface.intensity_gain": 2.0,
        "texture.gain_db": -38.0,
    },
    "gravel": {
        "disk.k2": 0.03,
        "surface.pattern": "grains",
        "surface.pattern_height": 8.0,
        "surface.pattern_period_percent": 0.8,
        "surface.material": "card",
        "surface.pitch_hz": 900.0,
    },
    "door": {
        "disk.k1": 0.008,
        "disk.k2": 0.5,
        "surface.friction": 2e-4,
        "surface.intensity_gain": 1.0,
        "surface.model": "bristle",
        "surface.torque_ratio": 16.0,
        "surface.static_ratio": 2.5,
        "surface.stribeck_speed": 0.25,
        "surface.material": "wood",
        "surface.pitch_hz": 320.0,
    },
    "dial": {
        "disk.k2": 0.25,
        "disk.inertia": 2e-5,
        "surface.model": "detent",
        "surface.pattern": "waves",
        "surface.pattern_period_percent": 5.0,
        "surface.torque_ratio": 8.0,
        "surface.end_stiffness": 1.0,
    },
}


def preset_of(name: str) -> ov.Preset:
    """The football preset on another surface."""
    return ov.load_preset("football").with_changes(CHANGES[name])
