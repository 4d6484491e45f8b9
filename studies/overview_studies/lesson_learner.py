"""Simulated learner who starts without knowledge, to compare orders of the examples of a lesson.

The learner has two sorts of noise, as in the theory of Durlach and Braida (1969). Sensory noise is
one JND and is all that limits the comparison with the example just before. Memory noise is larger
and is added to an example when it is stored.

The learner stores a mean of each kind and names an event by the nearest mean. An example alone is
stored as it is felt. Of several events the learner knows one name (a crowd) or both (a pair), but
not which event has it: each name goes to the event that is nearest to one of the two examples just
before, if they had that name, else to the remembered mean. Names without any go to random events.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from overview_studies.lesson import Lesson, measured

SENSORY_JND = 1.0
"""Standard deviation of a felt feature, JNDs."""

MEMORY_JND = 4.0
"""Default standard deviation that a feature gets when it is stored, JNDs."""

JUST_BEFORE = 2
"""Number of examples before, alone, that are compared without memory noise."""


@dataclass(frozen=True)
class Lived:
    """One example as a learner lives it: its names, and kinds and features of its events."""

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    features: NDArray[np.float64]


def lived_examples(lesson: Lesson) -> list[Lived]:
    """Return all examples of the steps before the questions, in order."""
    flat = [(step, example) for step in lesson.steps for example in step.examples]
    features = measured(lesson.preset, [example for _, example in flat])
    return [
        Lived((step.kind,) if len(example.kinds) > 2 else example.kinds, example.kinds, rows)
        for (step, example), rows in zip(flat, features, strict=True)
    ]


class Learner:
    """A learner; `memory` is the noise of stored features, in JNDs."""

    def __init__(self, rng: np.random.Generator, memory: float = MEMORY_JND) -> None:
        self._rng, self._memory = rng, memory
        self._means: dict[str, NDArray[np.float64]] = {}
        self._counts: dict[str, int] = {}
        self._before: list[tuple[str, NDArray[np.float64]]] = []

    def learn(self, one: Lived) -> None:
        """Learn one example."""
        felt = self._noisy(one.features, SENSORY_JND)
        if len(felt) == 1:
            self._store(one.names[0], felt[0])
            self._before = [*self._before, (one.names[0], felt[0])][-JUST_BEFORE:]
            return
        cost = [self._distances(name, felt) for name in one.names]
        # unknown names have equal costs, so their events are shuffled
        order = self._rng.permutation(len(felt))
        rows, columns = linear_sum_assignment(np.array(cost)[:, order])
        for row, column in zip(rows, columns, strict=True):
            self._store(one.names[row], felt[order[column]])
        self._before = []

    def _distances(self, name: str, felt: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the squared distance of each event from a name; 0 if the name is unknown."""
        for kind, row in reversed(self._before):
            if kind == name:
                return np.asarray(np.sum(np.square(felt - row), axis=1))
        if name not in self._means:
            return np.zeros(len(felt))
        return np.asarray(np.sum(np.square(felt - self._means[name]), axis=1))

    def name(self, features: NDArray[np.float64]) -> str:
        """Return the kind whose remembered mean is nearest to an event; "" without examples."""
        if not self._means:
            return ""
        kinds = list(self._means)
        felt = self._noisy(features, SENSORY_JND)
        return kinds[_nearest(felt, np.array([self._means[kind] for kind in kinds]))]

    def _noisy(self, values: NDArray[np.float64], jnds: float) -> NDArray[np.float64]:
        return values + jnds * self._rng.standard_normal(values.shape)

    def _store(self, kind: str, row: NDArray[np.float64]) -> None:
        self._counts[kind] = self._counts.get(kind, 0) + 1
        stored = self._noisy(row, self._memory)
        old = self._means.get(kind, stored)
        self._means[kind] = old + (stored - old) / self._counts[kind]


def _nearest(known: NDArray[np.float64], rows: NDArray[np.float64]) -> int:
    return int(np.argmin(np.sum(np.square(rows - known), axis=1)))


def taught_share(
    lived: Sequence[Lived],
    questions: Sequence[tuple[str, NDArray[np.float64]]],
    rng: np.random.Generator,
    memory: float = MEMORY_JND,
    repeats: int = 6,
) -> float:
    """Return the share of events that one learner names correctly after these examples."""
    learner = Learner(rng, memory)
    for one in lived:
        learner.learn(one)
    right = [learner.name(row) == kind for _ in range(repeats) for kind, row in questions]
    return float(np.mean(right))


def compare_orders(
    lesson: Lesson, learners: int, seed: int, memory: float = MEMORY_JND
) -> NDArray[np.float64]:
    """Return the shares of each learner with the order of the lesson and a random one: (n, 2).

    Both have the same examples, and the same kinds are questions.
    """
    lived = lived_examples(lesson)
    questions = [(one.kinds[0], one.features[0]) for one in lived if len(one.kinds) == 1]
    questions = list(
        {kind: (kind, row) for kind, row in questions if kind in lesson.choices}.values()
    )
    found = []
    for person in range(learners):
        order = np.random.default_rng([seed, person, 0]).permutation(len(lived))
        mixed = [lived[i] for i in order]
        rngs = [np.random.default_rng([seed, person, 1]) for _ in range(2)]
        found.append([
            taught_share(examples, questions, rng, memory)
            for examples, rng in zip((lived, mixed), rngs, strict=True)
        ])  # fmt: skip
    return np.array(found)
