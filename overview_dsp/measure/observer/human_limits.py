"""What a person can't know better: features blurred by normal noise, as large as its own limits.

Felt level 1.6 dB (a step is 2.3), slope 30 %, duration 18 % (Weber fraction 25 %), times between
pulses 5 ms; click level 0.8 dB, centroid 7 % (a step is 10 %), decay 18 %, delay 8 ms; the pace of
the own hand 15 %. Standard deviations. Pulses less than 30 ms apart are one already (`noticed`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LEVEL_DB, SLOPE, DURATION, RHYTHM_MS = 1.6, 0.30, 0.18, 5.0
CLICK_DB, CENTROID, DECAY, DELAY_MS = 0.8, 0.07, 0.18, 8.0
PACE = 0.15

_ADDED = {
    "level_db": LEVEL_DB,
    "over_surroundings_db": LEVEL_DB,
    "rise_db": LEVEL_DB,
    "fall_db": LEVEL_DB,
    "click_db": CLICK_DB,
    "click_delay_ms": DELAY_MS,
    "pace": PACE,
}
_RELATIVE = {
    "slope_db": SLOPE,
    "duration_ms": DURATION,
    "centroid_hz": CENTROID,
    "click_decay_ms": DECAY,
}
_OF_NEIGHBOUR = {
    "next_ms": ("next_ms", RHYTHM_MS),
    "next_db": ("next_ms", LEVEL_DB),
    "last_ms": ("last_ms", RHYTHM_MS),
    "last_db": ("last_ms", LEVEL_DB),
}
"""Added where there is a neighbour, which its time says."""


def blurred(
    features: NDArray[np.float64], names: tuple[str, ...], rng: np.random.Generator
) -> NDArray[np.float64]:
    """The features (onsets, features) of `noticed` as one person has them, once."""
    found = features.copy()
    for column, name in enumerate(names):
        if name in _ADDED:
            found[:, column] += _ADDED[name] * rng.standard_normal(len(found))
        elif name in _RELATIVE:
            found[:, column] *= np.exp(_RELATIVE[name] * rng.standard_normal(len(found)))
        elif name in _OF_NEIGHBOUR:
            time, size = _OF_NEIGHBOUR[name]
            there = features[:, names.index(time)] > 0.0
            found[:, column] += there * size * rng.standard_normal(len(found))
    return found
