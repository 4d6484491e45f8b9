"""Measures: one number per participant and condition.

Means, intervals and differences in `analysis` are computed from these numbers.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_studies.answers import FOUND_TOLERANCE, Answers
from overview_studies.scales import scale_of
from overview_studies.scoring import likeness
from overview_studies.statistics import (
    LapseProfiles,
    Psychometric,
    fit_lapse_profiles,
    sensitivity,
    sensitivity_2afc,
)
from overview_studies.thresholds import run_threshold

Condition = tuple[tuple[str, Any], ...]
Row = Mapping[str, Any]

SHARE_AT_LIMIT = 0.4
"""Share of adjustments at the lowest or highest level above which there is no adjusted level."""

LEVELS, DISTANCES = {"pse", "threshold"}, {"jnd", "adjusted"}
"""Measures that are positions on the scale of the levels, and distances between positions."""

FITTED = ("pse", "jnd", "lapse")
"""Measures of fitted functions, which depend on the lapse rate of the condition."""

JND_PER_WIDTH = 0.6745
"""Distance from 50 % to 75 % of a cumulative normal, in widths."""

MIN_LEVELS = 4
"""Fewest compared levels that a function is fitted to."""

UNITS = {
    "accuracy": "share of trials",
    "d_prime": "",
    "criterion": "",
    "false_alarms": "share of catch trials",
    "location_error": "share of the timeline",
    "location_bias": "share of the timeline",
    "found": "share of trials",
    "hits": "share of trials",
    "time": "s",
    "path": "timelines",
    "returns": "",
    "exact": "share of trials",
    "count_error": "events",
    "pse": "of the varied dimension",
    "jnd": "of the varied dimension",
    "lapse": "share of trials",
    "threshold": "of the varied dimension",
    "ratio": "ratio of levels",
    "likeness": "Pearson's r",
    "drawn_error": "0 to 1",
    "adjusted": "of the varied dimension",
    "rt": "ms, median of main trials",
    "tlx": "0 to 100",
}


def conditions_of(study: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the factors that form conditions, which excludes factors of the stimulus."""
    stimulus = {"timeline", "answer", "preset", "gesture", "seed"}
    own = {id for one in study["stimuli"].values() for id in one["parameters"]}
    return tuple(name for name in study["factors"] if name not in stimulus | own)


def condition_of(row: Row, names: Sequence[str]) -> Condition:
    """Return the condition of a row."""
    return tuple((name, row[name]) for name in names)


@dataclass(frozen=True)
class Missing:
    """A level that answers do not determine: the participant has no such number."""

    measure: str
    condition: Condition
    participant: str
    reason: str


@dataclass(frozen=True)
class Measures:
    """Numbers of the participants.

    Attributes
    ----------
    values : dict
        Each participant's number by measure and condition. `LEVELS` and `DISTANCES` are positions
        on the scale of the levels. A missing number is NaN.
    missing : list of Missing
    profiles : dict
        Fits of a compare task by condition, at each lapse rate.
    """

    values: dict[tuple[str, Condition], dict[str, float]]
    missing: list[Missing]
    profiles: dict[Condition, LapseProfiles]


def compute_measures(answers: Answers) -> Measures:
    """Return the numbers of all participants, and those that are missing."""
    study = answers.study
    missing: list[Missing] = []
    names, parts = conditions_of(study), rows_of(answers)
    found: dict[tuple[str, Condition], dict[str, float]] = defaultdict(dict)
    profiles = _lapse_profiles(study, parts)
    for (participant, condition), rows in parts.items():
        profile = profiles.get(condition)
        fitted = None if profile is None else profile.of(participant)
        for name, value in _task_measures(study, rows, fitted).items():
            if isinstance(value, str):
                missing.append(Missing(name, condition, participant, value))
            found[name, condition][participant] = math.nan if isinstance(value, str) else value
        main = (row["rt_ms"] for row in rows if row["phase"] == "main")
        if times := [time for time in main if time is not None]:
            found["rt", condition][participant] = float(np.median(times))
    thresholds: dict[Condition, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for condition, participant, value in _thresholds(answers, names):
        if isinstance(value, str):
            missing.append(Missing("threshold", condition, participant, value))
        thresholds[condition][participant].append(math.nan if isinstance(value, str) else value)
    for condition, by in thresholds.items():
        found["threshold", condition] = {who: _mean(values) for who, values in by.items()}
    for condition, participant, value in tlx_scores(answers, names):
        found["tlx", condition][participant] = value
    return Measures(dict(found), missing, profiles)


def rows_of(answers: Answers) -> dict[tuple[str, Condition], list[Row]]:
    """Return the main and catch trials of each participant in each condition."""
    names = conditions_of(answers.study)
    parts: dict[tuple[str, Condition], list[Row]] = defaultdict(list)
    for row in answers.rows():
        if row["phase"] in ("main", "catch"):
            parts[row["participant"], condition_of(row, names)].append(row)
    return parts


def _lapse_profiles(
    study: Mapping[str, Any], parts: Mapping[tuple[str, Condition], list[Row]]
) -> dict[Condition, LapseProfiles]:
    """Return the fits of each condition of a compare task, none of other tasks."""
    tables: dict[Condition, dict[str, Any]] = defaultdict(dict)
    for (participant, condition), rows in parts.items():
        if study["task"]["name"] == "compare":
            table = level_counts(study, [row for row in rows if row["phase"] == "main"])
            if len(table[0]) >= MIN_LEVELS:
                tables[condition][participant] = table
    return {condition: fit_lapse_profiles(own) for condition, own in tables.items()}


def _task_measures(
    study: Mapping[str, Any], rows: list[Row], fitted: Psychometric | None
) -> Mapping[str, float | str]:
    """Return the measures of one participant; a text says why a measure is missing."""
    main = [row for row in rows if row["phase"] == "main"]
    catch = [row for row in rows if row["phase"] == "catch"]
    task = study["task"]["name"]
    if task == "identify":
        return _identify_measures(study["task"]["choices"], rows)
    if task == "locate":
        off = [row["error"] for row in main if row["error"] is not None]
        values = {
            "location_error": _mean(np.abs(off)),
            "location_bias": _mean(off),
            "found": _mean([abs(o) <= FOUND_TOLERANCE for o in off]) * len(off) / max(len(main), 1),
        }
        return values | ({"false_alarms": 1.0 - _accuracy(catch)} if catch else {})
    if task == "search":
        off = [row["error"] for row in main]
        values = {"hits": _mean([one is not None and abs(one) <= FOUND_TOLERANCE for one in off])}
        for name, column in (("time", "time_s"), ("path", "path"), ("returns", "returns")):
            values[name] = _mean([row[column] for row in main if row.get(column) is not None])
        return values | ({"false_alarms": 1.0 - _accuracy(catch)} if catch else {})
    if task == "count":
        off = [row["error"] for row in main if row["error"] is not None]
        values = {"exact": _accuracy(main), "count_error": _mean(np.abs(off))}
        return values | ({"false_alarms": 1.0 - _accuracy(catch)} if catch else {})
    if task == "compare":
        return _compare_measures(study, main, fitted)
    if task == "draw":
        found = [likeness(r["response"], study["stimuli"][r["stimulus"]]) for r in main]
        return {
            "likeness": _mean([one for one in found if one is not None]),
            "drawn_error": _mean([row["error"] for row in main if row["error"] is not None]),
        }
    if task == "adjust":
        scale = scale_of(study)
        standard = scale.position(study["task"]["standard"])
        known = [scale.position(row["response"]) for row in main
                 if row["response"] in scale.levels]  # fmt: skip
        ends = sorted(map(scale.position, scale.levels))
        for limit, name in ((ends[0], "lowest"), (ends[-1], "highest")):
            # a match beyond this level would have the same answers
            if known.count(limit) > SHARE_AT_LIMIT * len(known):
                reason = f"{known.count(limit)} of {len(known)} answers are at the {name} level"
                return {"adjusted": reason}
        return {"adjusted": _mean([position - standard for position in known])}
    if study["task"]["method"] == "yesno" and catch:
        return {"accuracy": _accuracy(main), "false_alarms": 1.0 - _accuracy(catch)}
    return {"accuracy": _accuracy(main)}


def _identify_measures(choices: Sequence[str], rows: list[Row]) -> dict[str, float]:
    """Return accuracy over all trials, and d' and c of each choice against the others."""
    table = confusion(choices, rows)
    values = {"accuracy": _accuracy(rows)}
    totals, answered = table.sum(axis=1), table.sum(axis=0)
    for i, choice in enumerate(choices):
        others = totals.sum() - totals[i]
        # "none" is the noise of the other choices, not a signal
        if choice == "none" or not totals[i] or not others:
            continue
        d, c = sensitivity(table[i, i], totals[i], answered[i] - table[i, i], others)
        values[f"d_prime.{choice}"], values[f"criterion.{choice}"] = d, c
    sensitivities = [value for name, value in values.items() if name.startswith("d_prime.")]
    if sensitivities:
        values["d_prime"] = _mean(sensitivities)
        values["criterion"] = _mean([v for n, v in values.items() if n.startswith("criterion.")])
    return values


def confusion(choices: Sequence[str], rows: Iterable[Row]) -> NDArray[np.float64]:
    """Return the confusion counts: presented answer (rows) by given answer (columns)."""
    table = np.zeros((len(choices), len(choices)))
    for row in rows:
        if row["response"] in choices and row["correct_response"] in choices:
            table[choices.index(row["correct_response"]), choices.index(row["response"])] += 1
    return table


def level_counts(
    study: Mapping[str, Any], rows: Iterable[Row]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return positions of levels, counts of an answer, and trials.

    In a compare task, each level is counted when judged stronger, in others when correct.
    """
    scale, compared = scale_of(study), study["task"]["name"] == "compare"
    counts: dict[float, list[int]] = defaultdict(lambda: [0, 0])
    for row in rows:
        keys = row["stimulus"].split()
        place = next((i for i, key in enumerate(keys)
                      if study["stimuli"][key]["level"] == row["level"]), 0)  # fmt: skip
        count = counts[scale.position(row["level"])]
        count[0] += int(row["response"] == place if compared else row["correct"])
        count[1] += 1
    levels = np.array(sorted(counts))
    both = np.array([counts[level] for level in levels], dtype=np.float64).reshape(-1, 2)
    return levels, both[:, 0], both[:, 1]


def _compare_measures(
    study: Mapping[str, Any], rows: list[Row], fitted: Psychometric | None
) -> dict[str, float | str]:
    right = sum(row["correct"] == 1 for row in rows)
    values: dict[str, float | str] = {
        "accuracy": right / len(rows),
        "d_prime": sensitivity_2afc(right, len(rows)),
    }
    if fitted is not None:
        levels = level_counts(study, rows)[0]
        values["pse"], values["jnd"] = fitted.threshold, JND_PER_WIDTH * fitted.width
        values["lapse"] = fitted.lapse
        if not levels[0] <= fitted.threshold <= levels[-1]:
            values["pse"] = values["jnd"] = "the fitted level is outside of the compared levels"
        elif not fitted.has_slope:
            values["jnd"] = "the answers change between two levels, or hardly at all"
    return values


def _thresholds(
    answers: Answers, names: Sequence[str]
) -> Iterable[tuple[Condition, str, float | str]]:
    """Yield the threshold of each adaptive run, or why there is none."""
    scale, standard = scale_of(answers.study), answers.study["task"]["standard"]
    for session in answers.sessions:
        content = answers.lists[session.number]
        responses = {trial: row for trial, _, row in session.trials}
        for step in content["steps"]:
            if step["type"] == "adaptive":
                levels = {**content["factors"], **step["factors"]}
                value = run_threshold(scale, step, responses, standard)
                yield condition_of(levels, names), session.participant, value


def tlx_scores(answers: Answers, names: Sequence[str]) -> Iterable[tuple[Condition, str, float]]:
    """Yield the raw TLX of each form, the mean of its six scales."""
    items: dict[tuple[str, int, Condition], list[float]] = defaultdict(list)
    for row in answers.forms():
        if row["form"] == "tlx" and isinstance(row["value"], int | float):
            known = tuple((name, row[name]) for name in names if name in row)
            items[row["participant"], row["block"], known].append(float(row["value"]))
    for (participant, _, condition), values in items.items():
        yield condition, participant, _mean(values)


def _accuracy(rows: Sequence[Row]) -> float:
    return _mean([row["correct"] for row in rows if row["correct"] is not None])


def _mean(values: Any) -> float:
    return float(np.mean(values)) if len(values) else math.nan
