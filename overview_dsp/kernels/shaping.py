"""Second stage: what each sample of torque is worth, sample by sample alone.

No sample here needs its neighbour, so the compiler does several at once.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import point
from overview_dsp.kernels.elementary import sin_turns
from overview_dsp.kernels.envelope import compress
from overview_dsp.kernels.texture import brightness, grain_level


@point
def shape(m, frames):
    """Fill the D_AMPLITUDE, D_SINE, D_GRAIN and D_COLOUR columns of one chunk from the disk's."""
    scale = m[layout.C_TORQUE]
    gate = m[layout.C_GATE]
    exponent = m[layout.C_EXPONENT]
    gain = m[layout.C_TEXTURE_GAIN]
    cutoff = m[layout.C_TEXTURE_CUTOFF]
    for n in range(frames):
        torque = m[layout.D_TORQUE + n]
        m[layout.D_AMPLITUDE + n] = compress(torque, scale, gate, exponent)
        m[layout.D_SINE + n] = sin_turns(m[layout.D_PHASE + n])
        omega = m[layout.D_OMEGA + n]
        m[layout.D_GRAIN + n] = grain_level(torque, omega, gain)
        m[layout.D_COLOUR + n] = brightness(omega, cutoff)
