"""Many simulated studies of each task: coverage of intervals, bias, and flags of floor and ceiling.

The gate has 20 studies for each task and `.ci/soak` 2,000; OVERVIEW_SOAK_STUDIES sets another
number. `pytest -n 0 -m soak -s studies/tests/test_simulated_studies.py` prints the figures.
"""

from __future__ import annotations

import math
import os
import re
from collections import Counter
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from scipy.special import ndtr, ndtri
from scipy.stats import binom, norm, pearsonr

from overview_studies.analysis import analyse
from overview_studies.measures import compute_measures
from overview_studies.observers import SEARCH_PASSES, Observers, simulate_answers
from overview_studies.scales import scale_of
from studies.tests.files import study_of
from studies.tests.test_examples import EXAMPLES

PEOPLE = 12
GATE, SOAK = 20, int(os.environ.get("OVERVIEW_SOAK_STUDIES", "2000"))
RUNS = [GATE, pytest.param(SOAK, marks=pytest.mark.soak)]
COVERAGE = 0.92, 0.98
MAX_BIAS = 0.05
"""Largest bias, in JNDs."""

MOST_WRONG = 0.05
"""Largest share of false alarms, and of misses, of the flags of floor and ceiling."""

CHANCE = 1e-3
"""Chance that a gate of 20 studies fails although the limit is kept."""

SPREAD = 0.1
"""Standard deviation of sensitivity between observers, relative to its mean."""

NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(15)


def mean_over_observers(function, d):
    """Mean of a function of d' over observers whose d' is normal."""
    values = np.array([function(d * (1.0 + SPREAD * node)) for node in NODES])
    return float(WEIGHTS @ values / WEIGHTS.sum())


@dataclass(frozen=True)
class Truth:
    """What a measure estimates, on the scale of the levels, and how large a JND of it is."""

    value: float
    jnd: float


def right_of(choices, d):
    """Part of right answers of an observer who chooses the largest of some normal numbers."""
    x = np.linspace(-8.0, 8.0, 4001)
    return float(np.trapezoid(norm.pdf(x - d / math.sqrt(2.0)) * ndtr(x) ** (choices - 1), x))


def identified(study, lists, d):
    count = len(study["task"]["choices"])

    def own(ability):
        right = right_of(count, ability)
        return ndtri(right) - ndtri((1.0 - right) / (count - 1))

    accuracy = mean_over_observers(lambda one: right_of(count, one), d)
    slope = mean_over_observers(lambda one: right_of(count, one + 0.5), d) - mean_over_observers(
        lambda one: right_of(count, one - 0.5), d
    )
    return {
        "d_prime": Truth(mean_over_observers(own, d), 1.0),
        "accuracy": Truth(accuracy, slope),
    }


def step_of(study):
    scale = scale_of(study)
    return float(np.diff(sorted(map(scale.position, scale.levels))).mean())


def compared(study, lists, d):
    standard = scale_of(study).position(study["task"]["standard"])
    jnd = mean_over_observers(lambda one: ndtri(0.75) * math.sqrt(2.0) / one, d) * step_of(study)
    return {"pse": Truth(standard, jnd), "jnd": Truth(jnd, jnd)}


def adjusted(study, lists, d):
    return {"adjusted": Truth(0.0, ndtri(0.75) * math.sqrt(2.0) / d * step_of(study))}


def steps_at_threshold(study, d):
    """Steps from the standard, or from no stimulus, at which the target is reached."""
    share = math.sqrt(0.5) if study["task"]["name"] == "staircase" else 0.75
    if study["task"]["method"] == "2afc":
        return math.sqrt(2.0) * ndtri(share) / d
    return (1.0 + ndtri(share if study["task"]["name"] == "staircase" else 0.5)) / d


def threshold(study, lists, d):
    scale, step = scale_of(study), step_of(study)
    lowest = min(map(scale.position, scale.levels))
    below = 0.0 if study["task"]["method"] == "2afc" else 1.0
    steps = mean_over_observers(lambda one: steps_at_threshold(study, one), d)
    return {"threshold": Truth(lowest + step * (steps - below), step * steps)}


def searched(study, lists, d):
    places = [step["correct"][0] for one in lists.values() for step in one["steps"]
              if step.get("task") == "search" and step["phase"] == "main"]  # fmt: skip
    z = np.linspace(-5.0, 5.0, 401)

    def passes(ability):
        missed = 1.0 - float(ndtr(ability / 2.0))
        chances = [missed**i * (1.0 - missed) for i in range(SEARCH_PASSES - 1)]
        return np.array([*chances, 1.0 - sum(chances)])

    def path(ability):
        last = np.clip(np.array(places)[:, None] + 0.1 * z / ability, 0.0, 1.0)
        mean = float((last @ norm.pdf(z)).mean() / norm.pdf(z).sum())
        way = [i + (1.0 - mean if i % 2 else mean) for i in range(1, SEARCH_PASSES + 1)]
        return float(passes(ability) @ way)

    def count(ability):
        return float(passes(ability) @ np.arange(1.0, SEARCH_PASSES + 1.0))

    def of(function):
        return Truth(mean_over_observers(function, d), mean_over_observers(function, d))

    return {
        "hits": Truth(
            mean_over_observers(lambda one: 2.0 * ndtr(0.5 * one) - 1.0, d), norm.pdf(0.5 * d)
        ),
        # each pass has 20 samples, 0.1 s apart
        "time": of(lambda one: 2.0 * (count(one) + 1.0) - 0.1),
        "path": of(path),
        # the last movement returns to the place unless it ends before it
        "returns": of(lambda one: count(one) - 1.0 + float(ndtr(0.5 * one))),
    }


def jnd_of(spread, d):
    """JND of a quantity that is perceived with a standard deviation of `spread` over d'."""
    return ndtri(0.75) * math.sqrt(2.0) * spread / d


def per_d_prime(function, d):
    return mean_over_observers(lambda one: function(one + 0.5) - function(one - 0.5), d)


def main_trials(study, lists):
    """Stimulus and right answer of each main trial of a participant; equal for all."""
    steps = [one for one in lists[1]["steps"] if one.get("phase") == "main"]
    return [(study["stimuli"][one["stimuli"][0]], one["correct"]) for one in steps]


def located(study, lists, d):
    places = np.array([places for _, places in main_trials(study, lists)])
    z = np.linspace(-6.0, 6.0, 2401)
    density = norm.pdf(z) / norm.pdf(z).sum()

    def of(function):
        def mean(ability):
            off = np.clip(places + 0.1 * z / ability, 0.0, 1.0) - places
            return float((function(off) @ density).mean())

        return mean_over_observers(mean, d)

    near = mean_over_observers(lambda one: 2.0 * ndtr(0.5 * one) - 1.0, d)
    alarms = mean_over_observers(lambda one: ndtr(-0.5 * one), d)
    return {
        "location_error": Truth(of(np.abs), jnd_of(0.1, d)),
        "location_bias": Truth(of(np.positive), jnd_of(0.1, d)),
        "found": Truth(near, norm.pdf(0.5 * d)),
        "false_alarms": Truth(alarms, 0.5 * norm.pdf(0.5 * d)),
    }


def counted(study, lists, d):
    counts = np.array([count for _, count in main_trials(study, lists)])
    said = np.arange(60)[:, None]

    def of(values):
        def mean(ability):
            below = ndtr((said - 0.5 - counts) * ability / (0.3 * counts))
            below[0] = 0.0
            return float((np.diff(below, axis=0, append=1.0) * values).sum(axis=0).mean())

        return mean

    exact, off = of(said == counts), of(np.abs(said - counts))
    alarms = mean_over_observers(lambda one: ndtr(-one), d)
    return {
        "exact": Truth(mean_over_observers(exact, d), per_d_prime(exact, d)),
        "count_error": Truth(mean_over_observers(off, d), jnd_of(0.3 * counts.mean(), d)),
        "false_alarms": Truth(alarms, norm.pdf(d)),
    }


def drawn(study, lists, d):
    curves = {tuple(stimulus["curve"]) for stimulus, _ in main_trials(study, lists)}
    noise = np.random.default_rng(1).standard_normal((1000, len(min(curves))))

    def drawings(ability):
        for one in map(np.array, curves):
            yield np.clip(one + 0.3 / ability * noise, 0.0, 1.0), one

    def error(ability):
        return np.mean(
            [np.sqrt(np.square(own - one).mean(axis=1)) for own, one in drawings(ability)]
        )

    def likeness(ability):
        return np.mean(
            [pearsonr(own, one[None], axis=1).statistic for own, one in drawings(ability)]
        )

    return {
        "likeness": Truth(mean_over_observers(likeness, d), per_d_prime(likeness, d)),
        "drawn_error": Truth(mean_over_observers(error, d), jnd_of(0.3, d)),
    }


YESNO = {
    "standard = -18.0": 'method = "yesno"',
    "[questionnaires]": "[phases]\ncatch = 0.2\n[questionnaires]",
}
AT_LIMIT = "adjust, standard at the lowest level"
RATIOS = ", ".join(f"{2.0 * 2.0 ** (i / 2.0):.6g}" for i in range(13))
GAINS = ", ".join(f"{-18.0 + 0.5 * i}" for i in range(13))
LOG_ADAPTIVE = {
    "standard = -18.0": "standard = 2.0",
    '"tactor.gain_db" = [': '"kinds.goal.height" = [',
    'vary = "tactor.gain_db"': 'vary = "kinds.goal.height"',
    GAINS: RATIOS,
}
LOG = {
    "standard = -9.0": "standard = 16.0",
    '"tactor.gain_db" = [': '"kinds.goal.height" = [',
    'vary = "tactor.gain_db"': 'vary = "kinds.goal.height"',
    "-15.0, -13.0, -11.0, -9.0, -7.0, -5.0, -3.0": "2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0",
}
KINDS = 'made = { kinds = ["goal", "foul", "yellow_card"], variants = 2 }'
LOCATE = {
    'name = "identify"': 'name = "locate"',
    KINDS: 'made = { kinds = ["goal"], variants = 6 }',
    "attention = 1": "catch = 0.25",
}
COUNT = {
    'name = "identify"': 'name = "count"',
    KINDS: 'made = { kinds = ["goal"], counts = [1, 2, 4], variants = 2 }',
    "attention = 1": "catch = 0.25",
}
DRAW = {
    'name = "identify"': 'name = "draw"',
    KINDS: 'made = { curves = ["rise", "fall", "peak", "dip", "wave"] }',
    "attention = 1": "",
}
CASES = {  # example, what is replaced in it, d' (for levels, of a mean step) and what is true
    "identify": ("identify", {}, 1.5, identified),
    "detect": ("detect", {}, 1.5, identified),
    "locate": ("identify", LOCATE, 1.5, located),
    "count": ("identify", COUNT, 1.5, counted),
    "draw": ("identify", DRAW, 1.5, drawn),
    "compare": ("compare", {}, 1.2, compared),
    "compare, log": ("compare", LOG, 1.2, compared),
    "adjust": ("adjust", {}, 1.0, adjusted),
    "adjust, log": ("adjust", LOG, 1.0, adjusted),
    "staircase": ("staircase", {}, 0.22, threshold),
    "staircase, log": ("staircase", LOG_ADAPTIVE, 0.22, threshold),
    "staircase, yesno": ("staircase", YESNO, 0.3, threshold),
    AT_LIMIT: ("adjust", {"standard = -9.0": "standard = -15.0"}, 2.0, adjusted),
    "quest": ("quest", {}, 0.22, threshold),
    "quest, log": ("quest", LOG_ADAPTIVE, 0.22, threshold),
    "quest, yesno": ("quest", YESNO, 0.22, threshold),
    "search": ("search", {}, 1.5, searched),
}


@cache
def drafted(name):
    example, replaced, _, _ = CASES[name]
    text = (EXAMPLES / example / "study.toml").read_text()
    for line, replacement in replaced.items():
        assert text.count(line) == 1, line
        text = text.replace(line, replacement)
    with TemporaryDirectory() as folder:
        return study_of(Path(folder), text)


def at_most(share, runs):
    """Largest number of runs that a share of at most this allows; exact for a soak."""
    return share * runs if runs >= SOAK else binom.isf(CHANCE, runs, share)


def simulated(name, runs):
    """Coverage and errors of each measure with a known value, and what has no estimate."""
    study, lists = drafted(name)
    _, _, d, true_of = CASES[name]
    truths, scale = true_of(study, lists, d), scale_of(study)
    held, errors, none, missing = Counter(), {}, Counter(), 0
    for run in range(runs):
        found = analyse(simulate_answers(study, lists, Observers(d, SPREAD * d), PEOPLE, run))
        missing += len(found.missing)
        lines = [(line, False) for line in found.estimates]
        lines += [(line, True) for line in found.differences]
        for line, is_difference in lines:
            if line.measure not in truths:
                continue
            key = line.measure, line.condition
            one, truth = line.estimate, truths[line.measure]
            value = 0.0 if is_difference else truth.value
            on_axis = line.measure in ("pse", "jnd", "threshold", "adjusted")
            ends = [scale.axis_position(x) if on_axis and math.isfinite(x) else x
                    for x in (one.low, one.mean, one.high)]  # fmt: skip
            none[key] += not all(map(math.isfinite, ends))
            held[key] += ends[0] <= value <= ends[2]
            errors.setdefault(key, []).append((ends[1] - value) / truth.jnd)
    return held, errors, none, missing / (runs * PEOPLE)


@pytest.mark.parametrize("runs", RUNS)
@pytest.mark.parametrize("name", [name for name in CASES if name != AT_LIMIT])
def test_intervals_contain_what_is_true_of_the_observers_and_means_have_no_bias(name, runs):
    held, errors, none, missing = simulated(name, runs)
    wrong = []
    for (measure, condition), own in errors.items():
        known = np.array(own)[np.isfinite(own)]
        bias, error = float(known.mean()), float(known.std() / math.sqrt(len(known)))
        count = held[measure, condition]
        where = " ".join(f"{key} {level}" for key, level in condition)
        line = (f"{name}: {measure} {where}: {count} of {runs} intervals contain the true value, "
                f"bias {bias:+.4f} JND (standard error {error:.4f}), no estimate in "
                f"{none[measure, condition]}, without a number {missing:.4f}")  # fmt: skip
        print(line)
        outside = count < runs - at_most(1.0 - COVERAGE[0], runs)
        if runs > GATE:
            outside |= count > COVERAGE[1] * runs
        margin = 0.0 if runs > GATE else 3.3 * error
        if outside or abs(bias) > MAX_BIAS + margin:
            wrong.append(line)
    assert errors
    assert not wrong, "\n".join(wrong)


ADAPTIVE = {name: case for name, case in CASES.items() if case[0] in ("staircase", "quest")}
OBSERVERS = {  # weak, average and strong ones as in `study check`; and those at both limits
    "2afc": {"inside": (0.11, 0.22, 0.44), "floor": 2.2},
    "yesno": {"inside": (0.2, 0.3, 0.5), "floor": 2.2},
}


def flagged(name, observers, runs):
    """Share of runs without a threshold, and how often each reason was given."""
    study, lists = drafted(name)
    reasons, count = Counter(), 0
    for seed in range(math.ceil(runs / PEOPLE)):
        found = compute_measures(simulate_answers(study, lists, observers, PEOPLE, seed))
        count += sum(len(by) for (one, _), by in found.values.items()
                     if one in ("threshold", "adjusted"))  # fmt: skip
        reasons.update(re.sub(r"\d+", "N", one.reason) for one in found.missing)
    return sum(reasons.values()), count, reasons


@pytest.mark.parametrize("runs", RUNS)
@pytest.mark.parametrize("name", ADAPTIVE)
def test_a_run_is_flagged_at_floor_and_ceiling_and_not_between(name, runs):
    observers = OBSERVERS["yesno" if "yesno" in name else "2afc"]
    cases = {f"d' of {d:g}": (Observers(d), False) for d in observers["inside"]}
    cases["feels the lowest level"] = Observers(observers["floor"]), True
    cases["guesses"] = Observers(1.0, lapse=1.0), True
    wrong = []
    for who, (ability, is_limit) in cases.items():
        count, total, reasons = flagged(name, ability, runs)
        mistakes = total - count if is_limit else count
        kind = "misses" if is_limit else "false alarms"
        line = f"{name}: {who}: {mistakes} {kind} of {total} runs {dict(reasons)}"
        print(line)
        if mistakes > at_most(MOST_WRONG, total):
            wrong.append(line)
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("runs", RUNS)
def test_adjustments_are_flagged_at_the_end_of_the_levels_and_not_between(runs):
    wrong = []
    for name, d in (("adjust", 0.5), ("adjust", 1.0), ("adjust", 2.0), (AT_LIMIT, 2.0)):
        count, total, _ = flagged(name, Observers(d), runs)
        mistakes = total - count if name == AT_LIMIT else count
        print(f"{name}: d' of {d:g}: {mistakes} wrong of {total}")
        if mistakes > at_most(MOST_WRONG, total):
            wrong.append((name, d, mistakes, total))
    assert not wrong
