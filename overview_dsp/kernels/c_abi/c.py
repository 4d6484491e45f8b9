"""The voice as C functions: what `overview.h` declares, and says in full, for programs and plugins.

`NAMES` are the functions, each with its signature. Memory is `8 * layout.TOTAL` bytes.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
from numba import types

from overview_dsp.kernels import block, layout
from overview_dsp.kernels.control_events import push_control
from overview_dsp.kernels.derive import derive_at, set_parameter
from overview_dsp.kernels.memory_image import decode, is_image, is_valid

carray = getattr(numba, "carray")  # noqa: B009 - numba does not export it to type checkers

DONE, REFUSED = 0, -1
COLUMN_BYTES = 8


def load(memory, image, size, digest):
    """Begin with an image of `size` bytes; then `prepare`. REFUSED if it isn't one: all is zero."""
    f64 = carray(memory, (layout.TOTAL,), np.float64)
    i64 = carray(memory, (layout.TOTAL,), np.int64)
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
    """Begin anew at a sample rate, clicks on channel 0, tactor on 1; REFUSED if it can't be."""
    f64 = carray(memory, (layout.TOTAL,), np.float64)
    i64 = carray(memory, (layout.TOTAL,), np.int64)
    u64 = carray(memory, (layout.TOTAL,), np.uint64)
    if not derive_at(f64, i64, sample_rate):
        return REFUSED
    i64[layout.S_CLICK_CHANNEL] = 0
    i64[layout.S_TACTOR_CHANNEL] = 1
    block.reset(f64, i64, u64)
    return DONE


def reset(memory):
    """As new, with the same parameters; waiting events are dropped."""
    f64 = carray(memory, (layout.TOTAL,), np.float64)
    i64 = carray(memory, (layout.TOTAL,), np.int64)
    u64 = carray(memory, (layout.TOTAL,), np.uint64)
    block.reset(f64, i64, u64)
    return DONE


def control(memory, source, sample_time, theta2, touching):
    """Push a hand's event; REFUSED where its queue is full, or there is no such source."""
    f64 = carray(memory, (layout.TOTAL,), np.float64)
    i64 = carray(memory, (layout.TOTAL,), np.int64)
    if source < 0 or source >= layout.SOURCES:
        return REFUSED
    pushed = push_control(f64, i64, np.int64(source), sample_time, theta2, touching != 0)
    return DONE if pushed else REFUSED


def change(memory, parameter, value, sample_time):
    """Set a parameter, which glides; REFUSED where it can't be, or too many wait."""
    f64 = carray(memory, (layout.TOTAL,), np.float64)
    i64 = carray(memory, (layout.TOTAL,), np.int64)
    done = set_parameter(f64, i64, np.int64(parameter), value, sample_time)
    return DONE if done else REFUSED


def process(memory, out, frames, channels):
    """Overwrite the next block, float32 [frames * channels]; REFUSED with too few channels."""
    f64 = carray(memory, (layout.TOTAL,), np.float64)
    i64 = carray(memory, (layout.TOTAL,), np.int64)
    u64 = carray(memory, (layout.TOTAL,), np.uint64)
    if max(i64[layout.S_CLICK_CHANNEL], i64[layout.S_TACTOR_CHANNEL]) >= channels:
        return REFUSED
    samples = carray(out, (frames * channels,), np.float32)
    # a literal would be another type, and make a second `block.process`
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
