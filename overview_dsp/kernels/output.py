"""Last stage: both signals under the ceiling, into the output's channels, and metered.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import point
from overview_dsp.kernels.limiter import KNEE, limit


@point
def emit_column(m, column, frames, ceiling, out, first, channels):
    """Write one signal to every `channels`-th sample from `first`; its peak and limited samples."""
    peak = 0.0
    for n in range(frames):
        peak = max(peak, abs(m[column + n]))
    knee = KNEE * ceiling
    limited = 0
    if peak > knee:
        peak = 0.0
        for n in range(frames):
            x = m[column + n]
            if abs(x) > knee:
                limited += 1
            m[column + n] = limit(x, ceiling)
            peak = max(peak, abs(m[column + n]))
    if first >= 0:
        for n in range(frames):
            out[first + n * channels] = m[column + n]
    return peak, limited


@point
def emit(m, w, out, start, frames, channels):
    """Write frames `start` to `start + frames` of the output from D_CLICK and D_TACTOR."""
    ceiling = m[layout.C_CEILING]
    first = start * channels
    # two channels, one signal each: every sample is written below
    if channels != 2 or w[layout.S_CLICK_CHANNEL] + w[layout.S_TACTOR_CHANNEL] != 1:
        for i in range(first, first + frames * channels):
            out[i] = 0.0
    click_at = first + w[layout.S_CLICK_CHANNEL] if w[layout.S_CLICK_CHANNEL] >= 0 else -1
    tactor_at = first + w[layout.S_TACTOR_CHANNEL] if w[layout.S_TACTOR_CHANNEL] >= 0 else -1
    click, bent = emit_column(m, layout.D_CLICK, frames, ceiling, out, click_at, channels)
    tactor, also = emit_column(m, layout.D_TACTOR, frames, ceiling, out, tactor_at, channels)
    m[layout.M_PEAK_CLICK] = max(m[layout.M_PEAK_CLICK], click)
    m[layout.M_PEAK_TACTOR] = max(m[layout.M_PEAK_TACTOR], tactor)
    w[layout.M_LIMITED] += bent + also
    last = frames - 1
    while last >= 0 and m[layout.D_CLICK + last] == 0.0 and m[layout.D_TACTOR + last] == 0.0:
        last -= 1
    # samples since the last that sounded: in this chunk, or in those before too
    if last >= 0:
        w[layout.M_SILENT] = frames - 1 - last
    else:
        w[layout.M_SILENT] += frames
