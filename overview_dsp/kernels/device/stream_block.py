"""One block as an audio device gets it: the engine's, then the device's stage; counted.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.block import process
from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.device.output_stage import finish


@inlined
def deliver(f64, i64, u64, out, frames, channels):
    """One block into `out`, float32 [frames * channels]; whether the stream is over."""
    # a literal False would be another type, and make a second `process`
    process(f64, i64, u64, out, frames, channels, f64, frames < 0)
    over = finish(f64, i64, out, frames, channels)
    i64[layout.L_CALLBACKS] += 1
    i64[layout.L_FRAMES] += frames
    return over
