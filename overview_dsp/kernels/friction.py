"""Surface look-up: the friction B at a position, linear between the table's points.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import NOT_NEGATIVE, inlined, outlined
from overview_dsp.kernels.layout import CELLS
from overview_dsp.kernels.simd.vector import choose, load_pairs
from overview_dsp.kernels.two_disk import ROUNDS, midpoint_speed


@inlined
def friction_at(f64, table, position):
    """B at `position` (cells, clamped to the table) from pairs of value and slope, N m s/rad."""
    # a NaN fails both comparisons and must not become an index
    if not position > 0.0:
        position = 0.0
    if position > CELLS:
        position = float(CELLS)
    i = int(position)
    at = (table + 2 * i) & NOT_NEGATIVE
    return f64[at] + (position - float(i)) * f64[at + 1]


@inlined
def frictions_at(f64, tables, first, position):
    """`friction_at` for lanes: lane i's table begins at column `tables[first + i]`."""
    position = choose(position > 0.0, position, 0.0)
    position = choose(position > CELLS, float(CELLS), position)
    whole, friction, slope = load_pairs(f64, tables, first, position)
    return friction + (position - whole) * slope


@inlined
def friction_between(f64, table, old_table, left, position):
    """B at a position (cells) of a surface of which `left` is still that of another table."""
    friction = friction_at(f64, table, position)
    if left > 0.0:
        before = friction_at(f64, old_table, position)
        friction = friction + (before - friction) * left
    return friction


@outlined
def corrected(f64, table, old_table, left, x, v, stretch, spring, inertia, middle):
    """B at a step's own midpoint, and its midpoint speed: where `middle` missed the predicted one.

    The tables are as in `friction_between`, the other arguments as in `two_disk`.
    """
    denominator = inertia * (2.0 + 0.5 * spring)
    friction = 0.0
    for _ in range(ROUNDS):
        friction = friction_between(f64, table, old_table, left, x + 0.5 * middle)
        again = midpoint_speed(v, stretch, spring, inertia, denominator, friction)
        middle = 0.5 * (middle + again)
    friction = friction_between(f64, table, old_table, left, x + 0.5 * middle)
    return friction, midpoint_speed(v, stretch, spring, inertia, denominator, friction)
