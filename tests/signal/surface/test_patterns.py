"""What the base surface is made of, apart from data."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.parameters import PATTERNS
from overview_dsp.kernels.layout import CELLS
from overview_dsp.measure.report import character_distance, feel_report
from overview_dsp.signal.surface.patterns import pattern
from tests.examples import plain_preset, timeline_of

PERIOD_PERCENT = 2.0
RIDGES = 50


def preset_with(name, height=4.0):
    return plain_preset(
        surface__pattern=name,
        surface__pattern_height=height,
        surface__pattern_period_percent=PERIOD_PERCENT,
    )


@given(st.sampled_from(PATTERNS), st.floats(0.05, 50.0))
def test_every_pattern_is_between_0_and_1(name, period):
    course = pattern(name, CELLS, period)
    assert course.shape == (CELLS + 1,)
    assert course.min() >= 0.0
    assert course.max() <= 1.0


@pytest.mark.parametrize("name", ["waves", "ridges", "teeth"])
def test_a_regular_pattern_has_a_ridge_a_period(name):
    from scipy.signal import find_peaks

    peaks, _ = find_peaks(pattern(name, CELLS, PERIOD_PERCENT), prominence=0.5)
    assert len(peaks) == RIDGES
    assert np.diff(peaks) == pytest.approx(CELLS / RIDGES, abs=1.0)


def test_teeth_rise_slowly_and_fall_at_once():
    course = pattern("teeth", CELLS, PERIOD_PERCENT)
    assert np.count_nonzero(np.diff(course) > 0.0) == pytest.approx(0.9 * CELLS, rel=0.02)


def test_grains_are_the_same_every_time_and_of_different_heights():
    course = pattern("grains", CELLS, PERIOD_PERCENT)
    assert np.array_equal(course, pattern("grains", CELLS, PERIOD_PERCENT))
    tops = course[:: round(CELLS * PERIOD_PERCENT / 100.0)]
    assert tops.std() > 0.15


def test_none_is_the_surface_as_it_was():
    timeline = timeline_of(50.0)
    bare = ov.build_surface(timeline, preset_with("none", height=100.0))
    assert np.array_equal(bare.friction, ov.build_surface(timeline, plain_preset()).friction)


def test_ridges_are_felt_as_so_many_pulses():
    timeline = timeline_of()
    flat, ridged = (feel_report(preset_with(name), timeline) for name in ("none", "ridges"))
    for name, seconds in (("slow", 6.0), ("medium", 3.0)):
        pulses = ridged.stroke(name).density_hz * seconds
        # the disk catches up with its first ridges and with its last ones at once
        assert RIDGES * 0.8 < pulses < RIDGES * 1.2
        assert flat.stroke(name).density_hz * seconds < 3.0
    assert character_distance(flat, ridged) > 2.0
    assert character_distance(ridged, ridged) == 0.0


def test_twice_the_friction_is_steps_of_level():
    timeline = timeline_of()
    one, two = (
        feel_report(plain_preset(surface__friction=friction), timeline) for friction in (1e-3, 3e-3)
    )
    assert one.stroke("slow").level_db < two.stroke("slow").level_db
    assert character_distance(one, two) > 1.0


@pytest.mark.parametrize(
    ("name", "course"),
    [
        ("waves", {0.0: 0.0, 0.25: 0.5, 0.5: 1.0, 1.0 / 3.0: 0.75, 0.75: 0.5}),
        ("ridges", {0.5: 1.0, 0.4: 0.5, 0.6: 0.5, 0.3: 0.0625, 0.0: 2.0**-25}),
        ("beats", {0.25: 1.0, 0.2: 0.5, 0.3: 0.5, 0.55: 0.6, 0.6: 0.3, 0.9: 0.6 * 2.0**-49}),
        ("teeth", {0.0: 0.0, 0.45: 0.5, 0.9: 1.0, 0.95: 0.5}),
    ],
)
def test_a_period_of_a_pattern_has_its_stated_course(name, course):
    # tables of 120 points a period, which hold these parts of it
    found = pattern(name, 600, 20.0)
    for part, value in course.items():
        at = round(part * 120) + 120 * np.arange(5)
        assert found[at] == pytest.approx(np.full(5, value), abs=1e-12), part


def test_grains_are_heights_by_chance_joined_by_half_cosines():
    heights = np.random.default_rng(1).random(7)
    found = pattern("grains", 600, 20.0)
    assert found[::120] == pytest.approx(heights[:6])
    way = 0.5 - 0.5 * np.cos(np.pi * np.arange(120) / 120)
    for n in range(5):
        expected = heights[n] + (heights[n + 1] - heights[n]) * way
        assert found[120 * n : 120 * (n + 1)] == pytest.approx(expected)
    # however long the period is
    assert pattern("grains", 600, 250.0)[[0, 600]] == pytest.approx(
        [heights[0], heights[0] + (heights[1] - heights[0]) * (0.5 - 0.5 * np.cos(0.4 * np.pi))]
    )
