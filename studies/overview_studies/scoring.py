"""Correctness and error of answers, computed independently of the page."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def is_correct(task: str, step: dict[str, Any], row: dict[str, Any]) -> bool | None:
    """Return whether an answer is correct; None if the task has no correct answer.

    Parameters
    ----------
    task
        Name of the task.
    step
        Step of the list.
    row
        The answer; for an adaptive trial with its `trial_index`, from 0.
    """
    response = row.get("response")
    if step["type"] == "adaptive":
        index = row["trial_index"]
        wanted = step["sides"][index] if step["method"] == "2afc" else int(not step["catch"][index])
        return bool(response == wanted)
    if task in ("draw", "adjust"):
        return None
    if task in ("locate", "search"):
        if not step["correct"]:
            return response is None
        return None
    if step["correct"] is None:
        return None
    return bool(response == step["correct"])


def response_error(
    task: str, step: dict[str, Any], row: dict[str, Any], stimulus: dict[str, Any]
) -> float | None:
    """Return the signed error of an answer; None if the task has none.

    locate: distance to the nearest event, as a share of the timeline. count: difference of
    the counts. adjust: difference in the unit of the varied dimension. draw: root mean square of
    the difference, 0 to 1.
    """
    response = row.get("response")
    if task in ("locate", "search") and step["correct"] and _is_number(response):
        return float(min((response - position for position in step["correct"]), key=abs))
    if task in ("count", "adjust") and _is_number(response) and _is_number(step["correct"]):
        return float(response - step["correct"])
    if task == "draw":
        both = _drawing_and_curve(response, stimulus)
        if both is None:
            return None
        drawn, curve = both
        return float(np.sqrt(np.mean(np.square(drawn - curve))))
    return None


def search_path(take: dict[str, Any] | None, target: float, tolerance: float) -> dict[str, float]:
    """Return the movement of a search: `time_s` from touch to end, `path` and `returns`.

    Parameters
    ----------
    take
        The take of a trial.
    target
        Position of the event that was searched.
    tolerance
        Largest distance from the target, as a share of the timeline.

    Returns
    -------
    dict
        Seconds, the length of the movement in timelines, and how often it came back to the place.
    """
    touched = [event for event in (take or {}).get("events", ()) if event[2]]
    if take is None or len(touched) < 2:
        return {}
    position = np.array([event[1] for event in touched]) / math.pi
    path = float(np.abs(np.diff(position)).sum())
    # a fast movement may pass the place between two events
    side = np.where(np.abs(position - target) <= tolerance, 0.0, np.sign(position - target))
    visits = int(((side[1:] == 0.0) & (side[:-1] != 0.0)).sum() + (side[0] == 0.0))
    visits += int((side[1:] * side[:-1] < 0.0).sum())
    seconds = (touched[-1][0] - touched[0][0]) / take["sample_rate"]
    return {"time_s": float(seconds), "path": path, "returns": float(max(visits - 1, 0))}


def likeness(response: Any, stimulus: dict[str, Any]) -> float | None:
    """Return Pearson's r of a drawing and the curve; None if either is constant."""
    both = _drawing_and_curve(response, stimulus)
    if both is None or min(np.ptp(part) for part in both) == 0.0:
        return None
    return float(np.corrcoef(*both)[0, 1])


def _drawing_and_curve(response: Any, stimulus: dict[str, Any]) -> tuple[Any, Any] | None:
    """Return drawing and curve at the drawn points; None with fewer than two points."""
    curve = stimulus["curve"]
    if not isinstance(response, list) or curve is None or len(response) != len(curve):
        return None
    drawn = [i for i, value in enumerate(response) if _is_number(value)]
    if len(drawn) < 2:
        return None
    return np.array([response[i] for i in drawn]), np.array([curve[i] for i in drawn])


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
