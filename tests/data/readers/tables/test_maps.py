"""What becomes friction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from overview_dsp.data.timeline import Timeline
from tests.data.readers.tables.made import load, noted, refusal, values
from tests.data.readers.tables.test_events import daily

LEVEL = [10.0, 12.0, 9.0, 9.0, 18.0, 15.0]


def table(level: list[float]) -> str:
    rows = daily(level).splitlines()
    extra = ["load", *(str(100 * i) for i in range(len(level)))]
    return "\n".join(f"{row},{cell}" for row, cell in zip(rows, extra, strict=True))


def test_the_level_is_the_default_and_keeps_its_unit(tmp_path: Path) -> None:
    timeline = load(tmp_path, daily(LEVEL, "level (m)"))
    assert values(timeline) == LEVEL
    assert timeline.intensity is not None
    assert timeline.intensity.unit == "m"
    assert noted(timeline, "friction follows the level of 'level (m)'")


@pytest.mark.parametrize(
    ("wish", "expected"),
    [
        ("level", LEVEL),
        ("change", [2.0, 2.0, -3.0, 0.0, 9.0, -3.0]),
        ("activity", [2.0, 2.0, 3.0, 0.0, 9.0, 3.0]),
        ("change:percent", [20.0, 20.0, -25.0, 0.0, 100.0, -100.0 / 6.0]),
        ("load", [0.0, 100.0, 200.0, 300.0, 400.0, 500.0]),
        ("LOAD", [0.0, 100.0, 200.0, 300.0, 400.0, 500.0]),
    ],
)
def test_each_map_gives_its_curve_and_events_stay_those_of_the_value(
    tmp_path: Path, wish: str, expected: list[float]
) -> None:
    timeline = load(tmp_path, table(LEVEL), value="level", map=wish)
    assert values(timeline) == pytest.approx(expected)
    # events stay those of the value
    assert [e.label for e in timeline.events if e.kind == "highest"] == ["highest 18, 2019-01-05"]


def test_a_price_changes_in_per_cent_unless_asked_otherwise(tmp_path: Path) -> None:
    text = daily(LEVEL, "price")
    assert values(load(tmp_path, text, map="change"))[4] == pytest.approx(100.0)
    timeline = load(tmp_path, text, map="change:difference")
    assert values(timeline)[4] == 9.0


def test_a_split_does_not_count_as_a_change(tmp_path: Path) -> None:
    level = 100.0 + np.sin(np.arange(100.0))
    level[60] = level[59]
    split = level.copy()
    split[60:] /= 2.0
    timeline = load(tmp_path, daily(split, "price"), value="price:share", map="activity")
    whole = load(tmp_path, daily(level, "price"), value="price:price", map="activity")
    assert "split" in timeline.kinds()
    assert values(timeline) == pytest.approx(values(whole))


def test_volatility_is_the_deviation_of_the_last_changes(tmp_path: Path) -> None:
    level = np.cumsum(np.random.default_rng(3).normal(0.0, 1.0, 60))
    timeline = load(tmp_path, daily(level), map="volatility:10")
    change = np.diff(level)
    found = values(timeline)
    assert len(found) == 60
    for i in (10, 25, 59):
        assert found[i] == pytest.approx(np.std(change[i - 10 : i]))
    by_time = load(tmp_path, daily(level), map="volatility:10d")
    assert values(by_time)[30] == pytest.approx(found[30])
    assert noted(by_time, "volatility of 'level'")


def test_a_change_is_not_taken_over_a_gap(tmp_path: Path) -> None:
    text = daily([1, 2, 3, 50, 51, 52]).replace("2019-01-03,3.0", "2019-01-03,NA")
    timeline = load(tmp_path, text, map="change")
    assert values(timeline) == [1.0, 1.0, 1.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("wish", "words"),
    [
        ("loudness", "map is 'loudness'; must be level, change, activity, volatility, count or"),
        ("change:often", "give change:percent or change:difference"),
        ("volatility:1", "give a window as samples"),
        ("volatility:soon", "give a window as samples"),
        ("volatility:0d", "give a window as samples"),
        ("level:2", "map level takes no argument"),
    ],
)
def test_an_unknown_map_gives_a_one_line_error(tmp_path: Path, wish: str, words: str) -> None:
    assert words in refusal(lambda: load(tmp_path, daily(LEVEL), map=wish))


def at(timeline: Timeline, day: int) -> float:
    return float(timeline.normalised_intensity_at(day * 86_400.0))


def test_one_wild_value_moves_the_scale_little_and_is_clipped_there_alone(tmp_path: Path) -> None:
    level = np.linspace(10.0, 20.0, 500)
    level[250] = 1e6
    timeline = load(tmp_path, daily(level))
    assert timeline.intensity_at(250 * 86_400.0) == 1e6
    assert at(timeline, 250) == 1.0
    assert at(timeline, 0) == 0.0
    assert at(timeline, 125) == pytest.approx(0.25, abs=0.02)
    assert noted(timeline, "(percentiles 1 and 99); only the friction is clipped there")
