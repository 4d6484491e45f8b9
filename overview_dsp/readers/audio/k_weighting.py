"""The frequency weighting of loudness: ITU-R BS.1770's two filters, at any sample rate.

The Recommendation gives coefficients for 48 kHz only. These formulas (Brecht De Man, "Evaluation of
implementations of the EBU R128 loudness measurement", AES 145, 2018; the same in libebur128) give
those at 48 kHz to 1e-7 and the same response elsewhere, as far as the bilinear transform allows.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

MIN_RATE = 4000
"""Lowest sample rate, Hz: below it the shelf would lie beyond half the rate."""

_SHELF_HZ = 1681.974450955533
_SHELF_DB = 3.999843853973347
_SHELF_Q = 0.7071752369554196
_SHELF_BAND = 0.4996667741545416  # the exponent of the gain at the shelf's middle
_HIGH_PASS_HZ = 38.13547087602444
_HIGH_PASS_Q = 0.5003270373238773


def k_weighting(sample_rate: float) -> NDArray[np.float64]:
    """Return the shelf and the high-pass as second-order sections, float64 (2, 6).

    Parameters
    ----------
    sample_rate
        Hz, `MIN_RATE` or more.
    """
    k = math.tan(math.pi * _SHELF_HZ / sample_rate)
    high = 10.0 ** (_SHELF_DB / 20.0)
    band = high**_SHELF_BAND
    a0 = 1.0 + k / _SHELF_Q + k * k
    shelf = [
        (high + band * k / _SHELF_Q + k * k) / a0,
        2.0 * (k * k - high) / a0,
        (high - band * k / _SHELF_Q + k * k) / a0,
        1.0,
        2.0 * (k * k - 1.0) / a0,
        (1.0 - k / _SHELF_Q + k * k) / a0,
    ]
    k = math.tan(math.pi * _HIGH_PASS_HZ / sample_rate)
    a0 = 1.0 + k / _HIGH_PASS_Q + k * k
    # the numerator isn't divided by a0: so it stands in the Recommendation's table
    poles = [1.0, 2.0 * (k * k - 1.0) / a0, (1.0 - k / _HIGH_PASS_Q + k * k) / a0]
    return np.array([shelf, [1.0, -2.0, 1.0, *poles]], dtype=np.float64)
