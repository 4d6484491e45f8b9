"""Choice of the next level by staircases and QUEST+.

Nothing here is random, and the page makes the same choices. A run follows from its step
(docs/explanation/study-format.md) and the answers so far, so it resumes after a reload.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri, xlogy

LAPSES = (0.0, 0.03)
SLOPES = (0.5, 1.0, 2.0, 4.0, 8.0)
"""Widths of the psychometric function, in mean steps of the scale."""

FALSE_ALARMS = (0.0, 0.15)
"""Parts of "felt it" far below the threshold, of tasks with one interval."""

BEYOND = 0.3
"""Largest threshold above the levels, in parts of their range.

Thresholds above the levels are nearly flat functions. Without them, participants who feel no level
would have a threshold below the highest one.
"""


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

    def record(self, correct: bool) -> None:
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
    """State of one adaptive step.

    Parameters
    ----------
    step
        The step as stored in a list.
    """

    def __init__(self, step: dict[str, Any]) -> None:
        self.step = step
        self.trial = 0
        self._turn = 0
        self._next: int | None = None
        last = len(step["levels"]) - 1
        self._tracks = [
            _Track(t["start"], t["down"], t["steps"], last, t["reversals"])
            for t in step["tracks"] or []
        ]
        quest = step["quest"]
        if quest is not None:
            self._p = np.array(quest["p"])
            self._q = np.array(quest["prior"])
            self._logs = entropy_parts(self._p)
            # lists of version 0.2.0 have no thresholds
            old = np.linspace(-0.5, len(self._p) - 0.5, 2 * len(self._p) + 1)
            self._thresholds = np.array(
                quest.get("thresholds") or old.repeat(len(self._q) // len(old))
            )

    @property
    def over(self) -> bool:
        """True if no trial is left."""
        done = bool(self._tracks) and all(track.over for track in self._tracks)
        return done or self.trial >= self.step["most"]

    @property
    def reversals(self) -> int:
        """Number of reversals of all its tracks."""
        return sum(track.reversals for track in self._tracks)

    @property
    def posterior_mean(self) -> float:
        """Mean threshold of the QUEST+ hypotheses, in steps from the first level."""
        return float(self._q @ self._thresholds)

    @property
    def catch(self) -> bool:
        """True if the next trial presents no stimulus."""
        return bool(self.step["catch"][self.trial])

    @property
    def level(self) -> int:
        """Level index of the next trial."""
        if self._tracks:
            return self._track().at
        if self._next is None:
            self._next = next_level(self._p, self._q, self._logs)
        return self._next

    def _track(self) -> _Track:
        count = len(self._tracks)
        turns = (self._tracks[(self._turn + i) % count] for i in range(count))
        return next(track for track in turns if not track.over)

    def record(self, correct: bool) -> None:
        """Record the answer to the next trial."""
        if not self.catch:
            if self._tracks:
                track = self._track()
                self._turn = (self._tracks.index(track) + 1) % len(self._tracks)
                track.record(correct)
            else:
                self._q = update_posterior(self._p[self.level], self._q, correct)
                self._next = None
        self.trial += 1


def next_level(
    p: NDArray[np.float64],
    q: NDArray[np.float64],
    logs: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None,
) -> int:
    """Return the first level with the least expected entropy.

    `p` has the shape (levels, hypotheses) and `q` (hypotheses,); `logs` is `entropy_parts(p)`.
    """
    own = xlogy(q, q)
    expected = np.zeros(len(p))
    for share, part in zip((p, 1.0 - p), logs or entropy_parts(p), strict=True):
        probability = np.maximum(share @ q, np.finfo(np.float64).tiny)
        expected += xlogy(probability, probability) - part @ q - share @ own
    # rounding lets the order decide between equally informative levels
    return int(np.argmin(np.round(expected, 9)))


def entropy_parts(p: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return what the entropy of both answers has from the probabilities alone."""
    return xlogy(p, p), xlogy(1.0 - p, 1.0 - p)


def update_posterior(
    p: NDArray[np.float64], q: NDArray[np.float64], correct: bool
) -> NDArray[np.float64]:
    """Return the probabilities of the hypotheses after an answer."""
    found = q * (p if correct else 1.0 - p)
    return found / found.sum()  # type: ignore[no-any-return]


def quest_table(steps: NDArray[np.float64], guess: float) -> dict[str, Any]:
    """Return the QUEST+ hypotheses with equal prior probabilities.

    `steps` are the positions of the levels on their scale, in mean steps from the first. A
    hypothesis is a threshold, a slope, a lapse rate and, with a `guess` of 0, a rate of false
    alarms. The result has the keys `p` (levels,
    hypotheses), rounded to 6 decimals, `prior`, `thresholds` (of the hypotheses) and `steps`.
    """
    highest = steps[-1] + max(BEYOND * len(steps), 1.0)
    rows = product(
        np.arange(-0.5, highest, 0.5), SLOPES, LAPSES, [guess] if guess else FALSE_ALARMS
    )
    threshold, slope, lapse, low = np.array(list(rows)).T
    # without a side to guess, the threshold is where half of the answers are yes
    at_threshold = ndtri(0.5 if guess else (0.5 - low) / (1.0 - low - lapse))
    rise = ndtr((steps[:, None] - threshold) / slope + at_threshold)
    p = low + (1.0 - low - lapse) * rise
    p = np.round(np.clip(p, 0.001, 0.999), 6)
    prior = np.full(len(threshold), 1.0 / len(threshold))
    return {"p": p.tolist(), "prior": prior.tolist(), "thresholds": threshold.tolist(),
            "steps": steps.tolist()}  # fmt: skip
