"""Math functions with the same bits on every machine and in every runner.

libm differs between machines and blocks vectorisation. These are short Taylor series on reduced
arguments, summed in pairs (Estrin) so that a processor can overlap the terms. They have no branches
or conversions, so that a compiler can vectorise them. Each docstring states the accuracy.

Thread: any.
"""

from __future__ import annotations

from types import FunctionType

from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.simd.vector import bits_of, from_bits

LOG2_E = 1.4426950408889634  # 1 / ln 2
LN_2 = 0.6931471805599453
TURN = 6.283185307179586  # 2 pi
# IEEE 754 binary64: the exponent starts at bit 52 and is biased by 1023
ONE_BITS = 0x3FF0000000000000  # of 1.0
ROOT_HALF_BITS = 0x3FE6A09E667F3BCD  # of sqrt(1/2)
TWO_52_BITS = 0x4330000000000000  # of 2**52, whose low bits count integers
TWO_52_AND_BIAS = 4503599627370496.0 + 1023.0
# adding 1.5 * 2**52 rounds to the nearest integer and leaves it in the low bits
ROUND = 6755399441055744.0


@inlined
def log2(x):
    """Base-2 logarithm of a normal, positive x; absolute error below 2e-12.

    The atanh series of the mantissa: ln f = 2 (s + s**3/3 + ...), s = (f - 1)/(f + 1), |s| < 0.172.
    """
    bits = bits_of(x)
    exponent = (bits + (ONE_BITS - ROOT_HALF_BITS)) >> 52
    f = from_bits(bits - ((exponent - 1023) << 52))
    s = (f - 1.0) / (f + 1.0)
    t = s * s
    t2 = t * t
    high = (1.0 / 9.0 + t * (1.0 / 11.0)) + t2 * (1.0 / 13.0)
    low = (1.0 + t * (1.0 / 3.0)) + t2 * (1.0 / 5.0 + t * (1.0 / 7.0))
    whole = from_bits(exponent | TWO_52_BITS) - TWO_52_AND_BIAS
    return whole + (2.0 * LOG2_E) * s * (low + t2 * t2 * high)


@inlined
def exp2(y):
    """2 to the y (kept to -1000 to 1000); relative error below 1e-12."""
    y = min(max(y, -1000.0), 1000.0)
    rounded = y + ROUND
    z = (y - (rounded - ROUND)) * LN_2  # |z| <= 0.347
    z2 = z * z
    z4 = z2 * z2
    low = (1.0 + z) + z2 * (0.5 + z * (1.0 / 6.0))
    middle = (1.0 / 24.0 + z * (1.0 / 120.0)) + z2 * (1.0 / 720.0 + z * (1.0 / 5040.0))
    high = (1.0 / 40320.0 + z * (1.0 / 362880.0)) + z2 * (1.0 / 3628800.0)
    series = low + z4 * (middle + z4 * high)
    scale = from_bits((bits_of(rounded) << 52) + ONE_BITS)
    return series * scale


@inlined
def exp(x):
    """e to the x; relative error below 1e-12 for |x| < 100."""
    return exp2(x * LOG2_E)


@inlined
def power(x, p):
    """x to the p for a normal x > 0; relative error below 1e-11 for 0 <= p <= 2."""
    return exp2(p * log2(x))


@inlined
def tanh_positive(x):
    """Hyperbolic tangent of x >= 0; absolute error below 1e-12."""
    return 1.0 - 2.0 / (exp2(2.0 * LOG2_E * x) + 1.0)


@inlined
def sin_turns(p):
    """Sine of p turns (2 pi p radians), |p| < 2**31; absolute error below 1e-13 near zero."""
    rounded = 2.0 * p + ROUND
    x = (p - 0.5 * (rounded - ROUND)) * TURN  # |x| <= pi / 2
    t = x * x
    t2 = t * t
    t4 = t2 * t2
    low = (1.0 - t * (1.0 / 6.0)) + t2 * (1.0 / 120.0 - t * (1.0 / 5040.0))
    high = (1.0 / 362880.0 - t * (1.0 / 39916800.0)) + t2 * (
        1.0 / 6227020800.0 - t * (1.0 / 1307674368000.0)
    )
    s = x * (low + t4 * (high + t4 * (1.0 / 355687428096000.0)))
    # an odd number of half turns changes the sign
    sign = bits_of(rounded) << 63
    return from_bits(bits_of(s) ^ sign)


@inlined
def cos_turns(p):
    """Cosine of p turns, |p| < 2**31; absolute error below 1e-13 near zero."""
    return sin_turns(p + 0.25)


def plain(function):
    """Return a kernel function as plain Python, with all functions that it calls."""
    written = getattr(function, "py_func", function)
    called = {
        name: plain(written.__globals__[name])
        for name in written.__code__.co_names
        if hasattr(written.__globals__.get(name), "py_func")
    }
    return FunctionType(written.__code__, {**written.__globals__, **called}, written.__name__)
