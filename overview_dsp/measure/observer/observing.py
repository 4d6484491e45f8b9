"""Renders, teaches an observer on random timelines, and asks it on others.

What a person can't know better: features blurred by normal noise, as large as its own limits.

Felt level 1.6 dB (a step is 2.3), slope 30 %, duration 18 % (Weber fraction 25 %), times between
pulses 5 ms; click level 0.8 dB, centroid 7 % (a step is 10 %), decay 18 %, delay 8 ms; the pace of
the own hand 15 %. Standard deviations. Pulses less than 30 ms apart are one already (`noticed`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.measure.observer.noticed import MODALITIES, PACE, Modality
from overview_dsp.measure.observer.report import ObserverReport, SetScores, StrokeScores
from overview_dsp.measure.observer.scoring import Tally, groups_of
from overview_dsp.measure.observer.strokes import (
    GESTURES,
    HANDS,
    Hands,
    StrokeMet,
    rendered_strokes,
    stroke_names,
)
from overview_dsp.measure.observer.trees import Forest, grown
from overview_dsp.measure.random_data import random_timelines

NOISE: Mapping[str, float] = {
    **dict.fromkeys(("level_db", "over_surroundings_db", "rise_db", "fall_db"), 1.6),
    **dict.fromkeys(("next_db", "last_db"), 1.6),
    **dict.fromkeys(("next_ms", "last_ms"), 5.0),
    "slope_db": 0.30,
    **dict.fromkeys(("duration_ms", "click_decay_ms"), 0.18),
    "click_db": 0.8,
    "centroid_hz": 0.07,
    "click_delay_ms": 8.0,
    PACE: 0.15,
}
RELATIVE = ("slope_db", "duration_ms", "centroid_hz", "click_decay_ms")
"""Features whose logarithm has that noise."""


def blurred(
    features: NDArray[np.float64], names: tuple[str, ...], rng: np.random.Generator
) -> NDArray[np.float64]:
    """The features (onsets, features) of `noticed` as one person has them, once."""
    found = features.copy()
    for column, name in enumerate(names):
        if name not in NOISE:
            continue
        noise = NOISE[name] * rng.standard_normal(len(found))
        if name in RELATIVE:
            found[:, column] *= np.exp(noise)
        elif name.startswith(("next_", "last_")):
            # only where there is a neighbour, which its time says
            found[:, column] += noise * (features[:, names.index(f"{name[:4]}_ms")] > 0.0)
        else:
            found[:, column] += noise
    return found


LEARNED, HELD_OUT = 120, 40
"""Random timelines that it learns from, and others that it is asked about."""

DRAWS = 5
"""Draws of a person's noise for each stroke that is asked about."""

LESSONS = 2
"""Draws of that noise in what it learns from."""

_LESSON = 15
"""Teaching and asking one observer takes about as long as so many renders."""

_HELD_OUT_SEED = 1_000_000
"""How far the seeds of held-out timelines and hands are from those it learns from."""


def observe(
    preset: Preset,
    timelines: Sequence[Timeline] = (),
    *,
    modalities: Sequence[Modality] = MODALITIES,
    hands: Hands = "all",
    learned: int = LEARNED,
    held_out: int = HELD_OUT,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> ObserverReport:
    """Find out which kinds of events can be told apart, from what a hand and an ear get alone.

    An observer with human limits learns on random timelines of the preset's kinds what each feels
    and sounds like in each stroke, and says of each onset in other timelines which kind it was.

    Parameters
    ----------
    preset : Preset
        What is to be told apart.
    timelines : sequence of Timeline
        What it is asked about besides random timelines that it hasn't met.
    modalities : sequence of {"touch", "sound", "both"}
        What it gets.
    hands : {"all", "steady", "arm", "mixed"}
        `steady`: sweeps of 1 to 30 s, the recoil and a tap. `arm`: an arm's movements of 1 to 6 s,
        which release without waiting for the disk. `all`: both. `mixed`: hands that speed up,
        hesitate and turn back.
    learned, held_out : int
        How many random timelines it learns from, and is asked about.
    seed : int
        The same seed, the same report.
    progress : callable or None
        Called with the part done, 0 to 1.

    Returns
    -------
    ObserverReport
        Recall, precision and confusions of each kind in each stroke.

    Raises
    ------
    InputError
        Nothing to learn from or to be asked about, an unknown modality or hand; as `render`.

    Examples
    --------
    >>> report = ov.measure.observe(
    ...     football, modalities=["touch"], hands="mixed", learned=2, held_out=1
    ... )
    >>> [name for name in report.sets[0].strokes]
    ['mixed']
    """
    _check(modalities, hands, learned, held_out, seed)
    if not held_out and not timelines:
        raise InputError("held_out = 0 and no timelines: there is nothing to ask about")
    gestures = 1 if hands == "mixed" else len(GESTURES[hands])
    work = gestures * (learned + held_out + len(timelines))
    work += _LESSON * len(stroke_names(hands)) * len(modalities)
    done = 0

    def step(more: int) -> None:
        nonlocal done
        done += more
        if progress is not None:
            progress(done / work)

    def strokes_of(made: Sequence[Timeline], first: int) -> dict[str, list[StrokeMet]]:
        return rendered_strokes(preset, made, hands, modalities, first, step)

    lessons = strokes_of(random_timelines(preset, learned, seed), seed)
    asked = {}
    if held_out:
        other = seed + _HELD_OUT_SEED
        asked["random timelines"] = strokes_of(random_timelines(preset, held_out, other), other)
    if timelines:
        asked["timelines given"] = strokes_of(timelines, seed + 2 * _HELD_OUT_SEED)
    scores: dict[str, dict[str, dict[Modality, StrokeScores]]] = {name: {} for name in asked}
    kinds = tuple(preset.kinds)
    for number, stroke in enumerate(stroke_names(hands)):
        for modality in modalities:
            rng = np.random.default_rng([seed, number, MODALITIES.index(modality)])
            forest, names = taught(lessons[stroke], modality, kinds, rng)
            for name, every in asked.items():
                told = asked_of(every[stroke], modality, kinds, forest, names, rng)
                scores[name].setdefault(stroke, {})[modality] = told
            step(_LESSON)
    counts = {"random timelines": held_out, "timelines given": len(timelines)}
    return ObserverReport(
        preset.name,
        hands,
        learned,
        tuple(SetScores(name, counts[name], strokes) for name, strokes in scores.items()),
    )


def _check(
    modalities: Sequence[Modality], hands: Hands, learned: int, held_out: int, seed: int
) -> None:
    if not modalities or not set(modalities) <= set(MODALITIES):
        raise InputError(
            f"modalities {', '.join(modalities) or 'none'}; they are one or more of "
            f"{', '.join(MODALITIES)}"
        )
    if hands not in HANDS:
        raise InputError(f"hands {hands!r} are unknown; they are {', '.join(HANDS)}")
    if learned < 1:
        raise InputError(f"learned = {learned}; an observer learns from 1 timeline or more")
    if held_out < 0 or seed < 0:
        raise InputError(f"held_out = {held_out}, seed = {seed}; neither is below 0")


def _classes(stroke: StrokeMet, modality: Modality, nothing: int) -> NDArray[np.int64]:
    """What each onset of a stroke truly was."""
    kinds = np.append(stroke.met.kind, nothing)
    return kinds[stroke.owner[modality]]  # -1, the last, is nothing


def taught(
    strokes: Sequence[StrokeMet],
    modality: Modality,
    kinds: tuple[str, ...],
    rng: np.random.Generator,
) -> tuple[Forest | None, tuple[str, ...]]:
    """An observer of one stroke; None where nothing is noticed in any of them."""
    features = np.concatenate([stroke.noticed[modality].features for stroke in strokes])
    names = strokes[0].noticed[modality].names
    classes = np.concatenate([_classes(stroke, modality, len(kinds)) for stroke in strokes])
    if not len(features):
        return None, names
    lessons = np.concatenate([blurred(features, names, rng) for _ in range(LESSONS)])
    # rare kinds count by the root of their rarity
    weights = np.bincount(classes)[classes] ** -0.5
    return grown(lessons, np.tile(classes, LESSONS), np.tile(weights, LESSONS), rng), names


def asked_of(
    strokes: Sequence[StrokeMet],
    modality: Modality,
    kinds: tuple[str, ...],
    forest: Forest | None,
    names: tuple[str, ...],
    rng: np.random.Generator,
) -> StrokeScores:
    """What an observer says of strokes, with `DRAWS` draws of its noise each."""
    groups = groups_of(kinds)
    group_names = tuple(dict.fromkeys(groups))
    nothing = len(kinds)
    single = Tally(kinds, np.arange(nothing + 1))
    place = [*(group_names.index(group) for group in groups), len(group_names)]
    grouped = Tally(group_names, np.array(place))
    counts = [len(stroke.noticed[modality].at_ms) for stroke in strokes]
    features = np.concatenate([stroke.noticed[modality].features for stroke in strokes])
    for _ in range(DRAWS):
        said = np.zeros(0, dtype=np.int64)
        if forest is not None:
            said = forest.say(blurred(features, names, rng))
        for stroke, told in zip(strokes, np.split(said, np.cumsum(counts)[:-1]), strict=True):
            at, owner = stroke.noticed[modality].at_ms, stroke.owner[modality]
            single.add(at, told, owner, stroke.met.kind.tolist())
            grouped.add(at, told, owner, stroke.met.kind.tolist())
    return StrokeScores(single.scores(DRAWS), grouped.scores(DRAWS))
