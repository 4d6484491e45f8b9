"""Lesson in a terminal: plain lines, which screen readers read, and single keys."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import click

from overview_studies.lesson import QUESTIONS, Example, Lesson, Step, label
from overview_studies.lesson_scores import Attempt

NEXT, REPEAT, QUIT = "\n", "r", "q"
POLL_S = 0.05
HELP = "Keys: Enter continues, r repeats, q ends the lesson and keeps your place."

HEADINGS = {
    "alone": "Each kind alone.",
    "pair": "Two kinds, one after the other. You feel each alone first.",
    "crowd": "Each kind among others. You feel it alone first.",
    "question": f"{QUESTIONS} questions. Press the number of your answer.",
}

Play = Callable[[Example], list[str]]
ReadKey = Callable[[], str]
"""Function that waits for a key; "" at the end of the input."""


class TerminalLesson:
    """Lesson as lines of text, or of JSON.

    Parameters
    ----------
    attempt : Attempt
    play : callable
        Function that plays an example, and returns the kinds that were struck.
    read_key : callable
    as_json : bool
        Whether each line is a JSON object.
    """

    def __init__(self, attempt: Attempt, play: Play, read_key: ReadKey, as_json: bool) -> None:
        self._attempt, self._play, self._read_key = attempt, play, read_key
        self._as_json = as_json

    @property
    def _lesson(self) -> Lesson:
        return self._attempt.lesson

    def run(self) -> bool:
        """Run the remaining steps; return whether the lesson is complete."""
        attempt, part = self._attempt, ""
        self._emit({"lesson": self._lesson.name, "steps": len(attempt.steps), "done": attempt.done},
                   attempt.welcome, HELP)  # fmt: skip
        while (step := attempt.current) is not None:
            if step.part != part:
                part = step.part
                self._emit({"part": part}, "", HEADINGS[part])
            if not (self._ask(step) if part == "question" else self._show(step)):
                name = self._lesson.name
                self._emit({"stopped": attempt.done},
                           f"Your place is stored. Continue: overview learn {name}")  # fmt: skip
                return False
        assert attempt.score is not None
        score = attempt.score
        self._emit(
            {"right": score.right, "of": score.of, "confused": score.confused},
            "",
            score.text,
            "On another day, the same command asks again. --again repeats the whole lesson.",
        )
        return True

    def _show(self, step: Step) -> bool:
        number = self._attempt.done
        report = {"step": number + 1, "kind": step.kind, "text": step.text}
        self._emit(report, f"{number + 1} of {len(self._attempt.steps)}: {step.text}")
        key = REPEAT
        while True:
            if key == REPEAT:
                for example in step.examples:
                    self._play_one(example, len(step.examples) > 1)
            elif key in (NEXT, " "):
                self._attempt.complete(number)
                return True
            elif key in (QUIT, ""):
                return False
            key = self._read_key()

    def _ask(self, step: Step) -> bool:
        number, choices = self._attempt.done, self._lesson.choices
        question = 1 + len(self._attempt.answers)
        listed = ", ".join(f"{i} {label(kind)}" for i, kind in enumerate(choices, 1))
        self._emit({"question": question, "choices": choices},
                   f"Question {question} of {QUESTIONS}. {step.text}", listed)  # fmt: skip
        key = REPEAT
        while True:
            if key == REPEAT:
                self._play_one(step.examples[0], False)
            elif key.isdecimal() and 1 <= int(key) <= len(choices):
                answer = choices[int(key) - 1]
                self._attempt.complete(number, answer)
                self._correct(step, answer)
                return True
            elif key in (QUIT, ""):
                return False
            key = self._read_key()

    def _correct(self, step: Step, answer: str) -> None:
        right = answer == step.kind
        name = label(step.kind)
        text = f"Right: {name}." if right else f"It was {name}, not {label(answer)}. Again, {name}:"
        self._emit({"answer": answer, "was": step.kind, "right": right}, text)
        if not right:
            self._play_one(self._lesson.references[step.kind], False)

    def _play_one(self, example: Example, with_caption: bool) -> None:
        if with_caption and not self._as_json:
            click.echo(f"  {example.caption}")
        struck = self._play(example)
        if self._as_json:
            self._emit({"played": example.kinds, "struck": struck})

    def _emit(self, report: dict[str, Any], *lines: str) -> None:
        click.echo(json.dumps(report, ensure_ascii=False) if self._as_json else "\n".join(lines))


@contextmanager
def terminal_keys(stopped: Callable[[], bool]) -> Iterator[ReadKey]:
    """Yield a function that waits for a key of the terminal.

    Without a terminal it reads the first letter of a line. It returns "" at the end of the input,
    or when `stopped`.
    """
    if not sys.stdin.isatty():
        yield _line_key
    elif os.name == "nt":
        yield click.getchar
    else:
        import select
        import termios
        import tty

        file = sys.stdin.fileno()
        before = termios.tcgetattr(file)

        def read() -> str:
            while not stopped():
                if select.select([file], [], [], POLL_S)[0]:
                    return os.read(file, 1).decode(errors="replace")
            return ""

        try:
            tty.setcbreak(file)
            yield read
        finally:
            termios.tcsetattr(file, termios.TCSADRAIN, before)


def _line_key() -> str:
    line = sys.stdin.readline()
    return (line.strip()[:1] or NEXT) if line else ""
