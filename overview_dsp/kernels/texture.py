"""Texture of the surface: noise whose level follows the power of friction, brighter with speed.

    target = gain * sqrt(|torque * omega1|)       as in the elasto-plastic model's noise term
    level += a * (target - level)                 50 ms: many small contacts start gradually
    y    += a * (level * noise - y),  a = c/(1 + c),  c = cutoff * (|omega1| + SLOWEST)

sqrt(force * speed) is the noise term of SDT's friction model (Avanzini, Serafin, Rocchesso 2005);
at rest the power is zero, and the texture is silent.

Thread: audio.
"""

from __future__ import annotations

from math import sqrt

from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.simd.vector import choose, rarely

QUIET = 1e-5  # a level of -100 dBFS, below which the texture is zero
SLOWEST = 0.05  # rad/s: offset, so that the filter decays while the disk rests


@inlined
def texture_level(torque, omega, gain):
    """Return the target level of the noise at a torque (N m) and a speed (rad/s)."""
    return gain * sqrt(abs(torque * omega))


@inlined
def smooth_level(target, level, a):
    """Return the level after one sample of smoothing; exactly zero once inaudible."""
    level = level + a * (target - level)
    quiet = choose(target < QUIET, QUIET, -1.0)
    return rarely(level <= quiet, 0.0, level)


@inlined
def brightness(omega, cutoff):
    """Return the low-pass coefficient at a speed (rad/s)."""
    c = cutoff * (abs(omega) + SLOWEST)
    return c / (1.0 + c)


@inlined
def low_pass(x, y, a):
    """Return one sample of the low-pass; exactly zero after it has decayed."""
    y = y + (x - y) * a
    quiet = choose(x == 0.0, QUIET, 0.0)
    return rarely(max(y, -y) < quiet, 0.0, y)
