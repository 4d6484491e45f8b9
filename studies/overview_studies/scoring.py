"""Whether an answer is right, and how far off it is: found here again, whatever a page said."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def is_right(task: str, step: dict[str, Any], row: dict[str, Any]) -> bool | None:
    """Whether an answer is right; None where there is no such thing.

    Parameters
    ----------
    task
        What was asked.
    step
        The step of the list.
    row
        What was answered; of an adaptive trial with its `trial_index`, from 0.
    """
    response = row.get("response")
    if step["type"] == "adaptive":
        index = row["trial_index"]
        wanted = step["sides"][index] if step["method"] == "2afc" else int(not step["catch"][index])
        return bool(response == wanted)
    if task in ("draw", "adjust"):
        return None
    if task == "locate":
        if not step["correct"]:
            return response is None
        return None
    if step["correct"] is None:
        return None
    return bool(response == step["correct"])


def error_of(
    task: str, step: dict[str, Any], row: dict[str, Any], stimulus: dict[str, Any]
) -> float | None:
    """How far an answer is off, with its sign; None where there is no such thing.

    locate: parts of the timeline from the nearest event that was asked for. count: how many too
    many. adjust: in the varied dimension's unit. draw: root mean square of the difference, 0 to 1.
    """
    response = row.get("response")
    if task == "locate" and step["correct"] and _is_number(response):
        return float(min((response - place for place in step["correct"]), key=abs))
    if task in ("count", "adjust") and _is_number(response) and _is_number(step["correct"]):
        return float(response - step["correct"])
    if task == "draw":
        both = _drawn(response, stimulus)
        if both is None:
            return None
        drawn, curve = both
        return float(np.sqrt(np.mean(np.square(drawn - curve))))
    return None


def likeness(response: Any, stimulus: dict[str, Any]) -> float | None:
    """How alike a drawing and the curve are: Pearson's r; None for a flat one."""
    both = _drawn(response, stimulus)
    if both is None or min(np.ptp(part) for part in both) == 0.0:
        return None
    return float(np.corrcoef(*both)[0, 1])


def _drawn(response: Any, stimulus: dict[str, Any]) -> tuple[Any, Any] | None:
    """The drawing and the curve, where something was drawn; None if that is less than two."""
    curve = stimulus["curve"]
    if not isinstance(response, list) or curve is None or len(response) != len(curve):
        return None
    there = [i for i, value in enumerate(response) if _is_number(value)]
    if len(there) < 2:
        return None
    return np.array([response[i] for i in there]), np.array([curve[i] for i in there])


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
