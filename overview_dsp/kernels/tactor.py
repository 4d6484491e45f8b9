"""The tactor's carrier: a phase-continuous sine, whose amplitude is the envelope.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import point


@point
def advance(phase, increment):
    """The carrier's next phase, turns in [0, 1)."""
    phase = phase + increment
    return phase - 1.0 if phase >= 1.0 else phase
