"""Progress and scores of lessons, in a file of the user that every step updates.

The file is JSON, by preset: `scores`, a list of results with their dates, and `progress` of a
lesson that has begun: `seed`, `digest`, `whole`, `done` (number of completed steps) and `answers`.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import platformdirs

from overview_dsp.cli.extensions import write_file
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
        entry = self._read().get(name, {})
        self.scores = [_score(one) for one in entry.get("scores", [])]
        progress = entry.get("progress")
        seed = len(self.scores) if progress is None else int(progress["seed"])
        self.lesson = make(seed)
        if progress is not None and progress["digest"] != self.lesson.digest:
            progress = None  # of another version of the preset
        self.resumed = progress is not None and not (again and not progress["whole"])
        if progress is None or not self.resumed:
            progress = {"seed": seed, "digest": self.lesson.digest, "done": 0, "answers": [],
                        "whole": again or not self.scores}  # fmt: skip
        self._progress: dict[str, Any] = progress
        questions = self.lesson.questions
        self.steps = (*self.lesson.steps, *questions) if progress["whole"] else questions
        self.score: Score | None = None

    @property
    def path(self) -> Path:
        """Path of the file."""
        return self._path

    @property
    def done(self) -> int:
        """Number of completed steps."""
        return int(self._progress["done"])

    @property
    def answers(self) -> tuple[str, ...]:
        """Answers to the questions so far."""
        return tuple(self._progress["answers"])

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
        kinds, whole = len(self.lesson.kinds), self._progress["whole"]
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
        answers = [*self.answers, *([] if answer is None else [answer])]
        self._progress = {**self._progress, "done": step + 1, "answers": answers}
        if self.current is None:
            self.score = self._result()
        self._write()

    def _result(self) -> Score:
        kinds = (one.kind for one in self.lesson.questions)
        pairs = list(zip(kinds, self.answers, strict=True))
        mistakes = tuple(pair for pair in pairs if pair[0] != pair[1])
        return Score(self._today, len(pairs) - len(mistakes), len(pairs), mistakes)

    def _read(self) -> dict[str, Any]:
        try:
            found = json.loads(self._path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return {}
        except (OSError, ValueError) as error:
            raise InputError(f"{self._path}: cannot be read ({error}); delete it") from None
        if not isinstance(found, dict):
            raise InputError(f"{self._path}: must be a table of lessons; delete it")
        return found

    def _write(self) -> None:
        # read again, since another lesson may have changed the file
        table = self._read()
        scores = [asdict(one) for one in self.scores]
        entry: dict[str, Any] = {"scores": scores}
        if self.score is None:
            entry["progress"] = self._progress
        else:
            scores.append(asdict(self.score))
        table[self._name] = entry
        self._path.parent.mkdir(parents=True, exist_ok=True)
        write_file(self._path, json.dumps(table, indent=1, ensure_ascii=False) + "\n")


def _score(row: dict[str, Any]) -> Score:
    pairs = tuple((str(kind), str(answer)) for kind, answer in row["confused"])
    return Score(str(row["date"]), int(row["right"]), int(row["of"]), pairs)
