"""How a value moves to another without a corner that could be heard.

    value = target + (from - target) * s(left / length),   s(u) = u**2 (3 - 2 u)

The slope is zero at both ends. A straight ramp's corners are heard: 20 ms of it put a 250 Hz wave's
corner at -48 dB above 2 kHz, this at -80 dB.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import inlined


@inlined
def smooth_step(part):
    """0 to 1, without slope at either end, for a part of 0 to 1."""
    return part * part * (3.0 - 2.0 * part)
