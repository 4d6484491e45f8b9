"""Router: splits the tactor's signal among several tactors by the position of the disk.

    y[k] = w[k] * x,    w[k] -> sqrt(max(0, 1 - |place - k|))

`place` is the tactor at the disk's position, counted from 0. Between two tactors both vibrate, with
the power of one; at `ALL` every tactor has the whole signal. After the disk has left an event, its
tactor keeps the signal for `HOLD` samples, in which the vibration decays. The weights are smoothed,
and places are delayed like the signal.

Thread: audio.
"""

from __future__ import annotations

from math import sqrt

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import entry_point, inlined

MAX_TACTORS = 8
ALL = -1.0  # place at which every tactor vibrates
FRAMES = 64  # most frames of a call: fewer than a crossfade of surfaces has
CURSOR = layout.TRACE_COLUMNS.index("cursor")

column = layout.Columns()
TACTORS = column(1)  # i64: number of tactors
SMOOTHING = column(1)  # of the weights, per sample
HOLD = column(1)  # i64: samples
PLACE = column(1)  # at the last sample
SINCE = column(1)  # i64: samples since the disk left the last event that has a tactor
WRITTEN = column(1)  # i64: samples written to LINE
WEIGHTS = column(MAX_TACTORS)
CHANNELS = column(MAX_TACTORS)  # i64: bit mask of each tactor's output channels
TRACE = column(FRAMES * layout.TRACE)  # trace of the frames that are split
PLACES = column(layout.SLOTS * (layout.CELLS + 1))  # place of each cell, surface by surface
LINE = column(layout.DELAY_LINE)  # places of the latest samples
SIZE = column.end


@inlined
def find_tactor(r, ri, slot, cursor):
    """Return the place of the disk on a surface, after an event for a while that of the event."""
    cell = int(min(max(cursor, 0.0), 1.0) * layout.CELLS)
    place = r[PLACES + slot * (layout.CELLS + 1) + cell]
    ri[SINCE] = ri[SINCE] + 1 if place == ALL else 0
    if place != ALL or ri[SINCE] > ri[HOLD]:
        r[PLACE] = place
    return r[PLACE]


@inlined
def split(i64, r, ri, out, frames, channels, trace):
    """Split up to FRAMES frames of the tactor's channel among the channels of all tactors."""
    source = i64[layout.S_TACTOR_CHANNEL]
    delay = i64[layout.L_DELAY + layout.TACTOR]
    # in a crossfade, the samples before it belong to the surface that fades
    first = 0
    if i64[layout.FADING_SLOT] >= 0:
        first = frames - (i64[layout.S_FADE] - i64[layout.FADE_LEFT])
    for n in range(frames):
        slot = i64[layout.FADING_SLOT if n < first else layout.ACTIVE_SLOT]
        at = ri[WRITTEN] & (layout.DELAY_LINE - 1)
        r[LINE + at] = find_tactor(r, ri, slot, trace[n * layout.TRACE + CURSOR])
        place = r[LINE + ((ri[WRITTEN] - delay) & (layout.DELAY_LINE - 1))]
        ri[WRITTEN] += 1
        x = float(out[source + n * channels])
        for k in range(ri[TACTORS]):
            wanted = 1.0 if place == ALL else sqrt(max(0.0, 1.0 - abs(place - float(k))))
            r[WEIGHTS + k] += r[SMOOTHING] * (wanted - r[WEIGHTS + k])
            y = r[WEIGHTS + k] * x
            for channel in range(channels):
                if (ri[CHANNELS + k] >> channel) & 1 == 1:
                    out[channel + n * channels] = y


@entry_point
def split_block(i64, r, ri, out, frames, channels, trace):
    """Call `split` from Python.

    Parameters
    ----------
    i64 : int64 [layout.TOTAL]
        Memory of the engine, after `process`.
    r, ri : float64, int64 [SIZE]
        Memory of the router, seen two ways.
    out : float32 [frames * channels]
    frames, channels : int64
    trace : float64 [frames * layout.TRACE]
    """
    split(i64, r, ri, out, frames, channels, trace)
