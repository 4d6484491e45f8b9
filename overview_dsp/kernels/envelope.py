"""Envelope of the vibration: threshold, compression, rise and decay of the torque.

    t = max(0, |torque| / full - gate)
    c = t**p
    a = c (27 + c**2)/(27 + 9 c**2)       compression, saturating at 1 (Pade form of tanh)
    h = max(a, h + decay * (a - h))       peak follower: extends peaks too short for the skin
    e = two one-pole low-passes of h      keeps the vibration's sidebands near its carrier

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.math_functions import power
from overview_dsp.kernels.simd.vector import choose, rarely

FAINTEST = 1e-12  # of the full torque: below it, a torque has no amplitude
SILENCE = 1e-7  # an amplitude at -140 dBFS, below the last bit of 24: from here it is zero


@inlined
def compress(torque, scale, gate, exponent):
    """Return the amplitude in [0, 1] of a torque (N m); branch-free, so that it vectorises."""
    t = abs(torque) * scale - gate
    # a NaN fails the comparison and is silent
    felt = t > FAINTEST
    c = power(choose(felt, t, 1.0), exponent)
    c = choose(felt, min(c, 3.0), 0.0)
    squared = c * c
    return c * (27.0 + squared) / (27.0 + 9.0 * squared)


@inlined
def follow(amplitude, follower, e1, e2, decay, rise):
    """Return follower and low-passes after one sample; exactly zero once inaudible."""
    falling = follower + decay * (amplitude - follower)
    follower = choose(amplitude > follower, amplitude, falling)
    silence = choose(amplitude == 0.0, SILENCE, 0.0)
    follower = rarely(follower < silence, 0.0, follower)
    e1 = e1 + rise * (follower - e1)
    e2 = e2 + rise * (e1 - e2)
    silence = choose(follower == 0.0, SILENCE, 0.0)
    silent = e1 + e2 < silence
    return follower, rarely(silent, 0.0, e1), rarely(silent, 0.0, e2)
