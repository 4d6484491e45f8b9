"""Scan of the samples of a series for gaps, steps and share splits, and the Timeline made from it.

Times of samples stay exact: time 0 is that of the first row, and the timeline ends at the last row.
The curve is the mapped column (`curve_maps`) in its own unit; two of its percentiles become 0 and
1. Rules find events in the value column (`series_events`). Gaps are missing values and holes
between rows (`series_gaps`).

A series of up to `LONG_ROWS` rows is one block in memory, sorted by time. A longer one is scanned
block by block, and its curve is stored on disk. Its rows must be in order, and share splits are not
detected. Its events are at the largest steps, and at the lowest and highest of every N consecutive
samples (`Thinner`).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from datetime import datetime, timedelta

import numpy as np

from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.data.analysis import curve_maps
from overview_dsp.data.analysis.curve_maps import PERCENTILES
from overview_dsp.data.analysis.extrema import Thinner
from overview_dsp.data.analysis.series_events import (
    Calendar,
    Series,
    WindowRules,
    find_events,
    only_dates,
    value_text,
)
from overview_dsp.data.analysis.series_gaps import find_gaps, find_holes
from overview_dsp.data.analysis.share_splits import Split, find_splits
from overview_dsp.data.readers.series.read_plan import ReadPlan
from overview_dsp.data.readers.series.rows import (
    RowReader,
    Rows,
    in_order,
    last_of_each_time,
    skipped_note,
)
from overview_dsp.data.readers.tables.cells import sentinels
from overview_dsp.data.readers.tables.column_roles import is_adjusted, price_columns
from overview_dsp.data.readers.tables.table import CellLocation
from overview_dsp.data.timeline.curve_builder import CurveBuilder
from overview_dsp.data.timeline.curve_points import Points
from overview_dsp.data.timeline.growable_array import Store
from overview_dsp.data.timeline.intensity import LONG
from overview_dsp.data.timeline.model import Intensity, Timeline
from overview_dsp.errors import InputError, quoted

LONG_ROWS = 2_000_000
"""Tables with more rows are streamed."""

BLOCK_ROWS = 1_000_000
"""Rows per block."""

CONTEXT_ROWS = 65_536
"""Rows before a block from which the usual step is estimated."""

MAX_GAPS = 200_000

FEW_ROWS = "few rows"
"""Note of the error about a series of one time, which the next row makes valid."""

_EVEN = 1e-6
"""Maximum deviation of evenly spaced times, as a fraction of a step."""


def scan_samples(plan: ReadPlan, reader: RowReader) -> SampleScan:
    """Scan the rows of a table.

    InputError: no rows, only one time, no value, too many gaps; rows of a long series out of order.
    OutputError: the temporary folder is full.
    """
    rows = iter(reader)
    head: list[Rows] = []
    while reader.rows < LONG_ROWS and (part := next(rows, None)) is not None:
        head.append(part)
    if not reader.rows:
        raise InputError("no rows with a time; a series has one row per time")
    following = next(rows, None)
    scan = SampleScan(plan, reader, in_one_block=following is None)
    if following is None:
        whole, scan.notes = in_order(reader, np.concatenate(head, axis=1))
        scan.add(whole)
    else:
        for block in _blocks(plan, itertools.chain(head, (following,), rows)):
            scan.add(block)
    return scan


@dataclass
class SampleScan:
    """Scanner of consecutive blocks of samples; `in_one_block` if one block has all samples."""

    plan: ReadPlan
    reader: RowReader
    in_one_block: bool
    notes: list[str] = field(default_factory=list)
    builder: CurveBuilder = field(default_factory=CurveBuilder)
    times: Store = field(default_factory=lambda: Store(np.float64))
    thinner: Thinner = field(default_factory=Thinner)
    gaps: list[tuple[float, float]] = field(default_factory=list)
    splits: tuple[Split, ...] = ()
    gap_rule: str = ""
    missing: int = 0
    count: int = 0
    relative: bool = False
    start: datetime | None = None
    _dates_only: bool = False
    _first_s: float = 0.0
    _step_s: float = 0.0
    _even: bool = True
    _missing: list[list[float]] = field(default_factory=list)
    _context: FloatArray = field(default_factory=lambda: np.empty((3, 0)))
    _change: FloatArray = field(default_factory=lambda: np.empty(0))
    _samples: tuple[FloatArray, FloatArray, FloatArray] | None = None
    _points: tuple[FloatArray, FloatArray] | None = None

    def _begin(self, block: Rows) -> None:
        """Set what applies to all blocks, from the first one."""
        self._missing = [sentinels(value) for value in block[2:]]
        for index, values, found in zip(self.plan.columns, block[2:], self._missing, strict=True):
            for absent in found:
                many = f"{np.count_nonzero(values == absent)} " if self.in_one_block else ""
                header = quoted(self.plan.table.columns[index].header)
                self.notes.append(f"{many}values of {absent:g} in column {header} count as missing")
        value = self._column(block, 0)
        if self.in_one_block and np.isnan(value).all():
            raise self._no_value()
        number, seconds = block[:2]
        if len(seconds) < 2:
            raise InputError(
                f"only one time ({self.plan.table.row_word} {int(number[0])}); a series has "
                "two or more; name another column if this one doesn't have the times",
                note=FEW_ROWS,
            )
        self._first_s = float(seconds[0])
        self._require_span(seconds)
        self._step_s = float(seconds[-1] - seconds[0]) / (len(seconds) - 1)
        self.start = self.reader.time.start(self._first_s)
        if self.start is None and self._first_s != 0.0:
            self.notes.append(f"times begin at {self._first_s:g} s; the timeline counts from there")
        price = self.plan.value_type.relative
        self.relative = price and not bool((value <= 0.0).any())
        if price and not self.relative:
            self.notes.append(curve_maps.NOT_ABOVE_0)

    def _require_span(self, seconds: FloatArray) -> None:
        if not np.isfinite(seconds).all() or seconds[-1] - self._first_s > 1e15:
            raise InputError("the times span more than 30 million years; check their unit")

    def _no_value(self) -> InputError:
        header = quoted(self.plan.value_column.header)
        return InputError(f"column {header} has no value in any row; name another")

    def _column(self, block: Rows, i: int) -> FloatArray:
        """Return a column of a block, with NaN for the number that means "no value"."""
        value, absent = block[2 + i], self._missing[i]
        return np.where(np.isin(value, absent), np.nan, value) if absent else value

    def add(self, block: Rows) -> None:
        """Scan the next block, which has one row per time."""
        if not self.count:
            self._begin(block)
        self._require_span(block[1])
        time_s = block[1] - self._first_s
        if (np.diff(time_s) <= 0.0).any():
            raise InputError("times are too large to be distinguished; subtract the first one")
        columns = {index: self._column(block, i) for i, index in enumerate(self.plan.columns)}
        value, level = columns[self.plan.value], columns[self.plan.mapped]
        if self._even:
            ideal = np.arange(self.count, self.count + len(time_s)) * self._step_s
            self._even = bool(np.abs(time_s - ideal).max() <= _EVEN * self._step_s)
        self.missing += int(np.isnan(value).sum())
        self.count += len(value)

        carried = self._context.shape[1]
        whole = np.concatenate((self._context, [time_s, value, level]), axis=1)
        since = max(carried - 1, 0)  # index of the last sample before the block, if there is one
        holes = self._holes(whole[0], since)
        self._add_gaps(whole, since, holes)
        factors = self._find_splits(columns, time_s) if self.in_one_block else {}
        step = curve_maps.steps(whole[1, since:], holes - since, self.relative, factors)
        known = ~np.isnan(value)
        found = time_s[known], value[known], step[carried - since :][known]
        if self.in_one_block:
            self._samples = found
            self._dates_only = only_dates(self.start, time_s)
        else:
            self.times.append(time_s)
            self.thinner.add(*found)
        self._add_curve(whole, since, carried, holes, step, factors)
        self._context = whole[:, -CONTEXT_ROWS:].copy()

    def _find_splits(
        self, columns: Mapping[int, FloatArray], time_s: FloatArray
    ) -> dict[int, float]:
        """Find share splits, add notes, and return the factor by the index of each split."""
        if not self.relative or self.plan.value_type.kind != "share":
            return {}
        splits = _splits(self.plan, columns)
        value = columns[self.plan.value]
        calendar = Calendar(self.start, only_dates(self.start, time_s))
        self.notes += _split_notes(self.plan, value, time_s, splits, calendar)
        index = np.cumsum(~np.isnan(value)) - 1
        self.splits = tuple(Split(int(index[s.index]), s.ratio, s.factor) for s in splits)
        return {split.index: split.factor for split in splits}

    def _holes(self, time_s: FloatArray, since: int) -> IntArray:
        """Return the indices of samples before holes, from `since` on."""
        start = self.start
        if start is not None:
            start += timedelta(seconds=float(time_s[0]))
        holes = find_holes(time_s, start)
        self.gap_rule = self.gap_rule or holes.rule
        return holes.after[holes.after >= since]

    def _add_gaps(self, whole: FloatArray, since: int, holes: IntArray) -> None:
        time_s, value, level = whole[:, since:]
        value = np.where(np.isnan(level), np.nan, value)
        found = list(find_gaps(time_s, value, holes - since))
        if self.gaps and found and found[0][0] == self.gaps[-1][1] and np.isnan(value[0]):
            found[0] = self.gaps.pop()[0], found[0][1]  # a gap that began in the previous block
        self.gaps += found
        if len(self.gaps) > MAX_GAPS:
            raise InputError(
                f"more than {MAX_GAPS} gaps; keep the rows that have a value, or name another "
                "column"
            )

    def _add_curve(
        self,
        whole: FloatArray,
        since: int,
        carried: int,
        holes: IntArray,
        step: FloatArray,
        factors: dict[int, float],
    ) -> None:
        mapping, (time_s, _, level) = self.plan.map, whole
        if mapping.in_per_cent(self.relative) != self.relative:
            step = curve_maps.steps(level[since:], holes - since, not self.relative, factors)
        change = np.concatenate((self._change, step[carried - since :]))
        kept = len(change)
        curve = curve_maps.curve(mapping, level[-kept:], change, time_s[-kept:])
        if self.in_one_block:
            known = ~np.isnan(curve)
            if not known.any():
                raise InputError("the mapped column has no value in any row; name another")
            self._points = time_s[known], curve[known]
            return
        self.builder.append(curve[len(self._change) :])
        if mapping.name == "volatility":
            self._change = change[-self._changes_needed(time_s) :]

    def _changes_needed(self, time_s: FloatArray) -> int:
        """Return the number of changes before a block that its first volatility requires."""
        size, seconds = self.plan.map.window()
        if seconds:
            size = float(len(time_s) - np.searchsorted(time_s, time_s[-1] - size)) + 1.0
        if size >= CONTEXT_ROWS:
            raise InputError(
                f"map volatility: a window of more than {CONTEXT_ROWS} samples in a series of more "
                f"than {LONG_ROWS} rows; give a shorter one"
            )
        return int(size)

    def timeline(self, title: str) -> Timeline:
        """Return the Timeline of all blocks, with `title` and the name of the value column."""
        plan, column = self.plan, self.plan.value_column
        units = [number.unit or "" for number in self.reader.numbers]
        mapped_unit = plan.mapped_column.unit or units[plan.columns.index(plan.mapped)]
        samples = self._samples or self.thinner.finish()
        if not len(samples[1]):
            raise self._no_value()
        curve = self._curve(plan.map.unit(mapped_unit, plan.map.in_per_cent(self.relative)))
        unit, calendar = column.unit or units[0], Calendar(self.start, self._dates_only)
        series = Series(*samples, self.relative, unit, calendar, self.splits, self.in_one_block)
        gaps, duration_s = tuple(self.gaps), max(self._last_s, curve.last_s)
        events, event_notes = find_events(series, duration_s)
        is_level = plan.map.name == "level" and not self.in_one_block
        names = " and ".join(quoted(plan.table.columns[i].header) for i in plan.time.columns)
        times = f"over {names} ({plan.time.format.description})" if names else "evenly spaced"
        return Timeline(
            title=": ".join(filter(None, (title, column.name))),
            duration_s=duration_s,
            events=tuple(events),
            intensity=curve,
            gaps=gaps,
            provenance=(
                f"a {plan.table.kind} table, column {quoted(column.header)} {times}; events by rule"
            ),
            notes=(*plan.notes, *self.notes, *self._closing_notes(curve), *event_notes),
            start=self.start,
            # events of windows are found in all samples, even if the series has only some
            rules=WindowRules(series, 0.0, duration_s, curve if is_level else None, gaps),
        )

    def _closing_notes(self, curve: Intensity) -> Iterator[str]:
        if not self.in_one_block:
            if self.reader.skipped:
                yield skipped_note(self.reader)
            yield (
                f"of {self.count} samples, events are found among the lowest and highest of every "
                f"{self.thinner.run} and the largest steps; share splits are not detected"
            )
        if self.missing:
            rule = "which makes gaps where others aren't as close as usual"
            yield f"{self.missing} of {self.count} values are missing, {rule}"
        yield _gap_note(self.gaps, self.gap_rule)
        if curve.count > LONG:
            low, high = curve.scale_outside(tuple(self.gaps))
        else:
            low, high = curve.scale(np.ones(curve.count, np.bool_))
        words = self.plan.map.description(quoted(self.plan.mapped_column.header))
        yield (
            f"friction follows {words}: 0 at {value_text(low, curve.unit)} and 1 at "
            f"{value_text(high, curve.unit)} (percentiles {PERCENTILES[0]:g} and "
            f"{PERCENTILES[1]:g}); only the friction is clipped there, not the values"
        )

    @property
    def _last_s(self) -> float:
        return float(self._context[0, -1])

    def _curve(self, unit: str) -> Intensity:
        if self._points is not None:
            return Intensity(*self._points, unit, PERCENTILES)
        curve = self.builder.finish(
            step_s=self._last_s / (self.count - 1), unit=unit, percentiles=PERCENTILES
        )
        if self._even:
            return curve
        points = Points(self.times.finish(), curve.points.value)
        points.__dict__["levels"] = curve.points.levels  # built with the values
        return Intensity.checked(points, unit, PERCENTILES)


def _blocks(plan: ReadPlan, rows: Iterator[Rows]) -> Iterator[Rows]:
    """Combine rows to blocks with one row per time.

    InputError: a row has an earlier time than the row before it.
    """
    waiting: list[Rows] = []
    count = 0
    for part in rows:
        waiting.append(part)
        count += part.shape[1]
        if count >= BLOCK_ROWS:
            block = _sorted_block(plan, waiting)
            # rows of the last time may continue in the next part
            end = int(np.searchsorted(block[1], block[1, -1]))
            if not end:
                raise InputError(f"{count} rows of one time; check the time column")
            waiting, count = [block[:, end:]], count - end
            yield last_of_each_time(block[:, :end])
    if count:
        yield last_of_each_time(_sorted_block(plan, waiting))


def _sorted_block(plan: ReadPlan, parts: list[Rows]) -> Rows:
    block = np.concatenate(parts, axis=1)
    back = np.flatnonzero(np.diff(block[1]) < 0.0)
    if back.size:
        raise CellLocation(int(block[0, back[0] + 1]), word=plan.table.row_word).fault(
            f"earlier than the row before it; a series of more than {LONG_ROWS} rows has to be in "
            "order: sort it by time"
        )
    return block


def _splits(plan: ReadPlan, by_column: Mapping[int, FloatArray]) -> list[Split]:
    if is_adjusted(plan.value_column):
        return []
    beside = {
        name: by_column.get(i) if i != plan.value else None
        for name, i in price_columns(plan.table.columns).items()
    }
    adjusted, close = beside.get("adjusted"), beside.get("close")
    price = by_column[plan.value] if close is None or adjusted is None else close
    return find_splits(price, adjusted, beside.get("open"), beside.get("volume"))


def _split_notes(
    plan: ReadPlan, value: FloatArray, time_s: FloatArray, splits: list[Split], calendar: Calendar
) -> list[str]:
    if not splits:
        return []
    adjusted = price_columns(plan.table.columns).get("adjusted")
    if adjusted is not None:
        header = quoted(plan.table.columns[adjusted].header)
        advice = f"select the adjusted column {header} with value (--value-column)"
    else:
        advice = "the table has no adjusted column; use a file with adjusted prices"
    examples = []
    known = np.flatnonzero(~np.isnan(value))
    for split in splits[:6]:
        before = value[known[np.searchsorted(known, split.index) - 1]]
        examples.append(
            f"{split.ratio} on {calendar.text(float(time_s[split.index]))} "
            f"({value_text(float(before))} to {value_text(float(value[split.index]))})"
        )
    more = f" and {len(splits) - 6} more" if len(splits) > 6 else ""
    return [
        f"column {quoted(plan.value_column.header)} isn't adjusted for share splits: "
        f"{', '.join(examples)}{more}; steps are corrected for them, but the level jumps: {advice}"
    ]


def _gap_note(gaps: list[tuple[float, float]], rule: str) -> str:
    if not gaps:
        return f"no gaps ({rule})"
    longest = max(end - start for start, end in gaps)
    total = sum(end - start for start, end in gaps)
    days = f"{longest / 86_400:.4g} days" if longest >= 2 * 86_400 else f"{longest:.6g} s"
    share = f"{len(gaps)} gap{'s' if len(gaps) > 1 else ''}, the longest {days}"
    return f"{share}, {total:.6g} s in all, from the last value to the next ({rule})"
