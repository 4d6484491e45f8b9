"""Second stage: memoryless functions of torque and speed.

Samples are independent of each other, so the compiler vectorises this stage.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.envelope import compress
from overview_dsp.kernels.math_functions import sin_turns
from overview_dsp.kernels.texture import brightness, texture_level

SIDE_BY_SIDE = 16  # the number of samples is rounded up to this, which costs no time


@inlined
def shape(f64, frames, beyond):
    """Fill the D_AMPLITUDE, D_SINE, D_TEXTURE_LEVEL and D_BRIGHTNESS columns of one chunk from the
    disk's.

    It begins `beyond` samples after one of the output gain's grid.
    """
    first = f64[layout.GAIN_FROM]
    growth = f64[layout.GAIN_STEP]
    scale = f64[layout.C_TORQUE]
    gate = f64[layout.C_GATE]
    exponent = f64[layout.C_EXPONENT]
    gain = f64[layout.C_TEXTURE_GAIN] * f64[layout.TEXTURE_GAIN]
    cutoff = f64[layout.C_TEXTURE_CUTOFF]
    for n in range((frames + SIDE_BY_SIDE - 1) & -SIDE_BY_SIDE):
        torque = f64[layout.D_TORQUE + n]
        raised = first + growth * float(beyond + n + 1)
        f64[layout.D_AMPLITUDE + n] = compress(torque * raised, scale, gate, exponent)
        f64[layout.D_SINE + n] = sin_turns(f64[layout.D_PHASE + n])
        omega = f64[layout.D_OMEGA + n]
        f64[layout.D_TEXTURE_LEVEL + n] = texture_level(torque, omega, gain)
        f64[layout.D_BRIGHTNESS + n] = brightness(omega, cutoff)
