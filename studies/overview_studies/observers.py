"""Simulated observers of known ability: they answer lists as people do, through the same pipeline.

An observer has a sensitivity d'. What that means depends on the task:

========== ========================================================================================
identify   evidence for each choice is normal, with a mean of d'/sqrt(2) for what was given: two
           choices are told apart with exactly d'
compare    neighbouring levels are d' apart
staircase, neighbouring levels are d' apart; of one interval, the lowest is d' above nothing, and
quest      "felt it" is said one standard deviation above nothing
locate     the place is off by a tenth of the timeline, divided by d' (standard deviation)
count      off by 30 %, divided by d'
draw       each point is off by 0.3, divided by d'
adjust     off by one level, divided by d'
========== ========================================================================================
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.special import ndtr

from overview_studies.adaptive import Run
from overview_studies.answers import Answers
from overview_studies.file_model import Level
from overview_studies.forms import TLX
from overview_studies.store import Session, Store

LEAST = 0.05
"""An observer's d' isn't lower: it would answer at random for ever."""

RT_MS, RT_SPREAD = 1500.0, 0.35
SAID_UTC = "2000-01-01T00:00:00.000Z"
SIMULATED = "simulated observer"


@dataclass(frozen=True)
class Observers:
    """What simulated participants are like.

    Attributes
    ----------
    d_prime : float
        Their mean sensitivity.
    spread : float
        Standard deviation between participants.
    lapse : float
        Part of the trials that are answered blindly.
    effects : mapping
        What a factor's level adds to d': {("mapping", "static"): -0.5}.
    """

    d_prime: float = 1.5
    spread: float = 0.0
    lapse: float = 0.0
    effects: Mapping[tuple[str, Level], float] = field(default_factory=dict)

    def ability(self, own: float, levels: Mapping[str, Level]) -> float:
        """The d' of an observer whose own deviation is `own`, in a condition."""
        found = self.d_prime + own
        found += sum(self.effects.get((name, level), 0.0) for name, level in levels.items())
        return max(found, LEAST)


def simulated(
    study: dict[str, Any],
    lists: Mapping[int, dict[str, Any]],
    observers: Observers,
    count: int,
    seed: int,
) -> Answers:
    """The answers of `count` observers, each with the next list; lists begin again at the end."""
    numbers = sorted(lists)
    sessions = []
    for person in range(count):
        number = numbers[person % len(numbers)]
        rng = np.random.default_rng([seed, person])
        rows = _session(study, lists[number], observers, rng)
        trials = [(trial, SAID_UTC, row) for trial, row in rows]
        code = f"sim{person + 1:03d}"
        sessions.append(Session(code, "", number, code, SAID_UTC, SAID_UTC, False, trials))
    return Answers(study, dict(lists), sessions)


def store_simulated(store: Store, answers: Answers) -> None:
    """Store simulated sessions as a page's would be: the next free list each."""
    for one in answers.sessions:
        session, _ = store.begin(f"simulated-{one.id}-00000000", one.participant)
        rows = [(trial, json.dumps(row)) for trial, _, row in one.trials]
        store.put_all(session.id, rows)
        store.finish(session.id)


def _session(
    study: dict[str, Any], content: dict[str, Any], observers: Observers, rng: np.random.Generator
) -> list[tuple[str, dict[str, Any]]]:
    own = observers.spread * float(rng.standard_normal())
    found: list[tuple[str, dict[str, Any]]] = []
    for step in content["steps"]:
        if step["type"] == "form":
            found.append((step["id"], {"response": _form(study["forms"][step["form"]], rng)}))
        if step["type"] not in ("trial", "adaptive"):
            continue
        ability = observers.ability(own, {**content["factors"], **step["factors"]})
        if step["type"] == "adaptive":
            found += _run(step, ability, observers.lapse, rng)
            continue
        blind = rng.random() < observers.lapse
        response = _response(study, step, LEAST if blind else ability, rng)
        if step["attention"] is not None and not blind:
            response = step["attention"]
        found.append((step["id"], _row(response, rng)))
    return found


def _row(response: Any, rng: np.random.Generator, **more: Any) -> dict[str, Any]:
    rt_ms = round(RT_MS * math.exp(RT_SPREAD * float(rng.standard_normal())), 1)
    return {
        "response": response,
        "rt_ms": rt_ms,
        "started_utc": SAID_UTC,
        "source": SIMULATED,
        **more,
    }


def _response(
    study: dict[str, Any], step: dict[str, Any], d: float, rng: np.random.Generator
) -> Any:
    task = step["task"]
    shown = [study["stimuli"][key] for key in step["stimuli"]]
    noise = float(rng.standard_normal())
    if task == "identify":
        choices = study["task"]["choices"]
        evidence = rng.standard_normal(len(choices))
        evidence[choices.index(step["correct"])] += d / math.sqrt(2.0)
        return choices[int(np.argmax(evidence))]
    if task == "locate":
        if not step["correct"]:
            return None if noise < d / 2.0 else round(float(rng.random()), 4)
        place = step["correct"][int(rng.integers(len(step["correct"])))]
        return round(min(max(place + 0.1 * noise / d, 0.0), 1.0), 4)
    if task == "count":
        # nothing is now and then something
        given = step["correct"] * (1.0 + 0.3 * noise / d) if step["correct"] else noise > d
        return max(0, round(given))
    if task == "compare":
        order = _order(study)
        apart = order[shown[1]["level"]] - order[shown[0]["level"]]
        return int(rng.random() < ndtr(apart * d / math.sqrt(2.0)))
    if task == "draw":
        curve = np.array(shown[0]["curve"])
        drawn = np.clip(curve + 0.3 / d * rng.standard_normal(len(curve)), 0.0, 1.0)
        return [round(float(one), 4) for one in drawn]
    at = step["levels"].index(step["correct"]) + noise / d
    return step["levels"][min(max(round(at), 0), len(step["levels"]) - 1)]


def _order(study: dict[str, Any]) -> dict[Any, int]:
    levels = {one["level"] for one in study["stimuli"].values() if one["level"] is not None}
    known = list(dict.fromkeys(one["level"] for one in study["stimuli"].values()))
    numbers = all(isinstance(level, int | float) for level in levels)
    return {level: i for i, level in enumerate(sorted(levels) if numbers else known)}


def _run(
    step: dict[str, Any], d: float, lapse: float, rng: np.random.Generator
) -> list[tuple[str, dict[str, Any]]]:
    run, found = Run(step), []
    while not run.over:
        at, number, catch = run.level, run.trial, run.catch
        steps = 0 if catch else at + 1
        if step["method"] == "2afc":
            right = rng.random() < ndtr(steps * d / math.sqrt(2.0))
            side = step["sides"][number]
            response = side if right else 1 - side
        else:
            response = int(rng.random() < ndtr(steps * d - 1.0))
            right = bool(response) != catch
        if rng.random() < lapse:
            response = int(rng.integers(2))
            right = response == (step["sides"][number] if step["method"] == "2afc" else not catch)
        key = step["standard"] if catch else step["stimuli"][at]
        level = None if catch else step["levels"][at]
        row = _row(int(response), rng, stimulus=key, level=level)
        found.append((f"{step['id']}-{number + 1:03d}", row))
        run.answered(bool(right))
    return found


def _form(form: dict[str, Any], rng: np.random.Generator) -> dict[str, Any]:
    if "version" in form:
        return {"version": form["version"], "agreed": True}
    answers: dict[str, Any] = {}
    for item in form.get("items", []):
        if item["id"] in TLX:
            answers[item["id"]] = int(np.clip(5 * rng.integers(4, 15), 0, 100))
        else:
            answers[item["id"]] = SIMULATED
    return answers
