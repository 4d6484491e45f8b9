"""Dry run of a study before anyone takes part: observers complete it, and its flaws are listed.

Each flaw is one line with file, line, key and remedy, in the format of an error of the file.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from overview_dsp import measure, sweep
from overview_dsp.cli.extensions import TACTOR, faults_at_their_line, read_text
from overview_dsp.errors import InputError
from overview_studies.analysis import Analysis, analyse
from overview_studies.design import ADAPTIVE, Design
from overview_studies.file_model import Level
from overview_studies.folder import draft_study
from overview_studies.measures import conditions_of
from overview_studies.observers import Observers, simulate_answers
from overview_studies.power import estimate_power
from overview_studies.row_checks import impossible
from overview_studies.statistics import MIN_PARTICIPANTS
from overview_studies.steps import find_step, missing_steps
from overview_studies.stimuli import Stimulus, stimuli_of

ABILITIES = {"weak": 0.5, "average": 1.0, "strong": 2.0}
"""Observers who complete the study: factors of the average sensitivity."""

USUAL_D_PRIME = 1.5
"""Average sensitivity in tasks without levels."""

MOST_OBSERVERS = 6
ARM_SWEEP_S = 2.0
MOST_RENDERED = 60
CEILING, FLOOR_ABOVE_CHANCE = 0.97, 0.1
"""Share of right answers of weak observers, and share above chance of strong ones."""

RARE = 0.01
"""Chance of a run of catch trials that is too long."""

MIN_JNDS, SAME_SOUND = 0.1, 0.1
"""Differences up to which levels differ in strength alone: in JNDs, and relative to the sound."""

JND_DB = 2.3
"""Just noticeable difference of a vibration's amplitude (Israr and Tan 2006: 2.2 to 2.5 dB)."""

POWER_RUNS = 40
POWER_ERROR = 0.1
"""Error of the power of so many runs."""


def rehearse(design: Design) -> tuple[list[str], int]:
    """Return one line for each flaw of a study, and how many observers have completed it."""
    text = read_text(design.path)
    found: list[str] = []
    completed: list[str] = []
    for flaw in dict.fromkeys(_flaws(design, completed)):
        try:
            with faults_at_their_line(text, str(design.path)):
                raise InputError(flaw)
        except InputError as located:
            found.append(str(located))
    return found, len(completed)


def _flaws(design: Design, completed: list[str]) -> Iterator[str]:
    items = stimuli_of(design)
    study, lists = draft_study(design)
    yield from _order_flaws(design, lists)
    yield from _effect_flaws(design, items)
    yield from _unfelt_events(design, items)
    average = _felt_d_prime(design, items)
    yield from _answer_flaws(design, study, lists, average, completed)
    if design.file.power is not None:
        yield from _power_flaw(design, study, lists, average)


def _order_flaws(design: Design, lists: Mapping[int, dict[str, Any]]) -> Iterator[str]:
    count, whole = len(lists), design.lists_per_round
    if count % whole:
        yield (
            f"participants = {count}: not balanced, each round has {whole} lists; set "
            f"participants to {math.ceil(count / whole) * whole}"
        )
    if "consent" not in design.file.questionnaires.start:
        yield 'questionnaires.start: no consent form; add "consent"'
    share = design.file.phases.catch
    if share:
        most = max(3, math.ceil(math.log(RARE) / math.log(share)))
        number, length = max(((n, _longest_run(one)) for n, one in lists.items()),
                             key=lambda pair: pair[1])  # fmt: skip
        if length > most:
            yield (
                f"phases.catch: {length} catch trials in a row in list {number}; change seed, or "
                "lower phases.catch"
            )
    correct = {
        str(step["correct"])
        for one in lists.values()
        for step in one["steps"]
        if step["type"] == "trial" and step["phase"] in ("main", "catch")
    }
    if design.file.task.name in ("identify", "count", "compare") and len(correct) == 1:
        (answer,) = correct
        yield (
            f"task.name: {answer} is the right answer of every trial; add other stimuli, or "
            "phases.catch"
        )


def _longest_run(content: Mapping[str, Any]) -> int:
    """Return the largest number of catch trials in a row."""
    longest = run = 0
    for step in content["steps"]:
        catches = step["catch"] if step["type"] == "adaptive" else [step.get("phase") == "catch"]
        for is_catch in catches:
            run = run + 1 if is_catch else 0
            longest = max(longest, run)
    return longest


def _key_of(design: Design, dimension: str) -> str:
    """Return the key of the file that has the levels of a dimension."""
    if dimension in design.file.factors:
        return f"factors.{dimension}"
    plural = {"preset": "presets", "gesture": "gestures", "timeline": "timelines"}
    name = plural.get(dimension)
    return f"stimuli.{name}" if name else f"stimuli.parameters.{dimension}"


def _effect_flaws(design: Design, items: Sequence[Stimulus]) -> Iterator[str]:
    """Yield the dimensions whose levels have the same sound with every timeline."""
    sounds: dict[str, Any] = {}

    def sound(one: Stimulus) -> Any:
        if one.key not in sounds:
            sounds[one.key] = one.render_stimulus().samples
        return sounds[one.key]

    for name in ("preset", "gesture", *design.grid.parameters):
        for earlier, later in pairwise(design.dimension(name)):
            by = {tuple({**one.names, name: later}.items()): one for one in items
                  if not one.is_catch and one.names.get(name) == earlier}  # fmt: skip
            pairs = [(by[tuple(one.names.items())], one) for one in items
                     if tuple(one.names.items()) in by]  # fmt: skip
            if name == "gesture":
                pairs = [pair for pair in pairs if not any(one.free for one in pair)]
            if pairs and all(np.array_equal(*map(sound, pair)) for pair in _sample(pairs)):
                yield (
                    f"{_key_of(design, name)}: {earlier} and {later} have no effect, their sounds "
                    "are equal; choose other levels, or another dimension"
                )


def _sample(all_of: Sequence[Any]) -> list[Any]:
    """Return at most `MOST_RENDERED` of a sequence, drawn at random and in order."""
    chosen = np.random.default_rng(0).permutation(len(all_of))[:MOST_RENDERED]
    return [all_of[i] for i in sorted(chosen)]


def _first(items: Sequence[Stimulus], name: str, level: Level) -> Stimulus | None:
    """Return the first stimulus with events of a level, of the first levels otherwise."""
    fitting = (one for one in items if not one.is_catch and one.names.get(name) == level)
    return next(fitting, None)


def _unfelt_events(design: Design, items: Sequence[Stimulus]) -> Iterator[str]:
    """Yield the kinds with events that cannot be felt in the gesture, or in a sweep of an arm."""
    task = design.file.task
    if task.name in ADAPTIVE and task.method == "yesno":
        return  # some levels are meant to be too weak
    unfelt: Counter[str] = Counter()
    asked: Counter[str] = Counter()
    kept = [one for one in items if not one.is_catch and one.timeline.events
            and (task.vary is None or one.names[task.vary] == task.standard)]  # fmt: skip
    for one in _sample(kept):
        gesture = sweep(ARM_SWEEP_S) if one.free else one.gesture
        felt: dict[int, bool] = defaultdict(bool)
        kinds: dict[int, str] = {}
        for table in measure.felt_events(one.preset, [one.timeline], {"": gesture}):
            rows = zip(table.event, table.kind, table.detected & ~table.masked & ~table.merged,
                       strict=True)  # fmt: skip
            for event, kind, is_felt in rows:
                kinds[int(event)] = str(kind)
                felt[int(event)] |= bool(is_felt)
        for event, kind in kinds.items():
            if kind != "period" and task.target in (None, kind):
                asked[kind] += 1
                unfelt[kind] += not felt[event]
    free = any(one.free for one in kept)
    how = f"an arm's sweep of {ARM_SWEEP_S:g} s" if free else "the gestures"
    for kind, count in unfelt.items():
        if count:
            yield (
                f"stimuli: {count} of {asked[kind]} events ({kind}) cannot be felt in {how}; "
                "choose a stronger kind or preset, slower gestures, or events further apart"
            )


def _felt_d_prime(design: Design, items: Sequence[Stimulus]) -> float:
    """Return the average sensitivity: for levels, the felt JNDs of a mean step between them."""
    task = design.file.task
    if task.vary is None or task.vary in ("timeline", "answer"):
        return USUAL_D_PRIME
    levels = design.dimension(task.vary)
    ends = [_first(items, task.vary, level) for level in (levels[0], levels[-1])]
    sounds, strongest = [], []
    for one in ends:
        if one is None or not one.timeline.events:
            return USUAL_D_PRIME
        result = one.render_stimulus()
        _, level = measure.window_db(result.samples[:, TACTOR], result.sample_rate)
        strongest.append(float(level.max()))
        sounds.append(result.samples[: round(result.sample_rate * one.gesture.duration_s)])
    jnds = abs(strongest[1] - strongest[0]) / JND_DB
    if jnds <= MIN_JNDS:
        # equally strong levels may differ in frequency, for example
        lengths = {len(one) for one in sounds}
        change = np.ptp(sounds, axis=0) if len(lengths) == 1 else np.full(1, np.inf)
        if np.linalg.norm(change) > SAME_SOUND * np.linalg.norm(sounds[0]):
            return USUAL_D_PRIME
    return jnds / (len(levels) - 1)


def _answer_flaws(
    design: Design,
    study: dict[str, Any],
    lists: Mapping[int, dict[str, Any]],
    average: float,
    completed: list[str],
) -> Iterator[str]:
    """Let observers complete the study, and yield what their answers show."""
    count = max(MIN_PARTICIPANTS, min(len(lists), MOST_OBSERVERS))
    results: dict[str, Analysis] = {}
    for name, factor in ABILITIES.items():
        answers = simulate_answers(study, lists, Observers(average * factor), count, 0)
        for session in answers.sessions:
            content = lists[session.number]
            left = missing_steps(content, [trial for trial, _, _ in session.trials])
            if left:
                yield f"task: a {name} observer cannot complete the study, {left[0]} has no answer"
            else:
                completed.append(name)
            for trial, _, row in session.trials:
                step = find_step(trial, content)
                reason = step and impossible(answers.study, step, row)
                if reason:
                    yield f"task: a {name} observer has an impossible answer, {trial}: {reason}"
        try:
            results[name] = analyse(answers)
        except InputError as error:
            yield f"exclude: {name} observers: {error}"
    if len(results) == len(ABILITIES):
        yield from _limit_flaws(design, results)


def _limit_flaws(design: Design, results: Mapping[str, Analysis]) -> Iterator[str]:
    """Yield floors and ceilings."""
    task = design.file.task
    if task.name in ADAPTIVE:
        average = results["average"]
        counts = {condition: len(by) for (name, condition), by in average.measures.values.items()
                  if name == "threshold"}  # fmt: skip
        reasons = Counter((one.condition, _limit_of(one.reason)) for one in average.missing)
        remedies = {
            "lowest": f"{task.vary}: most average observers feel even the lowest level; add levels "
            "nearer to the standard",
            "highest": f"{task.vary}: most average observers do not feel the highest level; add "
            "levels further from the standard",
            "reversals": f"max_trials = {task.max_trials}: most average observers have fewer than "
            "six reversals; raise max_trials, or use fewer levels",
        }
        for limit, remedy in remedies.items():
            if any(2 * reasons[one, limit] > count for one, count in counts.items()):
                yield f"task.{'vary = ' if limit != 'reversals' else ''}{remedy}"
        return
    if task.name == "adjust":
        for condition in dict.fromkeys(one.condition for one in results["average"].missing):
            at_limit = [one.reason for one in results["average"].missing
                       if one.condition == condition]  # fmt: skip
            if 2 * len(at_limit) > len(results["average"].answers.sessions):
                yield (
                    f"task.standard = {task.standard}: most average observers choose the "
                    f"{_limit_of(at_limit[0])} level; add levels beyond it"
                )
                return
    if task.name not in ("identify", "compare", "count"):
        return
    choices = len(results["weak"].answers.study["task"].get("choices", ())) or 2
    name, chance = ("exact", 0.0) if task.name == "count" else ("accuracy", 1.0 / choices)
    shares = {who: [one.estimate.mean for one in found.estimates if one.measure == name]
              for who, found in results.items()}  # fmt: skip
    key = "stimuli" if task.vary is None else f"task.vary = {task.vary}"
    if min(shares["weak"]) > CEILING:
        yield (
            f"{key}: ceiling, weak observers have {min(shares['weak']):.0%} right answers; choose "
            "stimuli that are more alike"
        )
    if max(shares["strong"]) < chance + FLOOR_ABOVE_CHANCE:
        yield (
            f"{key}: floor, strong observers have {max(shares['strong']):.0%} right answers, "
            f"chance is {chance:.0%}; choose stimuli that differ more"
        )


def _limit_of(reason: str) -> str:
    return next((one for one in ("lowest", "highest", "reversals") if one in reason), "")


def _power_flaw(
    design: Design, study: dict[str, Any], lists: Mapping[int, dict[str, Any]], average: float
) -> Iterator[str]:
    """Yield the factors whose effect is detected in too few studies."""
    power, factors = design.file.power, conditions_of(study)
    assert power is not None
    if not factors:
        yield "power.effect: the study has no factor of conditions; add one, or remove [power]"
    elif power.effect >= average:
        yield (
            f"power.effect = {power.effect:g}: must be less than the d' of average observers, "
            f"{average:.2g}{' per level' if design.file.task.vary else ''}; choose a smaller effect"
        )
        return
    for factor in factors:
        first, *_, last = study["factors"][factor]["levels"]
        observers = Observers(average, 0.2 * average, 0.0, {(factor, last): -power.effect})
        found = estimate_power(study, lists, observers, len(lists), POWER_RUNS, 0)["found"]
        share = found.get(f"{factor} {last} - {first}", 0) / POWER_RUNS
        if share < power.share - POWER_ERROR:
            yield (
                f"power.share = {power.share:g}: an effect of {power.effect:g} of {factor} is "
                f"detected in {share:.0%} of {POWER_RUNS} simulated studies; raise "
                "phases.main.repeats or participants"
            )
