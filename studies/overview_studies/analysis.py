"""From answers to estimates: means with intervals by condition, differences, who was left out."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest

from overview_dsp.errors import InputError
from overview_studies.answers import Answers
from overview_studies.measures import (
    UNITS,
    Condition,
    condition_of,
    conditions_of,
    confusion,
    measured,
)
from overview_studies.statistics import (
    Estimate,
    difference_interval,
    information_interval,
    mean_interval,
)

ALPHA = 0.05


@dataclass(frozen=True)
class Line:
    """One estimate: of a measure in a condition, or of a difference between two levels."""

    measure: str
    condition: Condition
    estimate: Estimate

    def as_json(self) -> dict[str, Any]:
        """As results.json has it; what isn't known is null."""
        plain = {
            key: None if isinstance(value, float) and math.isnan(value) else value
            for key, value in asdict(self.estimate).items()
        }
        unit = UNITS.get(self.measure.partition(".")[0], "bits")
        return {"measure": self.measure, "condition": dict(self.condition), "unit": unit, **plain}


@dataclass(frozen=True, eq=False)
class Analysis:
    """What was found.

    Attributes
    ----------
    answers : Answers
        Those that count.
    excluded : dict
        Participants that don't, and why.
    lines : list of Line
        Estimates by condition.
    differences : list of Line
        Of each factor, later levels less the first; the condition is {factor: "b - a"}.
    matrices : dict
        Of each condition, its confusion matrix summed over participants.
    above_chance : dict
        Of each condition, how many participants are above chance alone, of how many.
    """

    answers: Answers
    excluded: dict[str, str]
    lines: list[Line]
    differences: list[Line]
    matrices: dict[Condition, NDArray[np.float64]]
    above_chance: dict[Condition, tuple[int, int]]

    def line(self, measure: str, **condition: Any) -> Line:
        """The estimate of a measure in the condition; KeyError if there is none."""
        for one in self.lines:
            if one.measure == measure and dict(one.condition) == condition:
                return one
        raise KeyError(measure)

    def as_json(self) -> dict[str, Any]:
        """All numbers, for results.json."""
        study = self.answers.study
        return {
            "study": study["name"],
            "title": study["title"],
            "design_sha256": study["design_sha256"],
            "program": study["program"],
            "participants": len(self.answers.sessions),
            "excluded": self.excluded,
            "estimates": [line.as_json() for line in self.lines],
            "differences": [line.as_json() for line in self.differences],
            "confusion": [
                {"condition": dict(c), "choices": study["task"]["choices"], "counts": m.tolist()}
                for c, m in self.matrices.items()
            ],
            "above_chance": [
                {"condition": dict(condition), "participants": above, "of": count}
                for condition, (above, count) in self.above_chance.items()
            ],
        }


def analyse(answers: Answers) -> Analysis:
    """Estimate everything that the study's task gives.

    Raises
    ------
    InputError
        Nobody is left.
    """
    answers, excluded = _kept(answers)
    if not answers.sessions:
        raise InputError("nobody is left to analyse; the study's [exclude] says who is left out")
    values = measured(answers)
    lines = [
        Line(name, condition, mean_interval(list(by.values())))
        for (name, condition), by in values.items()
    ]
    matrices: dict[Condition, NDArray[np.float64]] = {}
    above: dict[Condition, tuple[int, int]] = {}
    if answers.study["task"]["name"] == "identify":
        for condition, counts in _matrices(answers).items():
            matrices[condition] = counts.sum(axis=0)
            lines.append(Line("information", condition, information_interval(counts)))
            above[condition] = _above_chance(counts)
    return Analysis(answers, excluded, lines, _differences(answers, values), matrices, above)


def _kept(answers: Answers) -> tuple[Answers, dict[str, str]]:
    """Who is analysed, and why the others aren't: as the study's file said beforehand."""
    rule = answers.study["exclude"]
    excluded: dict[str, str] = {}
    attention: dict[str, list[int]] = defaultdict(list)
    for row in answers.rows():
        if row["phase"] == "attention":
            attention[row["participant"]].append(row["correct"])
    for session in answers.sessions:
        code, asked = session.participant, attention[session.participant]
        if rule["incomplete"] and session.finished_utc is None:
            excluded[code] = "the session wasn't finished"
        elif asked and float(np.mean(asked)) < rule["attention"]:
            excluded[code] = f"{sum(asked)} of {len(asked)} attention trials right"
    kept = [one for one in answers.sessions if one.participant not in excluded]
    return replace(answers, sessions=kept), excluded


def _matrices(answers: Answers) -> dict[Condition, NDArray[np.float64]]:
    """Of each condition: the confusion matrix of each participant."""
    names = conditions_of(answers.study)
    parts: dict[Condition, dict[str, list[Any]]] = defaultdict(lambda: defaultdict(list))
    for row in answers.rows():
        if row["phase"] in ("main", "catch"):
            parts[condition_of(row, names)][row["participant"]].append(row)
    choices = answers.study["task"]["choices"]
    return {
        condition: np.array([confusion(choices, rows) for rows in by.values()])
        for condition, by in parts.items()
    }


def _above_chance(counts: NDArray[np.float64]) -> tuple[int, int]:
    """How many participants are above chance by an exact binomial test, of how many."""
    chance = 1.0 / counts.shape[1]
    tests = [
        binomtest(int(np.trace(one)), int(one.sum()), chance, alternative="greater").pvalue
        for one in counts
        if one.sum()
    ]
    return sum(bool(p < ALPHA) for p in tests), len(tests)


def _differences(
    answers: Answers, values: dict[tuple[str, Condition], dict[str, float]]
) -> list[Line]:
    """Each factor's later levels less its first: within participants where it is within."""
    names = conditions_of(answers.study)
    lines = []
    for name in names:
        factor = answers.study["factors"][name]
        for measure in dict.fromkeys(measure for measure, _ in values):
            groups = [_at_level(values, measure, name, level) for level in factor["levels"]]
            for level, group in zip(factor["levels"][1:], groups[1:], strict=True):
                first = groups[0]
                both = [code for code in first if code in group]
                if factor["kind"] == "within":
                    estimate = mean_interval([group[code] - first[code] for code in both])
                else:
                    estimate = difference_interval(list(first.values()), list(group.values()))
                if estimate.participants:
                    condition = ((name, f"{level} - {factor['levels'][0]}"),)
                    lines.append(Line(measure, condition, estimate))
    return lines


def _at_level(
    values: dict[tuple[str, Condition], dict[str, float]], measure: str, factor: str, level: Any
) -> dict[str, float]:
    """A participant's mean over all conditions with that level."""
    found: dict[str, list[float]] = defaultdict(list)
    for (name, condition), by in values.items():
        if name == measure and (factor, level) in condition:
            for code, value in by.items():
                found[code].append(value)
    return {code: float(np.mean(all_of)) for code, all_of in found.items()}


def shown(condition: Condition | Sequence[tuple[str, Any]]) -> str:
    """A condition for a person."""
    return ", ".join(f"{name} {level}" for name, level in condition) or "all"
