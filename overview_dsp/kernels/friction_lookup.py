"""Surface look-up: the friction B at a position, linear between the table's points.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import NOT_NEGATIVE, inlined, outlined
from overview_dsp.kernels.layout import CELLS
from overview_dsp.kernels.simd.tables import gather, load_pairs, marking
from overview_dsp.kernels.simd.vector import any_of, choose, rarely
from overview_dsp.kernels.two_disk import midpoint_speed

ROUNDS = 2  # of Newton's method
SHORT = 1.0 / 64.0  # cells: shorter steps use the midpoint, since a difference would cancel
INTEGRAL = layout.SLOT_INTEGRAL - layout.SLOT_TABLE  # from a slot's table on
STEEP = layout.SLOT_STEEP - layout.SLOT_TABLE
marked, any_marked = marking(layout.STEEP_BLOCK.bit_length() - 1)


@inlined
def on_table(position):
    """Return `position` (cells) clamped to the table."""
    # a NaN fails both comparisons and must not become an index
    position = rarely(not position > 0.0, 0.0, position)
    return rarely(position > CELLS, float(CELLS), position)


@inlined
def on_tables(position):
    """`on_table` for lanes."""
    position = choose(position > 0.0, position, 0.0)
    return choose(position > CELLS, float(CELLS), position)


@inlined
def friction_on(f64, table, position):
    """Return B at a clamped `position` (cells) from pairs of value and slope, N m s/rad."""
    i = int(position)
    at = (table + 2 * i) & NOT_NEGATIVE
    return f64[at] + (position - float(i)) * f64[at + 1]


@inlined
def friction_at(f64, table, position):
    """Return B at any `position` (cells), N m s/rad."""
    return friction_on(f64, table, on_table(position))


@inlined
def frictions_at(f64, tables, first, position):
    """`friction_at` for lanes: lane i's table begins at column `tables[first + i]`."""
    position = on_tables(position)
    whole, friction, slope = load_pairs(f64, tables, first, position)
    return friction + (position - whole) * slope


@inlined
def friction_between(f64, table, old_table, left, position):
    """Return B at a position (cells) in a crossfade; `left` is the weight of the old table."""
    friction = friction_at(f64, table, position)
    if left > 0.0:
        before = friction_at(f64, old_table, position)
        friction = friction + (before - friction) * left
    return friction


@inlined
def integral_at(f64, table, position):
    """Return the integral of B from 0 to `position` (cells), N m s/rad cells."""
    inside = on_table(position)
    i = int(inside)
    part = inside - float(i)
    at = (table + 2 * i) & NOT_NEGATIVE
    friction, slope = f64[at], f64[at + 1]
    whole = f64[(table + INTEGRAL + i) & NOT_NEGATIVE]
    integral = whole + part * (friction + 0.5 * part * slope)
    return rarely(position != inside, integral + (position - inside) * friction, integral)


@inlined
def integrals_at(f64, tables, first, position):
    """`integral_at` for lanes, and `friction_at`; tables as in `frictions_at`."""
    inside = on_tables(position)
    whole, friction, slope = load_pairs(f64, tables, first, inside)
    part = inside - whole
    integral = gather(f64, tables, first, INTEGRAL, inside)
    integral = integral + part * (friction + 0.5 * part * slope)
    beyond = integral + (position - inside) * friction
    return choose(position == inside, integral, beyond), friction + part * slope


@inlined
def integral_between(f64, table, old_table, left, position):
    """Return `integral_at` in a crossfade; `left` is the weight of the old table."""
    integral = integral_at(f64, table, position)
    if left > 0.0:
        before = integral_at(f64, old_table, position)
        integral = integral + (before - integral) * left
    return integral


@inlined
def is_steep(i64, table, position):
    """Return whether a step about a `position` on the table (cells) may cross a steep edge."""
    return i64[(table + STEEP + int(position) // layout.STEEP_BLOCK) & NOT_NEGATIVE] == 1


@inlined
def any_steep(i64, tables, first, position):
    """Return whether a step about any lane's `position` may cross a steep edge."""
    return any_marked(i64, tables, first, STEEP, on_tables(position))


@inlined
def steep_at(i64, tables, first, position):
    """`is_steep` for lanes, at any position; as `frictions_at`."""
    return marked(i64, tables, first, STEEP, on_tables(position))


@outlined
def mean_friction(f64, table, old_table, left, x, v, stretch, spring, inertia, middle):
    """Return the mean of B over a step, and the midpoint speed, of which `middle` is a guess.

    The tables are as in `friction_between`, the other arguments as in `two_disk`.
    """
    denominator = inertia * (2.0 + 0.5 * spring)
    push = inertia * (2.0 * v + spring * stretch)
    start = integral_between(f64, table, old_table, left, x)
    for _ in range(ROUNDS):
        end = x + middle
        taken = integral_between(f64, table, old_table, left, end) - start
        there = friction_between(f64, table, old_table, left, end)
        middle = middle - (middle * denominator + taken - push) / (denominator + there)
    if abs(middle) > SHORT:
        taken = integral_between(f64, table, old_table, left, x + middle) - start
        friction = taken / middle
    else:
        friction = friction_between(f64, table, old_table, left, x + 0.5 * middle)
    return friction, midpoint_speed(v, stretch, spring, inertia, denominator, friction)


@inlined
def mean_frictions(f64, tables, first, x, v, stretch, spring, inertia, denominator, middle):
    """`mean_friction` for lanes without a crossfade; tables as in `frictions_at`."""
    push = inertia * (2.0 * v + spring * stretch)
    start, _ = integrals_at(f64, tables, first, x)
    for _ in range(ROUNDS):
        end, there = integrals_at(f64, tables, first, x + middle)
        taken = end - start
        middle = middle - (middle * denominator + taken - push) / (denominator + there)
    end, _ = integrals_at(f64, tables, first, x + middle)
    friction = (end - start) / middle
    if any_of(choose(abs(middle) > SHORT, 0.0, 1.0) > 0.0):
        halfway = frictions_at(f64, tables, first, x + 0.5 * middle)
        friction = choose(abs(middle) > SHORT, friction, halfway)
    return friction, midpoint_speed(v, stretch, spring, inertia, denominator, friction)
