"""Summary of a study before it starts: lists, trials, minutes, balance and stimulus levels."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

import numpy as np

from overview_dsp.cli.extensions import TACTOR
from overview_studies.design import Design
from overview_studies.dry_run import rehearse
from overview_studies.folder import make_lists, presented_stimuli
from overview_studies.static_mapping import held_levels, static_levels
from overview_studies.stimuli import RATE, Stimulus, stimuli_of
from overview_studies.tables import csv_text

ANSWER_S = 3.0
"""Assumed time to think and answer, for the duration of a trial."""

FREE_S = 6.0
FORM_S = 60.0
_LIST_COLUMNS = ("position", "id", "type", "phase", "block", "repeat", "form", "stimuli", "correct")


def list_name(number: int) -> str:
    """Return the file name of a list."""
    return f"list-{number:03d}.csv"


def list_csv(one: dict[str, Any]) -> str:
    """Return a list as CSV, one row per step."""
    steps = one["steps"]
    names = list(dict.fromkeys(name for step in steps for name in step.get("factors", {})))
    rows = (
        {**step, **step.get("factors", {}), "position": i,
         "stimuli": " ".join(step.get("stimuli", []))}
        for i, step in enumerate(steps, 1)
    )  # fmt: skip
    return csv_text([*_LIST_COLUMNS, *names], rows)


def summarize_design(design: Design, levels: bool = False) -> dict[str, Any]:
    """Return the numbers of a study.

    With `levels`, the levels of the stimuli are measured too; each stimulus is rendered for it.
    """
    items = stimuli_of(design)
    lists = make_lists(design, items)
    by = {item.key: item for item in items}
    minutes = [_minutes(one, by) for one in lists]
    phases: Counter[str] = Counter()
    for step in lists[0]["steps"]:
        if step["type"] == "trial":
            phases[step["phase"]] += 1
        elif step["type"] == "adaptive":
            phases["catch"] += sum(step["catch"])
            phases["main"] += step["most"] - sum(step["catch"])
    orders = Counter(_order(one) for one in lists)
    used = presented_stimuli(lists)
    flaws, completed = rehearse(design)
    found: dict[str, Any] = {
        "title": design.file.title,
        "name": design.name,
        "design_sha256": design.sha256,
        "lists": len(lists),
        "trials": {name: count for name, count in phases.items() if count},
        "minutes": round(float(np.mean(minutes)), 1),
        "stimuli": len(used),
        "orders": len(orders),
        "round": design.lists_per_round,
        "balanced": len(lists) % design.lists_per_round == 0,
        "consent": "consent" in design.file.questionnaires.start,
        "observers": completed,
        "flaws": flaws,
    }
    if levels:
        found["felt_db"] = [_strongest_levels(by[key], "static" in used[key]) for key in used]
    return found


def summary_lines(found: dict[str, Any]) -> list[str]:
    """Return a text summary of `summarize_design`."""
    trials = ", ".join(f"{count} {phase}" for phase, count in found["trials"].items())
    lines = [
        f"{found['title']} ({found['name']}), SHA-256 {found['design_sha256'][:16]}...",
        f"{found['lists']} lists of {trials} trials, about {found['minutes']:g} minutes each",
        f"{found['stimuli']} stimuli; {found['orders']} condition orders",
    ]
    if found["balanced"]:
        lines.append(f"balanced: each round has {found['round']} lists")
    lines.append(f"{found['observers']} observers of 3 abilities have completed it")
    lines += [f"warning: {flaw}" for flaw in found["flaws"]]
    for one in found.get("felt_db", ()):
        levels_text = ", ".join(
            f"{name} {one[name]:.1f} dB" for name in ("friction", "static") if one[name] is not None
        )
        lines.append(f"{one['timeline']}, {one['preset']}: {levels_text or 'no events'}")
    return lines


def _order(one: dict[str, Any]) -> tuple[str, ...]:
    heads = (step for step in one["steps"] if step["type"] == "instructions")
    return tuple(str(sorted(step["factors"].items())) for step in heads)


def _minutes(one: dict[str, Any], by: dict[str, Stimulus]) -> float:
    seconds = 0.0
    for step in one["steps"]:
        if step["type"] == "form":
            seconds += FORM_S
        elif step["type"] in ("trial", "adaptive"):
            stimuli = [by[key] for key in step["stimuli"][:2]]
            played_s = sum(FREE_S if one.free else one.gesture.duration_s for one in stimuli)
            seconds += step.get("most", 1) * (played_s + ANSWER_S)
    return seconds / 60.0


def _strongest_levels(item: Stimulus, static: bool) -> dict[str, Any]:
    """Return the level of a stimulus's strongest event in dB of full scale; None without events."""
    result = item.render_stimulus()
    surface, trace = result.engine.surface, result.trace
    levels, _ = held_levels(surface, trace, result.samples[:, TACTOR], RATE)
    return {
        "timeline": item.names["timeline"],
        "preset": item.names["preset"],
        "friction": _strongest(levels),
        "static": _strongest(static_levels(item, RATE)) if static else None,
    }


def _strongest(levels: Any) -> float | None:
    known = [float(level) for level in levels if math.isfinite(level)]
    return round(max(known), 2) if known else None
