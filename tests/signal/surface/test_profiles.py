from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.design.presets.parameters import SHAPES
from overview_dsp.signal.surface.profiles import AT_A_TIME, REACH, SPAN_LEVEL, bumps, profile, span

FINE = np.linspace(-4.0, 4.0, 80_001)  # steps of 1e-4 widths
STEP = FINE[1] - FINE[0]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("width", [1.0, 37.5])
def test_a_profile_is_one_at_its_event_and_between_zero_and_one_elsewhere(shape, width):
    values = profile(shape, FINE * width, width)
    assert profile(shape, np.zeros(1), width)[0] == 1.0
    assert values.min() >= 0.0
    assert values.max() <= 1.0


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("width", [1.0, 37.5])
def test_the_width_is_the_full_width_at_half_height(shape, width):
    above = profile(shape, FINE * width, width) >= 0.5
    # one piece, one width long
    assert np.count_nonzero(np.diff(above.astype(int))) == 2
    assert np.count_nonzero(above) * STEP == pytest.approx(1.0, abs=3 * STEP)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("width", [1.0, 37.5])
def test_the_span_is_where_the_profile_exceeds_a_tenth_of_its_height(shape, width):
    above = FINE[profile(shape, FINE * width, width) > SPAN_LEVEL] * width
    first, last = span(shape, width)
    assert first == pytest.approx(above[0], abs=2 * STEP * width)
    assert last == pytest.approx(above[-1], abs=2 * STEP * width)


@pytest.mark.parametrize("shape", SHAPES)
def test_no_profile_reaches_further_than_it_says(shape):
    assert profile(shape, FINE[np.abs(FINE) >= REACH[shape]], 1.0).max() < 2e-5


@pytest.mark.parametrize("shape", ["gaussian", "raised_cosine", "plateau"])
def test_the_even_shapes_feel_alike_from_both_sides(shape):
    assert np.allclose(profile(shape, FINE, 1.0), profile(shape, -FINE, 1.0), atol=1e-12)


def test_the_ramps_are_each_others_mirror_image():
    assert np.array_equal(profile("ramp_up", FINE, 1.0), profile("ramp_down", -FINE, 1.0))


def test_a_ramp_up_rises_slowly_before_its_event_and_falls_off_fast_after_it():
    values = profile("ramp_up", FINE, 1.0)
    rising, falling = FINE < 0.0, FINE > 0.0
    assert (np.diff(values[rising]) >= 0.0).all()
    assert (np.diff(values[falling]) <= 0.0).all()
    assert values[rising].sum() > 10.0 * values[falling].sum()


def test_a_plateau_is_flat_over_most_of_its_width_and_gone_soon_after():
    assert (profile("plateau", FINE[np.abs(FINE) <= 0.3], 1.0) > 0.99).all()
    assert (profile("plateau", FINE[np.abs(FINE) >= 0.65], 1.0) < 0.01).all()


def test_a_gaussian_and_a_raised_cosine_have_their_textbook_values():
    assert profile("gaussian", np.array([1.0]), 1.0)[0] == pytest.approx(0.5**4)
    assert profile("raised_cosine", np.array([0.25]), 1.0)[0] == pytest.approx(0.5 + 0.5**1.5)


def test_a_raised_cosine_is_one_hump_between_one_width_before_and_after_its_event():
    distance = np.array([-3.0, -2.0, -1.25, -1.0, -0.5, 0.0, 0.5, 1.0, 1.25, 2.0, 3.0])
    expected = [0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0]
    assert profile("raised_cosine", distance, 1.0) == pytest.approx(expected, abs=1e-15)


@given(
    st.sampled_from(SHAPES),
    st.floats(-1e9, 1e9),
    st.floats(1e-3, 1e9),
)
def test_a_profile_is_a_finite_part_of_its_height_at_any_distance(shape, distance, width):
    value = profile(shape, np.array([distance]), width)[0]
    assert 0.0 <= value <= 1.0


COURSE = (0.2, 1.0, 0.5, 0.3)  # drawn by hand; it ends in steps


@pytest.mark.parametrize("points", [(), COURSE])
@pytest.mark.parametrize("shape", [*SHAPES, "stop"])
@pytest.mark.parametrize("width", [3.0, 40.5, 300.0])
def test_a_table_holds_every_point_of_every_profile(shape, points, width):
    cells = 200
    centre = np.array([0.0, 0.25, 57.3, 100.0, 199.5, 200.0])
    height = np.arange(1.0, 7.0)
    found = list(bumps(shape, points, width, centre, height, cells))
    assert [number for number, _, _ in found] == list(range(6))
    for number, start, bump in found:
        table = np.zeros(cells + 1)
        table[start : start + len(bump)] = bump
        distance = np.arange(cells + 1) - centre[number]
        expected = height[number] * profile(shape, distance, width, points)
        # a gaussian's far foot is left out
        assert np.allclose(table, expected, rtol=0.0, atol=2e-5 * height[number])
        assert len(bump) <= 2.0 * (1.0 if points else REACH[shape]) * width + 3.0


def test_more_profiles_than_are_worked_out_at_once_are_all_laid():
    count = 3 * AT_A_TIME // 100
    centre = np.linspace(0.0, 1e6, count)
    found = list(bumps("gaussian", (), 25.0, centre, np.arange(count) + 1.0, 1_000_000))
    assert [number for number, _, _ in found] == list(range(count))
    tops = np.array([bump.max() for _, _, bump in found])
    assert tops == pytest.approx(np.arange(count) + 1.0, rel=2e-3)


def test_a_course_drawn_by_hand_goes_through_its_points_and_is_zero_beyond():
    at = np.array([-1.01, -1.0, -1.0 / 3.0, 0.0, 1.0 / 3.0, 1.0, 1.01])
    expected = [0.0, 0.2, 1.0, 0.75, 0.5, 0.3, 0.0]
    assert profile("gaussian", at * 7.0, 7.0, COURSE) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    "points", [COURSE, (0.0, 0.04, 0.4, 0.04, 0.0), (0.1, 1.0, 0.1), (1.0, 0.0)]
)
def test_the_span_of_a_course_is_where_it_exceeds_a_tenth_of_its_top(points):
    above = FINE[profile("gaussian", FINE, 1.0, points) > SPAN_LEVEL * max(points)]
    first, last = span("gaussian", 20.0, points)
    # a course is looked at in sixteenths of its steps
    assert span("gaussian", 20.0, (0.0, 1.0)) == (-15.0, 20.0)
    step = 2.0 / (len(points) - 1) / 16 * 20.0
    assert above[0] * 20.0 - 1e-9 <= first <= above[0] * 20.0 + step
    assert above[-1] * 20.0 - step <= last <= above[-1] * 20.0 + 1e-9


def test_a_stop_is_a_spring_before_the_event_and_lets_go_behind_it():
    values = profile("stop", np.array([-1.0, -0.5, 0.0, 1.0 / 16.0, 1.0 / 8.0, 1.0]) * 3.0, 3.0)
    assert values == pytest.approx([0.0, 0.25, 1.0, 0.25, 0.0, 0.0])
