"""The steps of a list, and the ids of their answers."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Any

ANSWERED = ("trial", "form", "adaptive")
"""Types of steps that are answered."""

MOST_PRACTICE = 3
"""Practice is done so often at most."""

_MORE = re.compile(r"(.+)-(\d{1,3})")


def step_of(trial: str, content: dict[str, Any]) -> dict[str, Any] | None:
    """The step of a list that a trial's id belongs to; None if there is none."""
    steps: dict[str, dict[str, Any]] = {
        step["id"]: step for step in content["steps"] if step["type"] in ANSWERED
    }
    if trial in steps and steps[trial]["type"] != "adaptive":
        return steps[trial]
    more = _MORE.fullmatch(trial)
    if more is None or more[1] not in steps:
        return None
    step, number = steps[more[1]], int(more[2])
    if step["type"] == "adaptive":
        return step if 1 <= number <= step["most"] else None
    repeated = step["type"] == "trial" and step["phase"] == "practice"
    return step if repeated and 2 <= number <= MOST_PRACTICE else None


def missing_of(content: dict[str, Any], stored: Collection[str]) -> list[str]:
    """The ids of steps that a finished session must have and that aren't stored."""
    begun = {trial.rpartition("-")[0] for trial in stored}
    return [
        step["id"]
        for step in content["steps"]
        if step["type"] in ANSWERED
        and step.get("phase") != "practice"
        and step["id"] not in (begun if step["type"] == "adaptive" else stored)
    ]
