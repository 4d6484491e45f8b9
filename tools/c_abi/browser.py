"""C functions of the voice and its output for browsers, with 32-bit pointers.

`tools/build_wasm.py` compiles them for WebAssembly; `NAMES` are the functions, each with its
signature. There are no timers, since the page uses JavaScript's clock. JavaScript's numbers are
floats, and so are sample times. Memory is `8 * layout.TOTAL` bytes.

Thread: audio.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types

from overview_dsp.kernels import block, layout
from overview_dsp.kernels.derive import derive_at, set_parameter
from overview_dsp.kernels.device.derive_actuator import derive_actuator
from overview_dsp.kernels.device.stream_block import deliver
from overview_dsp.kernels.plain_memory import carray, views


def render(output, frame_count, memory):
    """Overwrite a block, float32 [frame_count * L_CHANNELS]; return 1 at the stream's end."""
    f64, i64, u64 = views(memory)
    frames = np.int64(frame_count)
    channels = i64[layout.L_CHANNELS]
    out = carray(output, (frames * channels,), np.float32)
    return 1 if deliver(f64, i64, u64, out, frames, channels) else 0


def prepare(memory, sample_rate):
    """Reset at a sample rate, in Hz; return 1, or 0 if the rate is invalid."""
    f64, i64, u64 = views(memory)
    if not derive_at(f64, i64, sample_rate):
        return 0
    if i64[layout.L_ACTUATOR + layout.ACT_ON] == 1:
        derive_actuator(f64, layout.L_ACTUATOR, sample_rate)
    block.reset(f64, i64, u64)
    return 1


def change(memory, parameter, value, sample_time):
    """Set a parameter, with smoothing; return 1, or 0 if it is invalid or the queue is full."""
    f64, i64, _ = views(memory)
    number, stamp = np.int64(parameter), np.int64(sample_time)
    return 1 if set_parameter(f64, i64, number, value, stamp) else 0


_int32: Any = types.int32
NAMES: dict[str, tuple[Any, Any]] = {
    "render": (render, _int32(types.voidptr, types.int32, types.voidptr)),
    "prepare": (prepare, _int32(types.voidptr, types.float64)),
    "change": (change, _int32(types.voidptr, types.int32, types.float64, types.float64)),
}
