"""The surface's grain: noise that grows with the friction's power and brightens with speed.

    level = gain * sqrt(|torque * omega1|)        as in the elasto-plastic model's noise term
    y    += a * (level * noise - y),  a = c/(1 + c),  c = cutoff * (|omega1| + SLOWEST)

sqrt(force * speed) is the noise term of SDT's friction model (Avanzini, Serafin, Rocchesso 2005);
at rest there is no power, hence silence.

Thread: audio.
"""

from __future__ import annotations

from math import sqrt

from overview_dsp.kernels.compiling import point

QUIET = 1e-5  # a level at -100 dBFS: from here the grain is zero
SLOWEST = 0.05  # rad/s: the filter of a resting disk still forgets


@point
def grain_level(torque, omega, gain):
    """Level of the noise at a torque (N m) and a speed (rad/s); exactly zero once inaudible."""
    level = gain * sqrt(abs(torque * omega))
    return level if level > QUIET else 0.0


@point
def colour(x, y, omega, cutoff):
    """One sample of the speed-dependent low-pass; exactly zero once it has died away."""
    c = cutoff * (abs(omega) + SLOWEST)
    y = y + (x - y) * (c / (1.0 + c))
    if x == 0.0 and abs(y) < QUIET:
        y = 0.0
    return y
