"""Power: the whole study with simulated observers, many times over, through the same analysis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from overview_studies.analysis import analyse, shown
from overview_studies.figures import MAIN
from overview_studies.observers import Observers, simulated

RUN_SEEDS = 1_000_003
"""From one run's seed to the next."""


def power_of(
    study: dict[str, Any],
    lists: Mapping[int, dict[str, Any]],
    observers: Observers,
    people: int,
    runs: int,
    seed: int,
    progress: Callable[[float], None] | None = None,
) -> dict[str, Any]:
    """How often each difference's interval leaves out 0; and how often that of d' holds the truth.

    The latter is only known where two answers are told apart: one d' is all there is then, and
    observers don't lapse.
    """
    main = MAIN[study["task"]["name"]]
    found: dict[str, int] = {}
    held: dict[str, int] = {}
    known = main == "d_prime" and len(study["task"]["choices"]) == 2 and not observers.lapse
    for run in range(runs):
        answers = simulated(study, lists, observers, people, seed + RUN_SEEDS * run)
        analysis = analyse(answers)
        for line in analysis.differences:
            if line.measure == main:
                name = shown(line.condition)
                one = line.estimate
                found[name] = found.get(name, 0) + (one.low > 0.0 or one.high < 0.0)
        for line in analysis.lines:
            if known and line.measure == main:
                truth = observers.ability(0.0, dict(line.condition))
                name = shown(line.condition)
                held[name] = held.get(name, 0) + (line.estimate.low <= truth <= line.estimate.high)
        if progress is not None:
            progress((run + 1) / runs)
    return {
        "measure": main,
        "participants": people,
        "runs": runs,
        "found": found,
        "held": held,
        "d_prime": observers.d_prime,
    }


def power_lines(found: Mapping[str, Any]) -> list[str]:
    """For a person."""
    runs = found["runs"]
    lines = [f"{found['participants']} observers with a d' of {found['d_prime']:g}, {runs} runs"]
    lines += [
        f"{found['measure']}, {name}: the 95 % interval leaves out 0 in {count} of {runs} runs"
        for name, count in found["found"].items()
    ]
    lines += [
        f"{found['measure']}, {name}: the 95 % interval holds the truth in {count} of {runs} runs"
        for name, count in found["held"].items()
    ]
    return lines
