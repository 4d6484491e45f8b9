"""Power of a study, from many simulations with the same analysis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from overview_studies.analysis import analyse, condition_text
from overview_studies.observers import Observers, simulate_answers
from overview_studies.scripts import MAIN_MEASURES

SEED_STEP = 1_000_003
"""Difference between the seeds of successive runs."""


def estimate_power(
    study: dict[str, Any],
    lists: Mapping[int, dict[str, Any]],
    observers: Observers,
    participants: int,
    runs: int,
    seed: int,
    progress: Callable[[float], None] | None = None,
) -> dict[str, Any]:
    """Count the runs in which each difference is significant and each interval covers d'.

    Coverage is reported only for two choices without lapses, where the true d' is known.
    """
    main = MAIN_MEASURES[study["task"]["name"]]
    found: dict[str, int] = {}
    covered: dict[str, int] = {}
    known = main == "d_prime" and len(study["task"]["choices"]) == 2 and not observers.lapse
    for run in range(runs):
        answers = simulate_answers(study, lists, observers, participants, seed + SEED_STEP * run)
        analysis = analyse(answers)
        for line in analysis.differences:
            if line.measure == main:
                name = condition_text(line.condition)
                one = line.estimate
                found[name] = found.get(name, 0) + (one.low > 0.0 or one.high < 0.0)
        for line in analysis.estimates:
            if known and line.measure == main:
                truth = observers.ability(0.0, dict(line.condition))
                name = condition_text(line.condition)
                covered[name] = covered.get(name, 0) + (
                    line.estimate.low <= truth <= line.estimate.high
                )
        if progress is not None:
            progress((run + 1) / runs)
    return {
        "measure": main,
        "participants": participants,
        "runs": runs,
        "found": found,
        "held": covered,
        "d_prime": observers.d_prime,
    }


def power_lines(found: Mapping[str, Any]) -> list[str]:
    """Return a text summary of `estimate_power`."""
    runs = found["runs"]
    lines = [f"{found['participants']} observers with a d' of {found['d_prime']:g}, {runs} runs"]
    lines += [
        f"{found['measure']}, {name}: the 95 % interval excludes 0 in {count} of {runs} runs"
        for name, count in found["found"].items()
    ]
    lines += [
        f"{found['measure']}, {name}: the 95 % interval contains the true value in "
        f"{count} of {runs} runs"
        for name, count in found["held"].items()
    ]
    return lines
