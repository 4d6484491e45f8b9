"""Last stage: limiter, output channels and meters of both signals.

Thread: audio.
"""

from __future__ import annotations

import numpy as np

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import NOT_NEGATIVE, inlined
from overview_dsp.kernels.limiter import KNEE, limit

MAGNITUDE = 0x7FFFFFFFFFFFFFFF  # of a float64's bits, all but the sign


@inlined
def limit_column(f64, i64, column, frames, ceiling):
    """Limit one signal to the ceiling; return its peak and the number of limited samples."""
    # integer comparison of magnitudes, which compilers vectorise
    highest = 0
    for n in range(frames):
        highest = max(highest, i64[(column + n) & NOT_NEGATIVE] & MAGNITUDE)
    peak = float(np.int64(highest).view(np.float64))
    knee = KNEE * ceiling
    limited = 0
    if peak > knee:
        peak = 0.0
        for n in range(frames):
            x = f64[column + n]
            if abs(x) > knee:
                limited += 1
            f64[column + n] = limit(x, ceiling)
            peak = max(peak, abs(f64[column + n]))
    return peak, limited


@inlined
def write_column(f64, column, frames, out, first, channels):
    """Write one signal to every `channels`-th sample from `first`."""
    for n in range(frames):
        out[first + n * channels] = f64[column + n]


@inlined
def write(f64, i64, out, start, frames, channels):
    """Write frames `start` to `start + frames` of the output from D_CLICK and D_TACTOR."""
    first = start * channels
    click_channel = i64[layout.S_CLICK_CHANNEL]
    tactor_channel = i64[layout.S_TACTOR_CHANNEL]
    if channels == 2 and click_channel == 0 and tactor_channel == 1:
        for n in range(frames):
            out[(first + 2 * n) & NOT_NEGATIVE] = f64[layout.D_CLICK + n]
            out[(first + 2 * n + 1) & NOT_NEGATIVE] = f64[layout.D_TACTOR + n]
        return
    for i in range(first, first + frames * channels):
        out[i] = 0.0
    if click_channel >= 0:
        write_column(f64, layout.D_CLICK, frames, out, first + click_channel, channels)
    if tactor_channel >= 0:
        write_column(f64, layout.D_TACTOR, frames, out, first + tactor_channel, channels)


@inlined
def emit(f64, i64, out, start, frames, channels):
    """Limit both signals of a chunk and write them to the output and the meters."""
    ceiling = f64[layout.C_CEILING]
    click, bent = limit_column(f64, i64, layout.D_CLICK, frames, ceiling)
    tactor, also = limit_column(f64, i64, layout.D_TACTOR, frames, ceiling)
    write(f64, i64, out, start, frames, channels)
    f64[layout.M_PEAK_CLICK] = max(f64[layout.M_PEAK_CLICK], click)
    f64[layout.M_PEAK_TACTOR] = max(f64[layout.M_PEAK_TACTOR], tactor)
    i64[layout.M_LIMITED] += bent + also
    last = frames - 1
    while last >= 0 and f64[layout.D_CLICK + last] == 0.0 and f64[layout.D_TACTOR + last] == 0.0:
        last -= 1
    # samples since the last non-zero one, in this chunk or before it
    if last >= 0:
        i64[layout.M_SILENT] = frames - 1 - last
    else:
        i64[layout.M_SILENT] += frames
