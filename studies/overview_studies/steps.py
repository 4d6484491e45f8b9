"""Steps of a list, and the ids of their answers."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import Any

ANSWERED = ("trial", "form", "adaptive")
"""Types of steps that have answers."""

MAX_PRACTICE_ROUNDS = 3
"""Maximum number of practice rounds."""

_MORE = re.compile(r"(.+)-(\d{1,3})")


def answered_steps(content: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the steps of a list that have answers, by id."""
    return {step["id"]: step for step in content["steps"] if step["type"] in ANSWERED}


def find_step(trial: str, content: dict[str, Any]) -> dict[str, Any] | None:
    """Return the step of a list for a trial's id; None if there is none."""
    return find_among(trial, answered_steps(content))


def find_among(trial: str, steps: Mapping[str, dict[str, Any]]) -> dict[str, Any] | None:
    """Return the step of a trial's id among those of `answered_steps`; None if there is none."""
    if trial in steps and steps[trial]["type"] != "adaptive":
        return steps[trial]
    more = _MORE.fullmatch(trial)
    if more is None or more[1] not in steps:
        return None
    step, number = steps[more[1]], int(more[2])
    if step["type"] == "adaptive":
        return step if 1 <= number <= step["most"] else None
    repeated = step["type"] == "trial" and step["phase"] == "practice"
    return step if repeated and 2 <= number <= MAX_PRACTICE_ROUNDS else None


def missing_steps(content: dict[str, Any], stored: Collection[str]) -> list[str]:
    """Return the ids of required steps without a stored answer."""
    begun = {trial.rpartition("-")[0] for trial in stored}
    return [
        step["id"]
        for step in content["steps"]
        if step["type"] in ANSWERED
        and step.get("phase") != "practice"
        and step["id"] not in (begun if step["type"] == "adaptive" else stored)
    ]
