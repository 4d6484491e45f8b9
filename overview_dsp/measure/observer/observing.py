"""Training of an observer on random timelines and its evaluation on others.

Human limits are modelled by normal noise in the features. Its standard deviations are, for touch:
felt level 1.6 dB (one JND is 2.3 dB), slope 30 %, duration 18 % (Weber fraction 25 %), times
between pulses 5 ms; for sound: click level 0.8 dB, centroid 7 % (one JND is 10 %), decay 18 %,
delay 8 ms; for the pace of one's own movement: 15 %. `features` merges pulses within 30 ms.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.measure.observer.features import FEATURES, MODALITIES, Modality
from overview_dsp.measure.observer.forest import Forest, fit_forest
from overview_dsp.measure.observer.report import ObserverReport, SetScores, StrokeScores
from overview_dsp.measure.observer.scoring import Tally, groups_of
from overview_dsp.measure.observer.strokes import (
    GESTURES,
    MOVEMENTS,
    Movement,
    ObservedStroke,
    rendered_strokes,
    stroke_names,
)
from overview_dsp.measure.synthetic_data import random_timelines


def add_sensory_noise(
    features: FloatArray, names: tuple[str, ...], rng: np.random.Generator
) -> FloatArray:
    """Return features (onsets, features) with one draw of a human's sensory noise."""
    found = features.copy()
    known = {name: noise for group in FEATURES.values() for name, noise in group.items()}
    for column, name in enumerate(names):
        for noise_type, deviation in known[name].items():
            noise = deviation * rng.standard_normal(len(found))
            if noise_type == "relative_noise":
                found[:, column] *= np.exp(noise)
            elif name.startswith(("next_", "last_")):
                # only where there is a neighbouring pulse, which has a time
                found[:, column] += noise * (features[:, names.index(f"{name[:4]}_ms")] > 0.0)
            else:
                found[:, column] += noise
    return found


LEARNED, HELD_OUT = 120, 40  # numbers of random timelines for training and for evaluation
DRAWS = 5  # draws of the sensory noise for each stroke of the evaluation
TRAINING_DRAWS = 2  # draws of the sensory noise in the training data
_RENDERS_PER_MODEL = 15  # renders that take about as long as training and evaluating one observer

_HELD_OUT_SEED = 1_000_000
"""Offset of the seeds of held-out timelines and movements from those of the training data."""


def observe(
    preset: Preset,
    timelines: Sequence[Timeline] = (),
    *,
    modalities: Sequence[Modality] = MODALITIES,
    movement: Movement = "all",
    learned: int = LEARNED,
    held_out: int = HELD_OUT,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> ObserverReport:
    """Measure which kinds of events can be distinguished by touch and sound alone.

    An observer with human limits learns how each of the preset's kinds feels and sounds in each
    stroke, on random timelines. It then names the kind of each onset in other timelines.

    Parameters
    ----------
    preset : Preset
        Preset whose kinds are distinguished.
    timelines : sequence of Timeline
        Further timelines for the evaluation, beside held-out random ones.
    modalities : sequence of {"touch", "sound", "both"}
        Modalities, each with an observer of its own.
    movement : {"all", "steady", "arm", "mixed"}
        `steady`: sweeps of 1 to 30 s, the recoil and a tap. `arm`: an arm's movements of 1 to 6 s,
        which release without waiting for the disk. `all`: both. `mixed`: movements that change
        their pace, pause and turn back.
    learned, held_out : int
        Numbers of random timelines for training and for evaluation.
    seed : int
        Random seed; the same seed gives the same report.
    progress : callable or None
        Called with the completed share, 0 to 1.

    Returns
    -------
    ObserverReport
        Recall, precision and confusions of each kind in each stroke.

    Raises
    ------
    InputError
        No timelines, an unknown modality or movement, or an error of `render`.

    Examples
    --------
    >>> report = ov.measure.observe(
    ...     football, modalities=["touch"], movement="mixed", learned=2, held_out=1
    ... )
    >>> [name for name in report.sets[0].strokes]
    ['mixed']
    """
    _check(modalities, movement, learned, held_out, seed)
    if not held_out and not timelines:
        raise InputError(
            "held_out is 0 and there are no timelines to evaluate on; give at least one"
        )
    gestures = 1 if movement == "mixed" else len(GESTURES[movement])
    work = gestures * (learned + held_out + len(timelines))
    work += _RENDERS_PER_MODEL * len(stroke_names(movement)) * len(modalities)
    done = 0

    def step(more: int) -> None:
        nonlocal done
        done += more
        if progress is not None:
            progress(done / work)

    def strokes_of(observed: Sequence[Timeline], first: int) -> dict[str, list[ObservedStroke]]:
        return rendered_strokes(preset, observed, movement, modalities, first, step)

    training = strokes_of(random_timelines(preset, learned, seed), seed)
    evaluated = {}
    if held_out:
        test_seed = seed + _HELD_OUT_SEED
        drawn = random_timelines(preset, held_out, test_seed)
        evaluated["random timelines"] = strokes_of(drawn, test_seed)
    if timelines:
        evaluated["timelines given"] = strokes_of(timelines, seed + 2 * _HELD_OUT_SEED)
    scores: dict[str, dict[str, dict[Modality, StrokeScores]]] = {name: {} for name in evaluated}
    kinds = tuple(preset.kinds)
    for number, stroke in enumerate(stroke_names(movement)):
        for modality in modalities:
            rng = np.random.default_rng([seed, number, MODALITIES.index(modality)])
            forest, names = train_observer(training[stroke], modality, kinds, rng)
            for name, strokes in evaluated.items():
                result = evaluate_observer(strokes[stroke], modality, kinds, forest, names, rng)
                scores[name].setdefault(stroke, {})[modality] = result
            step(_RENDERS_PER_MODEL)
    counts = {"random timelines": held_out, "timelines given": len(timelines)}
    return ObserverReport(
        preset.name,
        movement,
        learned,
        tuple(SetScores(name, counts[name], strokes) for name, strokes in scores.items()),
    )


def _check(
    modalities: Sequence[Modality], movement: Movement, learned: int, held_out: int, seed: int
) -> None:
    if not modalities or not set(modalities) <= set(MODALITIES):
        raise InputError(
            f"modalities are {', '.join(modalities) or 'none'}; "
            f"must be one or more of {', '.join(MODALITIES)}"
        )
    if movement not in MOVEMENTS:
        raise InputError(f"movement is {movement!r}; must be one of {', '.join(MOVEMENTS)}")
    if learned < 1:
        raise InputError(f"learned is {learned}; must be at least 1")
    if held_out < 0 or seed < 0:
        raise InputError(f"held_out is {held_out} and seed is {seed}; both must be at least 0")


def _classes(stroke: ObservedStroke, modality: Modality, nothing: int) -> IntArray:
    """Return the true class of each onset of a stroke."""
    kinds = np.append(stroke.events.kind, nothing)
    return kinds[stroke.owner[modality]]  # -1, the last, is nothing


def train_observer(
    strokes: Sequence[ObservedStroke],
    modality: Modality,
    kinds: tuple[str, ...],
    rng: np.random.Generator,
) -> tuple[Forest | None, tuple[str, ...]]:
    """Train an observer of one stroke; None where no stroke has an onset."""
    features = np.concatenate([stroke.features[modality].features for stroke in strokes])
    names = strokes[0].features[modality].names
    classes = np.concatenate([_classes(stroke, modality, len(kinds)) for stroke in strokes])
    if not len(features):
        return None, names
    drawn = [add_sensory_noise(features, names, rng) for _ in range(TRAINING_DRAWS)]
    # the weight of a kind is the inverse root of its frequency
    weights = np.bincount(classes)[classes] ** -0.5
    classes, weights = (np.tile(one, TRAINING_DRAWS) for one in (classes, weights))
    return fit_forest(np.concatenate(drawn), classes, weights, rng), names


def evaluate_observer(
    strokes: Sequence[ObservedStroke],
    modality: Modality,
    kinds: tuple[str, ...],
    forest: Forest | None,
    names: tuple[str, ...],
    rng: np.random.Generator,
) -> StrokeScores:
    """Evaluate an observer on strokes, with `DRAWS` draws of sensory noise each."""
    groups = groups_of(kinds)
    group_names = tuple(dict.fromkeys(groups))
    single = Tally(kinds, np.arange(len(kinds) + 1))
    groups_of_kinds = [*(group_names.index(group) for group in groups), len(group_names)]
    grouped = Tally(group_names, np.array(groups_of_kinds))
    counts = [len(stroke.features[modality].at_ms) for stroke in strokes]
    features = np.concatenate([stroke.features[modality].features for stroke in strokes])
    for _ in range(DRAWS):
        answers = np.zeros(0, dtype=np.int64)
        if forest is not None:
            answers = forest.predict(add_sensory_noise(features, names, rng))
        for stroke, named in zip(strokes, np.split(answers, np.cumsum(counts)[:-1]), strict=True):
            at, owner = stroke.features[modality].at_ms, stroke.owner[modality]
            single.add(at, named, owner, stroke.events.kind)
            grouped.add(at, named, owner, stroke.events.kind)
    return StrokeScores(single.scores(DRAWS), grouped.scores(DRAWS))
