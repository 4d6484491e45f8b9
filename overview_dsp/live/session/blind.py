"""Blind comparisons (ABX): is X the sensation A or B? Trials, statistics, those of a session."""

from __future__ import annotations

import csv
import math
import random
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import output_errors

if TYPE_CHECKING:
    from overview_dsp.live.session.player import Player

COLUMNS = ("trial", "x", "answer", "is_right", "time_s", "hits", "trials", "p", "d_prime")
KEYS = {"a": ("blind", "a"), "b": ("blind", "b"), "x": ("blind", "x"),
        "A": ("blind", "is-a"), "B": ("blind", "is-b")}  # fmt: skip
"""Commands that are one key during a blind comparison."""


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

    `x`: index of the present X: 0 is A, 1 is B.
    `felt_x`: whether X was played since it was drawn.
    `hits`, `trials`: number of right answers, and of all answers.
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
        with output_errors(self._path):
            header = [] if self._path.exists() else [COLUMNS]
            with open(self._path, "a", newline="", encoding="utf-8") as file:
                csv.writer(file).writerows([*header, *self._unwritten])
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


class BlindComparison(AbxTrials):
    """Trials in a session: A and B are its presets. Each choice restarts the engine at rest.

    Thread: control.
    """

    def __init__(
        self,
        player: Player,
        presets: Sequence[Preset],
        path: Path,
        gesture: Gesture | None = None,
        repeats: bool = True,
        seed: int | None = None,
    ) -> None:
        """Compare two presets by a gesture, or by the user's hand without one.

        `path`: new CSV file of the answers. `seed`: of the drawn presets; None: another each time.
        """
        super().__init__(path, seed)
        self._player, self._gesture, self._repeats = player, gesture, repeats
        player.active_window.presets.fix(presets)

    def run(self, word: str) -> None:
        """Play `a`, `b` or `x`, or take an answer, `is-a` or `is-b`; InputError for others."""
        if word in ("is-a", "is-b"):
            self._player.say(self.answer("ab".index(word[-1])))
        elif word in ("a", "b", "x"):
            self._choose(word)
        else:
            raise InputError(f"{word!r} must be a, b, x, is-a or is-b")

    def _choose(self, name: str) -> None:
        player, window = self._player, self._player.active_window
        if not player.output.playing:
            player.say("no output; choose again when it plays")
            return
        index = self.x if name == "x" else "ab".index(name)
        window.pop_requested_preset()
        if self._gesture is None:
            preset = window.presets.choose(index)
            player.loop.restart(window.window_timeline, window.window, preset)
        else:
            window.presets.next_choice = index
            player.loop.begin(self._gesture, name.upper(), self._repeats)
            if not player.loop.playing:  # the output doesn't respond, as was reported
                return
        self.felt_x |= name == "x"
        player.say(f"now {name.upper()}")
