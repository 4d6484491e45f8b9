"""Rules that find events in a series, each at the time of a sample; labels have value and date.

`highest`, `lowest`
    The largest and the smallest value (the first occurrence).
`record_high`, `record_low`
    A peak above all earlier values, a trough below all earlier values, after a tenth of the
    timeline.
`peak`, `trough`
    Turning points: the eight most prominent of each (records among them), of at least a tenth of
    the range (1st to 99th percentile), at least a hundredth of the timeline apart.
`largest_rise`, `largest_fall`
    The up to five largest steps from one sample to the next, among the largest twentieth of all;
    weight 1.5 for the largest, in proportion to the square root of the size, at least 0.5.
`crossing_up`, `crossing_down`
    Crossings of round levels, with hysteresis (`extrema`).
`split`
    A share split for which prices are not adjusted (`share_splits`); steps leave it out.
`century` to `second`
    Ticks of the calendar (`timeline.ticks`).

Prominence and steps of prices are relative (logarithms and per cent), of other series in their
unit. Steps over gaps do not count.

Events of a window follow the same rules, on its samples (`WindowRules`).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from datetime import datetime, timedelta

import numpy as np

from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.data.analysis import curve_maps
from overview_dsp.data.analysis.extrema import crossings, lows_and_highs, peaks
from overview_dsp.data.analysis.share_splits import Split
from overview_dsp.data.timeline import ticks
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.gaps import Gaps, cut_gaps
from overview_dsp.data.timeline.intensity import LONG
from overview_dsp.data.timeline.model import Intensity, Timeline
from overview_dsp.units import clock_text

KINDS = (
    "highest", "lowest", "record_high", "record_low", "peak", "trough", "largest_rise",
    "largest_fall", "crossing_up", "crossing_down", "split", *ticks.KINDS,
)  # fmt: skip
"""All event kinds of series."""

DERIVED_UNIT = "0..1"
"""Part of the unit of a curve that a reader derived from events; such values aren't data."""

TURNS = 8
MOVES = 5
LEAST_PROMINENCE = 0.1
APART = 0.01
RECORDS_AFTER = 0.1
_LARGE_STEP = 95.0
_HEAVIEST, _LIGHTEST = 1.5, 0.5
_LESSER = 200  # maximum of other events: more than a window shows, to choose distant ones
_TINY = 1e-300
_FAINT = 0.1  # minimum weight of the smaller changes of a window

MOST_SAMPLES = 2048
"""Maximum number of samples of a window; longer ones keep extremes of runs and largest steps."""

_NONE = np.empty(0)


def has_values(timeline: Timeline) -> bool:
    """Return whether the curve's values are data in a unit."""
    return timeline.intensity is not None and DERIVED_UNIT not in timeline.intensity.unit


def value_text(value: float, unit: str = "") -> str:
    """Return a value as text: `702.1`, `35.6 °C`, `1251000`, `3.5 %`."""
    figures = f"{value:.6g}"
    if "e" in figures and abs(value) < 1e15:
        figures = f"{value:.0f}"
    return f"{figures} {unit}" if unit else figures


@dataclass(frozen=True)
class Calendar:
    """Formatter of the times of a series: dates, dates with time of day, or clock times.

    `start`: moment of time 0; None for clock times from 0.
    `dates_only`: whether all samples are at midnight.
    """

    start: datetime | None
    dates_only: bool

    def text(self, time_s: float) -> str:
        """Return a time as text: `2012-09-19`, `2012-09-19 16:00`, `12:30.5`."""
        if self.start is None:
            return clock_text(time_s)
        try:
            moment = self.start + timedelta(seconds=time_s)
        except OverflowError:  # rounding beyond the last moment of the calendar
            moment = datetime.max
        if self.dates_only:
            return f"{moment.date().isoformat()}"
        whole = moment.replace(tzinfo=None)
        if whole.microsecond:
            return whole.isoformat(" ", "milliseconds")
        return whole.isoformat(" ", "seconds" if whole.second else "minutes")


@dataclass(frozen=True, eq=False)
class Series:
    """Samples with a finite value, one or more in order of time, in which events are found.

    `step`: change of each sample from the one before it, or NaN.
    `relative`: whether steps are per cent.
    `splits`: share splits; their indices refer to samples of this series.
    `every`: whether these are all samples, not only the lowest and highest of runs.
    """

    time_s: FloatArray
    value: FloatArray
    step: FloatArray
    relative: bool
    unit: str
    calendar: Calendar
    splits: tuple[Split, ...] = ()
    every: bool = True

    def event(self, kind: str, index: int, text: str, weight: float = 1.0) -> Event:
        """Return an event at a sample, labelled with a text and its date."""
        time_s = float(self.time_s[index])
        return Event(time_s, kind, f"{text}, {self.calendar.text(time_s)}", weight)

    def value_text(self, index: int) -> str:
        """Return the value of a sample as text."""
        return value_text(float(self.value[index]), self.unit)


def find_events(series: Series, duration_s: float) -> tuple[list[Event], list[str]]:
    """Return all events of a series and the notes on how they were chosen."""
    turns = _Turns.of(series)
    extremes, events = _extremes(series)
    turn_events = _prominent(series, turns, extremes, duration_s)
    crossing_events, crossing_note = _crossings(series)
    events += [*turn_events, *_moves(series), *crossing_events]
    for split in series.splits:
        words = f"{split.ratio} split to {series.value_text(split.index)}"
        events.append(series.event("split", split.index, words))
    notes = []
    if turn_events:
        least = f"{value_text(turns.least, series.unit)} prominence"
        if turns.ratios:
            least = f"{100.0 * math.expm1(turns.least):.3g} % prominence"
        notes.append(f"peaks and troughs: the {TURNS} most prominent of each, of at least {least}")
    if crossing_note:
        notes.append(crossing_note)
    return [*events, *ticks.ticks(series.calendar.start, duration_s)], notes


def find_window_events(series: Series, duration_s: float) -> Iterator[Event]:
    """Yield the events of a window of a series, most important first, at different samples.

    First come those of the rules for a whole series, without ticks and splits. Labels of extremes
    and records contain "here". Then come the other turning points by prominence and the other
    changes by size, which are created only when requested.
    """
    turns = _Turns.of(series)
    extremes, ranked = _extremes(series, " here")
    ranked += _prominent(series, turns, extremes, duration_s, " here")
    ranked += [*_moves(series), *_crossings(series)[0]]
    by_time: dict[float, Event] = {}
    for event in ranked:
        by_time.setdefault(event.time_s, event)
    yield from by_time.values()
    yield from _lesser(series, turns, by_time.keys())


def _extremes(series: Series, here: str = "") -> tuple[set[int], list[Event]]:
    if not len(series.value):
        return set(), []
    high, low = int(np.argmax(series.value)), int(np.argmin(series.value))
    if series.value[high] == series.value[low]:
        return set(), []  # a constant series has no extremes
    weight = _LIGHTEST if here else 1.0  # extremes of a window are less important
    events = [
        series.event(kind, at, f"{kind}{here} {series.value_text(at)}{_ties(series, at)}", weight)
        for kind, at in (("highest", high), ("lowest", low))
    ]
    return {high, low}, events


def _ties(series: Series, index: int) -> str:
    count = int((series.value == series.value[index]).sum()) if series.every else 1
    return f" (first of {count})" if count > 1 else ""


@dataclass(frozen=True, eq=False)
class _Turns:
    """Turning points of a series, measured by ratios for prices.

    `found` has the indices and prominences of peaks (sign 1) and troughs (sign -1). `least` is the
    minimum prominence in a whole series, 0 if there is none.
    """

    level: FloatArray
    ratios: bool
    least: float
    found: dict[float, tuple[IntArray, FloatArray]]

    @classmethod
    def of(cls, series: Series) -> _Turns:
        level = series.value
        if len(level) < 3:
            return cls(level, False, 0.0, {})
        ratios = series.relative and float(level.min()) > 0.0
        if ratios:
            level = np.log(level)
        low, high = (float(edge) for edge in np.percentile(level, (1.0, 99.0)))
        least = LEAST_PROMINENCE * (high - low)
        if not math.isfinite(least):
            return cls(level, ratios, 0.0, {})
        found = {sign: peaks(sign * level) for sign in (1.0, -1.0)}
        return cls(level, ratios, max(least, 0.0), found)


def _prominent(
    series: Series, turns: _Turns, extremes: set[int], duration_s: float, here: str = ""
) -> list[Event]:
    """Return peaks and troughs, with records named as such."""
    events: list[Event] = []
    for sign, kind, record in ((1.0, "peak", "record_high"), (-1.0, "trough", "record_low")):
        if not turns.least:
            return []
        found, prominence = turns.found[sign]
        level = sign * turns.level
        order = np.argsort(-prominence, kind="stable")
        taken = [float(series.time_s[index]) for index in extremes]
        chosen: list[int] = []
        for k in order.tolist():
            at = float(series.time_s[found[k]])
            if len(chosen) == TURNS or prominence[k] < turns.least:
                break
            if all(abs(at - other) >= APART * duration_s for other in taken):
                taken.append(at)
                chosen.append(int(found[k]))
        for index in sorted(chosen):
            best_before = float(np.max(level[:index], initial=-np.inf))
            late = series.time_s[index] >= RECORDS_AFTER * duration_s
            is_record = late and level[index] > best_before
            name = record if is_record else kind
            words = name.replace("_", " ") + (here if is_record else "")
            events.append(series.event(name, index, f"{words} {series.value_text(index)}"))
    return events


def _lesser(series: Series, turns: _Turns, taken: Collection[float]) -> Iterator[Event]:
    """Yield the other turning points (weight by the root of their size), then other changes."""
    size = np.zeros(len(series.value))
    for found, prominence in turns.found.values():
        size[found] = prominence
    change = np.nan_to_num(np.abs(series.step))
    largest = [max(float(np.max(of, initial=0.0)), _TINY) for of in (size, change)]
    tops = set(turns.found[1.0][0].tolist()) if turns.found else set()
    order = np.lexsort((-change, -size))
    count = 0
    for k in order.tolist():
        at, height, moved = float(series.time_s[k]), float(size[k]), float(change[k])
        if count == _LESSER or not (height > 0.0 or moved > 0.0):
            break
        if at in taken:
            continue
        if height > 0.0:
            kind = "peak" if k in tops else "trough"
            words = f"{kind} {series.value_text(k)}"
            weight = max(_LIGHTEST, math.sqrt(height / largest[0]))
        else:
            kind = "largest_rise" if series.step[k] > 0.0 else "largest_fall"
            words = _step_text(series, k)
            weight = max(_FAINT, _LIGHTEST * moved / largest[1])
        count += 1
        yield series.event(kind, k, words, weight)


def _step_text(series: Series, i: int) -> str:
    step = float(series.step[i])
    if series.relative:
        return f"{step:+.2f} % to {series.value_text(i)}"
    words = value_text(step, series.unit)
    return f"{'' if words.startswith('-') else '+'}{words} to {series.value_text(i)}"


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
            weight = max(_LIGHTEST, _HEAVIEST * math.sqrt(float(size[i] / size[chosen[0]])))
            events.append(series.event(kind, i, _step_text(series, i), weight))
    return events


def _largest(size: FloatArray, count: int) -> IntArray:
    """Return the indices of the largest values, the first of equal ones first."""
    least = np.partition(size, -count)[-count] if len(size) > count else -np.inf
    some = np.flatnonzero(size >= least)
    return some[np.argsort(-size[some], kind="stable")[:count]]


def _crossings(series: Series) -> tuple[list[Event], str]:
    if not len(series.value):
        return [], ""
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
        value = series.value_text(crossing.index)
        words = f"{verb} {value_text(crossing.level, series.unit)} ({value})"
        events.append(series.event(f"crossing_{way}", crossing.index, words))
    shown = ", ".join(value_text(level) for level in levels)
    return events, (
        f"crossings of {shown}{' ' + series.unit if series.unit else ''} with a hysteresis of "
        f"{value_text(margin, series.unit)}"
    )


@dataclass(frozen=True, eq=False)
class WindowRules:
    """Rules for the events of a window (`timeline.window_events.Rules`).

    `series`: samples of the whole series, or only the lowest and highest of runs.
    `start_s`, `end_s`: window on the time axis of the whole series.
    `curve`: values at all samples, if `series` has only some; else None.
    `gaps`: gaps of the whole series.
    """

    series: Series
    start_s: float
    end_s: float
    curve: Intensity | None = None
    gaps: Gaps = ()

    def cut(self, start_s: float, end_s: float) -> WindowRules:
        """Return the rules for a window of this one."""
        return replace(self, start_s=self.start_s + start_s, end_s=self.start_s + end_s)

    def found(self, duration_s: float) -> Iterator[Event]:
        """Yield the events, most important first, at different samples."""
        series = self._all() or self.window_series()
        yield from find_window_events(_thinned(series), duration_s)

    def window_series(self) -> Series:
        """Return the samples of the window, on a time axis that begins with it."""
        series = self.series
        first, stop = np.searchsorted(series.time_s, (self.start_s, self.end_s))
        stop += int(stop < len(series.time_s) and series.time_s[stop] == self.end_s)
        return replace(
            series,
            time_s=series.time_s[first:stop] - self.start_s,
            value=series.value[first:stop],
            step=series.step[first:stop],
            calendar=self._calendar(),
            splits=(),
        )

    def _calendar(self) -> Calendar:
        calendar, start = self.series.calendar, self.series.calendar.start
        if start is None:
            return calendar
        return Calendar(start + timedelta(seconds=self.start_s), calendar.dates_only)

    def _all(self) -> Series | None:
        """Return all samples of the window from the curve, None without a curve or for too many."""
        if self.curve is None:
            return None
        part = self.curve.cut(self.start_s, self.end_s)
        if part is None or part.count > LONG:
            return None
        time_s = np.asarray(part.time_s)[1:-1]  # the ends are interpolated
        value = np.asarray(part.value, dtype=np.float64)[1:-1]
        series = replace(self.series, calendar=self._calendar())
        gaps, _ = cut_gaps(self.gaps, (), self.start_s, self.end_s)
        return _of(time_s, value, gaps, series, _NONE)


def rules_of(curve: Intensity, relative: bool, timeline: Timeline) -> WindowRules:
    """Return the rules for a series of which all samples are in a curve.

    `relative`: whether steps are per cent. Gaps, splits and calendar are of the timeline.
    """
    time_s = np.asarray(curve.time_s[:])
    calendar = Calendar(timeline.start, only_dates(timeline.start, time_s))
    like = Series(_NONE, _NONE, _NONE, relative, curve.unit, calendar)
    splits = np.array([event.time_s for event in timeline.events if event.kind == "split"])
    value = np.asarray(curve.value, dtype=np.float64)
    series = _of(time_s, value, timeline.gaps, like, splits)
    return WindowRules(series, 0.0, timeline.duration_s)


def only_dates(start: datetime | None, time_s: FloatArray) -> bool:
    """Return whether all samples are at midnight."""
    if start is None or (start.hour, start.minute, start.second) != (0, 0, 0):
        return False
    return not np.any(np.mod(np.round(time_s, 6), 86_400.0))


def _of(
    time_s: FloatArray, value: FloatArray, gaps: Gaps, like: Series, splits: FloatArray
) -> Series:
    """Return a series of samples, with no steps over gaps and share splits."""
    ends = np.concatenate(([end for _, end in gaps], splits))
    after = np.unique(np.searchsorted(time_s, ends))  # a gap may end between two samples
    over = after[(after > 0) & (after < len(time_s))] - 1
    step = curve_maps.steps(value, over, like.relative)
    return replace(like, time_s=time_s, value=value, step=step, every=True)


def _thinned(series: Series) -> Series:
    if len(series.value) <= MOST_SAMPLES:
        return series
    run = -(-2 * len(series.value) // MOST_SAMPLES)
    size = np.nan_to_num(np.abs(series.step))
    kept = np.zeros(len(size), np.bool_)
    kept[lows_and_highs(series.value, run)] = True
    kept[np.argpartition(size, len(size) - 32)[-32:]] = True
    columns = {name: getattr(series, name)[kept] for name in ("time_s", "value", "step")}
    return replace(series, **columns, every=False)
