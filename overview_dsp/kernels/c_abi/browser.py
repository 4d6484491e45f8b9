"""The voice and its output as C functions of 32-bit pointers, for a browser.

`tools/build_wasm.py` compiles them for WebAssembly; `NAMES` are the functions, each with its
signature. The page's clock is JavaScript's, so it books no times; and its numbers are floats, so
that a sample time is one. Memory is `8 * layout.TOTAL` bytes.

Thread: audio.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
from numba import types

from overview_dsp.kernels import block, layout
from overview_dsp.kernels.derive import derive_at, set_parameter
from overview_dsp.kernels.device.derive_actuator import derive_actuator
from overview_dsp.kernels.device.stream_block import deliver

carray = getattr(numba, "carray")  # noqa: B009 - numba does not export it to type checkers


def render(output, frame_count, memory):
    """Overwrite a block, float32 [frame_count * L_CHANNELS]; 1 if the stream is over, else 0."""
    f64 = carray(memory, (layout.TOTAL,), np.float64)
    i64 = carray(memory, (layout.TOTAL,), np.int64)
    u64 = carray(memory, (layout.TOTAL,), np.uint64)
    frames = np.int64(frame_count)
    channels = i64[layout.L_CHANNELS]
    out = carray(output, (frames * channels,), np.float32)
    return 1 if deliver(f64, i64, u64, out, frames, channels) else 0


def prepare(memory, sample_rate):
    """Begin anew at a sample rate, in Hz; 1 if that can be, else 0."""
    f64 = carray(memory, (layout.TOTAL,), np.float64)
    i64 = carray(memory, (layout.TOTAL,), np.int64)
    u64 = carray(memory, (layout.TOTAL,), np.uint64)
    if not derive_at(f64, i64, sample_rate):
        return 0
    if i64[layout.L_ACTUATOR + layout.ACT_ON] == 1:
        derive_actuator(f64, layout.L_ACTUATOR, sample_rate)
    block.reset(f64, i64, u64)
    return 1


def change(memory, parameter, value, sample_time):
    """Set a parameter, which glides; 1, or 0 where it can't be or too many wait."""
    f64 = carray(memory, (layout.TOTAL,), np.float64)
    i64 = carray(memory, (layout.TOTAL,), np.int64)
    number, stamp = np.int64(parameter), np.int64(sample_time)
    return 1 if set_parameter(f64, i64, number, value, stamp) else 0


_int32: Any = types.int32
NAMES: dict[str, tuple[Any, Any]] = {
    "render": (render, _int32(types.voidptr, types.int32, types.voidptr)),
    "prepare": (prepare, _int32(types.voidptr, types.float64)),
    "change": (change, _int32(types.voidptr, types.int32, types.float64, types.float64)),
}
