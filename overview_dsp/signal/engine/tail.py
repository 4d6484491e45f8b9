"""How long the sound goes on after the last hand has let go."""

from __future__ import annotations

import math

import numpy as np

from overview_dsp.design.presets.model import Preset
from overview_dsp.kernels.decibels import gain_of_db
from overview_dsp.kernels.derive import ARRIVAL_S, PACE_MOST
from overview_dsp.kernels.layout import CELLS
from overview_dsp.kernels.output_gain import LEAST_CURSOR, SLOWEST_PACE, USUAL_PACE
from overview_dsp.kernels.texture import QUIET
from overview_dsp.signal.surface.model import Surface

_MARGIN = 1.25  # the estimate takes the disk for quasi-static; events add their inertia
_SKIN_FALLS = 20.0  # e-foldings of the tactor's envelope until it is exactly zero
_DC_BLOCKER_S = 0.2


def tail_seconds(preset: Preset, surface: Surface) -> float:
    """An upper estimate of the time from the last release to exact silence, s.

    The disk is followed down from the end of the timeline: in the friction of each cell it falls by
    its slower time constant, until neither its torque nor its grain counts any more.
    """
    number = preset.number
    inertia, k1, k2 = number("disk.inertia"), number("disk.k1"), number("disk.k2")
    springs = [k1 + k2, k1] if preset.values["disk.release"] == "recoil" else [k1 + k2]
    gate = gain_of_db(number("tactor.threshold_db")) * number("tactor.full_torque_mnm") * 1e-3
    grain = gain_of_db(number("texture.gain_db")) / math.sqrt(1e-3)
    theta1_full = math.pi * k2 / (k1 + k2)
    slow, recoil = number("tactor.slow_gain_exponent"), number("tactor.recoil_gain_exponent")
    loudest = max((USUAL_PACE / SLOWEST_PACE) ** slow, LEAST_CURSOR**-recoil)
    has_clutch = number("clutch.max_speed_ratio") > 0.0
    longest = 0.0
    for k in springs:
        b = surface.friction
        root = np.sqrt(np.maximum(b * b - 4.0 * k * inertia, 0.0))
        falls = 2.0 * inertia / (b - root)
        fall = float(np.sum(falls[1:-1] * np.log(1.0 + 1.0 / np.arange(1, CELLS))))
        # below the first cell: down to the angle whose torque or grain is the last to matter
        silent_torque = gate / loudest / k
        lowest = float(falls[:2].max())
        silent_grain = QUIET / (grain * loudest**2) * math.sqrt(lowest / k)
        last = min(silent_torque, silent_grain) / theta1_full
        fall += lowest * max(0.0, math.log(1.0 / (last * CELLS)))
        if surface.bristles is not None or surface.detents is not None:
            # held off the springs' rest, the disk comes to its own from anywhere
            fall += float(falls.max()) * math.log(CELLS)
        if has_clutch and k > k1:
            # to a finger that rests, at least in proportion to the way that is left
            tap_s = number("clutch.tap_duration_s") or 1.0 / PACE_MOST
            fall += tap_s * math.log(CELLS)
            fall += 1.0 / (number("clutch.max_speed") or PACE_MOST)
        longest = max(longest, fall)
    ring = max(
        (
            mode.decay_ms * 1e-3
            for modes in (*surface.kind_modes, surface.own_modes)
            for mode in modes
        ),
        default=0.0,
    )
    skin = _SKIN_FALLS * (number("tactor.decay_ms") + 2.0 * number("tactor.rise_ms")) * 1e-3
    settle = 40.0 * number("input.smoothing_ms") * 1e-3
    return _MARGIN * longest + ARRIVAL_S + settle + skin + _DC_BLOCKER_S + 160.0 / 60.0 * ring
