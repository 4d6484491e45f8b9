"""Training of an observer on random timelines and its evaluation on others.

Human limits are modelled by normal noise in the features. Its standard deviations are, for touch:
felt level 1.6 dB (one JND is 2.3 dB), slope 30 %, duration 18 % (Weber fraction 25 %), times
between pulses 5 ms; for sound: click level 0.8 dB, centroid 7 % (one JND is 10 %), decay 18 %,
delay 8 ms; for the pace of one's own movement: 15 %. `features` merges pulses within 30 ms.

Classifier of extremely randomised trees (Geurts, Ernst and Wehenkel 2006) in plain numpy.

Each node of a tree is split by the best of several random candidates, by weighted Gini impurity. A
candidate compares one feature with its value in a random sample of the node. A node is a leaf if it
is pure, or if no candidate leaves `MIN_SAMPLES` or more on both sides. A forest predicts the class
with the largest mean share in the leaves of its trees. All nodes of a depth are split at once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import BoolArray, FloatArray, IntArray
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.measure.observer.features import FEATURES, MODALITIES, Modality
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
        for how, deviation in known[name].items():
            noise = deviation * rng.standard_normal(len(found))
            if how == "relative_noise":
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
        other = seed + _HELD_OUT_SEED
        evaluated["random timelines"] = strokes_of(random_timelines(preset, held_out, other), other)
    if timelines:
        evaluated["timelines given"] = strokes_of(timelines, seed + 2 * _HELD_OUT_SEED)
    scores: dict[str, dict[str, dict[Modality, StrokeScores]]] = {name: {} for name in evaluated}
    kinds = tuple(preset.kinds)
    for number, stroke in enumerate(stroke_names(movement)):
        for modality in modalities:
            rng = np.random.default_rng([seed, number, MODALITIES.index(modality)])
            forest, names = train_observer(training[stroke], modality, kinds, rng)
            for name, every in evaluated.items():
                result = evaluate_observer(every[stroke], modality, kinds, forest, names, rng)
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
    samples = np.concatenate(
        [add_sensory_noise(features, names, rng) for _ in range(TRAINING_DRAWS)]
    )
    # the weight of a kind is the inverse root of its frequency
    weights = np.bincount(classes)[classes] ** -0.5
    return fit_forest(
        samples, np.tile(classes, TRAINING_DRAWS), np.tile(weights, TRAINING_DRAWS), rng
    ), names


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
    nothing = len(kinds)
    single = Tally(kinds, np.arange(nothing + 1))
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
            single.add(at, named, owner, stroke.events.kind.tolist())
            grouped.add(at, named, owner, stroke.events.kind.tolist())
    return StrokeScores(single.scores(DRAWS), grouped.scores(DRAWS))


TREES = 40
CANDIDATES = 8  # random splits that are compared at each node
MIN_SAMPLES = 5  # fewest samples on each side of a split


@dataclass(frozen=True, eq=False)
class _Tree:
    """Nodes in order of depth; `below` is 0 for a leaf."""

    feature: IntArray
    threshold: FloatArray
    below: IntArray
    """Number of the node for samples below the threshold; the next node has the others."""
    share: FloatArray  # (nodes, classes)


@dataclass(frozen=True, eq=False)
class Forest:
    """Trained trees for a number of classes; see `fit_forest`."""

    classes: int
    trees: tuple[_Tree, ...]

    def probabilities(self, features: FloatArray) -> FloatArray:
        """Return the probability of each class: float64 (samples, classes)."""
        total = np.zeros((len(features), self.classes))
        rows = np.arange(len(features))
        for tree in self.trees:
            node = np.zeros(len(features), dtype=np.int64)
            undecided = rows
            while len(undecided):
                here = node[undecided]
                undecided, here = undecided[tree.below[here] > 0], here[tree.below[here] > 0]
                above = features[undecided, tree.feature[here]] >= tree.threshold[here]
                node[undecided] = tree.below[here] + above
            total += tree.share[node]
        return total / len(self.trees)

    def predict(self, features: FloatArray) -> IntArray:
        """Return the most probable class of each sample of (samples, features)."""
        return np.asarray(self.probabilities(features).argmax(axis=1), dtype=np.int64)


def fit_forest(
    features: FloatArray, classes: IntArray, weights: FloatArray, rng: np.random.Generator
) -> Forest:
    """Train a forest on features (samples, features), class numbers from 0 and weights > 0."""
    count = int(classes.max()) + 1
    grower = _Grower(features, classes, weights, count, rng)
    return Forest(count, tuple(grower.tree() for _ in range(TREES)))


@dataclass(frozen=True, eq=False)
class _Grower:
    """Trainer of trees on one set of samples."""

    features: FloatArray
    classes: IntArray
    weights: FloatArray
    count: int
    rng: np.random.Generator

    def tree(self) -> _Tree:
        """Grow one tree, depth by depth."""
        parts: list[tuple[NDArray[Any], ...]] = []
        # samples not in a leaf yet: their rows, sorted by node, and their node at this depth
        rows = np.arange(len(self.features))
        node = np.zeros(len(self.features), dtype=np.int64)
        nodes, total = 1, 1
        while nodes:
            sums = self._sums(rows, node, nodes)
            feature, threshold, splits = self._best_splits(rows, node, sums)
            splits &= (sums > 0.0).sum(axis=1) > 1
            # the nodes of the next depth, two for each that is split
            below = np.zeros(nodes, dtype=np.int64)
            below[splits] = total + 2 * np.arange(np.count_nonzero(splits))
            parts.append((feature, threshold, below, sums / sums.sum(axis=1)[:, None]))
            kept = splits[node]
            rows, node = rows[kept], node[kept]
            node = below[node] + (self.features[rows, feature[node]] >= threshold[node]) - total
            order = np.argsort(node, kind="stable")
            rows, node = rows[order], node[order]
            nodes = 2 * int(np.count_nonzero(splits))
            total += nodes
        return _Tree(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def _best_splits(
        self, rows: IntArray, node: IntArray, sums: FloatArray
    ) -> tuple[IntArray, FloatArray, BoolArray]:
        """Find the best of `CANDIDATES` at each node: feature, threshold, and whether it splits."""
        nodes = len(sums)
        size = np.bincount(node, minlength=nodes)
        first = np.concatenate([[0], np.cumsum(size)[:-1]])
        found, threshold = np.zeros(nodes, dtype=np.int64), np.zeros(nodes)
        # the purity of a node without a split
        best = (sums**2).sum(axis=1) / sums.sum(axis=1) + 1e-9
        splits = np.zeros(nodes, dtype=bool)
        for _ in range(CANDIDATES):
            feature = np.asarray(self.rng.integers(self.features.shape[1], size=nodes))
            drawn = rows[first + (self.rng.random(nodes) * size).astype(np.int64)]
            value = self.features[drawn, feature]
            below = self.features[rows, feature[node]] < value[node]
            lower = self._sums(rows[below], node[below], nodes)
            n_below = np.bincount(node[below], minlength=nodes)
            with np.errstate(invalid="ignore", divide="ignore"):
                purity = sum(
                    (part**2).sum(axis=1) / part.sum(axis=1) for part in (lower, sums - lower)
                )
            better = (n_below >= MIN_SAMPLES) & (size - n_below >= MIN_SAMPLES) & (purity > best)
            best = np.where(better, purity, best)
            found, threshold = np.where(better, feature, found), np.where(better, value, threshold)
            splits |= better
        return found, threshold, splits

    def _sums(self, rows: IntArray, node: IntArray, nodes: int) -> FloatArray:
        """Return the weight of each class at each node: (nodes, classes)."""
        column = node * self.count + self.classes[rows]
        sums = np.bincount(column, self.weights[rows], minlength=nodes * self.count)
        return np.asarray(sums, dtype=np.float64).reshape(nodes, self.count)
