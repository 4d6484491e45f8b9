"""C entry points of the kernels for Python and audio streams, on plain pointers.

`tools/build_objects.py` compiles them and `kernels/precompiled.py` calls them. `NAMES` maps the
names to functions and signatures. Memory is a block of `kernels.layout`, or its beginning.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types

from overview_dsp.kernels import atomics, block, derive, layout
from overview_dsp.kernels.control_events import push_control
from overview_dsp.kernels.device import actuator, derive_actuator, output_stage, router
from overview_dsp.kernels.device.callback import SIGNATURE, callback
from overview_dsp.kernels.plain_memory import carray, views
from overview_dsp.kernels.simd import block as side_by_side
from overview_dsp.kernels.simd.memory import MEMORY
from overview_dsp.kernels.simd.vector import SIMD_WIDTH


def process(memory, out, frames, channels, trace, traced):
    """Call `block.process`."""
    f64, i64, u64 = views(memory)
    samples = carray(out, (frames * channels,), np.float32)
    table = carray(trace, (frames * layout.TRACE,), np.float64)
    block.process(f64, i64, u64, samples, frames, channels, table, traced != 0)
    return 0


def process_lanes(memory, count, out, frames, trace, traced):
    """Call `simd.block.process_lanes`."""
    f64 = carray(memory, (MEMORY,), np.float64)
    i64 = carray(memory, (MEMORY,), np.int64)
    u64 = carray(memory, (MEMORY,), np.uint64)
    samples = carray(out, (SIMD_WIDTH * frames * layout.SIGNALS,), np.float32)
    table = carray(trace, (SIMD_WIDTH * frames * layout.TRACE,), np.float64)
    side_by_side.process_lanes(f64, i64, u64, count, samples, frames, table, traced != 0)
    return 0


def reset(memory):
    """Call `block.reset`."""
    f64, i64, u64 = views(memory)
    block.reset(f64, i64, u64)
    return 0


def tactor_stage(memory, torque, out, frames):
    """Call `block.tactor_stage`."""
    f64 = carray(memory, (layout.TOTAL,), np.float64)
    torques = carray(torque, (frames,), np.float64)
    block.tactor_stage(f64, torques, carray(out, (frames,), np.float32))
    return 0


def derive_coefficients(memory):
    """Call `derive.derive`."""
    f64 = carray(memory, (layout.SET_UP,), np.float64)
    i64 = carray(memory, (layout.SET_UP,), np.int64)
    derive.derive(f64, i64)
    return 0


def derive_clicks(memory, slot):
    """Call `derive.derive_clicks`."""
    f64, i64, _ = views(memory)
    derive.derive_clicks(f64, i64, slot)
    return 0


def derive_drive(memory, at, sample_rate):
    """Call `derive_actuator.derive_actuator`."""
    f64 = carray(memory, (at + layout.ACT_SIZE,), np.float64)
    derive_actuator.derive_actuator(f64, at, sample_rate)
    return 0


def drive_block(memory, at, out, frames, channels, channel):
    """Call `actuator.drive_block`."""
    f64 = carray(memory, (at + layout.ACT_SIZE,), np.float64)
    i64 = carray(memory, (at + layout.ACT_SIZE,), np.int64)
    samples = carray(out, (frames * channels,), np.float32)
    actuator.drive_block(f64, i64, at, samples, frames, channels, channel)
    return 0


def finish_block(memory, out, frames, channels):
    """Call `output_stage.finish_block`."""
    f64, i64, _ = views(memory)
    samples = carray(out, (frames * channels,), np.float32)
    return 1 if output_stage.finish_block(f64, i64, samples, frames, channels) else 0


def split_block(memory, router_memory, out, frames, channels, trace):
    """Call `router.split_block`."""
    i64 = carray(memory, (layout.TOTAL,), np.int64)
    r = carray(router_memory, (router.SIZE,), np.float64)
    ri = carray(router_memory, (router.SIZE,), np.int64)
    samples = carray(out, (frames * channels,), np.float32)
    table = carray(trace, (frames * layout.TRACE,), np.float64)
    router.split_block(i64, r, ri, samples, frames, channels, table)
    return 0


def push(memory, source, stamp, theta2, touching):
    """Call `control_events.push_control`."""
    f64, i64, _ = views(memory)
    return 1 if push_control(f64, i64, source, stamp, theta2, touching != 0) else 0


def acquired(memory, at):
    """Call `atomics.acquired`."""
    return atomics.acquired(carray(memory, (layout.TOTAL,), np.int64), at)


def publish(memory, at, value):
    """Call `atomics.publish`."""
    atomics.publish(carray(memory, (layout.TOTAL,), np.int64), at, value)
    return 0


_pointer, _int, _number = types.voidptr, types.int64, types.float64
_int64: Any = types.int64
_int32: Any = types.int32
NAMES: dict[str, tuple[Any, Any]] = {
    "process": (process, _int32(_pointer, _pointer, _int, _int, _pointer, _int)),
    "process_lanes": (process_lanes, _int32(_pointer, _int, _pointer, _int, _pointer, _int)),
    "reset": (reset, _int32(_pointer)),
    "tactor_stage": (tactor_stage, _int32(_pointer, _pointer, _pointer, _int)),
    "derive": (derive_coefficients, _int32(_pointer)),
    "derive_clicks": (derive_clicks, _int32(_pointer, _int)),
    "derive_actuator": (derive_drive, _int32(_pointer, _int, _number)),
    "drive_block": (drive_block, _int32(_pointer, _int, _pointer, _int, _int, _int)),
    "finish_block": (finish_block, _int32(_pointer, _pointer, _int, _int)),
    "split_block": (split_block, _int32(_pointer, _pointer, _pointer, _int, _int, _pointer)),
    "push_control": (push, _int32(_pointer, _int, _int, _number, _int)),
    "acquired": (acquired, _int64(_pointer, _int)),
    "publish": (publish, _int32(_pointer, _int, _int)),
    "callback": (callback, SIGNATURE),
}
