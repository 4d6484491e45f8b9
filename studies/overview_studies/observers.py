"""Simulated observers of known ability, who answer lists in the same pipeline as participants.

An observer has a sensitivity d', with this meaning in each task:

========== ========================================================================================
identify   evidence for each choice is normal; the presented one has a mean of d'/sqrt(2), so two
           choices are discriminated with exactly d'
compare    levels are d' apart for each mean step of their scale (`scales`)
staircase, the same, and the lowest is d' above the standard, or above no stimulus; with one
quest      interval, the criterion for "felt it" is one standard deviation above no stimulus
search     as in locate, after passing over the timeline until the event is noticed
locate     position error (standard deviation) of a tenth of the timeline, divided by d'
count      error of 30 %, divided by d'
draw       error of 0.3 at each point, divided by d'
adjust     error of one step between levels, divided by d'
========== ========================================================================================
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.special import ndtr

from overview_studies.adaptive import Run
from overview_studies.answers import Answers
from overview_studies.file_model import Level
from overview_studies.forms import TLX
from overview_studies.scales import Scale, scale_of
from overview_studies.store import SIMULATED, SIMULATED_REQUEST, Session, Store

MIN_D_PRIME = 0.05
"""Minimum d' of an observer, so that adaptive runs end."""

RT_MS, RT_SPREAD = 1500.0, 0.35
SEARCH_PASSES, SEARCH_PASS_S = 6, 2.0
SIMULATED_RATE = 48_000
SIMULATED_UTC = "2000-01-01T00:00:00.000Z"


@dataclass(frozen=True)
class Observers:
    """Ability of simulated participants.

    Attributes
    ----------
    d_prime : float
        Mean sensitivity.
    spread : float
        Standard deviation between participants.
    lapse : float
        Share of trials answered at random.
    effects : mapping
        Effect of a factor's level on d': {("mapping", "static"): -0.5}.
    """

    d_prime: float = 1.5
    spread: float = 0.0
    lapse: float = 0.0
    effects: Mapping[tuple[str, Level], float] = field(default_factory=dict)

    def ability(self, own: float, levels: Mapping[str, Level]) -> float:
        """Return the d' in a condition of an observer who deviates by `own` from the mean."""
        found = self.d_prime + own
        found += sum(self.effects.get((name, level), 0.0) for name, level in levels.items())
        return max(found, MIN_D_PRIME)


def simulate_answers(
    study: dict[str, Any],
    lists: Mapping[int, dict[str, Any]],
    observers: Observers,
    count: int,
    seed: int,
) -> Answers:
    """Simulate `count` observers, each with the next list; lists repeat when all are used."""
    numbers = sorted(lists)
    sessions = []
    for person in range(count):
        number = numbers[person % len(numbers)]
        rng = np.random.default_rng([seed, person])
        rows = _session(study, lists[number], observers, rng)
        trials = [(trial, SIMULATED_UTC, row) for trial, row in rows]
        code = f"sim{person + 1:03d}"
        sessions.append(
            Session(code, "", number, code, SIMULATED_UTC, SIMULATED_UTC, False, trials)
        )
    return Answers(study, dict(lists), sessions, simulated=True)


def store_simulated(store: Store, answers: Answers) -> None:
    """Store simulated sessions, each with the next free list."""
    for one in answers.sessions:
        session, _ = store.begin(f"{SIMULATED_REQUEST}{one.id}-00000000", one.participant)
        rows = [(trial, json.dumps(row)) for trial, _, row in one.trials]
        store.put_all(session.id, rows)
        store.finish(session.id)


def _session(
    study: dict[str, Any], content: dict[str, Any], observers: Observers, rng: np.random.Generator
) -> list[tuple[str, dict[str, Any]]]:
    own, scale = observers.spread * float(rng.standard_normal()), scale_of(study)
    found: list[tuple[str, dict[str, Any]]] = []
    for step in content["steps"]:
        if step["type"] == "form":
            found.append((step["id"], {"response": _form(study["forms"][step["form"]], rng)}))
        if step["type"] not in ("trial", "adaptive"):
            continue
        ability = observers.ability(own, {**content["factors"], **step["factors"]})
        if step["type"] == "adaptive":
            found += _run(scale, step, ability, observers.lapse, rng)
            continue
        blind = rng.random() < observers.lapse
        response = _response(study, scale, step, MIN_D_PRIME if blind else ability, rng)
        if step["attention"] is not None and not blind:
            response = step["attention"]
        take = {"take": _search_take(response, ability, rng)} if step["task"] == "search" else {}
        found.append((step["id"], _row(response, rng, **take)))
    return found


def _row(response: Any, rng: np.random.Generator, **more: Any) -> dict[str, Any]:
    rt_ms = round(RT_MS * math.exp(RT_SPREAD * float(rng.standard_normal())), 1)
    return {
        "response": response,
        "rt_ms": rt_ms,
        "started_utc": SIMULATED_UTC,
        "source": SIMULATED,
        **more,
    }


def _response(
    study: dict[str, Any], scale: Scale, step: dict[str, Any], d: float, rng: np.random.Generator
) -> Any:
    task = step["task"]
    presented = [study["stimuli"][key] for key in step["stimuli"]]
    noise = float(rng.standard_normal())
    if task == "identify":
        choices = study["task"]["choices"]
        evidence = rng.standard_normal(len(choices))
        evidence[choices.index(step["correct"])] += d / math.sqrt(2.0)
        return choices[int(np.argmax(evidence))]
    if task in ("locate", "search"):
        if not step["correct"]:
            return None if noise < d / 2.0 else round(float(rng.random()), 4)
        position = step["correct"][int(rng.integers(len(step["correct"])))]
        return round(min(max(position + 0.1 * noise / d, 0.0), 1.0), 4)
    if task == "count":
        # without events, high noise gives a false alarm
        perceived = step["correct"] * (1.0 + 0.3 * noise / d) if step["correct"] else noise > d
        return max(0, round(perceived))
    if task == "compare":
        steps = scale.steps([one["level"] for one in presented])
        difference = steps[1] - steps[0]
        return int(rng.random() < ndtr(difference * d / math.sqrt(2.0)))
    if task == "draw":
        curve = np.array(presented[0]["curve"])
        drawn = np.clip(curve + 0.3 / d * rng.standard_normal(len(curve)), 0.0, 1.0)
        return [round(float(one), 4) for one in drawn]
    at = step["levels"].index(step["correct"]) + noise / d
    return step["levels"][min(max(round(at), 0), len(step["levels"]) - 1)]


def _search_take(response: float | None, d: float, rng: np.random.Generator) -> dict[str, Any]:
    """Return the movement of an observer who notices the event in a pass with a chance by d'."""
    passes = min(int(rng.geometric(float(ndtr(d / 2.0)))), SEARCH_PASSES)
    last = 0.5 if response is None else response
    ends = [0.0, *(float((i + 1) % 2) for i in range(passes)), last]
    points = np.concatenate([np.linspace(a, b, 20) for a, b in pairwise(ends)])
    samples = (np.arange(len(points)) * SEARCH_PASS_S * SIMULATED_RATE / 20).astype(int)
    both = zip(samples.tolist(), (math.pi * points).tolist(), strict=True)
    events: list[list[Any]] = [[sample, point, 1, "touch"] for sample, point in both]
    events.append([int(samples[-1]) + 1, math.pi * float(points[-1]), 0, "touch"])
    return {"sample_rate": SIMULATED_RATE, "samples": int(samples[-1]) + 1, "events": events}


def _run(
    scale: Scale, step: dict[str, Any], d: float, lapse: float, rng: np.random.Generator
) -> list[tuple[str, dict[str, Any]]]:
    run, found = Run(step), []
    above = 1.0 + scale.steps(step["levels"])
    while not run.over:
        at, number, catch = run.level, run.trial, run.catch
        steps = 0.0 if catch else above[at]
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
        run.record(bool(right))
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
