"""Correctly rounded conversion of decibels to amplitude ratios.

    10**y = 2**k * exp(r),   r = y ln 10 - k ln 2,   |r| <= 0.35

A double is not exact enough, so numbers are pairs of a double and its rounding error, from
`exact_sum` and `exact_product` (Dekker 1971). A pair is accurate to 2**-70.

Thread: any.
"""

from __future__ import annotations

from overview_dsp.kernels.compiling import inlined, outlined
from overview_dsp.kernels.math_functions import ONE_BITS, ROUND, plain
from overview_dsp.kernels.simd.vector import bits_of, from_bits

SPLIT = 134217729.0  # 2**27 + 1: halves a double's digits
LOG2_10 = 3.321928094887362
LN_10 = 2.302585092994046
LN_10_LOW = -2.1707562233822494e-16
LN_2_HIGH = 0.693147180559663  # 41 bits, so that whole multiples are exact
LN_2_LOW = 2.8235290563031577e-13
HALVINGS = 5  # of r, so that few of the series' terms need pairs; squared as often afterwards


@inlined
def exact_sum(a, b):
    """Return a + b and its rounding error."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@inlined
def exact_product(a, b):
    """Return a * b and its rounding error."""
    product = a * b
    shifted = SPLIT * a
    a_high = shifted - (shifted - a)
    a_low = a - a_high
    shifted = SPLIT * b
    b_high = shifted - (shifted - b)
    b_low = b - b_high
    rest = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return product, rest


@outlined
def db_to_gain(db):
    """Return the amplitude ratio of a level in dB, -6000 to 6000."""
    y = db / 20.0
    rounded = y * LOG2_10 + ROUND
    k = rounded - ROUND
    product, rest = exact_product(y, LN_10)
    rest = rest + y * LN_10_LOW - k * LN_2_LOW
    high, low = exact_sum(product - k * LN_2_HIGH, rest)
    part = 1.0 / (1 << HALVINGS)
    high = high * part
    low = low * part
    # exp(r) = 1 + r + r**2/2 in pairs, the other terms in single doubles
    square, lost = exact_product(high, high)
    lost = lost + 2.0 * high * low
    tail = 0.0
    for factor in (9.0, 8.0, 7.0, 6.0, 5.0, 4.0):
        tail = (1.0 + tail) * high / factor
    tail = square * high * (1.0 + tail) / 6.0
    sum_high, sum_low = exact_sum(high, 0.5 * square)
    high, low = exact_sum(sum_high, sum_low + low + 0.5 * lost + tail)
    # (1 + e)**2 = 1 + (2 e + e**2): without the 1, so that e keeps its digits
    for _ in range(HALVINGS):
        square, lost = exact_product(high, high)
        lost = lost + 2.0 * high * low + 2.0 * low
        sum_high, sum_low = exact_sum(2.0 * high, square)
        high, low = exact_sum(sum_high, sum_low + lost)
    one, low_one = exact_sum(1.0, high)
    return (one + (low_one + low)) * from_bits((bits_of(rounded) << 52) + ONE_BITS)


_in_python = plain(db_to_gain)


def gain_of_db(db: float) -> float:
    """Return `db_to_gain` for callers in Python."""
    return float(_in_python(db))
