"""Surface look-up: the friction B at a place, linear between the table's points.

Thread: audio.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import NOT_NEGATIVE, point
from overview_dsp.kernels.lanes import choose, load_pairs
from overview_dsp.kernels.layout import CELLS


@point
def friction_at(m, table, place):
    """B at `place` (cells, clamped to the table) from pairs of value and slope, N m s/rad."""
    # a NaN fails both comparisons and must not become an index
    if not place > 0.0:
        place = 0.0
    if place > CELLS:
        place = float(CELLS)
    i = int(place)
    at = (table + 2 * i) & NOT_NEGATIVE
    return m[at] + (place - float(i)) * m[at + 1]


@point
def frictions_at(m, tables, first, place):
    """`friction_at` for lanes: lane i's table begins at column `tables[first + i]`."""
    place = choose(place > 0.0, place, 0.0)
    place = choose(place > CELLS, float(CELLS), place)
    whole, friction, slope = load_pairs(m, tables, first, place)
    return friction + (place - whole) * slope
