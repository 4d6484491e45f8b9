"""Event crossings: neighbouring edges of the disk's position, and strikes of events.

An event is struck where the disk enters it, as its friction begins there: at its lower
edge in upward direction, at its upper edge in downward direction. Leaving it is silent.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.click import strike
from overview_dsp.kernels.compiling import inlined, outlined

FAR = 1e300  # cells: beyond any position
RETREAT = 1e-6  # cells: hysteresis before an edge counts as passed again


@inlined
def edges_below(f64, i64, slot, edges, position):
    """Return the number of edges of a slot at or below `position` (cells) by binary search.

    `edges` is `layout.SLOT_LOWER` or `layout.SLOT_UPPER`.
    """
    low = 0
    high = i64[slot + layout.SLOT_EVENTS]
    while low < high:
        middle = (low + high) // 2
        if f64[slot + edges + middle] <= position:
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def edge_above(f64, i64, slot, edges, following):
    """Return the position (cells) of the edge in column `following`, or FAR."""
    number = i64[following]
    if number < i64[slot + layout.SLOT_EVENTS]:
        return f64[slot + edges + number]
    return FAR


@inlined
def edge_below(f64, i64, slot, edges, following):
    """Return the position (cells) below which the previous edge is passed downwards."""
    number = i64[following]
    if number > 0:
        return f64[slot + edges + number - 1] - RETREAT
    return -FAR


@inlined
def event_above(f64, i64):
    """Return the position (cells) of the next edge above the disk."""
    slot = layout.SURFACES + i64[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    return min(
        edge_above(f64, i64, slot, layout.SLOT_LOWER, layout.NEXT_LOWER),
        edge_above(f64, i64, slot, layout.SLOT_UPPER, layout.NEXT_UPPER),
    )


@inlined
def event_below(f64, i64):
    """Return the position (cells) below which the last edge is passed downwards."""
    slot = layout.SURFACES + i64[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    return max(
        edge_below(f64, i64, slot, layout.SLOT_LOWER, layout.NEXT_LOWER),
        edge_below(f64, i64, slot, layout.SLOT_UPPER, layout.NEXT_UPPER),
    )


@outlined
def pass_events(f64, i64, n, was):
    """Strike all events entered between the position `was` (cells) before sample n and now."""
    slot = layout.SURFACES + i64[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    x = f64[layout.X]
    approach = f64[layout.APPROACH]
    speed = abs(f64[layout.D_OMEGA + n])
    sample = i64[layout.CLOCK] + n
    edge = edge_above(f64, i64, slot, layout.SLOT_LOWER, layout.NEXT_LOWER)
    while x >= edge:
        event = i64[slot + layout.SLOT_LOWER_EVENT + i64[layout.NEXT_LOWER]]
        strike(f64, i64, slot, event, approach, speed, sample, (edge - was) / (x - was))
        i64[layout.NEXT_LOWER] += 1
        edge = edge_above(f64, i64, slot, layout.SLOT_LOWER, layout.NEXT_LOWER)
    while x < edge_below(f64, i64, slot, layout.SLOT_LOWER, layout.NEXT_LOWER):
        i64[layout.NEXT_LOWER] -= 1
    while x >= edge_above(f64, i64, slot, layout.SLOT_UPPER, layout.NEXT_UPPER):
        i64[layout.NEXT_UPPER] += 1
    while x < edge_below(f64, i64, slot, layout.SLOT_UPPER, layout.NEXT_UPPER):
        i64[layout.NEXT_UPPER] -= 1
        edge = edge_above(f64, i64, slot, layout.SLOT_UPPER, layout.NEXT_UPPER)
        event = i64[slot + layout.SLOT_UPPER_EVENT + i64[layout.NEXT_UPPER]]
        fraction = (was - edge) / (was - x) if was > edge else 0.0
        strike(f64, i64, slot, event, approach, speed, sample, fraction)
