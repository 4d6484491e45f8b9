"""Checks for answers that no participant can have given, for the server and the analysis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from overview_studies.forms import TLX
from overview_studies.store import SIMULATED

SOURCES = {"touch", "twist", "keys"}
MAX_COUNT = 1000
MAX_RT_MS = 1e10
"""Over 100 days: a page may stay open."""


def impossible(
    study: Mapping[str, Any], step: Mapping[str, Any], row: Mapping[str, Any]
) -> str | None:
    """Return why a row cannot be the answer to a step of a list; None if it can.

    Parameters
    ----------
    study
        Content of study.json.
    step
        A trial, form or adaptive step.
    row
        The answer.
    """
    response = row.get("response")
    if step["type"] == "form":
        return _impossible_form(step["form"], study["forms"][step["form"]], response)
    rt_ms, source = row.get("rt_ms"), row.get("source")
    used = set() if source in (None, SIMULATED) else set(str(source).split("+"))
    if rt_ms is not None and not (_is_number(rt_ms) and 0.0 <= rt_ms <= MAX_RT_MS):
        return f"rt_ms is {rt_ms!r}; must be a time, 0 to {MAX_RT_MS:g} ms"
    if not used <= SOURCES:
        return f"source is {source!r}; must be touch, twist or keys, or several joined by +"
    takes = row.get("takes") or []
    takes = [row.get("take"), *(takes if isinstance(takes, list) else [takes])]
    if not all(one is None or is_take(one) for one in takes):
        return "take must have a sample_rate and events [sample, theta2, touching]"
    if step["type"] == "adaptive":
        key = row.get("stimulus")
        if key is not None and key not in (*step["stimuli"], step["standard"]):
            return f"stimulus is {key!r}, which the step does not have"
        return None if _is_choice(response) else f"response is {response!r}; must be 0 or 1"
    return _impossible_response(study, step, response)


def _impossible_response(
    study: Mapping[str, Any], step: Mapping[str, Any], response: Any
) -> str | None:
    task, points = step["task"], None
    if task == "draw":
        points = len(study["stimuli"][step["stimuli"][0]]["curve"] or ())
    allowed: dict[str, tuple[str, bool]] = {
        "identify": ("one of the choices", response in study["task"].get("choices", ())),
        "locate": ("a place, 0 to 1, or null", response is None or is_part(response)),
        "search": ("a place, 0 to 1, or null", response is None or is_part(response)),
        "count": (
            f"a whole number, 0 to {MAX_COUNT}",
            type(response) is int and 0 <= response <= MAX_COUNT,
        ),
        "compare": ("0 or 1", _is_choice(response)),
        "draw": (
            f"{points} numbers, 0 to 1, or null",
            isinstance(response, list)
            and len(response) == points
            and all(one is None or is_part(one) for one in response),
        ),
        "adjust": ("one of the levels", response in step.get("levels", ())),
    }
    must_be, is_possible = allowed[task]
    return None if is_possible else f"response is {str(response)[:60]!r}; must be {must_be}"


def _impossible_form(name: str, form: Mapping[str, Any], response: Any) -> str | None:
    if not isinstance(response, dict):
        return f"the response of the form {name} must be an object"
    if "version" in form:
        if response.get("agreed") is not True:
            return "the participant does not consent; no answers are stored"
        if response.get("version") != form["version"]:
            return f"the version of the consent must be {form['version']!r}"
    for item in form.get("items", ()):
        value = response.get(item["id"])
        if item["id"] in TLX and not (_is_number(value) and item["min"] <= value <= item["max"]):
            return f"{item['id']} is {value!r}; must be {item['min']} to {item['max']}"
    return None


def is_take(value: Any) -> bool:
    """Return whether a value is a take that can be replayed."""
    events = value.get("events") if isinstance(value, dict) else None
    if not isinstance(events, list):
        return False
    rate = value.get("sample_rate")
    return not events or (
        _is_number(rate)
        and rate > 0.0
        and all(isinstance(one, list) and len(one) > 2 for one in events)
        and _are_numbers([value for one in events for value in one[:3]])
    )


def _are_numbers(values: list[Any]) -> bool:
    if set(map(type, values)) <= {int, float}:
        return all(map(math.isfinite, values))
    return all(map(_is_number, values))


def _is_number(value: Any) -> bool:
    if type(value) is float:
        return math.isfinite(value)
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def is_part(value: Any) -> bool:
    """Return whether a value is a position, 0 to 1."""
    return _is_number(value) and 0.0 <= value <= 1.0


def _is_choice(value: Any) -> bool:
    return type(value) is int and value in (0, 1)
