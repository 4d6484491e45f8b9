"""Output gains of tactor and texture for slow inputs and for the recoil.

    engaged:   (0.4 / pace)**a,   pace = the input's, 0.02 to 0.4 timelines per second
    recoil:    cursor**-b,        cursor from 0.02 up

A slow disk has little torque B*omega, and so has a disk near the end of the recoil, but the user's
threshold is constant. The texture's level, sqrt(torque*omega), falls twice as fast with the pace
and gets the squared gain (with a = 1/2 it is constant for slow paces). In the recoil it gets the
root of the gain. The model's torque, the clicks and the trace are not changed. The gain is
computed at every `layout.GAIN_GRID`-th sample since reset and interpolated linearly, so that no
partition into blocks changes a bit. With an exponent of 0 it is exactly 1.

Thread: audio.
"""

from __future__ import annotations

from math import sqrt

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import inlined, outlined
from overview_dsp.kernels.math_functions import power

USUAL_PACE, SLOWEST_PACE = 0.4, 0.02  # timelines a second
LEAST_CURSOR = 0.02
PER_GRID = 1.0 / layout.GAIN_GRID


@outlined
def gain_now(f64, i64):
    """Return the gain for the present state."""
    if i64[layout.ENGAGED] == 1:
        pace = f64[layout.PACE] * (f64[layout.S_SAMPLE_RATE] / layout.CELLS)
        pace = min(max(pace, SLOWEST_PACE), USUAL_PACE)
        return power(USUAL_PACE / pace, f64[layout.C_SLOW_EXPONENT])
    cursor = min(max(f64[layout.X] / layout.CELLS, LEAST_CURSOR), 1.0)
    return power(1.0 / cursor, f64[layout.C_RECOIL_EXPONENT])


@inlined
def set_gain(f64, i64):
    """Set the gain at a sample of the grid and its slope to the next one."""
    before = f64[layout.GAIN_TO]
    gain = 1.0
    texture = 1.0
    if max(f64[layout.C_SLOW_EXPONENT], f64[layout.C_RECOIL_EXPONENT]) > 0.0:
        gain = gain_now(f64, i64)
        texture = gain * gain if i64[layout.ENGAGED] == 1 else sqrt(gain)
    f64[layout.TEXTURE_GAIN] = texture
    f64[layout.GAIN_FROM] = before
    f64[layout.GAIN_TO] = gain
    f64[layout.GAIN_STEP] = (gain - before) * PER_GRID


@inlined
def on_grid(i64):
    """Return the number of samples since the last sample of the grid."""
    return i64[layout.CLOCK] & (layout.GAIN_GRID - 1)
