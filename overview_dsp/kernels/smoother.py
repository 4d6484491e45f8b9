"""The input smoother: two equal one-pole low-passes in series (critically damped).

    y1 += a * (target - y1);  y2 += a * (y1 - y2);  a = 1 - exp(-1 / (tau * sample_rate))

A steadily moving input is delayed by `latency` samples, which is also the centroid of the
impulse response; the step response is 1 - (1 + t/tau) * exp(-t/tau), without overshoot.
A touch is not smoothed: both poles start at the input angle, so that a tap is the same step
from any previous angle.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.simd.vector import choose

STILL = 1e-150  # cells: smaller would become denormal; positions are never negative


@inlined
def smooth(target, y1, y2, a):
    """Return the two poles after one sample."""
    y1 = y1 + a * (target - y1)
    y2 = y2 + a * (y1 - y2)
    return choose(y1 > STILL, y1, 0.0), choose(y2 > STILL, y2, 0.0)


def latency(a: float) -> float:
    """Return the delay of a moving input, samples: (1 - a) / a for each pole."""
    return 2.0 * (1.0 - a) / a
