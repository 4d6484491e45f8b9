"""Own math_functions functions: accurate, and the same compiled as plain."""

from __future__ import annotations

import math

import numba
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from overview_dsp.kernels import math_functions
from overview_dsp.kernels.math_functions import plain

log2, exp2, exp, power, sin_turns, cos_turns, tanh_positive = (
    math_functions.log2,
    math_functions.exp2,
    math_functions.exp,
    math_functions.power,
    math_functions.sin_turns,
    math_functions.cos_turns,
    math_functions.tanh_positive,
)


@numba.njit
def compiled(x, y):
    return (log2(x), exp2(y), power(x, 0.6), sin_turns(y), cos_turns(y), tanh_positive(x))


@given(x=st.floats(1e-300, 1e300))
@example(x=1.0)
@example(x=math.sqrt(0.5))
@example(x=math.nextafter(1.0, 0.0))
def test_log2_is_within_2e_12(x):
    assert abs(plain(log2)(x) - math.log2(x)) <= 2e-12 + 2e-16 * abs(math.log2(x))


@given(y=st.floats(-900.0, 900.0))
@example(y=0.5)
@example(y=-0.5)
def test_exp2_is_within_1e_12(y):
    assert plain(exp2)(y) == pytest.approx(2.0**y, rel=1e-12)


def test_exp2_stays_finite_and_positive_at_any_argument():
    for y in (-1e300, -2000.0, 2000.0, 1e300):
        assert 0.0 < plain(exp2)(y) < math.inf


@given(p=st.floats(0.0, 10.0))
@example(p=0.25)
@example(p=0.75)
def test_sine_and_cosine_of_turns_are_within_1e_13(p):
    assert plain(sin_turns)(p) == pytest.approx(math.sin(2 * math.pi * p), abs=1e-13)
    compiled_cosine = compiled(1.0, p)[4]
    assert compiled_cosine == pytest.approx(math.cos(2 * math.pi * p), abs=1e-13)


@given(x=st.floats(0.0, 40.0))
def test_tanh_is_within_1e_12(x):
    assert compiled(x + 1e-300, 0.0)[5] == pytest.approx(math.tanh(x), abs=1e-12)


@given(x=st.floats(1e-12, 1e12), y=st.floats(-100.0, 100.0))
def test_compiled_and_plain_functions_give_the_same_bits(x, y):
    fast = compiled(x, y)
    assert fast[0] == plain(log2)(x)
    assert fast[1] == plain(exp2)(y)
    assert fast[3] == plain(sin_turns)(y)
