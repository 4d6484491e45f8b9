"""One block as an audio device gets it: the engine's, then the device's stage; counted.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.block import process
from overview_dsp.kernels.compiling import point
from overview_dsp.kernels.device import finish


@point
def deliver(m, w, u, out, frames, channels):
    """One block into `out`, float32 [frames * channels]; whether the stream is over."""
    process(m, w, u, out, frames, channels, m, False)
    over = finish(m, w, out, frames, channels)
    w[layout.L_CALLBACKS] += 1
    w[layout.L_FRAMES] += frames
    return over
