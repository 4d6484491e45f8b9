"""Native PortAudio callback, without the Python interpreter.

It never takes the GIL, so Python can't interrupt the sound. PortAudio's user data is the
memory block, which the stream must keep alive (`live/`).

Thread: audio (the callback), main (`native_callback`).
"""

from __future__ import annotations

import sys
from functools import cache
from typing import Any

import numba
import numpy as np
from numba import types

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import c_callback, inlined
from overview_dsp.kernels.device import router
from overview_dsp.kernels.device.stream_block import deliver, deliver_routed
from overview_dsp.kernels.math_functions import ONE_BITS
from overview_dsp.kernels.plain_memory import carray, pointer_at, views
from overview_dsp.kernels.precompiled import precompiled_callback
from overview_dsp.kernels.simd.vector import bits_of

# PortAudio's unsigned long: 32 bits on Windows, 64 elsewhere
_UNSIGNED_LONG = types.uint32 if sys.platform == "win32" else types.uint64
_int32: Any = types.int32
SIGNATURE = _int32(
    types.voidptr, types.voidptr, _UNSIGNED_LONG, types.voidptr, _UNSIGNED_LONG, types.voidptr
)
OUTPUT_UNDERFLOW = 4  # paOutputUnderflow
CONTINUE, COMPLETE = 0, 1  # paContinue, paComplete
MONOTONIC = 1  # CLOCK_MONOTONIC, on Linux
MANTISSA = 0xFFFFFFFFFFFFF  # of a float64's bits; that of
BORDERS = (0x306FE0A31B715, 0x6A09E667F3BCD, 0xAE89F995AD3AD)  # 2**(1/4), 2**(1/2), 2**(3/4)
HAS_CLOCK = sys.platform == "linux"

_external: Any = types.ExternalFunction
_clock_gettime = _external("clock_gettime", _int32(types.int32, types.uintp))


@inlined
def now(i64):
    """Return the time of the monotonic clock, s; 0 without one."""
    if HAS_CLOCK:
        _clock_gettime(MONOTONIC, i64[layout.L_SECONDS : layout.L_SECONDS + 2].ctypes.data)
        return float(i64[layout.L_SECONDS]) + float(i64[layout.L_NANOSECONDS]) * 1e-9
    return 0.0


@inlined
def record_busy_time(f64, i64, seconds, frames):
    """Record the duration of a callback."""
    if seconds > f64[layout.L_LONGEST]:
        f64[layout.L_LONGEST] = seconds
    if seconds * f64[layout.S_SAMPLE_RATE] > float(frames):
        i64[layout.L_LATE] += 1
    where = 0
    if seconds > layout.SHORTEST_S:
        bits = bits_of(seconds * (1.0 / layout.SHORTEST_S))
        mantissa = bits & MANTISSA
        where = ((bits - ONE_BITS) >> 52) * layout.BINS_PER_OCTAVE
        for border in BORDERS:
            where += mantissa >= border
        where = min(where, layout.BUSY_BINS - 1)
    i64[layout.L_BUSY + where] += 1


def callback(unused, output, frame_count, time_info, flags, user):
    """Overwrite a block, float32 [frame_count * L_CHANNELS]; COMPLETE ends the stream."""
    f64, i64, u64 = views(user)
    started = now(i64)
    frames = np.int64(frame_count)
    channels = i64[layout.L_CHANNELS]
    out = carray(output, (frames * channels,), np.float32)
    if i64[layout.L_ROUTER] == 0:
        over = deliver(f64, i64, u64, out, frames, channels)
    else:
        memory = pointer_at(i64[layout.L_ROUTER])
        r = carray(memory, (router.SIZE,), np.float64)
        ri = carray(memory, (router.SIZE,), np.int64)
        over = deliver_routed(f64, i64, u64, r, ri, out, frames, channels)
    if flags & OUTPUT_UNDERFLOW:
        i64[layout.L_UNDERFLOWS] += 1
    record_busy_time(f64, i64, now(i64) - started, frames)
    return COMPLETE if over else CONTINUE


@cache
def native_callback():
    """Return the callback as machine code; its `.address` is a `PaStreamCallback *`."""
    return precompiled_callback() or c_callback(SIGNATURE, callback)


@cache
def repeated_callback():
    """Return a compiled loop over the native callback, for measurements.

    `run(m, out, frames, blocks)`: m float64 [layout.TOTAL], out float32 [frames * channels].
    """
    call = native_callback().ctypes

    @numba.njit
    def run(f64, out, frames, blocks):
        for _ in range(blocks):
            call(out.ctypes, out.ctypes, frames, out.ctypes, 0, f64.ctypes)

    return run
