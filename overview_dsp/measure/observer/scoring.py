"""Scores of an observer: recall over the events passed, precision over its reports, confusions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.files.toml import load_toml
from overview_dsp.measure.observer.features import RHYTHM_MS

NOTHING = "nothing"
"""Answer of an observer that takes an onset for the intensity curve, and class of an event without
an onset."""


@dataclass(frozen=True, eq=False)
class ObserverScores:
    """Answers of an observer in one stroke, summed over timelines and draws of its noise.

    Attributes
    ----------
    kinds : tuple of str
        Classes of its answers, without "nothing".
    confusion : int64 (kinds + 1, kinds + 1)
        Rows: true kind of the events passed; the last row: reports without an event. Columns:
        answer; the last column: nothing, or no onset. An event with several onsets counts as
        recognised if one of them was.
    reports, right : int64 (kinds,)
        Number of reports of each kind, at most one in 120 ms for one event; number of true ones.
    draws : int
        Number of times that each stroke is counted, each time with different noise.

    Examples
    --------
    >>> table = np.array([[9, 1, 0], [1, 7, 2], [0, 1, 0]])
    >>> scores = ov.measure.ObserverScores(
    ...     ("goal", "card"), table, np.array([10, 9]), np.array([9, 7]), 1
    ... )
    >>> scores.recall, scores.precision.round(2), scores.balanced
    (array([0.9, 0.7]), array([0.9 , 0.78]), 0.8)
    """

    kinds: tuple[str, ...]
    confusion: IntArray
    reports: IntArray
    right: IntArray
    draws: int

    @property
    def events(self) -> IntArray:
        """Number of passed events of each kind, each counted once per draw."""
        return np.asarray(self.confusion[:-1].sum(axis=1), dtype=np.int64)

    @property
    def recall(self) -> FloatArray:
        """Share of each kind's events that was recognised; NaN without events."""
        return _shares(np.diagonal(self.confusion)[:-1], self.events)

    @property
    def precision(self) -> FloatArray:
        """Share of each kind's reports that was true; NaN without reports."""
        return _shares(self.right, self.reports)

    @property
    def f1(self) -> FloatArray:
        """The harmonic mean of recall and precision; NaN without events."""
        precision = np.nan_to_num(self.precision)  # without reports, recall is 0 too
        total = self.recall + precision
        return _shares(2.0 * self.recall * precision, np.where(total > 0.0, total, 1.0))

    @property
    def balanced(self) -> float:
        """Mean recall of the kinds that were passed; NaN if none was."""
        known = self.recall[self.events > 0]
        return float(known.mean()) if len(known) else float("nan")

    def to_json(self) -> dict[str, Any]:
        """Return plain data of the kinds that were passed or reported.

        Returns
        -------
        dict
            Texts, numbers and lists, for JSON. The rows and columns of the confusion matrix are
            these kinds and "nothing".

        Examples
        --------
        >>> table = np.array([[9, 1], [0, 0]])
        >>> scores = ov.measure.ObserverScores(("goal",), table, np.array([9]), np.array([9]), 1)
        >>> scores.to_json()["kinds"]["goal"]
        {'events': 10, 'recall': 0.9, 'precision': 1.0, 'f1': 0.9474}
        """
        rows = np.flatnonzero((self.events > 0) | (self.reports > 0))
        columns = np.append(rows, len(self.kinds))
        return {
            "balanced": _rounded(self.balanced),
            "kinds": {
                self.kinds[row]: {
                    # each event counts once per draw
                    "events": int(self.events[row]) // self.draws,
                    "recall": _rounded(self.recall[row]),
                    "precision": _rounded(self.precision[row]),
                    "f1": _rounded(self.f1[row]),
                }
                for row in rows.tolist()
            },
            "draws": self.draws,
            "confusion": self.confusion[np.ix_(columns, columns)].tolist(),
        }

    def __repr__(self) -> str:
        return (
            f"<ObserverScores: {len(self.kinds)} kinds, {int(self.events.sum())} events passed, "
            f"balanced recall {self.balanced:.2f}>"
        )


def _shares(some: NDArray[Any], of: NDArray[Any]) -> FloatArray:
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(some / of, dtype=np.float64)


def _rounded(value: float) -> float | None:
    return round(float(value), 4) if np.isfinite(value) else None


class Tally:
    """Counter of an observer's answers; `group` maps each class to one of `kinds`.

    Classes are the preset's kinds by index. The last class is "nothing".
    """

    def __init__(self, kinds: tuple[str, ...], group: IntArray) -> None:
        self.kinds, self.group = kinds, group
        count = len(kinds)
        self.confusion = np.zeros((count + 1, count + 1), dtype=np.int64)
        self.reports = np.zeros(count, dtype=np.int64)
        self.right = np.zeros(count, dtype=np.int64)

    def add(self, at_ms: IntArray, answers: IntArray, owner: IntArray, kinds: IntArray) -> None:
        """Count the onsets of a stroke (time, answer, row of its event) and its events."""
        nothing = len(self.kinds)
        named: dict[int, list[int]] = {}
        true = self.group[kinds].tolist()
        last: dict[int, tuple[int, int]] = {}
        onsets = zip(at_ms.tolist(), self.group[answers].tolist(), owner.tolist(), strict=True)
        for at, name, row in onsets:
            named.setdefault(row, []).append(name)
            if name == nothing:
                continue
            before, of = last.get(name, (-(2**60), -1))
            if at - before <= RHYTHM_MS and of == row:
                continue
            last[name] = (at, row)
            self.reports[name] += 1
            self.right[name] += row >= 0 and true[row] == name
            if row < 0:
                self.confusion[nothing, name] += 1
        for row, kind in enumerate(true):
            names = named.get(row, [])
            others = [name for name in names if name != nothing]
            taken = kind if kind in names else others[0] if others else nothing
            self.confusion[kind, taken] += 1

    def scores(self, draws: int) -> ObserverScores:
        """Return the scores so far."""
        return ObserverScores(self.kinds, self.confusion, self.reports, self.right, draws)


GROUPS: dict[str, str] = load_toml(__file__, "groups.toml")
"""Group of each kind, for scores that do not distinguish the kinds of a group."""

MINOR = "minor"  # group of all other kinds


def groups_of(kinds: Sequence[str]) -> tuple[str, ...]:
    """Return the group of each kind; without any known kind, each is a group."""
    if not any(kind in GROUPS for kind in kinds):
        return tuple(kinds)
    return tuple(GROUPS.get(kind, MINOR) for kind in kinds)
