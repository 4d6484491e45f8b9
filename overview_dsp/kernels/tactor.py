"""Carrier of the tactor: a phase-continuous sine with the envelope as amplitude.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.simd.vector import choose


@inlined
def advance(phase, increment):
    """Return the carrier's next phase, turns in [0, 1)."""
    phase = phase + increment
    return choose(phase >= 1.0, phase - 1.0, phase)
