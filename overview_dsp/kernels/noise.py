"""Seeded white noise whose whole state is one 64-bit word.

Thread: audio.
"""

from __future__ import annotations

import numpy as np

from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.simd.vector import count

SHIFT_A = np.uint64(12)
SHIFT_B = np.uint64(25)
SHIFT_C = np.uint64(27)
SHIFT_TO_53_BITS = np.uint64(11)
MULTIPLIER = np.uint64(2685821657736338717)
TWO_TO_MINUS_52 = 2.220446049250313e-16


@inlined
def next_state(state):
    """Return the next word of xorshift64* (Vigna 2016, arXiv:1402.6246); state is never zero."""
    state = state ^ (state >> SHIFT_A)
    state = state ^ (state << SHIFT_B)
    return state ^ (state >> SHIFT_C)


@inlined
def white(state):
    """Return a uniform value in [-1, 1) from a state word (variance 1/3)."""
    return count((state * MULTIPLIER) >> SHIFT_TO_53_BITS) * TWO_TO_MINUS_52 - 1.0


def seed_state(seed: int) -> int:
    """Return a well-mixed, non-zero state word of any integer seed (splitmix64's finaliser)."""
    mask = (1 << 64) - 1
    z = (seed + 0x9E3779B97F4A7C15) & mask
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & mask
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
    return (z ^ (z >> 31)) or 1
