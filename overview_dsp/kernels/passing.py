"""The events that the disk passes: which lie next above and below it, and their strikes.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.click import strike
from overview_dsp.kernels.compiling import point, routine

FAR = 1e300  # cells: beyond any place
RETREAT = 1e-6  # cells: how far the disk must go back before an event counts as passed again


@point
def event_above(m, w):
    """The place (cells) from which on the next event of the active surface is passed upwards."""
    slot = layout.SURFACES + w[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    following = w[layout.NEXT_EVENT]
    if following < w[slot + layout.SLOT_EVENTS]:
        return m[slot + layout.SLOT_PLACE + following]
    return FAR


@point
def event_below(m, w):
    """The place (cells) below which the last event is passed again, downwards."""
    slot = layout.SURFACES + w[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    following = w[layout.NEXT_EVENT]
    if following > 0:
        return m[slot + layout.SLOT_PLACE + following - 1] - RETREAT
    return -FAR


@routine
def pass_events(m, w, n, was):
    """Strike every event from the place `was` (cells) before sample n of a chunk to the disk's."""
    slot = layout.SURFACES + w[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    x = m[layout.X]
    approach = m[layout.APPROACH]
    speed = abs(m[layout.D_OMEGA + n])
    sample = w[layout.CLOCK] + n
    above = event_above(m, w)
    while x >= above:
        fraction = (above - was) / (x - was)
        strike(m, w, slot, w[layout.NEXT_EVENT], approach, speed, sample, fraction)
        w[layout.NEXT_EVENT] += 1
        above = event_above(m, w)
    while x < event_below(m, w):
        w[layout.NEXT_EVENT] -= 1
        above = event_above(m, w)
        fraction = (was - above) / (was - x) if was > above else 0.0
        strike(m, w, slot, w[layout.NEXT_EVENT], approach, speed, sample, fraction)
