"""A series of ordinary length, looked at in one piece."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.readers.tables import mapping, prices
from overview_dsp.readers.tables.events import Series
from overview_dsp.readers.tables.found import Found, require_few_gaps
from overview_dsp.readers.tables.holes import find_holes, gaps_of
from overview_dsp.readers.tables.mapping import PERCENTILES
from overview_dsp.readers.tables.plan import Plan
from overview_dsp.readers.tables.samples import Samples
from overview_dsp.readers.tables.splits import Split, find_splits
from overview_dsp.readers.tables.words import Calendar, value_text
from overview_dsp.timeline import checks
from overview_dsp.timeline.model import Intensity


def look_at(plan: Plan, samples: Samples) -> Found:
    """Find gaps, steps, share splits and the mapped curve of samples in order.

    Raises
    ------
    InputError
        The mapped column has no value, or there are too many gaps.
    """
    by_column = dict(zip(plan.columns, samples.values, strict=True))
    units = dict(zip(plan.columns, samples.units, strict=True))
    value, level = by_column[plan.value], by_column[plan.mapped]
    unit = plan.value_column.unit or units[plan.value]
    time_s = samples.time_s

    holes = find_holes(time_s, samples.start)
    gaps = gaps_of(time_s, np.where(np.isnan(level), np.nan, value), holes.after)
    require_few_gaps(len(gaps))

    price = prices.is_price(plan.value_column)
    relative = price or mapping.grows_like_a_price(value, unit)
    splits = _splits(plan, by_column) if relative else []
    calendar = Calendar(samples.start, _dates_only(samples))
    notes = [*samples.notes, *_split_notes(plan, value, time_s, splits, calendar)]
    if relative and not price:
        notes.append(mapping.GROWS)

    factors = {split.index: split.factor for split in splits}
    step = mapping.steps(value, holes.after, relative, factors)
    known = ~np.isnan(value)
    index = np.cumsum(known) - 1
    series = Series(
        time_s[known],
        value[known],
        step[known],
        relative,
        unit,
        calendar,
        tuple(Split(int(index[s.index]), s.ratio, s.factor) for s in splits),
    )
    if plan.map.in_per_cent(relative) != relative:
        relative = not relative
        step = mapping.steps(level, holes.after, relative, factors)
    curve = mapping.curve(plan.map, level, step, time_s)
    kept = ~np.isnan(curve)
    if not kept.any():
        raise InputError("the mapped column has no value in any row; name another")
    mapped_unit = plan.mapped_column.unit or units[plan.mapped]
    return Found(
        series=series,
        intensity=Intensity(
            time_s[kept], curve[kept], plan.map.unit(mapped_unit, relative), PERCENTILES
        ),
        words=plan.map.words(checks.shown(plan.mapped_column.header)),
        gaps=gaps,
        gap_rule=holes.rule,
        missing=int((~known).sum()),
        count=len(value),
        duration_s=float(time_s[-1]),
        notes=tuple(notes),
    )


def _dates_only(samples: Samples) -> bool:
    """Tell whether all samples are at midnight."""
    start = samples.start
    if start is None or (start.hour, start.minute, start.second) != (0, 0, 0):
        return False
    return not np.any(np.mod(np.round(samples.time_s, 6), 86_400.0))


def _splits(plan: Plan, by_column: dict[int, NDArray[np.float64]]) -> list[Split]:
    columns = plan.table.columns
    if prices.is_adjusted(plan.value_column):
        return []

    def beside(found: int | None) -> NDArray[np.float64] | None:
        return None if found is None or found == plan.value else by_column.get(found)

    return find_splits(
        by_column[plan.value],
        beside(prices.adjusted(columns)),
        beside(prices.opening(columns)),
        beside(prices.volume(columns)),
    )


def _split_notes(
    plan: Plan,
    value: NDArray[np.float64],
    time_s: NDArray[np.float64],
    splits: list[Split],
    calendar: Calendar,
) -> list[str]:
    if not splits:
        return []
    adjusted = prices.adjusted(plan.table.columns)
    if adjusted is not None:
        header = checks.shown(plan.table.columns[adjusted].header)
        advice = f"take {header} with value (--value), which is"
    else:
        advice = "the table has no adjusted column; get prices that are"
    shown = []
    known = np.flatnonzero(~np.isnan(value))
    for split in splits[:6]:
        before = value[known[np.searchsorted(known, split.index) - 1]]
        shown.append(
            f"{split.ratio} on {calendar.text(float(time_s[split.index]))} "
            f"({value_text(float(before))} to {value_text(float(value[split.index]))})"
        )
    more = f" and {len(splits) - 6} more" if len(splits) > 6 else ""
    return [
        f"column {checks.shown(plan.value_column.header)} isn't adjusted for share splits: "
        f"{', '.join(shown)}{more}; these steps are no moves, but the level jumps: {advice}"
    ]
