"""Events by rule: each kind where it must be, with its label, and nowhere else."""

from __future__ import annotations

import itertools
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy import signal

from overview_dsp.data.analysis.extrema import (
    MOST_CROSSINGS,
    crossings,
    peaks,
    round_levels,
)
from overview_dsp.data.analysis.series_events import KINDS
from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.ticks import MOST_TICKS, ticks
from overview_dsp.design.presets.library import load_preset
from tests.data.readers.tables.made import load, noted

DAY = 86_400.0


def daily(values: list[float] | np.ndarray, header: str = "level") -> str:
    begin = datetime(2019, 1, 1)
    rows = (f"{begin + timedelta(days=i):%Y-%m-%d},{v!r}" for i, v in enumerate(map(float, values)))
    return f"date,{header}\n" + "\n".join(rows)


def found(timeline: Timeline, kind: str) -> list[tuple[float, str]]:
    return [(event.time_s / DAY, event.label) for event in timeline.events if event.kind == kind]


def test_the_extremes_are_at_their_days_with_value_and_date(tmp_path: Path) -> None:
    timeline = load(tmp_path, daily([3, 5, 2, 9.5, 4, 9.5, 6]))
    assert found(timeline, "highest") == [(3.0, "highest 9.5 (first of 2), 2019-01-04")]
    assert found(timeline, "lowest") == [(2.0, "lowest 2, 2019-01-03")]


def test_a_constant_series_has_no_extremes_turns_moves_or_crossings(tmp_path: Path) -> None:
    timeline = load(tmp_path, daily([4.0] * 10))
    assert set(timeline.kinds()) <= {"day", "week", "month", "year"}
    assert timeline.intensity_at(5 * DAY) == 4.0


def test_a_record_is_a_peak_above_all_before_it(tmp_path: Path) -> None:
    wave = [0, 4, 0, 6, 0, 5, 0, 8, 0, 3, 0, 9, 0, 7, 0]
    timeline = load(tmp_path, daily([*([0.5] * 3), *wave]))
    assert [day for day, _ in found(timeline, "record_high")] == [4.0, 6.0, 10.0]
    assert [day for day, _ in found(timeline, "highest")] == [14.0]
    assert [day for day, _ in found(timeline, "peak")] == [8.0, 12.0, 16.0]
    assert found(timeline, "record_high")[0][1] == "record high 4, 2019-01-05"


def test_a_peak_at_the_very_beginning_is_no_record(tmp_path: Path) -> None:
    level = np.zeros(200)
    level[[5, 90, 150]] = 4.0, 6.0, 9.0
    timeline = load(tmp_path, daily(level))
    assert [day for day, _ in found(timeline, "peak")] == [5.0]
    assert [day for day, _ in found(timeline, "record_high")] == [90.0]


def test_turning_points_are_the_most_prominent_and_apart(tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    level = np.cumsum(random.normal(0.0, 1.0, 2000))
    timeline = load(tmp_path, daily(level))
    turns = [e for e in timeline.events if e.kind in ("peak", "record_high")]
    indices, prominence = peaks(level)
    prominent = dict(zip(indices.tolist(), prominence.tolist(), strict=True))
    low, high = np.percentile(level, (1, 99))
    chosen = [round(e.time_s / DAY) for e in turns]
    assert 1 <= len(chosen) <= 8
    assert all(prominent[i] >= 0.1 * (high - low) for i in chosen)
    assert min(np.diff(sorted(chosen)), default=99) >= 0.01 * 1999
    omitted = [p for i, p in prominent.items() if min(abs(i - j) for j in chosen) > 40]
    if len(chosen) == 8:
        assert max(omitted) <= max(prominent[i] for i in chosen)


@given(hnp.arrays(np.float64, st.integers(1, 60), elements=st.integers(-5, 5).map(float)))
def test_prominences_are_scipys(value: np.ndarray) -> None:
    indices, prominence = peaks(value)
    theirs, about = signal.find_peaks(value, plateau_size=1)
    assert indices.tolist() == about["left_edges"].tolist()
    assert prominence.tolist() == signal.peak_prominences(value, theirs)[0].tolist()


def test_the_largest_steps_are_moves_weighted_by_their_size(tmp_path: Path) -> None:
    level = 10.0 + np.sin(np.arange(400) / 3.0) / 50.0
    level[100:] += 5.0
    level[200:] -= 3.0
    level[300:] += 1.0
    timeline = load(tmp_path, daily(level))
    rises, falls = found(timeline, "largest_rise"), found(timeline, "largest_fall")
    assert {100.0, 300.0} <= {day for day, _ in rises}
    assert 200.0 in {day for day, _ in falls}
    assert len(rises) <= 5
    weights = {e.time_s / DAY: e.weight for e in timeline.events if e.kind == "largest_rise"}
    assert weights[100.0] == 1.5
    assert weights[300.0] == pytest.approx(1.5 / np.sqrt(5.0), rel=0.02)
    assert min(weights.values()) == 0.5


def test_a_step_over_a_gap_is_no_move(tmp_path: Path) -> None:
    rows = daily([*np.linspace(1, 2, 40), *np.linspace(90, 91, 40)]).splitlines()
    timeline = load(tmp_path, "\n".join(rows[:38] + rows[45:]))
    assert timeline.gaps
    sizes = [label for _, label in found(timeline, "largest_rise")]
    assert sizes
    assert all(float(label.partition(" ")[0]) < 5.0 for label in sizes)


def test_a_price_moves_in_per_cent(tmp_path: Path) -> None:
    level = [100.0] * 30 + [50.0] * 30 + [60.0] * 30
    timeline = load(tmp_path, daily(level, "price"))
    assert found(timeline, "largest_rise") == [(60.0, "+20.00 % to 60, 2019-03-02")]


def test_a_price_below_0_has_no_step_in_per_cent_from_there(tmp_path: Path) -> None:
    level = [20.0, 21.0] * 40 + [-37.0, 10.0] + [13.0, 14.0] * 20
    timeline = load(tmp_path, daily(level, "price"))
    falls = [day for day, _ in found(timeline, "largest_fall")]
    assert 80.0 in falls
    assert 81.0 not in falls
    assert [day for day, _ in found(timeline, "lowest")] == [80.0]


def test_levels_are_crossed_with_hysteresis(tmp_path: Path) -> None:
    level = [0, 4, 8, 12, 9.9, 10.1, 9.9, 12, 16, 20, 12, 8, 4, 0]
    timeline = load(tmp_path, daily(level))
    up = [label for _, label in found(timeline, "crossing_up")]
    down = [label for _, label in found(timeline, "crossing_down")]
    assert [label for label in up if "above 10" in label] == ["rises above 10 (12), 2019-01-04"]
    assert [label for label in down if "below 10" in label] == ["falls below 10 (8), 2019-01-12"]
    assert noted(timeline, "with a hysteresis of")


@given(hnp.arrays(np.float64, st.integers(2, 80), elements=st.integers(-50, 50).map(float)))
def test_crossings_alternate_and_are_where_the_level_is_passed(value: np.ndarray) -> None:
    low, high = np.percentile(value, (10, 90))
    events, levels, _ = crossings(value, float(low), float(high))
    assert len(events) <= MOST_CROSSINGS
    for level in levels:
        way = [c for c in events if c.level == level]
        assert all(a.up != b.up for a, b in itertools.pairwise(way))
        for c in way:
            before, here = value[c.index - 1], value[c.index]
            assert (before < level <= here) if c.up else (before > level >= here)


@given(st.floats(-1e9, 1e9), st.floats(1e-6, 1e9))
def test_round_levels_lie_between(low: float, span: float) -> None:
    levels = round_levels(low, low + span)
    assert len(levels) <= 3
    assert all(low < level < low + span for level in levels)


@pytest.mark.parametrize(
    ("start", "days", "kind", "count", "first"),
    [
        (datetime(2019, 6, 15), 3650.0, "year", 10, "2020"),
        (datetime(2019, 6, 15), 365.0, "month", 11, "July 2019"),
        (datetime(2019, 6, 15), 60.0, "week", 9, "week of 2019-06-17"),
        (datetime(2019, 6, 15), 10.0, "day", 7, "2019-06-16"),
        (datetime(2019, 6, 15, 9), 0.5, "hour", 11, "10:00"),
        (datetime(2019, 6, 15, 9), 1 / 24, "minute", 0, ""),
        (datetime(1850, 6, 15), 36525.0, "decade", 9, "1860s"),
        (None, 0.5, "hour", 11, "hour 1"),
        (None, 3.0, "day", 2, "day 1"),
    ],
)
def test_ticks_fit_the_span(
    start: datetime | None, days: float, kind: str, count: int, first: str
) -> None:
    events = ticks(start, days * DAY)
    assert len(events) <= MOST_TICKS
    of_kind = [event for event in events if event.kind == kind]
    assert len(of_kind) == count
    if first:
        assert of_kind[0].label == first
    if start is not None and first == "2020":
        assert of_kind[0].time_s == (datetime(2020, 1, 1) - start).total_seconds()


@given(st.datetimes(datetime(1, 1, 1), datetime(9999, 12, 31)), st.floats(1e-3, 1e11))
def test_ticks_lie_inside_any_span(start: datetime, duration_s: float) -> None:
    events = ticks(start, duration_s)
    assert len(events) <= MOST_TICKS
    assert all(0.0 < event.time_s < duration_s for event in events)


def test_the_series_preset_knows_every_kind() -> None:
    preset = load_preset("series")
    assert [kind for kind in KINDS if preset.kind_for(kind) is None] == []
    assert set(preset.kinds) - {"default"} <= set(KINDS)
