"""Statistics of answers, on numpy and scipy: sensitivity, information, intervals, fits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import minimum_filter
from scipy.special import ndtr, ndtri, xlogy
from scipy.stats import t as student

Floats = NDArray[np.float64]
Table = tuple[Floats, Floats, Floats]
"""Levels, counts of an answer and trials."""

RESAMPLES = 10_000
MIN_PARTICIPANTS = 5
"""Minimum number of participants for a bootstrap interval."""

MAX_LAPSE = 0.1
LAPSES = MAX_LAPSE * np.linspace(0.0, 1.0, 13) ** 2
"""Tried lapse rates; small ones, which change the width most, are closer to each other."""

WIDTHS = (0.02, 5.0)
"""Narrowest and widest fitted function, in spans of the levels."""

MAX_CORRECTION = 1.25
"""Largest factor by which a width is corrected; answers that need more hardly determine it."""

STARTS, REFINEMENTS = 3, 30
REFINED, SMALLEST_GAIN = 5, 1e-9
"""A fit ends after so many refinements that gain less than this much likelihood."""

_LOW, _HIGH = (np.array([end, math.log(w)]) for end, w in zip((-1.5, 1.5), WIDTHS, strict=True))
"""Limits of threshold, in spans from the middle of the levels, and logarithm of width."""

_LENGTHS = 2.0 ** np.array([1.0, 0.0, -1.0, -2.0, -3.0, -5.0, -8.0, -np.inf])[:, None]
_AROUND = np.array([one for one in product((-1, 0, 1), (-2, -1, 0, 1, 2)) if any(one)]) / 2.0
"""Tried parts of a scoring step, and steps around a point."""

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
    return float(_information(table[None], corrected)[0]) if table.sum() else math.nan


def _information(tables: Floats, corrected: bool = True) -> Floats:
    """Return the information transfer of each of several tables."""
    total = tables.sum(axis=(1, 2))

    def entropy(part: Floats) -> Floats:
        share = part / total[:, None]
        nats: Floats = -xlogy(share, share).sum(axis=1)
        return nats + ((part > 0.0).sum(axis=1) - 1) / (2.0 * total) if corrected else nats

    both = entropy(tables.reshape(len(tables), -1))
    bits = (entropy(tables.sum(axis=2)) + entropy(tables.sum(axis=1)) - both) / math.log(2.0)
    found: Floats = np.maximum(bits, 0.0)
    return found


@lru_cache(maxsize=64)
def resample_counts(participants: int) -> Floats:
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
    return resampled_interval(float(known.mean()), resample_counts(n) @ known / n, n)


def resampled_interval(
    mean: float, resampled: Floats, participants: int, smallest: int | None = None
) -> Estimate:
    """Return a mean with the percentiles of resampled means; `smallest` is the smaller group."""
    limits = np.percentile(resampled, _interval_percentiles(smallest or participants))
    return Estimate(mean, float(limits[0]), float(limits[1]), participants)


def difference_interval(first: Sequence[float], second: Sequence[float]) -> Estimate:
    """Return the second group's mean minus the first's; both groups are resampled."""
    a, b = (np.array([v for v in one if math.isfinite(v)]) for one in (first, second))
    n = min(len(a), len(b))
    if n < MIN_PARTICIPANTS:
        mean = float(b.mean() - a.mean()) if n else math.nan
        return Estimate(mean, math.nan, math.nan, len(a) + len(b))
    # the reversed order makes both resamplings independent
    means = resample_counts(len(b)) @ b / len(b) - (resample_counts(len(a)) @ a / len(a))[::-1]
    return resampled_interval(float(b.mean() - a.mean()), means, len(a) + len(b), n)


def information_interval(counts: Floats) -> Estimate:
    """Return the information transfer of pooled counts (participants, rows, columns), in bits."""
    n = len(counts)
    bits = information_bits(counts.sum(axis=0))
    if n < MIN_PARTICIPANTS:
        return Estimate(bits, math.nan, math.nan, n)
    pooled = np.tensordot(resample_counts(n), counts, 1)
    low, high = np.percentile(_information(pooled), _interval_percentiles(n))
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

    cost: float = math.nan
    """Negative logarithm of the likelihood of the answers."""

    def at(self, level: ArrayLike) -> Floats:
        """Return the probability at levels."""
        z = (np.asarray(level, dtype=np.float64) - self.threshold) / self.width
        found: Floats = self.guess + (1.0 - self.guess - self.lapse) * ndtr(z)
        return found


def fit_psychometric(
    level: ArrayLike,
    right: ArrayLike,
    trials: ArrayLike,
    guess: float | None,
    lapse: float | None = None,
) -> Psychometric:
    """Fit a rising cumulative normal to counts by maximum likelihood, without priors.

    The threshold is at most one span beyond the levels, the width within `WIDTHS`, the lapse rate
    at most `MAX_LAPSE`.

    Parameters
    ----------
    guess
        Probability far below the threshold; None makes it equal to the lapse rate above.
    lapse
        Lapse rate; None fits it, too.
    """
    table, span, middle = _scaled(level, right, trials)
    rates = LAPSES if lapse is None else np.array([lapse])
    found = _profile(table, guess, rates)
    if lapse is None:
        near = int(found[0].argmin())
        rates = np.linspace(LAPSES[max(near - 1, 0)], LAPSES[min(near + 1, len(LAPSES) - 1)], 11)
        found = _profile(table, guess, rates)
    at = int(found[0].argmin())
    cost, place, log_width = (float(one[0, at]) for one in found)
    rate = float(rates[at])
    return Psychometric(
        middle + span * place,
        span * math.exp(log_width),
        rate if guess is None else guess,
        rate,
        bool(_inside(log_width)),
        cost,
    )


def _scaled(level: ArrayLike, right: ArrayLike, trials: ArrayLike) -> tuple[Table, float, float]:
    """Return levels in spans from their middle, one row of counts per person, span and middle."""
    x, k, n = (np.asarray(one, dtype=np.float64) for one in (level, right, trials))
    span, middle = float(np.ptp(x)) or 1.0, float(x.min() + x.max()) / 2.0
    return ((x - middle) / span, np.atleast_2d(k), np.atleast_2d(n)), span, middle


def _inside(log_width: ArrayLike) -> NDArray[np.bool_]:
    """Return where the logarithm of a width is not at a limit."""
    return np.clip(log_width, _LOW[1] + 0.01, _HIGH[1] - 0.01) == log_width  # type: ignore[no-any-return]


def _profile(table: Table, guess: float | None, lapses: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the least cost, and where it is: threshold, logarithm of width (people, lapse rates).

    Between uneven levels the cost has several minima. The lowest ones of a grid, whose thresholds
    include the levels and their midpoints, are refined: by scoring steps of several lengths, and
    by steps around the point, which get shorter.
    """
    x, k, n = table
    low = (lapses if guess is None else np.full_like(lapses, guess))[:, None]
    rise = 1.0 - lapses[:, None] - low
    thresholds = np.unique([*np.linspace(_LOW[0], _HIGH[0], 25), *x, *(x[1:] + x[:-1]) / 2.0])
    axes = np.meshgrid(thresholds, np.linspace(_LOW[1], _HIGH[1], 23), indexing="ij")
    pairs = np.stack(axes, axis=-1).reshape(-1, 2)
    p = _chances(pairs, low, rise, x)
    grid = -(np.log(p) @ k.T + np.log1p(-p) @ (n - k).T)
    costs = np.moveaxis(grid, -1, 0).reshape(-1, *axes[0].shape)
    near = minimum_filter(costs, (1, 3, 3), mode="constant", cval=np.inf)
    minima = np.where(costs <= near, costs, np.inf).reshape(len(costs), -1)
    at = pairs[minima.argpartition(STARTS, axis=1)[:, :STARTS]]
    around = _AROUND * (thresholds[1] - thresholds[0], pairs[1, 1] - pairs[0, 1])
    # a row for each person and lapse rate
    low, rise = (np.tile(one, (len(k), 1)) for one in (low, rise))
    k_rows, n_rows = (one.repeat(len(lapses), axis=0)[:, None] for one in (k, n))
    best, still = np.full(at.shape[:2], np.inf), np.zeros(len(at), dtype=int)
    for _ in range(REFINEMENTS):
        rows = np.flatnonzero(still < REFINED)
        own, part = at[rows], (low[rows], rise[rows])
        table = x, k_rows[rows], n_rows[rows]
        step = _scoring_step(own, *part, table)[:, :, None]
        both = [-_LENGTHS * step, np.broadcast_to(around, (*own.shape[:2], *around.shape))]
        tried = np.clip(own[:, :, None] + np.concatenate(both, axis=2), _LOW, _HIGH)
        costs = _cost(tried, part[0][..., None], part[1][..., None], table)
        at[rows] = np.take_along_axis(tried, costs.argmin(axis=2)[..., None, None], 2)[:, :, 0]
        around, least = 0.75 * around, best[rows].min(axis=1)
        best[rows] = costs.min(axis=2)
        gain = least - best[rows].min(axis=1)
        still[rows] = np.where(gain < SMALLEST_GAIN, still[rows] + 1, 0)
    start = best.argmin(axis=1)
    found = np.take_along_axis(at, start[:, None, None], 1)[:, 0].T
    cost, threshold, width = (one.reshape(len(k), -1) for one in (best.min(axis=1), *found))
    return cost, threshold, width


def _chances(at: Floats, low: Floats, rise: Floats, x: Floats) -> Floats:
    """Return the probability of an answer at each level, at pairs of threshold and log width."""
    z = (x - at[..., :1]) / np.exp(at[..., 1:])
    p: Floats = np.clip(low[..., None] + rise[..., None] * ndtr(z), 1e-9, 1.0 - 1e-9)
    return p


def _cost(at: Floats, low: Floats, rise: Floats, table: Table) -> Floats:
    """Return the negative logarithm of the likelihood at tried pairs (rows, starts, tried)."""
    x, k, n = table
    p = _chances(at, low, rise, x)
    k, n = k[:, None], n[:, None]
    costs: Floats = -np.einsum("...l,...l->...", k, np.log(p))
    costs -= np.einsum("...l,...l->...", n - k, np.log1p(-p))
    return costs


def _scoring_step(at: Floats, low: Floats, rise: Floats, table: Table) -> Floats:
    """Return the step of Fisher's scoring at each pair, along the limits where it would leave."""
    (x, k, n), width = table, np.exp(at[..., 1:])
    z = (x - at[..., :1]) / width
    p = np.clip(low[..., None] + rise[..., None] * ndtr(z), 1e-9, 1.0 - 1e-9)
    density = -rise[..., None] * np.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi)
    slopes = np.stack([density / width, density * z], axis=-1)
    weight = 1.0 / (p * (1.0 - p))
    gradient = (((n * p - k) * weight)[..., None] * slopes).sum(axis=-2)
    fixed = ((at <= _LOW) & (gradient > 0.0)) | ((at >= _HIGH) & (gradient < 0.0))
    gradient = np.where(fixed, 0.0, gradient)
    information = np.einsum("...l,...li,...lj->...ij", n * weight, slopes, slopes)
    information = np.where(fixed[..., None] | fixed[..., None, :], 0.0, information)
    ridge = 1e-9 + 1e-6 * np.trace(information, axis1=-2, axis2=-1)[..., None] + fixed
    step: Floats = np.linalg.solve(information + np.eye(2) * ridge[..., None], gradient[..., None])[
        ..., 0
    ]
    return step


def _width_correction(table: Table, threshold: Floats, width: Floats, lapses: Floats) -> Floats:
    """Return factors that remove the bias of most likely widths (people, lapse rates).

    In small samples they are too small; the factor is that of the first order (Cox and Snell 1968).
    """
    x, _, n = table
    z = (x - threshold[..., None]) / width[..., None]
    rise = 1.0 - 2.0 * lapses[:, None]
    p = np.clip(lapses[:, None] + rise * ndtr(z), 1e-9, 1.0 - 1e-9)
    density = rise * np.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi) / width[..., None]
    slopes = -density[..., None] * np.stack([np.ones_like(z), z], axis=-1)
    mixed = 1.0 - z * z
    curves = np.stack([np.stack([-z, mixed], -1), np.stack([mixed, z * (2.0 - z * z)], -1)], -1)
    curves *= (density / width[..., None])[..., None, None]
    weight = n[:, None] / (p * (1.0 - p))
    information = np.einsum("...l,...li,...lj->...ij", weight, slopes, slopes)
    # without a ridge, levels that are all right or all wrong have no inverse
    ridge = 1e-9 + 1e-6 * np.trace(information, axis1=-2, axis2=-1)[..., None, None]
    covariance = np.linalg.inv(information + ridge * np.eye(2))
    bending = weight * np.einsum("...ij,...lij->...l", covariance, curves)
    bias = -0.5 * np.einsum("...ij,...l,...lj->...i", covariance, bending, slopes)[..., 1]
    factor: Floats = np.clip(1.0 - bias / width, 1.0, MAX_CORRECTION)
    return factor


@dataclass(frozen=True)
class LapseProfiles:
    """Fits of the participants of a condition at each of `LAPSES`.

    A hundred trials of one participant do not separate the lapse rate from the width, and a rate
    of their own would make the widths too small. A rate of all conditions would turn a difference
    of lapses into one of widths.

    Attributes
    ----------
    participants : list of str
    cost, threshold, width : numpy.ndarray
        One row for each participant, one column for each lapse rate. Widths are corrected for the
        bias of small samples.
    has_slope : numpy.ndarray
        False where the answers do not determine the width.
    """

    participants: list[str]
    cost: Floats
    threshold: Floats
    width: Floats
    has_slope: NDArray[np.bool_]

    @property
    def best(self) -> int:
        """Column of the lapse rate that makes the answers of all participants most likely."""
        return int(self.cost.sum(axis=0).argmin())

    def of(self, participant: str) -> Psychometric | None:
        """Return the function of a participant with the lapse rate of the condition, if fitted."""
        if participant not in self.participants:
            return None
        row, column = self.participants.index(participant), self.best
        rate = float(LAPSES[column])
        at, width = float(self.threshold[row, column]), float(self.width[row, column])
        return Psychometric(at, width, rate, rate, bool(self.has_slope[row, column]))


def fit_lapse_profiles(
    tables: Mapping[str, Table],
) -> LapseProfiles:
    """Fit levels, counts and trials of each participant, with equal lapses at both ends."""
    people = list(tables)
    groups: dict[tuple[float, ...], list[int]] = {}
    for row, one in enumerate(tables.values()):
        groups.setdefault(tuple(one[0].tolist()), []).append(row)
    found = np.empty((4, len(people), len(LAPSES)))
    for levels, rows in groups.items():
        counts = [[tables[people[row]][i] for row in rows] for i in (1, 2)]
        table, span, middle = _scaled(levels, *counts)
        cost, threshold, log_width = _profile(table, None, LAPSES)
        width = np.exp(log_width) * _width_correction(table, threshold, np.exp(log_width), LAPSES)
        found[:, rows] = cost, middle + span * threshold, span * width, log_width
    cost, threshold, width, log_width = found
    return LapseProfiles(people, cost, threshold, width, _inside(log_width))
