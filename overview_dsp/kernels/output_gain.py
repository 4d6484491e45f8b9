"""Output gains of a slow hand and of the recoil: of the torque that the tactor gets, and of grain.

    engaged:   (0.4 / pace)**a,   pace = the hand's, 0.02 to 0.4 timelines a second
    recoil:    cursor**-b,        cursor from 0.02 up

A slow disk has little torque, as B*omega is, and so has one whose spring is nearly unwound; a
person's threshold stays. The grain's level, sqrt(torque*omega), falls twice as fast with the pace
and gets the gain twice (with a = 1/2 it is the same at any slow pace); in the recoil it gets its
root, as its torque does. The model's torque, the clicks and the trace are not changed. The gain is
known at every `layout.GAIN_GRID`-th sample and linear between, counted from reset, so that no
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
    """The gain that the state at this sample asks for."""
    if i64[layout.ENGAGED] == 1:
        pace = f64[layout.PACE] * (f64[layout.S_SAMPLE_RATE] / layout.CELLS)
        pace = min(max(pace, SLOWEST_PACE), USUAL_PACE)
        return power(USUAL_PACE / pace, f64[layout.C_SLOW_EXPONENT])
    cursor = min(max(f64[layout.X] / layout.CELLS, LEAST_CURSOR), 1.0)
    return power(1.0 / cursor, f64[layout.C_RECOIL_EXPONENT])


@inlined
def set_gain(f64, i64):
    """At a sample of the grid: the gain's way to the next."""
    before = f64[layout.GAIN_TO]
    gain = 1.0
    grain = 1.0
    if max(f64[layout.C_SLOW_EXPONENT], f64[layout.C_RECOIL_EXPONENT]) > 0.0:
        gain = gain_now(f64, i64)
        grain = gain * gain if i64[layout.ENGAGED] == 1 else sqrt(gain)
    f64[layout.GRAIN_GAIN] = grain
    f64[layout.GAIN_FROM] = before
    f64[layout.GAIN_TO] = gain
    f64[layout.GAIN_STEP] = (gain - before) * PER_GRID


@inlined
def on_grid(i64):
    """How many samples the clock is beyond the last sample of the grid."""
    return i64[layout.CLOCK] & (layout.GAIN_GRID - 1)
