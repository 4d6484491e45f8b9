"""The events of a series, by rule, each at the exact time of a sample; labels give value and date.

`highest`, `lowest`
    The largest and the smallest value (the first, if it comes back).
`record_high`, `record_low`
    A peak above all before it, a trough below all before it, once a tenth of the timeline has
    passed.
`peak`, `trough`
    Turning points: the eight most prominent of each (records among them), of at least a tenth of
    the range (1st to 99th percentile), a hundredth of the timeline apart.
`largest_rise`, `largest_fall`
    The up to five largest steps from one sample to the next, among the largest twentieth of all;
    weight: 1.5 for the largest, less as the root of the size, at least 0.5.
`crossing_up`, `crossing_down`
    Round levels crossed, with hysteresis (`crossings`).
`split`
    A share split the prices aren't adjusted for (`splits`); steps are taken without it.
`century` to `minute`
    Ticks of the calendar (`event_rules`).

Prominence and steps of prices are relative (logarithms and per cent), of other series in their
unit. A step over a gap is no move.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.readers.tables import event_rules
from overview_dsp.readers.tables.cells import Calendar, value_text
from overview_dsp.readers.tables.event_rules import crossings, peaks
from overview_dsp.readers.tables.share_splits import Split
from overview_dsp.timeline.event import Event

KINDS = (
    "highest", "lowest", "record_high", "record_low", "peak", "trough", "largest_rise",
    "largest_fall", "crossing_up", "crossing_down", "split", *event_rules.KINDS,
)  # fmt: skip
"""Every kind a series may have."""

TURNS = 8
MOVES = 5
LEAST_PROMINENCE = 0.1
APART = 0.01
RECORDS_AFTER = 0.1
_LARGE_STEP = 95.0
_HEAVIEST, _LIGHTEST = 1.5, 0.5


@dataclass(frozen=True, eq=False)
class Series:
    """What events are found in: samples with a value, in order.

    Parameters
    ----------
    time_s, value
        Shape (n,), n >= 1, finite.
    step
        Change of each sample from the one before it, NaN where there is none, shape (n,).
    relative
        Steps are per cent.
    unit
        Of the values.
    calendar
        Names times.
    splits
        Their indices count samples of this series.
    every
        These are all samples, not just the lowest and highest of runs.
    """

    time_s: NDArray[np.float64]
    value: NDArray[np.float64]
    step: NDArray[np.float64]
    relative: bool
    unit: str
    calendar: Calendar
    splits: tuple[Split, ...] = ()
    every: bool = True

    def event(self, kind: str, index: int, words: str, weight: float = 1.0) -> Event:
        """An event at a sample, labelled with words and its date."""
        time_s = float(self.time_s[index])
        return Event(time_s, kind, f"{words}, {self.calendar.text(time_s)}", weight)

    def shown(self, index: int) -> str:
        """The value of a sample, in words."""
        return value_text(float(self.value[index]), self.unit)


def find_events(series: Series, duration_s: float) -> tuple[list[Event], list[str]]:
    """Return all events of a series and the notes on how they were chosen."""
    extremes, extreme_events = _extremes(series)
    turn_events, least = _turns(series, extremes, duration_s)
    move_events = _moves(series)
    crossing_events, crossing_note = _crossings(series)
    split_events = [
        series.event("split", split.index, f"{split.ratio} split to {series.shown(split.index)}")
        for split in series.splits
    ]
    ticks = event_rules.ticks(series.calendar.start, duration_s)
    notes = []
    if turn_events:
        notes.append(f"peaks and troughs: the {TURNS} most prominent of each, of at least {least}")
    if crossing_note:
        notes.append(crossing_note)
    return [
        *extreme_events,
        *turn_events,
        *move_events,
        *crossing_events,
        *split_events,
        *ticks,
    ], notes


def _extremes(series: Series) -> tuple[set[int], list[Event]]:
    high, low = int(np.argmax(series.value)), int(np.argmin(series.value))
    if series.value[high] == series.value[low]:
        return set(), []  # a constant series has no highest place
    events = [
        series.event("highest", high, f"highest {series.shown(high)}{_often(series, high)}"),
        series.event("lowest", low, f"lowest {series.shown(low)}{_often(series, low)}"),
    ]
    return {high, low}, events


def _often(series: Series, index: int) -> str:
    count = int((series.value == series.value[index]).sum()) if series.every else 1
    return f" (first of {count})" if count > 1 else ""


def _turns(series: Series, extremes: set[int], duration_s: float) -> tuple[list[Event], str]:
    """Peaks and troughs, those of them that are records under that name."""
    level = series.value
    ratios = series.relative and float(level.min()) > 0.0
    if ratios:
        level = np.log(level)
    low, high = (float(edge) for edge in np.percentile(level, (1.0, 99.0)))
    least = LEAST_PROMINENCE * (high - low)
    events: list[Event] = []
    if not least > 0.0 or not math.isfinite(least):
        return events, ""
    for sign, kind, record in ((1.0, "peak", "record_high"), (-1.0, "trough", "record_low")):
        found, prominence = peaks(sign * level)
        order = np.argsort(-prominence, kind="stable")
        taken = [float(series.time_s[index]) for index in extremes]
        chosen: list[int] = []
        for k in order.tolist():
            at = float(series.time_s[found[k]])
            if len(chosen) == TURNS or prominence[k] < least:
                break
            if all(abs(at - other) >= APART * duration_s for other in taken):
                taken.append(at)
                chosen.append(int(found[k]))
        for index in sorted(chosen):
            best_before = float(np.max(sign * level[:index], initial=-np.inf))
            late = series.time_s[index] >= RECORDS_AFTER * duration_s
            is_record = late and sign * level[index] > best_before
            name = record if is_record else kind
            events.append(
                series.event(name, index, f"{name.replace('_', ' ')} {series.shown(index)}")
            )
    if ratios:
        words = f"{100.0 * math.expm1(least):.3g} % prominence"
    else:
        words = f"{value_text(least, series.unit)} prominence"
    return events, words


def _moves(series: Series) -> list[Event]:
    step = series.step
    known = np.abs(step[~np.isnan(step)])
    if not known.size or float(known.max()) == 0.0:
        return []
    least = float(np.percentile(known, _LARGE_STEP)) if series.every else 0.0
    events: list[Event] = []
    for sign, kind in ((1.0, "largest_rise"), (-1.0, "largest_fall")):
        size = np.where(np.isnan(step), 0.0, sign * step)
        order = _largest(size, MOVES)
        chosen = [i for i in order.tolist() if size[i] > 0.0 and size[i] >= least]
        for i in chosen:
            by = f"{step[i]:+.2f} %" if series.relative else _signed(float(step[i]), series.unit)
            weight = max(_LIGHTEST, _HEAVIEST * math.sqrt(float(size[i] / size[chosen[0]])))
            events.append(series.event(kind, i, f"{by} to {series.shown(i)}", weight))
    return events


def _largest(size: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """Indices of the largest, the first of equal ones first; without sorting all."""
    least = np.partition(size, -count)[-count] if len(size) > count else -np.inf
    some = np.flatnonzero(size >= least)
    return some[np.argsort(-size[some], kind="stable")[:count]]


def _signed(value: float, unit: str) -> str:
    words = value_text(value, unit)
    return words if words.startswith("-") else f"+{words}"


def _crossings(series: Series) -> tuple[list[Event], str]:
    low, high = (float(edge) for edge in np.percentile(series.value, (10.0, 90.0)))
    if not math.isfinite(high - low):
        return [], ""
    found, levels, margin = crossings(series.value, low, high)
    if not levels:
        return [], ""
    events = []
    for crossing in found:
        way = "up" if crossing.up else "down"
        verb = "rises above" if crossing.up else "falls below"
        words = f"{verb} {value_text(crossing.level, series.unit)} ({series.shown(crossing.index)})"
        events.append(series.event(f"crossing_{way}", crossing.index, words))
    shown = ", ".join(value_text(level) for level in levels)
    return events, (
        f"crossings of {shown}{' ' + series.unit if series.unit else ''} with a hysteresis of "
        f"{value_text(margin, series.unit)}"
    )
