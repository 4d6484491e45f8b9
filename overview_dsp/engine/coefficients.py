"""Parameters become coefficients: what a person sets, turned into what the kernel multiplies by.

Every exponential and sine here is the kernels' own, so that two machines derive the same bits.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.kernels import clutch, elementary, layout
from overview_dsp.kernels.dc_block import CORNER_HZ
from overview_dsp.presets.model import ClickMode, Preset
from overview_dsp.units import db_to_gain

_exp2 = elementary.plain(elementary.exp2)
_sin_turns = elementary.plain(elementary.sin_turns)

CARRIER_LIMIT = 0.45
"""The carrier's frequency stays below this part of the sample rate."""

MODE_LIMIT = 0.49
"""Modes above this part of the sample rate are left out: they would fold back."""

RING_DB = 160.0
"""A click is exactly zero once it has fallen by this much."""

GLIDE_S = 0.02
"""How long a parameter takes to reach a new value."""

APPROACH_S = 0.2
"""Time constant with which the speed of the arriving disk is forgotten: it may stick that long."""

GRAIN_S = 0.05
"""Time constant of the grain's level: many small contacts don't start at once."""

PACE_S = 0.08
"""Time constant of the hand's pace, behind the input smoother."""

PACE_LEAST, PACE_MOST = 0.02, 6.0
"""Timelines a second: below, a finger rests (3.6 degrees a second); above, the input jumps."""

FADE_S = 0.03
"""How long one surface takes to give way to another."""

_MILLIWATT = 1e-3


def _exp(x: float) -> float:
    return float(_exp2(x * elementary.LOG2_E))


def one_pole(time_constant_s: float, sample_rate: float) -> float:
    """Coefficient a of y += a * (x - y) with that time constant."""
    return 1.0 - _exp(-1.0 / (time_constant_s * sample_rate))


def coefficients(preset: Preset, sample_rate: float) -> dict[int, float]:
    """Every gliding coefficient, by its column in the memory block."""
    number = preset.number
    dt = 1.0 / sample_rate
    inertia, k1, k2 = number("disk.inertia"), number("disk.k1"), number("disk.k2")
    to_theta1 = math.pi / layout.CELLS * (k2 / (k1 + k2))
    catch_up, unfold_s = number("disk.catch_up"), number("disk.unfold_s")
    tactor_gain = 0.0 if preset.values["tactor.mute"] else db_to_gain(number("tactor.gain_db"))
    click_gain = 0.0 if preset.values["click.mute"] else db_to_gain(number("click.gain_db"))
    # white noise has its power in half the sample rate, the grain's low-pass keeps a fixed band
    grain = math.sqrt(3.0 * sample_rate / 48_000.0) / math.sqrt(_MILLIWATT)
    return {
        layout.C_SPRING_HELD: (k1 + k2) / inertia * dt * dt,
        layout.C_SPRING_FREE: k1 / inertia * dt * dt,
        layout.C_INERTIA: inertia / dt,
        layout.C_THETA: to_theta1,
        layout.C_OMEGA: to_theta1 * sample_rate,
        layout.C_SMOOTH: one_pole(number("input.smoothing_ms") * 1e-3, sample_rate),
        layout.C_TORQUE: 1e3 / number("tactor.full_torque_mnm"),
        layout.C_GATE: db_to_gain(number("tactor.threshold_db")),
        layout.C_EXPONENT: number("tactor.compression"),
        layout.C_DECAY: one_pole(number("tactor.decay_ms") * 1e-3, sample_rate),
        layout.C_RISE: one_pole(number("tactor.rise_ms") * 1e-3, sample_rate),
        layout.C_CARRIER: number("tactor.frequency_hz") * dt,
        layout.C_TACTOR_GAIN: tactor_gain,
        layout.C_CLICK_GAIN: click_gain,
        layout.C_STRIKE_TORQUE: 1e3 / number("click.full_torque_mnm"),
        layout.C_STRIKE_EXPONENT: number("click.compression"),
        layout.C_TEXTURE_GAIN: db_to_gain(number("texture.gain_db")) * grain,
        layout.C_TEXTURE_CUTOFF: 2.0 * math.pi * number("texture.brightness_hz") * dt,
        layout.C_CEILING: db_to_gain(number("output.ceiling_db")),
        layout.C_GRAIN: one_pole(GRAIN_S, sample_rate),
        layout.C_FORGET: _exp(-dt / APPROACH_S),
        layout.C_CATCH: catch_up / ((k1 + k2) * dt) if catch_up > 0.0 else clutch.OFF,
        layout.C_UNFOLD: dt / unfold_s if unfold_s > 0.0 else PACE_MOST * dt,
        layout.C_PACE: one_pole(PACE_S, sample_rate),
        layout.C_PACE_LEAST: PACE_LEAST * layout.CELLS * dt,
        layout.C_PACE_MOST: PACE_MOST * layout.CELLS * dt,
        layout.C_DC_POLE: _exp(-2.0 * math.pi * CORNER_HZ * dt),
    }


def changes(before: Preset, after: Preset, sample_rate: float) -> list[tuple[int, float]]:
    """The changes that take the kernel from one preset's parameters to another's.

    Pairs of what (a gliding coefficient or a command of `kernels.layout`) and value; the surface
    isn't among them.
    """
    old = coefficients(before, sample_rate)
    new = coefficients(after, sample_rate)
    changed = [(column, target) for column, target in new.items() if target != old[column]]
    returns = after.values["disk.release"] == "return"
    if returns != (before.values["disk.release"] == "return"):
        changed.append((layout.COMMAND_RELEASE_RETURNS, float(returns)))
    return changed


def check_carrier(preset: Preset, sample_rate: float) -> None:
    """InputError if the tactor's carrier is too high for a sample rate (Hz)."""
    frequency = preset.number("tactor.frequency_hz")
    if not frequency < CARRIER_LIMIT * sample_rate:
        raise InputError(
            f"tactor.frequency_hz = {frequency:g} is too high for {sample_rate:g} Hz; "
            f"it must stay below {CARRIER_LIMIT * sample_rate:g} Hz"
        )


@functools.lru_cache(maxsize=1024)
def mode_coefficients(mode: ClickMode, sample_rate: float) -> NDArray[np.float64] | None:
    """A modal resonator's columns in a surface slot, read-only; None if it folds back."""
    turns = mode.frequency_hz / sample_rate
    if turns > MODE_LIMIT:
        return None
    decay = -math.log(1000.0) / (mode.decay_ms * 1e-3 * sample_rate)
    span = layout.PHASES
    columns = np.zeros(layout.MODE_SIZE)
    for n in range(span + 1):
        radius = _exp(n * decay)
        re = radius * float(_sin_turns(n * turns + 0.25))
        im = radius * float(_sin_turns(n * turns))
        if n < span:
            # twice over, so that they can be read from any of them on
            columns[[layout.MODE_RE + n, layout.MODE_RE + span + n]] = re
            columns[[layout.MODE_IM + n, layout.MODE_IM + span + n]] = im
        else:
            columns[layout.MODE_COS] = re
            columns[layout.MODE_SIN] = im
    columns[layout.MODE_TURNS] = turns
    columns[layout.MODE_DECAY] = decay
    columns[layout.MODE_GAIN] = db_to_gain(mode.gain_db)
    columns.flags.writeable = False
    return columns


def ring_samples(mode: ClickMode, sample_rate: float) -> int:
    """Samples until a mode has fallen by `RING_DB`."""
    return math.ceil(RING_DB / 60.0 * mode.decay_ms * 1e-3 * sample_rate)
