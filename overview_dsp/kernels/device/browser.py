"""The browser's door: what PortAudio's callback runs, as a C function of 32-bit pointers.

`tools/build_wasm.py` compiles it for WebAssembly. The page's clock is JavaScript's, so it books no
times.

Thread: audio.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
from numba import types

from overview_dsp.kernels import layout
from overview_dsp.kernels.device.stream_block import deliver

_int32: Any = types.int32
SIGNATURE = _int32(types.voidptr, types.int32, types.voidptr)

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
