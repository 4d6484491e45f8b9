"""Surface look-up: the friction B at a position, linear between the table's points.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import NOT_NEGATIVE, inlined
from overview_dsp.kernels.layout import CELLS
from overview_dsp.kernels.simd.vector import choose, load_pairs


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
