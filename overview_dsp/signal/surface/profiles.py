"""Friction profiles of event shapes.

A profile is 1 at its top, and its width is the full width at half height. `distance` is the
position minus the event's, in the width's unit; later times have positive distances.

| shape | profile |
|---|---|
| gaussian | exp(-4 ln2 (d/w)**2) |
| raised_cosine | (1 + cos(pi d/w))/2 for abs(d) < w |
| ramp_up | a linear rise from d = -15/8 w, and a fall within w/8 after the event |
| ramp_down | ramp_up reversed |
| plateau | exp(-ln2 (2d/w)**10): a flat top with steep, smooth edges |

`stop` is the energy of an end stop: a spring from d = -w to the event, with a fall within w/8. It
is not available as a shape of friction.

A profile that is drawn or imported from a haptic clip is a list of points, linearly interpolated
from d = -w to d = w.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from overview_dsp.arrays import FloatArray

AT_A_TIME = 1 << 17  # number of profile points computed at once
SPAN_LEVEL = 0.1  # part of its height above which a position lies in a profile's span
_RISE = 15.0 / 8.0  # so that rise/2 + fall/2 is one width at half height
_FALL = 1.0 / 8.0


def _ramp_up(d: FloatArray) -> FloatArray:
    return np.maximum(np.minimum(1.0 + d / _RISE, 1.0 - d / _FALL), 0.0)


def _stop(d: FloatArray) -> FloatArray:
    return np.where(d < 0.0, np.maximum(1.0 + d, 0.0), np.maximum(1.0 - d / _FALL, 0.0)) ** 2


_SHAPES: dict[str, Callable[[FloatArray], FloatArray]] = {
    "gaussian": lambda d: np.exp(-4.0 * math.log(2.0) * d * d),
    "raised_cosine": lambda d: np.where(np.abs(d) < 1.0, 0.5 + 0.5 * np.cos(np.pi * d), 0.0),
    "ramp_up": _ramp_up,
    "ramp_down": lambda d: _ramp_up(-d),
    "plateau": lambda d: np.exp(-math.log(2.0) * (2.0 * d) ** 10),
    "stop": _stop,
}

_COSINE_SPAN = math.acos(2.0 * SPAN_LEVEL - 1.0) / math.pi
_SPANS: dict[str, tuple[float, float]] = {
    "gaussian": (-(half := math.sqrt(math.log(1.0 / SPAN_LEVEL) / (4.0 * math.log(2.0)))), half),
    "raised_cosine": (-_COSINE_SPAN, _COSINE_SPAN),
    "ramp_up": (-_RISE * (1.0 - SPAN_LEVEL), _FALL * (1.0 - SPAN_LEVEL)),
    "ramp_down": (-_FALL * (1.0 - SPAN_LEVEL), _RISE * (1.0 - SPAN_LEVEL)),
    "stop": (-1.0 + math.sqrt(SPAN_LEVEL), _FALL * (1.0 - math.sqrt(SPAN_LEVEL))),
    "plateau": (-(foot := 0.5 * math.log2(1.0 / SPAN_LEVEL) ** 0.1), foot),
}

REACH: dict[str, float] = {
    "gaussian": 2.0,  # below 2e-5 from there
    "raised_cosine": 1.0,
    "ramp_up": _RISE,
    "ramp_down": _RISE,
    "stop": 1.0,
    "plateau": 1.05,  # exactly 0 from there, as float64 has it
}
"""Distance in widths beyond which a profile is zero."""


Points = tuple[float, ...]


def reach(shape: str, points: Points = ()) -> float:
    """Return the distance in widths beyond which the profile is zero."""
    return 1.0 if points else REACH[shape]


def profile(shape: str, distance: FloatArray, width: float, points: Points = ()) -> FloatArray:
    """Return the profile's value, 0 to 1, at each distance (in the unit of `width`) from the event.

    `width` is the full width at half height, > 0. `points` replace the shape.
    """
    if points:
        places = np.linspace(-1.0, 1.0, len(points))
        return np.interp(distance / width, places, points, left=0.0, right=0.0)
    return _SHAPES[shape](distance / width)


def span(shape: str, width: float, points: Points = ()) -> tuple[float, float]:
    """Return the range of distances in which the profile exceeds a tenth of its height."""
    if points:
        fine = np.linspace(-1.0, 1.0, 16 * (len(points) - 1) + 1)
        over = np.flatnonzero(profile(shape, fine, 1.0, points) > SPAN_LEVEL * max(points))
        return float(fine[over[0]]) * width, float(fine[over[-1]]) * width
    first, last = _SPANS[shape]
    return first * width, last * width


def entries(shape: str, width: float, points: Points = ()) -> tuple[float, float]:
    """Return the distances at which a disk from below and one from above strike the profile.

    These are the ends of its span, or 0 for the top of a rising ramp.
    """
    first, last = span(shape, width, points)
    if not points and shape == "ramp_up":
        return 0.0, last
    if not points and shape == "ramp_down":
        return first, 0.0
    return first, last


def bumps(
    shape: str, points: Points, width: float, centre: FloatArray, height: FloatArray, cells: int
) -> Iterator[tuple[int, int, FloatArray]]:
    """Yield the profiles of events of one shape and width on a table of cells + 1 points.

    Each item is the event's index, its first point, and its profile from there.
    """
    most = reach(shape, points) * width
    low = np.floor(centre - most)
    steps = np.arange(math.ceil(2.0 * most) + 2)
    begin = np.maximum(low, 0.0).astype(np.int64)
    end = np.minimum(np.ceil(centre + most), cells).astype(np.int64) + 1
    skipped = begin - low.astype(np.int64)
    rows = max(1, AT_A_TIME // len(steps))
    for start in range(0, len(centre), rows):
        some = slice(start, start + rows)
        distance = low[some, None] + steps - centre[some, None]
        high = height[some, None] * profile(shape, distance, width, points)
        numbers = range(start, start + len(high))
        places = (row[some].tolist() for row in (begin, end, skipped))
        for i, bump, a, b, skip in zip(numbers, high, *places, strict=True):
            yield i, a, bump[skip : skip + b - a]
