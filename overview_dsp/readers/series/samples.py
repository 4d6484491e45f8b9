"""A series too long for memory, looked at block by block; its curve goes to disk.

Rows must be in order. Share splits are not looked for, and events are found among the lowest and
highest samples of equal runs and the largest steps (`thinning`): each at a true sample.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import datetime, timedelta

import numpy as np
from numpy.typing import NDArray

from overview_dsp.analysis import curve_maps
from overview_dsp.analysis.curve_maps import PERCENTILES
from overview_dsp.analysis.extrema import Thinner
from overview_dsp.analysis.series_events import Series
from overview_dsp.analysis.series_gaps import find_holes, gaps_of
from overview_dsp.analysis.series_labels import Calendar
from overview_dsp.errors import InputError, shown
from overview_dsp.readers.series.plan import Found, Plan, require_few_gaps
from overview_dsp.readers.series.rows import RowReader, Rows, joined, last_of_each_time
from overview_dsp.readers.tables.cells import sentinel
from overview_dsp.timeline.curve_builder import CurveBuilder
from overview_dsp.timeline.growable_array import Store
from overview_dsp.timeline.model import Intensity
from overview_dsp.timeline.samples import Points

LONG_ROWS = 2_000_000
"""A table of more rows is streamed."""

BLOCK_ROWS = 1_000_000
"""Rows looked at at a time."""

CONTEXT_ROWS = 65_536
"""Rows before a block that help to estimate the usual step between rows."""

_EVEN = 1e-6
"""Part of a step by which times may be off and still count as evenly spaced."""


@dataclass(frozen=True, eq=False)
class _Block:
    """Samples from the one before the block on: times from the series' first, values, levels."""

    time_s: NDArray[np.float64]
    value: NDArray[np.float64]
    level: NDArray[np.float64]


def look_at(plan: Plan, reader: RowReader, rows: Iterator[Rows]) -> Found:
    """Find gaps, steps and the mapped curve of rows in order.

    Raises
    ------
    InputError
        Rows that aren't in order (named), too many gaps, no value at all.
    OutputError
        The temporary folder is full.
    """
    return _Stream(plan, reader).read(rows)


@dataclass
class _Stream:
    plan: Plan
    reader: RowReader
    builder: CurveBuilder = field(default_factory=CurveBuilder)
    times: Store = field(default_factory=lambda: Store(np.float64))
    thinner: Thinner = field(default_factory=Thinner)
    gaps: list[tuple[float, float]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    gap_rule: str = ""
    missing: int = 0
    count: int = 0
    relative: bool = False
    start: datetime | None = None
    _first_s: float = 0.0
    _step_s: float = 0.0
    _even: bool = True
    _absent: list[float | None] = field(default_factory=list)
    _before: _Block | None = None
    _change: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))

    def read(self, rows: Iterator[Rows]) -> Found:
        for block in _blocks(self.plan, rows):
            if not self.count:
                self._begin(block)
            self._take(block)
        return self._found()

    def _begin(self, block: Rows) -> None:
        """Decide by the first block what holds for all."""
        if len(block) < 2:
            raise InputError(f"{BLOCK_ROWS} rows of one time; check the time column")
        self._first_s = float(block.seconds[0])
        self._step_s = float(block.seconds[-1] - block.seconds[0]) / (len(block) - 1)
        self.start = self.reader.time.start(self._first_s)
        self._absent = [sentinel(value) for value in block.values]
        value = self._known(block, 0)
        price = self.plan.worth.relative
        self.relative = price and not bool((value <= 0.0).any())
        if price and not self.relative:
            self.notes.append(curve_maps.NOT_ABOVE_0)
        if self.start is None and self._first_s != 0.0:
            self.notes.append(f"times begin at {self._first_s:g} s; the timeline counts from there")
        for index, absent in zip(self.plan.columns, self._absent, strict=True):
            if absent is not None:
                header = shown(self.plan.table.columns[index].header)
                self.notes.append(f"values of {absent:g} in column {header} count as missing")

    def _known(self, block: Rows, i: int) -> NDArray[np.float64]:
        """A column of a block, NaN where it holds the number for nothing."""
        value, absent = block.values[i], self._absent[i]
        return value if absent is None else np.where(value == absent, np.nan, value)

    def _take(self, block: Rows) -> None:
        time_s = block.seconds - self._first_s
        if (np.diff(time_s) <= 0.0).any():
            raise InputError("times lie too close together to be distinguished; count them from 0")
        value = self._known(block, 0)
        level = self._known(block, self.plan.columns.index(self.plan.mapped))
        self._watch_steps(time_s)
        self.times.append(time_s)
        self.missing += int(np.isnan(value).sum())
        self.count += len(value)

        context, tail = self._before, 0
        whole = _Block(time_s, value, level)
        if context is not None:
            tail = len(context.time_s)
            whole = _Block(
                np.concatenate((context.time_s, time_s)),
                np.concatenate((context.value, value)),
                np.concatenate((context.level, level)),
            )
        since = max(tail - 1, 0)  # steps from the last sample before the block on
        holes = self._holes(whole.time_s, since)
        self._add_gaps(whole, since, holes)
        step = curve_maps.steps(whole.value[since:], holes - since, self.relative)
        fresh = slice(tail - since, None)
        known = ~np.isnan(value)
        self.thinner.add(time_s[known], value[known], step[fresh][known])
        self._add_curve(whole, since, tail, holes, step)
        self._before = _Block(
            whole.time_s[-CONTEXT_ROWS:], whole.value[-CONTEXT_ROWS:], whole.level[-CONTEXT_ROWS:]
        )

    def _watch_steps(self, time_s: NDArray[np.float64]) -> None:
        if self._even:
            ideal = np.arange(self.count, self.count + len(time_s)) * self._step_s
            self._even = bool(np.abs(time_s - ideal).max() <= _EVEN * self._step_s)

    def _holes(self, time_s: NDArray[np.float64], since: int) -> NDArray[np.int64]:
        """Indices of samples before holes, from `since` on."""
        start = self.start
        if start is not None:
            start += timedelta(seconds=float(time_s[0]))
        holes = find_holes(time_s, start)
        self.gap_rule = self.gap_rule or holes.rule
        return holes.after[holes.after >= since]

    def _add_gaps(self, whole: _Block, since: int, holes: NDArray[np.int64]) -> None:
        value = np.where(np.isnan(whole.level), np.nan, whole.value)[since:]
        found = list(gaps_of(whole.time_s[since:], value, holes - since))
        if self.gaps and found and found[0][0] == self.gaps[-1][1] and np.isnan(value[0]):
            found[0] = self.gaps.pop()[0], found[0][1]  # it goes on from block to block
        self.gaps += found
        require_few_gaps(len(self.gaps))

    def _add_curve(
        self,
        whole: _Block,
        since: int,
        tail: int,
        holes: NDArray[np.int64],
        step: NDArray[np.float64],
    ) -> None:
        wish = self.plan.map
        if wish.in_per_cent(self.relative) != self.relative:
            step = curve_maps.steps(whole.level[since:], holes - since, not self.relative)
        fresh = step[tail - since :]
        change = np.concatenate((self._change, fresh))
        kept = len(change)
        curve = curve_maps.curve(wish, whole.level[-kept:], change, whole.time_s[-kept:])
        self.builder.append(curve[len(self._change) :])
        if wish.name == "volatility":
            self._change = change[-self._needed(whole.time_s) :]

    def _needed(self, time_s: NDArray[np.float64]) -> int:
        """How many changes before a block its first volatility needs."""
        size, seconds = self.plan.map.window()
        if seconds:
            size = float(len(time_s) - np.searchsorted(time_s, time_s[-1] - size)) + 1.0
        if size >= CONTEXT_ROWS:
            raise InputError(
                f"map volatility: a window of more than {CONTEXT_ROWS} samples in a series of more "
                f"than {LONG_ROWS} rows; give a shorter one"
            )
        return int(size)

    def _found(self) -> Found:
        plan, units = self.plan, [number.unit or "" for number in self.reader.numbers]
        unit = plan.value_column.unit or units[0]
        mapped_unit = plan.mapped_column.unit or units[plan.columns.index(plan.mapped)]
        header = shown(plan.value_column.header)
        time_s, value, step = self.thinner.finish()
        if not len(value):
            raise InputError(f"column {header} has no value in any row; name another")
        relative = plan.map.in_per_cent(self.relative)
        curve = self._curve(plan.map.unit(mapped_unit, relative))
        if self.reader.skipped:
            self.notes.append(f"{self.reader.skipped} rows without time and value were left out")
        self.notes.append(
            f"of {self.count} samples, events are found among the lowest and highest of every "
            f"{self.thinner.run} and the largest steps; share splits aren't looked for"
        )
        return Found(
            series=Series(
                time_s, value, step, self.relative, unit, Calendar(self.start, False), every=False
            ),
            intensity=curve,
            words=plan.map.words(shown(plan.mapped_column.header)),
            gaps=tuple(self.gaps),
            gap_rule=self.gap_rule,
            missing=self.missing,
            count=self.count,
            duration_s=max(self._last_s, curve.last_s),
            notes=tuple(self.notes),
        )

    @property
    def _last_s(self) -> float:
        assert self._before is not None
        return float(self._before.time_s[-1])

    def _curve(self, unit: str) -> Intensity:
        curve = self.builder.finish(
            step_s=self._last_s / (self.count - 1), unit=unit, percentiles=PERCENTILES
        )
        if self._even:
            return curve
        points = Points(self.times.finish(), curve.points.value)
        points.__dict__["levels"] = curve.points.levels  # built with the values
        return Intensity.checked(points, unit, PERCENTILES)


def _blocks(plan: Plan, rows: Iterator[Rows]) -> Iterator[Rows]:
    """Put rows together to blocks, one row a time.

    Raises
    ------
    InputError
        A row is earlier than the one before it.
    """
    waiting: list[Rows] = []
    count = 0
    for part in rows:
        waiting.append(part)
        count += len(part)
        if count >= BLOCK_ROWS:
            block = joined(waiting)
            _require_order(plan, block)
            # rows of the last time may go on in the next part
            end = int(np.searchsorted(block.seconds, block.seconds[-1]))
            if not end:
                raise InputError(f"{len(block)} rows of one time; check the time column")
            waiting, count = [block.cut(end, len(block))], len(block) - end
            yield last_of_each_time(block.cut(0, end))
    if count:
        block = joined(waiting)
        _require_order(plan, block)
        yield last_of_each_time(block)


def _require_order(plan: Plan, block: Rows) -> None:
    back = np.flatnonzero(np.diff(block.seconds) < 0.0)
    if back.size:
        raise InputError(
            f"{plan.table.row_word} {int(block.number[back[0] + 1])}: earlier than the row before "
            f"it; a series of more than {LONG_ROWS} rows has to be in order: sort it by time"
        )
