"""What a page says and shows of a series: the data's own values, dates and extremes."""

from __future__ import annotations

import os
import tracemalloc
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.data.timeline.curve_builder import CurveBuilder
from overview_dsp.data.timeline.curve_points import RegularTimes
from overview_dsp.data.timeline.gaps import in_gap
from overview_dsp.signal.surface.angle_map import AngleMap
from overview_dsp.web import site_data as values
from tests.web.driving import until
from tests.web.exported import opened_page

NEAR = """(() => {
    const { left, right } = window.overview.picture.geometry;
    return 3 / (right - left);
})()"""  # 3 px as a part of the window: as near is at an event

SAID_AT = """(position) => {
    const p = window.overview;
    p.navigation.to(position);
    p.slider.updatedAt = -Infinity;
    p.draw();
    return document.getElementById("slider").getAttribute("aria-valuetext");
}"""


def shared(name, **given):
    folder = os.environ.get("OVERVIEW_TEST_DATA")
    if not folder:
        pytest.skip("needs other people's series: OVERVIEW_TEST_DATA")
    return ov.load_timeline(Path(folder) / name, **given)


@pytest.mark.parametrize(
    ("name", "given", "preset", "decimals"),
    [
        ("stocks/bokeh_AAPL.csv", {}, "stocks", 2),
        ("weather/seattle-weather-hourly-normals.csv", {"value": "temperature"}, "weather", 1),
    ],
)
def test_the_value_text_is_the_datas_own_at_every_position(
    chromium, tmp_path, name, given, preset, decimals
):
    timeline = shared(name, **given)
    times = np.asarray(timeline.intensity.time_s)
    with opened_page(chromium, timeline, preset, tmp_path / "site") as page:
        near = page.evaluate(NEAR) * timeline.duration_s
        for position in np.random.default_rng(1).random(60):
            moment = position * timeline.duration_s
            event = min(timeline.events, key=lambda one: abs(one.time_s - moment))
            if abs(event.time_s - moment) <= near:
                moment = event.time_s  # its own value is told
            nearest = int(np.abs(times - moment).argmin())
            said = page.evaluate(SAID_AT, position).split(", ")
            day = timeline.start + timedelta(seconds=float(times[nearest]))
            assert said[1] == f"{day.day} {day:%B %Y}"
            if "hourly" in name:
                assert said[2] == f"{day:%H:%M}"
            value = float(timeline.intensity.value[nearest])
            assert said[0].replace("\u2212", "-") == f"{value:.{decimals}f}"


def test_highest_lowest_first_and_last_by_key_and_by_button(chromium, tmp_path):
    timeline = shared("stocks/bokeh_AAPL.csv")
    curve = timeline.intensity
    timeline = replace(timeline, intensity=ov.Intensity(curve.time_s, curve.value, "dollars"))
    value = np.asarray(curve.value)
    with opened_page(chromium, timeline, "stocks", tmp_path / "site") as page:

        def says():
            page.wait_for_timeout(150)
            return page.get_attribute("#slider", "aria-valuetext")

        until(page, "document.getElementById('summary').textContent.includes('90.61 dollars')")
        page.focus("#slider")
        for key, expected in (("x", value.max()), ("n", value.min()), ("End", value[-1]),
                              ("Home", value[0])):  # fmt: skip
            page.keyboard.press(key)
            until(
                page,
                f"document.getElementById('slider').ariaValueText.startsWith('{expected:.2f}')",
            )
        page.keyboard.press("x")
        until(page, "document.getElementById('slider').ariaValueText.includes('September 2012')")
        assert says() == "90.61 dollars, 19 September 2012, highest"
        for name, expected in (("Lowest", value.min()), ("Last", value[-1]), ("First", value[0]),
                               ("Highest", value.max())):  # fmt: skip
            page.click("#list")
            page.click(f"#events button:text-is('{name}')")
            until(
                page,
                f"document.getElementById('slider').ariaValueText.startsWith('{expected:.2f}')",
            )
        until(page, "document.getElementById('value').textContent === '90.61 dollars'")
        page.keyboard.press("h")
        assert page.is_visible("#help")
        assert "highest, lowest" in page.text_content("#keys")


def test_the_highest_of_a_part_is_that_parts(chromium, tmp_path):
    page_values = (
        "async ([view, way]) => (await import('./modules/values.js')).extremeOf(view, way)"
    )
    with opened_page(
        chromium, ov.load_timeline("world-cup-final-2018"), "football", tmp_path / "s"
    ) as p:
        points = {"time_s": [0, 10, 20, 30, 40], "value": [9, 2, 5, 1, -3]}
        view = {"start_s": 10, "end_s": 30, "points": points, "level": [0, 1]}
        assert p.evaluate(page_values, [view, 1]) == 0.5
        assert p.evaluate(page_values, [view, -1]) == 1.0
        assert p.evaluate(page_values, [{**view, "start_s": 12}, -1]) == 1.0
        # without values the curve will do
        assert p.evaluate(page_values, [{"level": [0, 0.2, 0.9, 0.1, 0]}, 1]) == 0.5


def test_a_long_series_has_points_of_its_own_at_even_moments_and_events():
    n = 5 * values.MAX_POINTS
    signal = np.sin(np.arange(n) / 500.0) + np.arange(n) * 1e-6
    events = (ov.Event(777.0, "note"), ov.Event(54_321.0, "note"))
    timeline = ov.Timeline("long", float(n), events, ov.Intensity(np.arange(n) * 1.0, signal))
    told = values.points_json(timeline, 0.0, float(n))
    assert values.MAX_POINTS // 2 <= len(told["value"]) <= values.MAX_POINTS + 2
    assert {float(signal.min()), float(signal.max())} <= set(told["value"])
    assert {777, 54_321} <= set(told["time_s"])
    assert np.array_equal(signal[np.array(told["time_s"])], told["value"])
    part = values.points_json(timeline, 1000.0, 1100.0)
    assert part["time_s"] == list(range(1000, 1101))
    assert values.series_json(timeline)["complete"] is False


def test_a_series_larger_than_the_memory_is_read_in_parts():
    n = 4_000_000
    curve = ov.Intensity(RegularTimes(n, 1.0), np.sin(np.arange(n) / 1e4))
    timeline = ov.Timeline("long", float(n), (ov.Event(7.0, "note"),), curve, gaps=((50.0, 90.0),))
    curve.points  # noqa: B018 - made once for all windows
    tracemalloc.start()
    points = values.points_json(timeline, 0.0, float(n))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(points["value"]) > values.MAX_POINTS // 2
    assert peak < n  # bytes: an array of all points has 8 n


def test_decimals_are_the_datas_but_no_more_than_can_be_heard():
    def decimals(*given):
        curve = ov.Intensity(np.arange(float(len(given))), np.array(given))
        return values.series_json(ov.Timeline("t", 10.0, intensity=curve))["decimals"]

    assert decimals(12.8, 10.6, 35.6) == 1
    assert decimals(3.0, 900.0, 1200.0) == 0
    assert decimals(4.1866628, 702.1, 80.12345) == 2
    assert decimals(0.0001234, 0.0004567) > 5
    match = ov.load_timeline("world-cup-final-2018")
    assert values.series_json(match) is None  # excitement that was made up is nobody's data


def with_gaps(seed, count):
    """Return a series with missing values and spikes of one point, some alone between two gaps."""
    random = np.random.default_rng(seed)
    value = np.cumsum(random.standard_normal(count))
    value[random.integers(0, count, 8)] += random.choice([-1.0, 1.0], 8) * 50.0
    for start in random.integers(1, count - 40, 6):
        value[start : start + int(random.integers(1, 30))] = np.nan
    alone = int(random.integers(50, count - 50))
    value[alone - 3 : alone + 4] = np.nan
    value[alone] = 99.0
    value[[0, -1]] = 0.0
    times = np.arange(count) * 86_400.0
    builder = CurveBuilder()
    builder.append(value, times)
    curve = builder.finish()
    known = np.isfinite(value)
    return (
        ov.Timeline("gaps", times[-1], intensity=curve, gaps=builder.gaps(times[-1])),
        times[known],
        value[known],
    )


@pytest.mark.parametrize("count", [300, 10_000, 5 * values.MAX_POINTS])
@pytest.mark.parametrize("seed", range(4))
def test_a_gap_removes_only_what_is_missing_and_no_extreme_is_lost(seed, count):
    timeline, times, value = with_gaps(seed, count)
    random = np.random.default_rng(seed)
    windows = np.sort(random.random((20, 2)) * timeline.duration_s)
    for start_s, end_s in [(0.0, timeline.duration_s), *windows.tolist()]:
        inside = (times >= start_s) & (times <= end_s)
        if not inside.any():
            continue
        points = values.points_json(timeline, start_s, end_s)
        assert min(points["value"]) == value[inside].min()
        assert max(points["value"]) == value[inside].max()
        if inside.sum() <= values.MAX_POINTS:
            assert points["time_s"] == times[inside].tolist()


@pytest.mark.parametrize("count", [300, 10_000, 5 * values.MAX_POINTS])
def test_the_picture_spans_all_values_and_is_interrupted_only_in_gaps(count):
    timeline, times, value = with_gaps(3, count)
    angle_map = AngleMap.of(timeline, ov.load_preset("stocks"))
    drawn = values.drawn_curve(timeline, angle_map, 1025)
    low, span = drawn["scale"]
    assert (low, low + span) == (value.min(), pytest.approx(value.max()))
    lows, highs = drawn["band"] or [drawn["level"]] * 2
    known = np.array([one is not None for one in lows])
    columns = np.rint(times / timeline.duration_s * 1024).astype(int)
    assert known[columns].all()  # no column with a point is empty
    in_a_gap = in_gap(timeline.gaps, np.arange(1025) * timeline.duration_s / 1024)
    assert (~known <= in_a_gap).all()
    assert min(one for one in lows if one is not None) == 0.0
    assert max(one for one in highs if one is not None) == 1.0
    for edge in (value.argmin(), value.argmax()):
        near = range(max(columns[edge] - 1, 0), min(columns[edge] + 2, 1025))
        rows = highs if edge == value.argmax() else lows
        assert any(rows[i] in (0.0, 1.0) for i in near)


@pytest.mark.parametrize(
    ("interval_s", "says", "ticks"),
    [(3600.0, r"9 Mar 2024, 1[345]:\\d\\d", "11 Mar"), (86_400.0, "9 Mar 2024", "11 Mar")],
    ids=["hourly", "daily"],
)
def test_the_hour_is_told_where_a_date_alone_doesnt_say_which(
    chromium, tmp_path, interval_s, says, ticks
):
    times = np.arange(int(20 * 86_400 / interval_s)) * interval_s
    curve = ov.Intensity(times, np.sin(times / 1e5))
    timeline = ov.Timeline("t", times[-1], intensity=curve, start=datetime(2024, 3, 1))
    with opened_page(chromium, timeline, "stocks", tmp_path / "site") as page:
        labels = page.locator("#canvas text").all_text_contents()
        assert any(ticks in label for label in labels)
        assert all(":" not in label for label in labels)  # a day apart, or more
        # nothing was touched yet, and a page that began before the first evaluation is still
        page.evaluate("overview.sound.start()")
        page.evaluate(
            "(position) => overview.navigation.to(position)", (8 * 86_400 + 14 * 3600) / times[-1]
        )
        told = "document.getElementById('clock').textContent"
        until(page, f"RegExp('^{says}$').test({told})")  # where the disk has come to
        spoken = page.get_attribute("#slider", "aria-valuetext").split(", ")
        assert spoken[1:] == (
            ["9 March 2024", "14:00"] if interval_s < 86_400 else ["10 March 2024"]
        )
