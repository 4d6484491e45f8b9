"""What is just noticeable, and the gestures that it is measured by."""

from __future__ import annotations

import math
from collections.abc import Mapping

from overview_dsp.design.gestures import Gesture, sweep, tap

STEP_DB = 2.3
STEP_DURATION = 1.25
STEP_SHARPNESS = 2.0
MERGED_S = 0.030
FALL_DB = 6.0

GESTURES: Mapping[str, Gesture] = {
    "slow": sweep(6.0),
    "medium": sweep(3.0),
    "fast": sweep(1.0),
    "tap": tap(1.0, 3.0),
}
"""Slow, medium and fast sweeps over all of the timeline, and a tap at its end."""


def ratio_steps(first: float, second: float, step: float) -> float:
    """How many times two figures are a ratio of `step` apart; NaN if one isn't above 0."""
    if not (first > 0.0 and second > 0.0):
        return math.nan
    return abs(math.log(first / second)) / math.log(step)
