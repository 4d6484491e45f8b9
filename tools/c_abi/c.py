"""C functions of the voice for programs and plugins; `overview.h` declares and documents them.

`NAMES` are the functions, each with its signature. Memory is `8 * layout.TOTAL` bytes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types

from overview_dsp.kernels import block, layout
from overview_dsp.kernels.control_events import push_control
from overview_dsp.kernels.derive import derive_at, set_parameter
from overview_dsp.kernels.memory_image import decode, is_image, is_valid
from overview_dsp.kernels.plain_memory import carray, views

DONE, REFUSED = 0, -1
COLUMN_BYTES = 8


def load(memory, image, size, digest):
    """Load an image of `size` bytes; on an invalid image clear the memory and return REFUSED."""
    f64, i64, _ = views(memory)
    columns = size // COLUMN_BYTES
    words = carray(image, (max(columns, 0),), np.int64)
    values = carray(image, (max(columns, 0),), np.float64)
    if size % COLUMN_BYTES == 0 and is_image(words, columns, digest):
        decode(words, values, columns, f64, i64)
        if is_valid(f64, i64):
            return DONE
    for n in range(layout.TOTAL):
        i64[n] = 0
    return REFUSED


def prepare(memory, sample_rate):
    """Reset at a sample rate, with clicks on channel 0 and tactor on 1, or return REFUSED."""
    f64, i64, u64 = views(memory)
    if not derive_at(f64, i64, sample_rate):
        return REFUSED
    i64[layout.S_CLICK_CHANNEL] = 0
    i64[layout.S_TACTOR_CHANNEL] = 1
    block.reset(f64, i64, u64)
    return DONE


def reset(memory):
    """Reset with the same parameters and drop pending events."""
    f64, i64, u64 = views(memory)
    block.reset(f64, i64, u64)
    return DONE


def control(memory, source, sample_time, theta2, touching):
    """Push an input's event; return REFUSED if its queue is full or the source is unknown."""
    f64, i64, _ = views(memory)
    if source < 0 or source >= layout.SOURCES:
        return REFUSED
    pushed = push_control(f64, i64, np.int64(source), sample_time, theta2, touching != 0)
    return DONE if pushed else REFUSED


def change(memory, parameter, value, sample_time):
    """Set a parameter, with smoothing; return REFUSED if it is invalid or the queue is full."""
    f64, i64, _ = views(memory)
    done = set_parameter(f64, i64, np.int64(parameter), value, sample_time)
    return DONE if done else REFUSED


def process(memory, out, frames, channels):
    """Overwrite a block, float32 [frames * channels]; return REFUSED with too few channels."""
    f64, i64, u64 = views(memory)
    if max(i64[layout.S_CLICK_CHANNEL], i64[layout.S_TACTOR_CHANNEL]) >= channels:
        return REFUSED
    samples = carray(out, (frames * channels,), np.float32)
    # a literal would have another type and compile `block.process` a second time
    traced = frames < 0
    block.process(f64, i64, u64, samples, frames, np.int64(channels), f64, traced)
    return DONE


_int32: Any = types.int32
_memory = types.voidptr
NAMES = {
    "overview_load": (load, _int32(_memory, types.voidptr, types.int64, types.int64)),
    "overview_prepare": (prepare, _int32(_memory, types.float64)),
    "overview_reset": (reset, _int32(_memory)),
    "overview_control": (
        control,
        _int32(_memory, types.int32, types.int64, types.float64, types.int32),
    ),
    "overview_change": (change, _int32(_memory, types.int32, types.float64, types.int64)),
    "overview_process": (process, _int32(_memory, types.voidptr, types.int64, types.int32)),
}
