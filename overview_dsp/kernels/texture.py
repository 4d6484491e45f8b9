"""The surface's grain: noise that grows with the friction's power and brightens with speed.

    target = gain * sqrt(|torque * omega1|)       as in the elasto-plastic model's noise term
    level += a * (target - level)                 50 ms: many small contacts don't start at once
    y    += a * (level * noise - y),  a = c/(1 + c),  c = cutoff * (|omega1| + SLOWEST)

sqrt(force * speed) is the noise term of SDT's friction model (Avanzini, Serafin, Rocchesso 2005);
at rest there is no power, hence silence.

Thread: audio.
"""

from __future__ import annotations

from math import sqrt

from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.simd.vector import choose, rarely

QUIET = 1e-5  # a level at -100 dBFS: from here the grain is zero
SLOWEST = 0.05  # rad/s: the filter of a resting disk still forgets


@inlined
def grain_level(torque, omega, gain):
    """Level the noise heads for at a torque (N m) and a speed (rad/s)."""
    return gain * sqrt(abs(torque * omega))


@inlined
def smooth_level(target, level, a):
    """One sample of the level's smoothing; exactly zero once inaudible."""
    level = level + a * (target - level)
    quiet = choose(target < QUIET, QUIET, -1.0)
    return rarely(level <= quiet, 0.0, level)


@inlined
def brightness(omega, cutoff):
    """The low-pass's coefficient at a speed (rad/s)."""
    c = cutoff * (abs(omega) + SLOWEST)
    return c / (1.0 + c)


@inlined
def low_pass(x, y, a):
    """One sample of the low-pass; exactly zero once it has died away."""
    y = y + (x - y) * a
    quiet = choose(x == 0.0, QUIET, 0.0)
    return rarely(max(y, -y) < quiet, 0.0, y)
