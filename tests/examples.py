"""Small presets and timelines for tests, with numbers that formulas can be checked against."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import overview_dsp as ov

INERTIA, K1, K2 = 1e-4, 2e-3, 1e-2


def plain_preset(**values):
    """A preset whose surface is bare: `disk__k1=...` sets disk.k1."""
    given = {
        "disk.inertia": INERTIA,
        "disk.k1": K1,
        "disk.k2": K2,
        "surface.friction": 1e-3,
        "surface.intensity_gain": 0.0,
        **{key.replace("__", "."): value for key, value in values.items()},
    }
    kind = ov.EventKind(height=0.0, width_percent=1.0)
    return ov.Preset("plain", "Plain", "A bare surface.", given, {"default": kind})


def preset_with(height=20.0, width=1.0, shape="gaussian", modes=None, **values):
    """The plain preset, whose every event has this profile and click."""
    preset = plain_preset(**values)
    if modes is None:
        modes = (ov.ClickMode(1500.0, 20.0), ov.ClickMode(3700.0, 12.0, -6.0))
    kind = ov.EventKind(height=height, width_percent=width, shape=shape, modes=tuple(modes))
    return replace(preset, kinds={"default": kind})


def timeline_of(*times, duration=100.0, kind="default"):
    """Events of one kind at these times, s; no intensity."""
    events = tuple(ov.Event(float(time), kind) for time in times)
    if not events:
        flat = ov.Intensity(np.array([0.0, duration]), np.array([0.0, 0.0]))
        return ov.Timeline(title="flat", duration_s=duration, events=(), intensity=flat)
    return ov.Timeline(title="test", duration_s=duration, events=events, intensity=None)


def with_friction(surface, friction):
    """A surface with another table, float64 (CELLS + 1,)."""
    return replace(surface, friction=np.asarray(friction, dtype=np.float64))
