"""Staircases and QUEST+: which level comes next. Nothing here is random; a page does the same.

A run is told by its step (docs/explanation/study-format.md) and the answers so far, so a reload
goes on where it was.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, xlogy

LAPSES = (0.0, 0.02, 0.05)
SLOPES = (0.5, 1.0, 2.0)
"""Widths of the psychometric function, in steps from level to level."""


@dataclass
class _Track:
    at: int
    down: int
    steps: list[int]
    last: int
    most: int
    right: int = 0
    reversals: int = 0
    move: int = 0

    @property
    def over(self) -> bool:
        return self.reversals >= self.most

    def answered(self, correct: bool) -> None:
        self.right = self.right + 1 if correct else 0
        move = -1 if self.right == self.down else 0 if correct else 1
        if not move:
            return
        self.right = 0
        if self.move and move != self.move:
            self.reversals += 1
        self.move = move
        step = self.steps[min(self.reversals, len(self.steps) - 1)]
        self.at = min(max(self.at + move * step, 0), self.last)


class Run:
    """One adaptive step being answered.

    Parameters
    ----------
    step
        As a list holds it.
    """

    def __init__(self, step: dict[str, Any]) -> None:
        self.step = step
        self.trial = 0
        self._turn = 0
        last = len(step["levels"]) - 1
        self._tracks = [
            _Track(t["start"], t["down"], t["steps"], last, t["reversals"])
            for t in step["tracks"] or []
        ]
        quest = step["quest"]
        if quest is not None:
            self._p = np.array(quest["p"])
            self._q = np.array(quest["prior"])

    @property
    def over(self) -> bool:
        """Whether there is no further trial."""
        done = bool(self._tracks) and all(track.over for track in self._tracks)
        return done or self.trial >= self.step["most"]

    @property
    def reversals(self) -> int:
        """How often its tracks have turned."""
        return sum(track.reversals for track in self._tracks)

    @property
    def believed(self) -> float:
        """The mean threshold of QUEST+'s hypotheses, as a level's index."""
        return float(self._q @ thresholds_of(len(self.step["levels"])))

    @property
    def catch(self) -> bool:
        """Whether nothing is played in the next trial."""
        return bool(self.step["catch"][self.trial])

    @property
    def level(self) -> int:
        """The index of the next trial's level."""
        if self._tracks:
            return self._track().at
        return next_level(self._p, self._q)

    def _track(self) -> _Track:
        count = len(self._tracks)
        turns = (self._tracks[(self._turn + i) % count] for i in range(count))
        return next(track for track in turns if not track.over)

    def answered(self, correct: bool) -> None:
        """Take the answer to the next trial."""
        if not self.catch:
            if self._tracks:
                track = self._track()
                self._turn = (self._tracks.index(track) + 1) % len(self._tracks)
                track.answered(correct)
            else:
                self._q = posterior(self._p[self.level], self._q, correct)
        self.trial += 1


def next_level(p: NDArray[np.float64], q: NDArray[np.float64]) -> int:
    """The first level of least expected entropy; `p` (levels, hypotheses), `q` (hypotheses,)."""
    right = p @ q
    entropies = []
    for m, one in zip(right, p, strict=True):
        expected = 0.0
        for part, chance in ((one * q, m), ((1.0 - one) * q, 1.0 - m)):
            if chance > 0.0:
                expected -= chance * float(xlogy(part / chance, part / chance).sum())
        # levels that tell as much are told apart by their order, not by rounding
        entropies.append(round(expected, 9))
    return int(np.argmin(entropies))


def posterior(p: NDArray[np.float64], q: NDArray[np.float64], correct: bool) -> NDArray[np.float64]:
    """What is believed of the hypotheses after an answer."""
    found = q * (p if correct else 1.0 - p)
    return found / found.sum()  # type: ignore[no-any-return]


def quest_table(levels: int, guess: float) -> dict[str, Any]:
    """Hypotheses over level indexes: threshold, slope, lapse, each as likely at first.

    Returns `p` (levels, hypotheses), rounded to 6 decimals, and `prior`.
    """
    index = np.arange(levels, dtype=np.float64)
    rows = []
    for threshold, slope, lapse in _hypotheses(levels):
        rise = ndtr((index - threshold) / slope)
        rows.append(guess + (1.0 - guess - lapse) * rise)
    p = np.round(np.clip(np.array(rows).T, 0.001, 0.999), 6)
    return {"p": p.tolist(), "prior": np.full(p.shape[1], 1.0 / p.shape[1]).tolist()}


def thresholds_of(levels: int) -> NDArray[np.float64]:
    """The threshold of each hypothesis, as a level's index."""
    return np.array([threshold for threshold, _, _ in _hypotheses(levels)])


def _hypotheses(levels: int) -> list[tuple[float, float, float]]:
    thresholds = np.linspace(-0.5, levels - 0.5, 2 * levels + 1).tolist()
    return list(product(thresholds, SLOPES, LAPSES))
