"""Routes of the page of a lesson.

| path | answers |
|---|---|
| `/`, `/learn.js`, ... | the page's files, without the token |
| `GET /lesson` | steps, choices, progress and scores |
| `GET /sounds/N.wav` | example N: left clicks, right vibration |
| `POST /lesson/steps` | `{"step": N}`, with `answer` for a question: stores that it is completed |
| `POST /lesson/passes` | `{"again": false}`: begins the next pass, like `GET /lesson` |

Thread: the server's workers.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import date
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import BaseRoute, Route

from overview_dsp import render
from overview_dsp.cli.extensions import (
    START,
    TYPES,
    json_object,
    other_page_files,
    sound_bytes,
    threaded_endpoint,
)
from overview_dsp.errors import InputError
from overview_studies.lesson import TAIL_S, Example, Lesson, label, make_lesson
from overview_studies.lesson_scores import Attempt
from overview_studies.lesson_terminal import HEADINGS

RATE = 48_000
FROM_STUDIES = ("browser_store.js", "client.js", "make.js", "study.css")
"""Files shared with the page of a study."""


@cache
def lesson_files() -> dict[str, bytes]:
    """Return the files of the page by their path."""
    folder = Path(__file__).parent
    paths = [
        *(folder / "lesson_page").iterdir(),
        *(folder / "page" / name for name in FROM_STUDIES),
    ]
    own = {path.name: path.read_bytes() for path in paths if path.is_file()}
    return other_page_files(own, ("style.css", "icon.svg"))


def lesson_paths() -> tuple[str, ...]:
    """Return the paths that need no token."""
    return ("/", *(f"/{name}" for name in lesson_files() if name != START))


def lesson_routes(begin: Callable[[bool], Attempt], again: bool = False) -> list[BaseRoute]:
    """Return the routes; `begin` starts or resumes a pass, of the whole lesson if True.

    `again` is its argument for the first pass.
    """
    served = _ServedLesson(begin, again)

    def file(request: Request, body: bytes) -> Response:
        name = request.path_params["path"] or START
        if name not in lesson_files():
            return PlainTextResponse("not found\n", 404)
        kind = TYPES[name.rpartition(".")[2]]
        return Response(
            lesson_files()[name], media_type=kind, headers={"cache-control": "no-cache"}
        )

    def lesson(request: Request, body: bytes) -> Response:
        return JSONResponse(served.content())

    def step(request: Request, body: bytes) -> Response:
        fields = json_object(body)
        number, answer = fields.get("step"), fields.get("answer")
        if type(number) is not int or not isinstance(answer, str | None):
            raise InputError("the body must have a whole number step, and may have an answer")
        return JSONResponse(served.complete(number, answer))

    def next_pass(request: Request, body: bytes) -> Response:
        again = json_object(body).get("again")
        if not isinstance(again, bool):
            raise InputError("the body must have the key again, true or false")
        return JSONResponse(served.begin(again))

    def sound(request: Request, body: bytes) -> Response:
        data = served.sound(int(request.path_params["number"]))
        if data is None:
            return PlainTextResponse("not found\n", 404)
        return Response(data, media_type="audio/wav", headers={"cache-control": "no-store"})

    return [
        Route("/lesson", threaded_endpoint(lesson)),
        Route("/lesson/steps", threaded_endpoint(step), methods=["POST"]),
        Route("/lesson/passes", threaded_endpoint(next_pass), methods=["POST"]),
        Route("/sounds/{number:int}.wav", threaded_endpoint(sound)),
        Route("/{path:path}", threaded_endpoint(file)),
    ]


def additional_routes(preset: str) -> list[BaseRoute]:
    """Return the routes of a preset's lesson beside the page of a timeline, for its scores."""

    def begin(again: bool) -> Attempt:
        today = date.today().isoformat()
        return Attempt(None, preset, lambda seed: make_lesson(preset, None, seed), today, again)

    return lesson_routes(begin)


class _ServedLesson:
    """The current pass, for one request at a time."""

    def __init__(self, begin: Callable[[bool], Attempt], again: bool) -> None:
        self._begin, self._lock = begin, threading.Lock()
        self._again = again
        self._sounds: dict[int, bytes] = {}

    @cached_property
    def _attempt(self) -> Attempt:
        """The pass, begun by the first request."""
        return self._begin(self._again)

    @property
    def _examples(self) -> tuple[Example, ...]:
        return self._attempt.lesson.examples

    def content(self) -> dict[str, Any]:
        with self._lock:
            return self._content()

    def begin(self, again: bool) -> dict[str, Any]:
        with self._lock:
            self._attempt, self._sounds = self._begin(again), {}
            return self._content()

    def complete(self, step: int, answer: str | None) -> dict[str, Any]:
        with self._lock:
            attempt = self._attempt
            attempt.complete(step, answer)
            if answer is None:
                return {"done": attempt.done}
            question = step - len(attempt.steps) + len(attempt.lesson.questions)
            was, stored = attempt.steps[step].kind, attempt.answers[question]
            return {"done": attempt.done, "was": was, "right": stored == was}

    def sound(self, number: int) -> bytes | None:
        with self._lock:
            if number >= len(self._examples):
                return None
            if number not in self._sounds:
                self._sounds[number] = _sound(self._attempt.lesson, self._examples[number])
            return self._sounds[number]

    def _content(self) -> dict[str, Any]:
        attempt, lesson = self._attempt, self._attempt.lesson
        paths = {id(one): f"sounds/{number}.wav" for number, one in enumerate(self._examples)}
        scores = [*attempt.scores, *([attempt.score] if attempt.score else [])]
        return {
            "title": lesson.title,
            "welcome": attempt.welcome,
            "headings": HEADINGS,
            "choices": [{"kind": kind, "label": label(kind)} for kind in lesson.choices],
            "references": {kind: paths[id(one)] for kind, one in lesson.references.items()},
            "steps": [
                {
                    "part": step.part,
                    "text": step.text,
                    "examples": [
                        # the caption of a question is its answer
                        {"caption": "" if step.part == "question" else one.caption,
                         "sound": paths[id(one)]}
                        for one in step.examples
                    ],
                }
                for step in attempt.steps
            ],
            "done": attempt.done,
            "score": None if attempt.score is None else attempt.score.text,
            "scores": [{"date": one.date, "right": one.right, "of": one.of} for one in scores],
        }  # fmt: skip


def _sound(lesson: Lesson, example: Example) -> bytes:
    result = render(
        example.timeline, lesson.preset, example.gesture, RATE, tail=TAIL_S, trace=False
    )
    return sound_bytes("example.wav", result.samples, RATE, "PCM_16")
