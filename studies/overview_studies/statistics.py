"""Statistics of answers, on numpy and scipy: sensitivity, information, intervals, fits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize
from scipy.special import ndtr, ndtri, xlog1py, xlogy
from scipy.stats import t as student

RESAMPLES = 10_000
MIN_PARTICIPANTS = 5
"""Minimum number of participants for a bootstrap interval."""

MAX_LAPSE = 0.06
WIDTHS = (0.02, 5.0)
"""Narrowest and widest fitted function, in spans of the levels."""

_SEED = 20091115
"""Seed of the bootstrap, so that intervals are reproducible."""


@dataclass(frozen=True)
class Estimate:
    """Mean over participants with its 95 % interval; NaN if there is none."""

    mean: float
    low: float
    high: float
    participants: int


def sensitivity(
    hits: float, signals: float, false_alarms: float, noises: float
) -> tuple[float, float]:
    """Return d' and criterion c of counts, with the log-linear correction (Hautus 1995)."""
    hit = ndtri((hits + 0.5) / (signals + 1.0))
    alarm = ndtri((false_alarms + 0.5) / (noises + 1.0))
    return float(hit - alarm), float(-0.5 * (hit + alarm))


def sensitivity_2afc(right: float, trials: float) -> float:
    """Return d' of correct answers in two intervals, with the same correction."""
    return float(math.sqrt(2.0) * ndtri((right + 0.5) / (trials + 1.0)))


def information_bits(counts: ArrayLike, corrected: bool = True) -> float:
    """Return the information transfer from rows (presented) to columns (answered), in bits.

    `corrected` removes the bias of small samples after Miller and Madow. The result is at least 0.
    """
    table = np.asarray(counts, dtype=np.float64)
    total = table.sum()
    if total == 0.0:
        return math.nan
    presented, answered = table.sum(axis=1), table.sum(axis=0)

    def entropy(part: NDArray[np.float64]) -> float:
        nats = -float(xlogy(part / total, part / total).sum())
        return nats + ((part > 0.0).sum() - 1) / (2.0 * total) if corrected else nats

    bits = (entropy(presented) + entropy(answered) - entropy(table.ravel())) / math.log(2.0)
    return max(0.0, bits)


@lru_cache(maxsize=64)
def _resample_counts(participants: int) -> NDArray[np.float64]:
    """Return how often resamples contain participants: float64 (RESAMPLES, participants)."""
    rng = np.random.default_rng(_SEED)
    equal = np.full(participants, 1.0 / participants)
    return rng.multinomial(participants, equal, RESAMPLES).astype(np.float64)


def _interval_percentiles(participants: int) -> tuple[float, float]:
    """Return the percentiles of a 95 % interval.

    They are wider than 2.5 and 97.5. For few participants this corrects the spread of the
    bootstrap by sqrt((n - 1)/n), and replaces normal tails by those of t (Hesterberg 2015).
    """
    n = participants
    low = float(ndtr(-math.sqrt(n / (n - 1)) * student.ppf(0.975, n - 1)))
    return 100.0 * low, 100.0 * (1.0 - low)


def mean_interval(values: Sequence[float]) -> Estimate:
    """Return the mean of one number per participant, with a bootstrap interval."""
    known = np.array([value for value in values if math.isfinite(value)])
    n = len(known)
    if n < MIN_PARTICIPANTS:
        return Estimate(float(known.mean()) if n else math.nan, math.nan, math.nan, n)
    low, high = np.percentile(_resample_counts(n) @ known / n, _interval_percentiles(n))
    return Estimate(float(known.mean()), float(low), float(high), n)


def difference_interval(first: Sequence[float], second: Sequence[float]) -> Estimate:
    """Return the second group's mean minus the first's; both groups are resampled."""
    a, b = (np.array([v for v in one if math.isfinite(v)]) for one in (first, second))
    n = min(len(a), len(b))
    if n < MIN_PARTICIPANTS:
        mean = float(b.mean() - a.mean()) if n else math.nan
        return Estimate(mean, math.nan, math.nan, len(a) + len(b))
    # the reversed order makes both resamplings independent
    means = _resample_counts(len(b)) @ b / len(b) - (_resample_counts(len(a)) @ a / len(a))[::-1]
    low, high = np.percentile(means, _interval_percentiles(n))
    return Estimate(float(b.mean() - a.mean()), float(low), float(high), len(a) + len(b))


def information_interval(counts: NDArray[np.float64], resamples: int = 1000) -> Estimate:
    """Return the information transfer of pooled counts (participants, rows, columns), in bits."""
    n = len(counts)
    bits = information_bits(counts.sum(axis=0))
    if n < MIN_PARTICIPANTS:
        return Estimate(bits, math.nan, math.nan, n)
    pooled = np.tensordot(_resample_counts(n)[:resamples], counts, 1)
    low, high = np.percentile([information_bits(one) for one in pooled], _interval_percentiles(n))
    return Estimate(bits, float(low), float(high), n)


@dataclass(frozen=True)
class Psychometric:
    """Fitted function: guess + (1 - guess - lapse) * normal((level - threshold)/width)."""

    threshold: float
    width: float
    guess: float
    lapse: float
    has_slope: bool = True
    """False if the answers do not determine the width, which is then at a limit of `WIDTHS`."""

    def at(self, level: ArrayLike) -> NDArray[np.float64]:
        """Return the probability at levels."""
        z = (np.asarray(level, dtype=np.float64) - self.threshold) / self.width
        found: NDArray[np.float64] = self.guess + (1.0 - self.guess - self.lapse) * ndtr(z)
        return found


def fit_psychometric(
    level: ArrayLike, right: ArrayLike, trials: ArrayLike, guess: float | None
) -> Psychometric:
    """Fit a rising cumulative normal to counts by maximum likelihood, without priors.

    The threshold is at most one span beyond the levels, the width within `WIDTHS`, the lapse rate
    at most `MAX_LAPSE`.

    Parameters
    ----------
    guess
        Probability far below the threshold; None makes it equal to the lapse rate above.
    """
    x, k, n = (np.asarray(one, dtype=np.float64) for one in (level, right, trials))
    span = float(np.ptp(x)) or 1.0

    def unpack(p: NDArray[np.float64]) -> Psychometric:
        lapse = float(p[2])
        low = lapse if guess is None else guess
        return Psychometric(float(x.mean()) + span * float(p[0]), span * math.exp(p[1]), low, lapse)

    def cost(p: NDArray[np.float64]) -> float:
        probability = np.clip(unpack(p).at(x), 1e-9, 1.0 - 1e-9)
        return -float((xlogy(k, probability) + xlog1py(n - k, -probability)).sum())

    bounds = [(-1.5, 1.5), tuple(map(math.log, WIDTHS)), (0.0, MAX_LAPSE)]
    starts = [(at, width, 0.01) for at in (-0.3, 0.3) for width in (-2.5, -1.0)]
    precise = {"xatol": 1e-4, "fatol": 1e-6, "maxiter": 1000}
    tries = [
        minimize(cost, start, method="Nelder-Mead", bounds=bounds, options=precise)
        for start in starts
    ]
    best = min(tries, key=lambda one: float(one.fun)).x
    has_slope = bounds[1][0] + 0.01 < best[1] < bounds[1][1] - 0.01
    return replace(unpack(best), has_slope=has_slope)
