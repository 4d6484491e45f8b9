"""Lanes: every function gives each of them the bits that it gives a number alone."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.kernels import layout
from overview_dsp.kernels.clutch import allowed_speed, clutched, slowed
from overview_dsp.kernels.dc_block import block_dc
from overview_dsp.kernels.envelope import compress, follow
from overview_dsp.kernels.friction_lookup import (
    any_steep,
    friction_at,
    frictions_at,
    is_steep,
    mean_friction,
    mean_frictions,
    on_table,
    steep_at,
)
from overview_dsp.kernels.math_functions import exp2, log2, power, sin_turns
from overview_dsp.kernels.noise import next_state, white
from overview_dsp.kernels.simd.vector import SIMD_WIDTH, choose, load, load_words, store
from overview_dsp.kernels.smoother import smooth
from overview_dsp.kernels.tactor import advance
from overview_dsp.kernels.texture import brightness, low_pass, smooth_level, texture_level
from overview_dsp.kernels.two_disk import midpoint_speed
from overview_dsp.kernels.viscous import STANDSTILL, flush_to_zero

ANY = st.floats(width=64, allow_subnormal=True)


@numba.njit(error_model="numpy")
def everything(a, b, c, d, e, f, state):
    """What kernels make of numbers, or of lanes."""
    y1, y2 = smooth(a, b, c, d)
    h, e1, e2 = follow(a, b, c, d, e, f)
    following = next_state(state)
    noise = choose(a > 0.0, following, state)
    return (
        a + b,
        a - b,
        a * b,
        a / b,
        2.0 * a,
        a - 1.0,
        abs(a),
        -a,
        max(a, b),
        min(a, b),
        choose(a >= b, a, 1.0),
        choose(a <= b, c, d),
        choose(a < b, 0.0, c),
        choose(a == b, c, d),
        y1,
        y2,
        h,
        e1,
        e2,
        block_dc(a, b, c, d),
        smooth_level(a, b, c),
        low_pass(a, b, c),
        brightness(a, b),
        texture_level(a, b, c),
        advance(a, b),
        midpoint_speed(a, b, c, d, e, f),
        allowed_speed(a, b, c, d, e, f, 1.0),
        slowed(a, b, c, d, e),
        clutched(a, b, c, d),
        flush_to_zero(a, STANDSTILL),
        compress(a, b, c, d),
        white(following),
        white(noise),
    )


@numba.njit(error_model="numpy")
def of_lanes(m, u, out):
    """The same of six columns of lanes, results column after column."""
    a = load(m, 0)
    b = load(m, SIMD_WIDTH)
    c = load(m, 2 * SIMD_WIDTH)
    d = load(m, 3 * SIMD_WIDTH)
    e = load(m, 4 * SIMD_WIDTH)
    f = load(m, 5 * SIMD_WIDTH)
    results = everything(a, b, c, d, e, f, load_words(u, 0))
    for i in range(len(results)):
        store(out, i * SIMD_WIDTH, results[i])


def bits(values):
    """The bits, but that one NaN is as good as another."""
    values = np.asarray(values, dtype=np.float64)
    return np.where(np.isnan(values), np.nan, values).view(np.int64)


@given(
    columns=st.lists(
        st.lists(ANY, min_size=SIMD_WIDTH, max_size=SIMD_WIDTH), min_size=6, max_size=6
    ),
    states=st.lists(st.integers(1, 2**64 - 1), min_size=SIMD_WIDTH, max_size=SIMD_WIDTH),
)
def test_every_lane_has_the_bits_of_a_number_alone(columns, states):
    m = np.array(columns).ravel()
    u = np.array(states, np.uint64)
    alone = [everything(*values, state) for *values, state in zip(*columns, u, strict=True)]
    out = np.zeros(len(alone[0]) * SIMD_WIDTH)
    of_lanes(m, u, out)
    np.testing.assert_array_equal(bits(out.reshape(-1, SIMD_WIDTH).T), bits(alone))


@numba.njit(error_model="numpy")
def elementary_lanes(m, out):
    x = load(m, 0)
    store(out, 0, log2(x))
    store(out, SIMD_WIDTH, exp2(x))
    store(out, 2 * SIMD_WIDTH, power(x, 0.6))
    store(out, 3 * SIMD_WIDTH, sin_turns(x))


@numba.njit(error_model="numpy")
def elementary_number(x):
    return log2(x), exp2(x), power(x, 0.6), sin_turns(x)


@given(x=st.lists(st.floats(1e-300, 1e300), min_size=SIMD_WIDTH, max_size=SIMD_WIDTH))
def test_elementary_functions_give_a_lane_the_bits_of_a_number(x):
    out = np.zeros(4 * SIMD_WIDTH)
    elementary_lanes(np.array(x), out)
    alone = [elementary_number(one) for one in x]
    np.testing.assert_array_equal(bits(out.reshape(4, SIMD_WIDTH).T), bits(alone))


@numba.njit(error_model="numpy")
def look_up_lanes(m, starts, positions, out):
    store(out, 0, frictions_at(m, starts, 1, load(positions, 0)))


@numba.njit(error_model="numpy")
def look_up(m, start, position):
    return friction_at(m, start, position)


@given(
    positions=st.lists(
        st.one_of(ANY, st.floats(-1.0, layout.CELLS + 1.0)),
        min_size=SIMD_WIDTH,
        max_size=SIMD_WIDTH,
    ),
    seed=st.integers(0, 9),
)
def test_each_lane_looks_up_its_own_table(positions, seed):
    rng = np.random.default_rng(seed)
    size = 2 * (layout.CELLS + 1)
    m = rng.uniform(0.0, 1.0, 2 * size)
    starts = np.append(-1, rng.integers(0, size, SIMD_WIDTH))
    out = np.zeros(SIMD_WIDTH)
    look_up_lanes(m, starts, np.array(positions), out)
    alone = [
        look_up(m, start, position) for start, position in zip(starts[1:], positions, strict=True)
    ]
    np.testing.assert_array_equal(bits(out), bits(alone))


@numba.njit(error_model="numpy")
def step_lanes(m, starts, columns, out):
    x, v, stretch, spring, inertia, middle = (
        load(columns, 0),
        load(columns, SIMD_WIDTH),
        load(columns, 2 * SIMD_WIDTH),
        load(columns, 3 * SIMD_WIDTH),
        load(columns, 4 * SIMD_WIDTH),
        load(columns, 5 * SIMD_WIDTH),
    )
    denominator = inertia * (2.0 + 0.5 * spring)
    friction, speed = mean_frictions(
        m, starts, 0, x, v, stretch, spring, inertia, denominator, middle
    )
    store(out, 0, friction)
    store(out, SIMD_WIDTH, speed)


@numba.njit(error_model="numpy")
def step_alone(m, start, x, v, stretch, spring, inertia, middle):
    return mean_friction(m, start, start, 0.0, x, v, stretch, spring, inertia, middle)


@pytest.fixture(scope="module")
def slots():
    """Two surfaces of random friction with its integral, and marks; where their tables begin."""
    rng = np.random.default_rng(1)
    m = rng.uniform(0.0, 1.0, 2 * layout.SLOT_SIZE)
    starts = np.array([0, layout.SLOT_SIZE]) + layout.SLOT_TABLE
    for start in starts:
        marks = start - layout.SLOT_TABLE + layout.SLOT_STEEP
        m.view(np.int64)[marks : marks + layout.CELLS // layout.STEEP_BLOCK + 1] = rng.integers(
            0, 2, layout.CELLS // layout.STEEP_BLOCK + 1
        )
    return m, starts


PLACES = st.one_of(
    st.floats(-1.0, layout.CELLS + 1.0),
    st.sampled_from([0.0, -0.0, layout.CELLS - 1e-9, float(layout.CELLS), math.nan, math.inf]),
)
SPEEDS = st.one_of(st.floats(-3.0, 3.0), st.sampled_from([0.0, 1.0 / 64.0, -1.0 / 64.0]))


@given(
    lanes=st.lists(
        st.tuples(PLACES, SPEEDS, SPEEDS, st.floats(0.0, 1.0), st.floats(0.1, 10.0), SPEEDS),
        min_size=SIMD_WIDTH,
        max_size=SIMD_WIDTH,
    ),
    where=st.lists(st.integers(0, 1), min_size=SIMD_WIDTH, max_size=SIMD_WIDTH),
)
def test_every_lane_steps_over_an_edge_as_a_voice_alone(slots, lanes, where):
    m, starts = slots
    out = np.zeros(2 * SIMD_WIDTH)
    step_lanes(m, starts[where], np.array(lanes).T.ravel().copy(), out)
    alone = [step_alone(m, starts[i], *lane) for i, lane in zip(where, lanes, strict=True)]
    np.testing.assert_array_equal(bits(out.reshape(2, SIMD_WIDTH).T), bits(alone))


@numba.njit(error_model="numpy")
def steep_lanes(i64, starts, positions, out):
    position = load(positions, 0)
    store(out, 0, choose(steep_at(i64, starts, 0, position), 1.0, 0.0 * position))
    return any_steep(i64, starts, 0, position)


@numba.njit(error_model="numpy")
def steep_alone(i64, start, position):
    return is_steep(i64, start, on_table(position))


@given(
    positions=st.lists(
        st.floats(-1.0, layout.CELLS + 1.0), min_size=SIMD_WIDTH, max_size=SIMD_WIDTH
    ),
    where=st.lists(st.integers(0, 1), min_size=SIMD_WIDTH, max_size=SIMD_WIDTH),
    same=st.booleans(),
)
def test_each_lane_sees_the_marks_of_its_own_table(slots, positions, where, same):
    m, starts = slots
    if same:  # without it, hardly ever is no lane marked
        positions, where = [positions[0]] * SIMD_WIDTH, [where[0]] * SIMD_WIDTH
    i64 = m.view(np.int64)
    out = np.zeros(SIMD_WIDTH)
    some = steep_lanes(i64, starts[where], np.array(positions), out)
    alone = [
        steep_alone(i64, starts[i], position) for i, position in zip(where, positions, strict=True)
    ]
    assert (out == 1.0).tolist() == alone
    assert some == any(alone)


@pytest.mark.parametrize("condition", [True, False])
def test_choose_is_for_numbers_too(condition):
    assert choose(condition, 1.0, 2.0) == (1.0 if condition else 2.0)
    assert math.isnan(choose(condition, math.nan, math.nan))
