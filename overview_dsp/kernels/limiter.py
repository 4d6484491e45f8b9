"""Limiter: samples below the knee are unchanged, and none exceeds the ceiling.

    y = x                                                        |x| <= knee
    y = sign(x) * (knee + (top - knee) * tanh((|x| - knee)/(top - knee)))    above

Memoryless and odd: no latency, no DC. `knee` is 6 dB below the ceiling.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.math_functions import tanh_positive

KNEE = 0.5  # of the ceiling
TOP = 0.999999  # of the ceiling: rounding to float32 can't pass it


@inlined
def limit(x, ceiling):
    """Return x limited to the ceiling."""
    knee = KNEE * ceiling
    if abs(x) <= knee:
        return x
    headroom = TOP * ceiling - knee
    y = knee + headroom * tanh_positive((abs(x) - knee) / headroom)
    return y if x > 0.0 else -y
