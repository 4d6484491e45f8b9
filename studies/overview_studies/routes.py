"""Routes of the study server, documented in docs/explanation/study-format.md.

Thread: the server's workers.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import BaseRoute, Route

from overview_dsp.cli.extensions import START, TYPES, json_object, threaded_endpoint
from overview_dsp.errors import InputError
from overview_studies.folder import STUDY, listed_files
from overview_studies.row_checks import impossible
from overview_studies.steps import find_step, missing_steps
from overview_studies.store import (
    RESUME_KEYS,
    SIMULATED,
    SIMULATED_REQUEST,
    NoListLeftError,
    Session,
    Store,
)

SESSIONS = "/study/sessions"
REQUEST = re.compile(r"[A-Za-z0-9-]{16,64}")
CODE = re.compile(r"[A-Za-z0-9_-]{1,32}")
PRIVATE = ("study.json", "lists/", "stimuli/", "forms/", "mask")
"""Files that require the token."""

Answer = Callable[[Request, bytes, int], Response]


def public_files(folder: Path) -> tuple[str, ...]:
    """Return the paths of the page, without the study's content."""
    names = (name for name in listed_files(folder) if not name.startswith(PRIVATE))
    return ("/", *(f"/{name}" for name in names if name != START))


def study_routes(folder: Path, store: Store) -> list[BaseRoute]:
    """Return the routes of a built folder and its store."""
    content = cache(store.load_list)
    # only listed files are served; the folder may also hold the database
    known = frozenset(listed_files(folder))

    def file(request: Request, body: bytes) -> Response:
        name = request.url.path.removeprefix("/") or START
        if name not in known:
            return PlainTextResponse("not found\n", 404)
        if name == STUDY:
            return JSONResponse({**store.study, "server": {"sessions": SESSIONS}})
        kind = TYPES.get(name.rpartition(".")[2], "application/octet-stream")
        if name.endswith(".json"):
            kind = "application/json"
        data = (folder / name).read_bytes()
        return Response(data, media_type=kind, headers={"cache-control": "no-cache"})

    def begin(request: Request, body: bytes) -> Response:
        fields = json_object(body)
        if not fields.keys() <= {"request", "participant"}:
            raise InputError("the body contains an unknown key; allowed: request and participant")
        number, code = fields.get("request"), fields.get("participant")
        if not isinstance(number, str) or not REQUEST.fullmatch(number):
            raise InputError("request must be 16 to 64 letters, digits or -")
        if number.startswith(SIMULATED_REQUEST):
            raise InputError(f"request must not start with {SIMULATED_REQUEST}")
        if code is not None and not (isinstance(code, str) and CODE.fullmatch(code)):
            raise InputError("participant must be 1 to 32 letters, digits, - or _")
        try:
            session, new = store.begin(number, code)
        except NoListLeftError as error:
            return PlainTextResponse(f"{error}\n", 409)
        return JSONResponse(_session_json(session), 201 if new else 200)

    def session_route(answer: Answer) -> Callable[[Request, bytes], Response]:
        def authorized(request: Request, body: bytes) -> Response:
            secret = request.headers.get("x-study-secret", "")
            number = store.list_number(request.path_params["session"], secret)
            if number is None:
                return PlainTextResponse("unknown session or wrong secret\n", 403)
            return answer(request, body, number)

        return authorized

    def read_session(request: Request, body: bytes, number: int) -> Response:
        return JSONResponse(_session_json(store.session(request.path_params["session"])))

    def put(request: Request, body: bytes, number: int) -> Response:
        trial = request.path_params["trial"]
        step = find_step(trial, content(number))
        if step is None:
            return PlainTextResponse(f"list {number} has no trial {trial!a}\n", 404)
        row = json_object(body)
        if "response" not in row:
            raise InputError("the key response is missing")
        reason = impossible(store.study, step, row)
        if row.get("source") == SIMULATED:
            reason = "simulated answers are not stored"
        if reason is not None:
            return PlainTextResponse(f"{trial}: {reason}\n", 422)
        new = store.put(request.path_params["session"], trial, body.decode())
        return JSONResponse({"stored": trial}, 201 if new else 200)

    def finish(request: Request, body: bytes, number: int) -> Response:
        session = store.session(request.path_params["session"])
        missing = missing_steps(content(number), [trial for trial, _, _ in session.trials])
        if missing:
            return JSONResponse({"missing": missing}, 409)
        store.finish(session.id)
        return JSONResponse({"complete": True})

    one = f"{SESSIONS}/{{session}}"
    return [
        Route(SESSIONS, threaded_endpoint(begin), methods=["POST"]),
        Route(one, threaded_endpoint(session_route(read_session))),
        Route(f"{one}/trials/{{trial}}", threaded_endpoint(session_route(put)), methods=["PUT"]),
        Route(f"{one}/finish", threaded_endpoint(session_route(finish)), methods=["POST"]),
        Route("/{path:path}", threaded_endpoint(file)),
    ]


def _session_json(session: Session) -> dict[str, Any]:
    return {
        "session": session.id,
        "secret": session.secret,
        "list": session.number,
        "participant": session.participant,
        "answers": {
            trial: {key: row.get(key) for key in RESUME_KEYS} for trial, _, row in session.trials
        },
        "complete": session.finished_utc is not None,
    }
