"""Classifier of extremely randomised trees (Geurts, Ernst and Wehenkel 2006) in plain numpy.

Each node of a tree is split by the best of several random candidates, by weighted Gini impurity. A
candidate compares one feature with its value in a random sample of the node. A node is a leaf if it
is pure, or if no candidate leaves `MIN_SAMPLES` or more on both sides. A forest predicts the class
with the largest mean share in the leaves of its trees. All nodes of a depth are split at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import BoolArray, FloatArray, IntArray

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
                sides = (lower, sums - lower)
                purity = sum((side**2).sum(axis=1) / side.sum(axis=1) for side in sides)
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
