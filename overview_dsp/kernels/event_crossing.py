"""The events that the disk passes: which lie next above and below it, and their strikes.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.click import strike
from overview_dsp.kernels.compiling import inlined, outlined

FAR = 1e300  # cells: beyond any position
RETREAT = 1e-6  # cells: how far the disk must go back before an event counts as passed again


@inlined
def event_above(f64, i64):
    """The position (cells) from which on the next event of the active surface is passed upwards."""
    slot = layout.SURFACES + i64[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    following = i64[layout.NEXT_EVENT]
    if following < i64[slot + layout.SLOT_EVENTS]:
        return f64[slot + layout.SLOT_POSITION + following]
    return FAR


@inlined
def event_below(f64, i64):
    """The position (cells) below which the last event is passed again, downwards."""
    slot = layout.SURFACES + i64[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    following = i64[layout.NEXT_EVENT]
    if following > 0:
        return f64[slot + layout.SLOT_POSITION + following - 1] - RETREAT
    return -FAR


@outlined
def pass_events(f64, i64, n, was):
    """Strike every event between the position `was` (cells) before sample n and the disk's."""
    slot = layout.SURFACES + i64[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    x = f64[layout.X]
    approach = f64[layout.APPROACH]
    speed = abs(f64[layout.D_OMEGA + n])
    sample = i64[layout.CLOCK] + n
    above = event_above(f64, i64)
    while x >= above:
        fraction = (above - was) / (x - was)
        strike(f64, i64, slot, i64[layout.NEXT_EVENT], approach, speed, sample, fraction)
        i64[layout.NEXT_EVENT] += 1
        above = event_above(f64, i64)
    while x < event_below(f64, i64):
        i64[layout.NEXT_EVENT] -= 1
        above = event_above(f64, i64)
        fraction = (was - above) / (was - x) if was > above else 0.0
        strike(f64, i64, slot, i64[layout.NEXT_EVENT], approach, speed, sample, fraction)
