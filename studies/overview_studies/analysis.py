"""Estimates from answers: means with intervals by condition, differences and exclusions."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest

from overview_dsp.errors import InputError
from overview_studies.answers import Answers
from overview_studies.measures import (
    DISTANCES,
    FITTED,
    JND_PER_WIDTH,
    LEVELS,
    UNITS,
    Condition,
    Measures,
    Missing,
    compute_measures,
    conditions_of,
    confusion,
    rows_of,
)
from overview_studies.row_checks import impossible
from overview_studies.scales import Scale, scale_of
from overview_studies.statistics import (
    LAPSES,
    RESAMPLES,
    Estimate,
    difference_interval,
    information_interval,
    mean_interval,
    resample_counts,
    resampled_interval,
)
from overview_studies.steps import answered_steps, find_among

ALPHA = 0.05
MOST_MISSING = 0.2
"""Largest share of participants without a level for a mean of the others."""


@dataclass(frozen=True)
class MeasureEstimate:
    """Estimate of a measure in a condition, or of a difference between two levels."""

    measure: str
    condition: Condition
    estimate: Estimate
    unit: str

    def as_json(self) -> dict[str, Any]:
        """Return the entry for results.json; unknown values are null."""
        plain = {
            key: None if isinstance(value, float) and math.isnan(value) else value
            for key, value in asdict(self.estimate).items()
        }
        head = {"measure": self.measure, "condition": dict(self.condition), "unit": self.unit}
        return {**head, **plain}


@dataclass(frozen=True, eq=False)
class Analysis:
    """Results of a study.

    Attributes
    ----------
    answers : Answers
        Answers of the participants that are analysed.
    excluded : dict
        Reason for each excluded participant.
    estimates : list of MeasureEstimate
        Estimates by condition.
    differences : list of MeasureEstimate
        Each later level of a factor minus its first; the condition is {factor: "b - a"}.
    matrices : dict
        Confusion matrix of each condition, summed over participants.
    better_than_guessing : dict
        For each condition, the number of participants above chance level and the number tested.
    measures : Measures
        Number of each participant.
    """

    answers: Answers
    excluded: dict[str, str]
    estimates: list[MeasureEstimate]
    differences: list[MeasureEstimate]
    matrices: dict[Condition, NDArray[np.float64]]
    better_than_guessing: dict[Condition, tuple[int, int]]
    measures: Measures

    @property
    def missing(self) -> list[Missing]:
        """Participants without a threshold or point of equality, each with the reason."""
        return self.measures.missing

    def line(self, measure: str, **condition: Any) -> MeasureEstimate:
        """Return the estimate of a measure in the condition; KeyError if there is none."""
        for one in self.estimates:
            if one.measure == measure and dict(one.condition) == condition:
                return one
        raise KeyError(measure)

    def as_json(self) -> dict[str, Any]:
        """Return all numbers, for results.json."""
        study = self.answers.study
        return {
            "study": study["name"],
            "title": study["title"],
            "simulated": self.answers.simulated,
            "design_sha256": study["design_sha256"],
            "program": study["program"],
            "participants": len(self.answers.sessions),
            "excluded": self.excluded,
            "missing": [{**asdict(one), "condition": dict(one.condition)} for one in self.missing],
            "estimates": [line.as_json() for line in self.estimates],
            "differences": [line.as_json() for line in self.differences],
            "confusion": [
                {"condition": dict(c), "choices": study["task"]["choices"], "counts": m.tolist()}
                for c, m in self.matrices.items()
            ],
            "above_chance": [
                {"condition": dict(condition), "participants": above, "of": count}
                for condition, (above, count) in self.better_than_guessing.items()
            ],
        }


def analyse(answers: Answers) -> Analysis:
    """Estimate every measure of the study's task.

    Raises
    ------
    InputError
        The rules of [exclude] leave no session.
    """
    answers, excluded = _apply_exclusions(answers)
    if not answers.sessions:
        raise InputError("no session is left after [exclude]; change its rules or add answers")
    measures = compute_measures(answers)
    scale = scale_of(answers.study)
    estimates = []
    for (name, condition), by in measures.values.items():
        one = _mean_of(measures, name, by, [(1.0, condition)])
        estimates.append(_estimate(scale, name, condition, one))
    matrices: dict[Condition, NDArray[np.float64]] = {}
    above: dict[Condition, tuple[int, int]] = {}
    if answers.study["task"]["name"] == "identify":
        for condition, counts in _matrices(answers).items():
            matrices[condition] = counts.sum(axis=0)
            information = information_interval(counts)
            estimates.append(MeasureEstimate("information", condition, information, "bits"))
            above[condition] = _better_than_guessing(counts)
    differences = _differences(scale, answers, measures)
    return Analysis(answers, excluded, estimates, differences, matrices, above, measures)


Parts = list[tuple[float, Condition]]
"""Conditions whose mean is added (1) or subtracted (-1)."""


def _mean_of(measures: Measures, measure: str, by: Mapping[str, float], parts: Parts) -> Estimate:
    """Return the mean with its interval; none of levels that too many participants lack.

    Those at a limit of the levels are not a random part of all: a mean without them would be wrong.
    """
    values = list(by.values())
    if not _suffices(values, measure):
        return _no_estimate(values)
    plain = mean_interval(values)
    if measure not in FITTED or math.isnan(plain.low):
        return plain
    resampled = _refitted(measures, measure, by, parts)
    return resampled_interval(plain.mean, resampled, plain.participants)


def _refitted(
    measures: Measures, measure: str, by: Mapping[str, float], parts: Parts
) -> NDArray[np.float64]:
    """Return means in resamples of participants, each with lapse rates of its own."""
    people = [code for code, value in by.items() if math.isfinite(value)]
    own = [(sign, measures.profiles[condition]) for sign, condition in parts
           if condition in measures.profiles]  # fmt: skip
    shares = Counter((sign, code) for sign, one in own for code in one.participants)
    # of small products, numpy starts no threads, which take longer than they save
    counts = resample_counts(len(people)).reshape(50, -1, len(people))
    total = np.zeros(RESAMPLES)
    for sign, one in own:
        widths = np.where(one.has_slope, one.width, one.width[:, [one.best]])
        values = {"pse": one.threshold, "jnd": JND_PER_WIDTH * widths,
                  "lapse": np.broadcast_to(LAPSES, widths.shape)}[measure]  # fmt: skip
        row_of = {code: row for row, code in enumerate(one.participants)}
        rows = [row_of.get(code, 0) for code in people]
        weight = np.array([sign / shares[sign, c] if c in row_of else 0.0 for c in people])[:, None]
        costs = one.cost[rows] * np.abs(np.sign(weight))
        costs, sums = (
            (counts @ part).reshape(RESAMPLES, -1) for part in (costs, values[rows] * weight)
        )
        total += sums[np.arange(RESAMPLES), costs.argmin(axis=1)]
    return total / len(people)


def _suffices(values: Sequence[float], measure: str) -> bool:
    lacking = sum(math.isnan(value) for value in values)
    return measure not in LEVELS | DISTANCES or lacking <= MOST_MISSING * len(values)


def _no_estimate(values: Sequence[float]) -> Estimate:
    return Estimate(math.nan, math.nan, math.nan, sum(map(math.isfinite, values)))


def _estimate(
    scale: Scale, name: str, condition: Condition, found: Estimate, is_difference: bool = False
) -> MeasureEstimate:
    """Return an estimate in levels, or as a ratio of levels for distances on a log scale."""
    unit = UNITS.get(name.partition(".")[0], "bits")
    if name in LEVELS | DISTANCES and scale.kind == "log":
        if is_difference or name in DISTANCES:
            unit = UNITS["ratio"]
        mean, low, high = (scale.level(one) for one in (found.mean, found.low, found.high))
        found = Estimate(mean, low, high, found.participants)
    return MeasureEstimate(name, condition, found, unit)


def _apply_exclusions(answers: Answers) -> tuple[Answers, dict[str, str]]:
    """Return the analysed answers, and the reason for each excluded participant."""
    rule = answers.study["exclude"]
    excluded: dict[str, str] = {}
    attention: dict[str, list[int]] = defaultdict(list)
    for session in answers.sessions:
        steps = answered_steps(answers.lists[session.number])
        for trial, _, row in session.trials:
            step = find_among(trial, steps)
            reason = step and impossible(answers.study, step, row)
            if reason:
                excluded.setdefault(session.participant, f"impossible answer {trial}: {reason}")
    for row in answers.rows() if rule["attention"] else ():
        if row["phase"] == "attention":
            attention[row["participant"]].append(row["correct"])
    for session in answers.sessions:
        code, asked = session.participant, attention[session.participant]
        if code in excluded:
            continue
        if rule["incomplete"] and session.finished_utc is None:
            excluded[code] = "the session is not complete"
        elif asked and float(np.mean(asked)) < rule["attention"]:
            excluded[code] = f"{sum(asked)} of {len(asked)} attention trials correct"
    kept = [one for one in answers.sessions if one.participant not in excluded]
    return replace(answers, sessions=kept), excluded


def _matrices(answers: Answers) -> dict[Condition, NDArray[np.float64]]:
    """Return the confusion matrix of each participant, by condition."""
    choices = answers.study["task"]["choices"]
    found: dict[Condition, list[NDArray[np.float64]]] = defaultdict(list)
    for (_, condition), rows in rows_of(answers).items():
        found[condition].append(confusion(choices, rows))
    return {condition: np.array(tables) for condition, tables in found.items()}


def _better_than_guessing(counts: NDArray[np.float64]) -> tuple[int, int]:
    """Return how many participants pass an exact binomial test, and how many were tested."""
    chance = 1.0 / counts.shape[1]
    tests = [
        binomtest(int(np.trace(one)), int(one.sum()), chance, alternative="greater").pvalue
        for one in counts
        if one.sum()
    ]
    return sum(bool(p < ALPHA) for p in tests), len(tests)


def _differences(scale: Scale, answers: Answers, measures: Measures) -> list[MeasureEstimate]:
    """Return each later level of a factor minus its first, on a log scale their ratio.

    Differences are within participants where the factor is.
    """
    names, values = conditions_of(answers.study), measures.values
    estimates = []
    for name in names:
        factor = answers.study["factors"][name]
        for measure in dict.fromkeys(measure for measure, _ in values):
            groups = [_at_level(values, measure, name, level) for level in factor["levels"]]
            for level, group in zip(factor["levels"][1:], groups[1:], strict=True):
                first = groups[0]
                conditions = [condition for one, condition in values if one == measure]
                old, new = ([c for c in conditions if (name, one) in c]
                            for one in (factor["levels"][0], level))  # fmt: skip
                if factor["kind"] == "within":
                    change = {code: group[code] - first[code] for code in first if code in group}
                    parts = [*((-1.0, c) for c in old), *((1.0, c) for c in new)]
                    estimate = _mean_of(measures, measure, change, parts)
                elif not all(_suffices(list(one.values()), measure) for one in (first, group)):
                    estimate = _no_estimate([*first.values(), *group.values()])
                else:
                    estimate = difference_interval(list(first.values()), list(group.values()))
                    if measure in FITTED and math.isfinite(estimate.low):
                        sizes = [sum(map(math.isfinite, one.values())) for one in (first, group)]
                        later = _refitted(measures, measure, group, [(1.0, c) for c in new])
                        before = _refitted(measures, measure, first, [(1.0, c) for c in old])
                        estimate = resampled_interval(
                            estimate.mean, later - before[::-1], sum(sizes), min(sizes)
                        )
                if estimate.participants:
                    condition = ((name, f"{level} - {factor['levels'][0]}"),)
                    estimates.append(_estimate(scale, measure, condition, estimate, True))
    return estimates


def _at_level(
    values: dict[tuple[str, Condition], dict[str, float]], measure: str, factor: str, level: Any
) -> dict[str, float]:
    """Return each participant's mean over all conditions with that level."""
    found: dict[str, list[float]] = defaultdict(list)
    for (name, condition), by in values.items():
        if name == measure and (factor, level) in condition:
            for code, value in by.items():
                found[code].append(value)
    return {code: float(np.mean(all_of)) for code, all_of in found.items()}


def condition_text(condition: Condition | Sequence[tuple[str, Any]]) -> str:
    """Return a condition as text."""
    return ", ".join(f"{name} {level}" for name, level in condition) or "all"
