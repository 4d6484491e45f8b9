"""Decoder of memory images (`offline/export/browser_memory.py` describes and writes them).

Images of other layouts are rejected before any column is written. Indices are checked
afterwards, so that no image can cause access outside the block.

Thread: main.
"""

from __future__ import annotations

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import NOT_NEGATIVE, inlined, outlined

HEAD = 5  # columns before the pairs
WHOLE, CHANGE = range(2)  # kinds
FILL, DATA, TABLE, INTEGRAL = range(4)  # how a run is written
INTEGRAL_FROM_TABLE = layout.SLOT_INTEGRAL - layout.SLOT_TABLE
LOW = 0xFFFFFFFF  # of a column's two halves


@inlined
def values_of(how, count):
    """Return the number of values that a run stores for `count` columns."""
    if how == FILL:
        return 1
    if how == INTEGRAL:
        return 0
    return count if how == DATA else count // 2


@outlined
def is_image(ints, columns, digest):
    """Return whether `columns` columns are a complete image of the layout with a digest."""
    if columns < HEAD or ints[0] != digest or ints[1] != WHOLE:
        return False
    covered = 0
    at = HEAD
    while at < columns:
        how = ints[at & NOT_NEGATIVE] & LOW
        count = ints[at & NOT_NEGATIVE] >> 32
        if how > INTEGRAL or count <= 0 or count > layout.TOTAL - covered:
            return False
        if how == TABLE and count & 1 == 1:
            return False
        # an integral is computed from the preceding table
        if how == INTEGRAL and (covered < INTEGRAL_FROM_TABLE or 2 * count > INTEGRAL_FROM_TABLE):
            return False
        covered += count
        at += 1 + values_of(how, count)
    return at == columns and covered == layout.TOTAL


@outlined
def decode(ints, values, columns, f64, i64):
    """Write the runs of an image, viewed as int64 and float64, to a memory block."""
    at = HEAD
    to = 0
    while at < columns:
        how = ints[at & NOT_NEGATIVE] & LOW
        count = ints[at & NOT_NEGATIVE] >> 32
        data = (at + 1) & NOT_NEGATIVE
        if how == FILL:
            for n in range(count):
                i64[to + n] = ints[data]
        elif how == DATA:
            for n in range(count):
                i64[to + n] = ints[data + n]
        elif how == TABLE:
            points = count // 2
            for n in range(points):
                f64[to + 2 * n] = values[data + n]
                last = n + 1 == points
                f64[to + 2 * n + 1] = 0.0 if last else values[data + n + 1] - values[data + n]
        else:
            table = to - INTEGRAL_FROM_TABLE
            f64[to] = 0.0
            for n in range(1, count):
                mean = 0.5 * (f64[table + 2 * n] + f64[table + 2 * n - 2])
                f64[to + n] = f64[to + n - 1] + mean
        to += count
        at += 1 + values_of(how, count)


@inlined
def has_valid_indices(i64, slot):
    """Return whether all indices of a surface are within its range."""
    events = i64[slot + layout.SLOT_EVENTS]
    if events < 0 or events > layout.MAX_EVENTS:
        return False
    sound = True
    for n in range(events):
        lower = i64[slot + layout.SLOT_LOWER_EVENT + n]
        upper = i64[slot + layout.SLOT_UPPER_EVENT + n]
        kind = i64[slot + layout.SLOT_KIND + n]
        sound = sound and 0 <= lower < events and 0 <= upper < events and 0 <= kind < layout.BANKS
    for n in range(layout.CELLS + 1):
        sound = sound and -1 <= i64[slot + layout.SLOT_OWNER + n] < max(events, 1)
    for kind in range(layout.BANKS):
        sound = sound and 0 <= i64[slot + layout.KIND_CLICK + kind] <= layout.MAX_MODES
    return sound


@inlined
def is_valid(f64, i64):
    """Return whether a decoded block has valid indices and finite friction > 0."""
    active = i64[layout.ACTIVE_SLOT]
    if active < 0 or active >= layout.SLOTS:
        return False
    for number in range(layout.SLOTS):
        if not has_valid_indices(i64, layout.SURFACES + number * layout.SLOT_SIZE):
            return False
    table = layout.SURFACES + active * layout.SLOT_SIZE + layout.SLOT_TABLE
    total = 0.0
    least = 1.0
    for n in range(layout.CELLS + 1):
        total = total + f64[table + 2 * n]
        least = min(least, f64[table + 2 * n])
    return total - total == 0.0 and least > 0.0
