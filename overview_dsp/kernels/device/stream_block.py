"""Block of an audio device: the engine's block and the output stage.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.block import process
from overview_dsp.kernels.compiling import inlined, outlined
from overview_dsp.kernels.device import router
from overview_dsp.kernels.device.output_stage import finish


@outlined
def deliver_routed(f64, i64, u64, r, ri, out, frames, channels):
    """Write a block as `deliver` does, with the tactor's signal split by the router `r`."""
    over = False
    start = 0
    while start < frames:
        count = min(router.FRAMES, frames - start)
        piece = out[start * channels : (start + count) * channels]
        trace = r[router.TRACE : router.TRACE + count * layout.TRACE]
        process(f64, i64, u64, piece, count, channels, trace, count > 0)
        over = finish(f64, i64, piece, count, channels)
        router.split(i64, r, ri, piece, count, channels, trace)
        start += count
    i64[layout.L_CALLBACKS] += 1
    i64[layout.L_FRAMES] += frames
    return over


@inlined
def deliver(f64, i64, u64, out, frames, channels):
    """Write a block to `out`, float32 [frames * channels]; return whether the stream is over."""
    # a literal False would have another type and compile `process` a second time
    process(f64, i64, u64, out, frames, channels, f64, frames < 0)
    over = finish(f64, i64, out, frames, channels)
    i64[layout.L_CALLBACKS] += 1
    i64[layout.L_FRAMES] += frames
    return over
