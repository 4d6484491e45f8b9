"""Progress and scores of lessons, in a file of the user that every step updates.

The file is JSON, by preset: `scores`, a list of results with their dates, and `progress` of a
lesson that has begun: `seed`, `digest`, `whole`, `done` (number of completed steps) and `answers`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import platformdirs
from pydantic import TypeAdapter, ValidationError

from overview_dsp.cli.extensions import read_table, write_table
from overview_dsp.errors import InputError
from overview_studies.lesson import QUESTIONS, Lesson, Step, label


@dataclass(frozen=True)
class Score:
    """Result of ten questions.

    Attributes
    ----------
    date : str
        Day of the last answer, such as 2026-11-20.
    right, of : int
        Number of right answers, and of questions.
    confused : tuple of (str, str)
        Presented kind and answer of each mistake.
    """

    date: str
    right: int
    of: int
    confused: tuple[tuple[str, str], ...]

    @property
    def text(self) -> str:
        """The score and its mistakes as a sentence."""
        counts = Counter(self.confused).most_common()
        pairs = (
            f"{label(kind)} with {label(answer)}" + (f" ({count} times)" if count > 1 else "")
            for (kind, answer), count in counts
        )
        mistakes = f" Confused: {', '.join(pairs)}." if counts else ""
        return f"{self.right} of {self.of} right.{mistakes}"


@dataclass(frozen=True)
class Progress:
    """Progress of a pass."""

    seed: int
    digest: str
    whole: bool
    done: int = 0
    answers: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Entry:
    scores: tuple[Score, ...] = ()
    progress: Progress | None = None


_ENTRY = TypeAdapter(_Entry)


def scores_file() -> Path:
    """Return the default path of the scores: `lessons.json` in the data folder of the user."""
    return platformdirs.user_data_path("overview-dsp", appauthor=False) / "lessons.json"


class Attempt:
    """One pass through a lesson, stored after each step; a new object resumes it.

    A first pass has all steps. Later ones have the questions alone, unless `again` is set.

    Parameters
    ----------
    path : Path or None
        File of the scores; None for `scores_file`.
    name : str
        Name of the lesson in the file.
    make : callable
        Function that makes the lesson from a seed; each pass has another one.
    today : str
        Date, such as 2026-11-27.

    Raises
    ------
    InputError
        The file is damaged.
    """

    def __init__(
        self,
        path: Path | None,
        name: str,
        make: Callable[[int], Lesson],
        today: str,
        again: bool = False,
    ) -> None:
        self._path, self._name, self._today = path or scores_file(), name, today
        entry = self._read()
        self.scores, progress = entry.scores, entry.progress
        seed = len(self.scores) if progress is None else progress.seed
        self.lesson = make(seed)
        if progress is not None and progress.digest != self.lesson.digest:
            progress = None  # of another version of the preset
        self.resumed = progress is not None and not (again and not progress.whole)
        if progress is None or not self.resumed:
            progress = Progress(seed, self.lesson.digest, again or not self.scores)
        self._progress = progress
        questions = self.lesson.questions
        self.steps = (*self.lesson.steps, *questions) if progress.whole else questions
        self.score: Score | None = None
        answered = [step for step in self.steps[: self.done] if step.part == "question"]
        unknown = set(self.answers) - set(self.lesson.choices)
        if not 0 <= self.done < len(self.steps) or len(answered) != len(self.answers) or unknown:
            raise self._damaged("not of this lesson", "progress")

    @property
    def path(self) -> Path:
        """Path of the file."""
        return self._path

    @property
    def done(self) -> int:
        """Number of completed steps."""
        return self._progress.done

    @property
    def answers(self) -> tuple[str, ...]:
        """Answers to the questions so far."""
        return self._progress.answers

    @property
    def current(self) -> Step | None:
        """The step that is next; None at the end."""
        return self.steps[self.done] if self.done < len(self.steps) else None

    @property
    def last(self) -> Score | None:
        """The score of the pass before this one."""
        return self.scores[-1] if self.scores else None

    @property
    def welcome(self) -> str:
        """Text about the lesson and the last score."""
        kinds, whole = len(self.lesson.kinds), self._progress.whole
        length = f"about {self.lesson.minutes} min" if whole else f"{QUESTIONS} questions"
        text = f"{self.lesson.title}: {kinds} kinds, {length}."
        if self.last is not None:
            text += f" Last time {self.last.right} of {self.last.of} on {self.last.date}."
        if self.resumed:
            text += f" You continue at step {self.done + 1} of {len(self.steps)}."
        return text

    def complete(self, step: int, answer: str | None = None) -> None:
        """Store that step number `step` (from 0) is completed; a repeated call does nothing.

        Raises
        ------
        InputError
            The step is not the next one, or the answer is missing or not a choice.
        """
        if 0 <= step < self.done:
            return
        current = self.current
        if current is None or step != self.done:
            raise InputError(f"step {step} is not the next one, {self.done}")
        if (current.part == "question") != (answer is not None):
            raise InputError(f"step {step}: only a question has an answer")
        if answer is not None and answer not in self.lesson.choices:
            raise InputError(f"answer {answer!r}: must be one of {', '.join(self.lesson.choices)}")
        answers = self.answers if answer is None else (*self.answers, answer)
        self._progress = replace(self._progress, done=step + 1, answers=answers)
        if self.current is None:
            self.score = self._result()
        self._write()

    def _result(self) -> Score:
        kinds = (one.kind for one in self.lesson.questions)
        pairs = list(zip(kinds, self.answers, strict=True))
        mistakes = tuple(pair for pair in pairs if pair[0] != pair[1])
        return Score(self._today, len(pairs) - len(mistakes), len(pairs), mistakes)

    def _read(self) -> _Entry:
        try:
            return _ENTRY.validate_python(self._table().get(self._name, {}))
        except ValidationError as error:
            first = error.errors()[0]
            raise self._damaged(first["msg"], *first["loc"]) from None

    def _table(self) -> dict[str, object]:
        return read_table(self._path, "must be a table of lessons")

    def _damaged(self, fault: str, *keys: object) -> InputError:
        where = ".".join(map(str, (self._name, *keys)))
        return InputError(f"{self._path}: {where}: {fault}; correct or delete it")

    def _write(self) -> None:
        entry: dict[str, Any] = {"scores": [asdict(one) for one in self.scores]}
        if self.score is None:
            entry["progress"] = asdict(self._progress)
        else:
            entry["scores"].append(asdict(self.score))
        # read again, since another lesson may have changed the file
        write_table(self._path, {**self._table(), self._name: entry})
