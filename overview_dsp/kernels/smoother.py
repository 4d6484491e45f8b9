"""The input smoother: two equal one-pole low-passes in series (critically damped).

    y1 += a * (target - y1);  y2 += a * (y1 - y2);  a = 1 - exp(-1 / (tau * sample_rate))

A steadily moving hand is followed `latency` samples behind, which is also the centroid of the
impulse response; the step response is 1 - (1 + t/tau) * exp(-t/tau), without overshoot.
Touching down is not smoothed: both poles start at the finger, so that a tap is the same step
wherever the hand was.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.simd.vector import choose

STILL = 1e-150  # cells: smaller would become denormal; positions are never negative


@inlined
def smooth(target, y1, y2, a):
    """One sample: the two poles after it."""
    y1 = y1 + a * (target - y1)
    y2 = y2 + a * (y1 - y2)
    return choose(y1 > STILL, y1, 0.0), choose(y2 > STILL, y2, 0.0)


def latency(a: float) -> float:
    """Delay of a moving input, samples: (1 - a) / a for each pole."""
    return 2.0 * (1.0 - a) / a
