"""Simulated learner who starts without knowledge, to compare orders of the examples of a lesson.

The learner stores a mean of the noisy features of each kind, and names an event by the nearest
mean. An example alone is stored as it is felt. Among several events, the learner knows only that
one of them has the name, and stores the one that is nearest to the mean so far; without a mean, any
of them. A pair, whose events are both named in order, is stored as two examples.

A reference just before an example stays in the memory for that example alone: it is felt with less
noise than a mean of examples before, so that the event among others can be recognised by it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_studies.lesson import Example, Lesson, Step, measured

SCATTER_JND = 3.0
"""Default standard deviation of a felt feature, JNDs."""

FORGETTING = 0.3
"""Lowest weight of a new example in a mean, so that early examples are forgotten."""


@dataclass(frozen=True)
class Lived:
    """One example as a learner lives it: named kind, true kinds and features of its events."""

    kind: str
    kinds: tuple[str, ...]
    features: NDArray[np.float64]
    named: bool


def lived_examples(lesson: Lesson) -> list[Lived]:
    """Return all examples of the steps before the questions, in order."""
    flat = [(step, example) for step in lesson.steps for example in step.examples]
    features = measured(lesson.preset, [example for _, example in flat])
    return [
        Lived(_named(step, example), example.kinds, rows, _is_named(step, example))
        for (step, example), rows in zip(flat, features, strict=True)
    ]


def _named(step: Step, example: Example) -> str:
    return example.kinds[0] if len(example.kinds) == 1 else step.kind


def _is_named(step: Step, example: Example) -> bool:
    """Return whether each of its events is named in order."""
    return len(example.kinds) == 1 or step.part == "pair"


class Learner:
    """A learner; `scatter` is the standard deviation of what is felt, in JNDs."""

    def __init__(self, rng: np.random.Generator, scatter: float = SCATTER_JND) -> None:
        self._rng, self._scatter = rng, scatter
        self._means: dict[str, NDArray[np.float64]] = {}
        self._counts: dict[str, int] = {}
        self._recent: tuple[str, NDArray[np.float64]] | None = None

    def learn(self, one: Lived) -> None:
        """Learn one example."""
        felt = self._feel(one.features)
        if one.named:
            for kind, row in zip(one.kinds, felt, strict=True):
                self._store(kind, row)
            self._recent = (one.kind, felt[0]) if len(felt) == 1 else None
            return
        known = self._means.get(one.kind)
        if self._recent is not None and self._recent[0] == one.kind:
            known = self._recent[1]
        chosen = int(self._rng.integers(len(felt))) if known is None else _nearest(known, felt)
        self._store(one.kind, felt[chosen])
        self._recent = None

    def name(self, features: NDArray[np.float64]) -> str:
        """Return the kind whose mean is nearest to an event; any kind before the first example."""
        if not self._means:
            return ""
        kinds = list(self._means)
        felt = self._feel(features[None, :])[0]
        return kinds[_nearest(felt, np.array([self._means[kind] for kind in kinds]))]

    def _feel(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        return features + self._scatter * self._rng.standard_normal(features.shape)

    def _store(self, kind: str, row: NDArray[np.float64]) -> None:
        self._counts[kind] = self._counts.get(kind, 0) + 1
        weight = max(1.0 / self._counts[kind], FORGETTING)
        old = self._means.get(kind, row)
        self._means[kind] = old + weight * (row - old)


def _nearest(known: NDArray[np.float64], rows: NDArray[np.float64]) -> int:
    return int(np.argmin(np.sum(np.square(rows - known), axis=1)))


def taught_share(
    lived: Sequence[Lived],
    asked: Sequence[tuple[str, NDArray[np.float64]]],
    rng: np.random.Generator,
    scatter: float = SCATTER_JND,
    repeats: int = 20,
) -> float:
    """Return the share of events that one learner names correctly after these examples."""
    learner = Learner(rng, scatter)
    for one in lived:
        learner.learn(one)
    right = [learner.name(row) == kind for _ in range(repeats) for kind, row in asked]
    return float(np.mean(right))


def compare_orders(
    lesson: Lesson, learners: int, seed: int, scatter: float = SCATTER_JND
) -> NDArray[np.float64]:
    """Return the shares of each learner with the order of the lesson and a random one: (n, 2).

    Both have the same examples, and the same kinds are asked.
    """
    lived = lived_examples(lesson)
    asked = [(one.kind, one.features[0]) for one in lived if len(one.kinds) == 1]
    asked = list({kind: (kind, row) for kind, row in asked if kind in lesson.choices}.values())
    found = []
    for person in range(learners):
        order = np.random.default_rng([seed, person, 0]).permutation(len(lived))
        mixed = [lived[i] for i in order]
        rngs = [np.random.default_rng([seed, person, 1]) for _ in range(2)]
        found.append([
            taught_share(examples, asked, rng, scatter)
            for examples, rng in zip((lived, mixed), rngs, strict=True)
        ])  # fmt: skip
    return np.array(found)
