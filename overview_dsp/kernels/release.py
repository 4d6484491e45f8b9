"""Release: shaft 2 stays engaged until the disk has arrived at the last target.

A tap is thus a target that is released at once, and a swipe that is released early still ends at
the last input angle. The disk has arrived when it is near the target and past all events before it.
A disk that does not arrive in `derive.ARRIVAL_S` is released after that time. A new
touch ends the wait. Where the preset's release is `return`, shaft 2 stays and theta2 falls to 0.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.event_crossing import FAR, edges_below, event_above, event_below

NEAR = 0.006 * layout.CELLS  # cells: a disk this close to its target has arrived


@inlined
def stop_waiting(f64, i64):
    """Stop waiting for an arrival."""
    i64[layout.WAITING] = 0
    f64[layout.ARRIVAL_ABOVE] = FAR
    f64[layout.ARRIVAL_BELOW] = -FAR


@inlined
def arrive(f64, i64):
    """Disengage shaft 2, or return to 0, after a release."""
    stop_waiting(f64, i64)
    i64[layout.M_STILL] = 0  # the rest position changes
    if i64[layout.S_RELEASE_RETURNS] == 1:
        f64[layout.INPUT] = 0.0
        f64[layout.PACE] = f64[layout.C_TAP_RATE] * layout.CELLS
        f64[layout.WANTED] = f64[layout.PACE]
    else:
        i64[layout.ENGAGED] = 0


@inlined
def has_arrived(f64):
    """Return whether a released disk is at its target or beyond."""
    x = f64[layout.X]
    return x >= f64[layout.ARRIVAL_ABOVE] or x < f64[layout.ARRIVAL_BELOW]


@inlined
def last_edge_below(f64, i64, target):
    """Return the last edge of an event at or below the target (cells), or -FAR."""
    slot = layout.SURFACES + i64[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    lower = edges_below(f64, i64, slot, layout.SLOT_LOWER, target)
    upper = edges_below(f64, i64, slot, layout.SLOT_UPPER, target)
    return max(
        f64[slot + layout.SLOT_LOWER + lower - 1] if lower > 0 else -FAR,
        f64[slot + layout.SLOT_UPPER + upper - 1] if upper > 0 else -FAR,
    )


@inlined
def first_edge_above(f64, i64, target):
    """Return the first edge of an event above the target (cells), or FAR."""
    slot = layout.SURFACES + i64[layout.ACTIVE_SLOT] * layout.SLOT_SIZE
    events = i64[slot + layout.SLOT_EVENTS]
    lower = edges_below(f64, i64, slot, layout.SLOT_LOWER, target)
    upper = edges_below(f64, i64, slot, layout.SLOT_UPPER, target)
    return min(
        f64[slot + layout.SLOT_LOWER + lower] if lower < events else FAR,
        f64[slot + layout.SLOT_UPPER + upper] if upper < events else FAR,
    )


@inlined
def wait_for_disk(f64, i64):
    """Wait for the disk's arrival after the last release, unless it has arrived."""
    target = f64[layout.INPUT]
    i64[layout.WAITING] = 1
    i64[layout.RELEASE_DUE] = i64[layout.CLOCK] + i64[layout.S_ARRIVAL]
    if f64[layout.X] < target:
        f64[layout.ARRIVAL_ABOVE] = max(target - NEAR, last_edge_below(f64, i64, target))
    else:
        f64[layout.ARRIVAL_BELOW] = min(target + NEAR, first_edge_above(f64, i64, target))
    if has_arrived(f64):
        arrive(f64, i64)


@inlined
def next_above(f64, i64):
    """Return the position (cells) of the next event or of arrival, upwards."""
    return min(event_above(f64, i64), f64[layout.ARRIVAL_ABOVE])


@inlined
def next_below(f64, i64):
    """Return the position (cells) of the next event or of arrival, downwards."""
    return max(event_below(f64, i64), f64[layout.ARRIVAL_BELOW])
