"""Thresholds of adaptive runs: most likely functions, and runs whose levels do not include them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri, xlogy

from overview_studies.adaptive import Run
from overview_studies.scales import Scale

Floats = NDArray[np.float64]

MIN_REVERSALS = 6
"""Fewest reversals of a staircase for a threshold."""

LAPSE = 0.01
"""Stated lapse rate of the functions fitted to runs."""

GUESSED = {"2afc": 5.02, "yesno": 7.38}
"""Twice the log likelihood ratio below which answers are like guesses.

The upper 2.5 % of chi-squared with one and two degrees of freedom. Of 5 %, a twentieth of those who
guess would have a threshold, which leaves no room for more.
"""

EXPONENTS = 2.0 ** np.arange(-1.5, 1.51, 0.25)
EXPONENT_SPREAD = 0.4
"""Tried exponents of d' over the distance from the standard; spread of their logarithms.

Their prior is normal around 1. Without it, thresholds are too large, as the levels that a staircase
chooses hardly determine an exponent. With an exponent of 1, those of other observers are wrong.
"""

WIDTHS = 2.0 ** np.arange(-1.0, 4.51, 0.5)
"""Tried widths of functions without a standard, in mean steps of the scale."""

FALSE_ALARMS = (0.02, 0.08, 0.16, 0.25, 0.35, 0.5)
"""Tried parts of "felt it" without a stimulus."""


def run_threshold(
    scale: Scale, step: dict[str, Any], responses: Mapping[str, Mapping[str, Any]], standard: Any
) -> float | str:
    """Return the threshold of a run as a position on the scale, or why there is none.

    Parameters
    ----------
    scale
        Scale of the levels.
    step
        Adaptive step of a list.
    responses
        Rows of a session by trial.
    standard
        Level of the standard; not used with one interval.
    """
    run = Run(step)
    places = np.array([scale.position(level) for level in step["levels"]])
    counts = np.zeros((2, len(places)))
    catches = np.zeros(2)
    yesno = step["method"] == "yesno"
    while not run.over:
        row = responses.get(f"{step['id']}-{run.trial + 1:03d}")
        if row is None:
            break
        response = row.get("response")
        wanted = int(not run.catch) if yesno else step["sides"][run.trial]
        right = response == wanted
        if run.catch:
            catches += [response == 1, 1]
        else:
            counts[:, run.level] += [right, 1]
        run.record(right)
    steps = _steps(scale, step["levels"], None if yesno else standard)
    share = 0.5 ** (1.0 / step["tracks"][0]["down"]) if step["tracks"] else 0.5 if yesno else 0.75
    fit = _fit_yesno if yesno else _fit_2afc
    threshold, ratio = fit(tuple(steps), share, counts, catches)
    if reason := _reason(run, step, counts[1], ratio):
        return reason
    if step["quest"] is not None:
        # lists of version 0.2.0 count the levels
        steps = np.array(step["quest"].get("steps", list(range(len(places)))), dtype=np.float64)
        threshold = run.posterior_mean
    if not steps[0] <= threshold <= steps[-1]:
        name = "below the lowest" if threshold < steps[0] else "above the highest"
        return f"the threshold is {name} level"
    return float(np.interp(threshold, steps, places))


def _reason(run: Run, step: Mapping[str, Any], presented: Floats, ratio: float) -> str:
    """Return why a run has no threshold, whatever its function; empty if it may have one."""
    total = int(presented.sum())
    if step["quest"] is not None:
        if run.trial < step["most"]:
            return f"{run.trial} of {step['most']} trials"
    elif run.reversals < MIN_REVERSALS:
        for limit, name in ((0, "lowest"), (-1, "highest")):
            if 2 * presented[limit] > total:
                return f"{int(presented[limit])} of {total} trials are at the {name} level"
        return f"{run.reversals} reversals, at least {MIN_REVERSALS} are needed"
    if ratio < GUESSED[step["method"]]:
        return "the answers are like guesses, up to the highest level"
    return ""


def _steps(scale: Scale, levels: Sequence[Any], standard: Any) -> Floats:
    """Return levels in mean steps from the standard, or from the first level without one."""
    plain = scale.steps(levels)
    first: Floats = np.abs(plain - plain[0])
    if standard is None:
        return first
    both = scale.steps([standard, *levels])
    found: Floats = np.abs(both[1:] - both[0])
    # with levels on both sides of the standard, the first is the nearest
    return found if bool((np.diff(found) > 0.0).all()) else 1.0 + first


@lru_cache(maxsize=32)
def _grid_2afc(steps: tuple[float, ...], share: float) -> tuple[Floats, Floats, Floats]:
    """Return logarithms of both probabilities (thresholds, exponents, levels), and thresholds."""
    x = np.array(steps)
    axis = np.geomspace(0.25 * x[0], 4.0 * x[-1], 121)
    at_threshold = ndtri((share - 0.5 * LAPSE) / (1.0 - LAPSE))
    z = at_threshold * (x / axis[:, None, None]) ** EXPONENTS[:, None]
    p = np.clip(0.5 * LAPSE + (1.0 - LAPSE) * ndtr(z), 0.0, 1.0 - 1e-6)
    return np.log(p), np.log1p(-p), axis


def _fit_2afc(
    steps: tuple[float, ...], share: float, counts: Floats, catches: Floats
) -> tuple[float, float]:
    right, wrong, axis = _grid_2afc(steps, share)
    likelihood = right @ counts[0] + wrong @ (counts[1] - counts[0])
    likelihood -= 0.5 * (np.log(EXPONENTS) / EXPONENT_SPREAD) ** 2
    ratio = 2.0 * (float(likelihood.max()) - float(counts[1].sum()) * math.log(0.5))
    return math.exp(_peak(likelihood.max(axis=1), np.log(axis))), ratio


@lru_cache(maxsize=32)
def _grid_yesno(steps: tuple[float, ...], share: float) -> tuple[Floats, Floats, Floats, Floats]:
    """Return logarithms of both probabilities (thresholds, others, levels), and these."""
    x = np.array(steps)
    axis = np.arange(-0.5 * len(x), 2.0 * len(x) + 0.01, 0.25)
    width, low = np.array(list(product(WIDTHS, FALSE_ALARMS))).T
    rise = 1.0 - low - LAPSE
    z = (x - axis[:, None, None]) / width[:, None] + ndtri((share - low) / rise)[:, None]
    p = np.clip(low[:, None] + rise[:, None] * ndtr(z), 1e-6, 1.0 - 1e-6)
    return np.log(p), np.log1p(-p), axis, low


def _fit_yesno(
    steps: tuple[float, ...], share: float, counts: Floats, catches: Floats
) -> tuple[float, float]:
    yes, no, axis, low = _grid_yesno(steps, share)
    likelihood = yes @ counts[0] + no @ (counts[1] - counts[0])
    likelihood += catches[0] * np.log(low) + (catches[1] - catches[0]) * np.log1p(-low)
    said, total = counts[0].sum() + catches[0], counts[1].sum() + catches[1]
    # answers that depend neither on the level nor on whether there is a stimulus
    flat = xlogy(said, said / total) + xlogy(total - said, 1.0 - said / total) if total else 0.0
    return _peak(likelihood.max(axis=1), axis), 2.0 * (float(likelihood.max()) - float(flat))


def _peak(likelihood: Floats, axis: Floats) -> float:
    """Return where a likelihood is largest, by a parabola through three points."""
    at = int(likelihood.argmax())
    if not 0 < at < len(axis) - 1:
        return float(axis[at])
    before, here, after = likelihood[at - 1 : at + 2]
    bend = before - 2.0 * here + after
    part = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    return float(axis[at] + part * (axis[1] - axis[0]))
