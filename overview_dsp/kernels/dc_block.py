"""DC blocker: a zero at 0 Hz and a pole close to it.

    y = x - x_before + r * y_before,    r = exp(-2 pi * 20 Hz / sample_rate)

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.simd.vector import choose, rarely

CORNER_HZ = 20.0  # below hearing and below the tactor's band
SILENCE = 1e-9


@inlined
def block_dc(x, x_before, y_before, pole):
    """Return one output sample; exactly zero after input and output have decayed."""
    y = x - x_before + pole * y_before
    silence = choose(x == 0.0, SILENCE, 0.0)
    return rarely(max(y, -y) < silence, 0.0, y)
