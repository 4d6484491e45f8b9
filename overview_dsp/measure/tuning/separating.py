"""Heights and widths moved until no two kinds of a preset feel alike at any speed.

A local search, seeded: a kind that is in the way, or all of them, is moved a little, and stays so
if all kinds together are better apart for it (level, sharpness or duration: `steps_apart`), with
none masked and none run together.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture, sweep
from overview_dsp.design.presets.model import Preset
from overview_dsp.measure.comparing import steps_apart
from overview_dsp.measure.feel import KindFeel
from overview_dsp.measure.felt import STEP_DB
from overview_dsp.measure.report import feel_report
from overview_dsp.measure.tuning.moves import RATE, Tuned, limits, moved
from overview_dsp.measure.tuning.ordering import check_target
from overview_dsp.offline.rendering.audition import pages

WANTED_STEPS = 1.0
_AIM_STEPS = 1.3
_CLEAR_STEPS = 1.8
_GOOD = 0.02
"""More is aimed at, so that other speeds than the measured ones hold it too, and the fainter of a
kind's events (_CLEAR_STEPS above what is none); the search ends where that is all but reached."""

SECONDS = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0)
SPEEDS = {f"{seconds:g} s": sweep(seconds) for seconds in SECONDS}
ROUGH = {f"{seconds:g} s": sweep(seconds) for seconds in (1.0, 2.0, 5.0)}
FAULT = 2.0
"""What a masked or merged event costs, as a pair of kinds that lack so many steps, squared."""

TRIES = 2000
TOGETHER = 0.15
"""Part of the tries that raise or lower all kinds at once."""

SPREAD = (0.3, 0.15)
"""Of a try, in logarithms of the height's and the width's ratio."""

Feels = Mapping[str, Mapping[str, KindFeel]]


def separated(
    preset: Preset,
    order: Sequence[str] = (),
    seed: int = 0,
    progress: Callable[[float], None] = lambda part: None,
) -> Tuned:
    """Move heights and widths until all kinds of a preset are a step apart, in sweeps of 1 to 6 s.

    Parameters
    ----------
    preset : Preset
        Whose kinds are moved.
    order : sequence of str
        Kinds of which each is stronger than the next by a step of level.
    seed : int
        The same seed gives the same preset.
    progress : callable
        Called with the part done, 0 to 1.

    Returns
    -------
    Tuned
        What was found.

    Raises
    ------
    InputError
        The order has a kind that the preset doesn't name, or one twice.

    Examples
    --------
    >>> only = ov.EventKind(height=120.0, width_percent=3.0, shape="plateau")
    >>> preset = ov.Preset("mine", "Mine", "one kind", {}, {"default": only})
    >>> ov.measure.separated(preset).preset.name
    'mine-tuned'
    """
    if order:
        check_target(preset, order)
    names = tuple(preset.kinds)
    rng = validation.random(seed)
    best = np.zeros(2 * len(names))
    # few speeds bring it near, all of them to the end
    best, _ = _searched(preset, names, order, ROUGH, rng, best, lambda p: progress(0.5 * p))
    best, feels = _searched(
        preset, names, order, SPEEDS, rng, best, lambda p: progress(0.5 + 0.5 * p)
    )
    progress(1.0)
    found = moved(preset, names, best)
    least = min(_least_steps(kinds, order) for kinds in feels.values())
    faults = sum(kind.masked + kind.merged for kinds in feels.values() for kind in kinds.values())
    named = replace(found, name=f"{preset.name}-tuned", title=f"{preset.title}, tuned")
    return Tuned(named, least, least >= WANTED_STEPS and not faults)


def _searched(
    preset: Preset,
    names: tuple[str, ...],
    order: Sequence[str],
    speeds: Mapping[str, Gesture],
    rng: np.random.Generator,
    start: NDArray[np.float64],
    progress: Callable[[float], None],
) -> tuple[NDArray[np.float64], Feels]:
    """The best moves found from some on, and how they feel at these speeds."""
    most = limits(len(names))
    all_pages = pages(preset)
    best = start
    feels = _felt(moved(preset, names, best), all_pages, speeds)
    lacking = _lacking(feels, names, order)
    for count in range(TRIES):
        if lacking.sum() < _GOOD:
            break
        progress(count / TRIES)
        share = lacking.sum(axis=0) + lacking.sum(axis=1)
        which = np.array([rng.choice(len(names), p=share / share.sum())])
        if rng.random() < TOGETHER:
            # the others give way
            which = np.arange(len(names))
        tried = best.copy()
        move = rng.choice([1.0, 0.3]) * rng.normal(0.0, SPREAD)
        tried[which] += move[0]
        tried[which + len(names)] += move[1] if len(which) == 1 else 0.0
        tried = np.clip(tried, -most, most)
        there = [page for page in all_pages if any(names[i] in page.kinds() for i in which)]
        felt = _felt(moved(preset, names, tried), there, speeds)
        merged = {speed: {**feels[speed], **felt[speed]} for speed in speeds}
        now = _lacking(merged, names, order)
        if now.sum() < lacking.sum():
            best, feels, lacking = tried, merged, now
    return best, feels


def _felt(preset: Preset, timelines: Sequence[Timeline], speeds: Mapping[str, Gesture]) -> Feels:
    report = feel_report(preset, timelines, speeds, RATE, recoils=False)
    return {speed: {kind.kind: kind for kind in report.stroke(speed).kinds} for speed in speeds}


def _least_steps(kinds: Mapping[str, KindFeel], order: Sequence[str]) -> float:
    pairs = itertools.combinations(kinds.values(), 2)
    steps = [steps_apart(first, second) for first, second in pairs]
    steps += [_above(kinds[first], kinds[second]) for first, second in itertools.pairwise(order)]
    return min(steps, default=np.inf)


def _above(first: KindFeel, second: KindFeel) -> float:
    return (first.level_db - second.level_db) / STEP_DB


def _lacking(feels: Feels, names: Sequence[str], order: Sequence[str]) -> NDArray[np.float64]:
    """What lacks, (kinds, kinds): between two kinds, or of one by itself on the diagonal."""
    found = np.zeros((len(names), len(names)))
    place = {name: i for i, name in enumerate(names)}
    for kinds in feels.values():
        for first, second in itertools.combinations(names, 2):
            steps = steps_apart(kinds[first], kinds[second])
            found[place[first], place[second]] += max(0.0, _AIM_STEPS - steps) ** 2
        for first, second in itertools.pairwise(order):
            steps = _above(kinds[first], kinds[second])
            found[place[first], place[second]] += max(0.0, _AIM_STEPS - steps) ** 2
        for name, i in place.items():
            kind = kinds[name]
            above = kind.contrast_db / STEP_DB
            found[i, i] += max(0.0, _CLEAR_STEPS - above) ** 2 if kind.events else FAULT**2
            found[i, i] += FAULT**2 * (kind.masked + kind.merged)
    return found
