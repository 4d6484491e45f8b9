"""Trials of a blind comparison (ABX), their statistics and their file."""

from __future__ import annotations

import csv
import math
import random
import time
from pathlib import Path

from overview_dsp.files.atomic import output_error

COLUMNS = ("trial", "x", "answer", "is_right", "time_s", "hits", "trials", "p", "d_prime")


def abx_p(hits: int, trials: int) -> float:
    """Return the probability of at least so many hits by guessing (exact binomial test)."""
    from scipy.stats import binom  # slow

    return float(binom.sf(hits - 1, trials, 0.5))


def abx_d_prime(hits: int, trials: int) -> float:
    """Return d' of an ABX test (Macmillan and Creelman 2005, chapter 9: independent observations).

    Without a wrong answer half of one is counted, as d' would be infinite. Half of the
    answers and less are 0.
    """
    from scipy.optimize import brentq
    from scipy.stats import norm

    right = min(hits, trials - 0.5) / trials
    if right <= 0.5:
        return 0.0

    def excess(d: float) -> float:
        far, near = d / math.sqrt(2.0), d / 2.0
        return float(norm.cdf(far) * norm.cdf(near) + norm.cdf(-far) * norm.cdf(-near)) - right

    return float(brentq(excess, 0.0, 20.0))


class AbxTrials:
    """Trials: X is A or B, drawn at random for each answer, which is at once a row of a file.

    Attributes
    ----------
    x : int
        Index of the present X: 0 is A, 1 is B.
    felt_x : bool
        Whether X was played since it was drawn.
    hits, trials : int
        Number of right answers, and of all answers.
    """

    def __init__(self, path: Path, seed: int | None = None) -> None:
        """Write the answers to a new CSV file. `seed`: of X; None: another each time."""
        self._path = path
        self._random = random.Random(seed) if seed is not None else random.SystemRandom()
        self._began_s = time.monotonic()
        self.hits = self.trials = 0
        self._unwritten: list[tuple[object, ...]] = []  # rows that found no room on the disk
        self.x, self.felt_x = self._random.randrange(2), False

    def answer(self, index: int) -> str:
        """Take an answer (0: X is A), draw X again and return a message.

        InputError or OutputError: the answer can't be written yet; it is kept for the next one.
        """
        if not self.felt_x:
            return "X was not felt yet; press x"
        self.trials += 1
        self.hits += index == self.x
        self._unwritten.append((
            self.trials, "AB"[self.x], "AB"[index], int(index == self.x),
            f"{time.monotonic() - self._began_s:.2f}", self.hits, self.trials,
            f"{abx_p(self.hits, self.trials):.4g}", f"{abx_d_prime(self.hits, self.trials):.3f}",
        ))  # fmt: skip
        self.x, self.felt_x = self._random.randrange(2), False
        try:
            header = [] if self._path.exists() else [COLUMNS]
            with open(self._path, "a", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows([*header, *self._unwritten])
        except OSError as error:
            raise output_error(self._path, error) from error
        self._unwritten.clear()
        return f"answer {self.trials}; X is drawn again"

    @property
    def result_text(self) -> str:
        """Result as a sentence."""
        if not self.trials:
            return "no answers in the blind comparison"
        p, d_prime = abx_p(self.hits, self.trials), abx_d_prime(self.hits, self.trials)
        return (
            f"{self._path}: {self.hits} of {self.trials} right, p {p:.3g} by guessing, "
            f"d' {d_prime:.2f}"
        )
