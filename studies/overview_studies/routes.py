"""What the server of a study answers: see docs/explanation/study-format.md.

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
from overview_studies.steps import missing_of, step_of
from overview_studies.store import TOLD, NoListLeftError, Session, Store

SESSIONS = "/study/sessions"
REQUEST = re.compile(r"[A-Za-z0-9-]{16,64}")
CODE = re.compile(r"[A-Za-z0-9_-]{1,32}")
PRIVATE = ("study.json", "lists/", "stimuli/", "forms/", "mask")
"""Files of the folder that only who was let in may get."""

Answer = Callable[[Request, bytes, int], Response]


def public_files(folder: Path) -> tuple[str, ...]:
    """The paths of the page alone, without a study."""
    names = (name for name in listed_files(folder) if not name.startswith(PRIVATE))
    return ("/", *(f"/{name}" for name in names if name != START))


def study_routes(folder: Path, store: Store) -> list[BaseRoute]:
    """The routes of a built folder whose answers go to a store."""
    content = cache(store.list_of)
    # nothing else that lies there, a database say
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
        asked = json_object(body)
        if not asked.keys() <= {"request", "participant"}:
            raise InputError("the body has the keys request and participant")
        number, code = asked.get("request"), asked.get("participant")
        if not isinstance(number, str) or not REQUEST.fullmatch(number):
            raise InputError("request is 16 to 64 letters, digits or -, made once by the page")
        if code is not None and not (isinstance(code, str) and CODE.fullmatch(code)):
            raise InputError("a participant's code is 1 to 32 letters, digits, - or _")
        try:
            session, new = store.begin(number, code)
        except NoListLeftError as error:
            return PlainTextResponse(f"{error}\n", 409)
        return JSONResponse(_told(session), 201 if new else 200)

    def within(answer: Answer) -> Callable[[Request, bytes], Response]:
        def checked(request: Request, body: bytes) -> Response:
            secret = request.headers.get("x-study-secret", "")
            number = store.list_number(request.path_params["session"], secret)
            if number is None:
                return PlainTextResponse("no such session, or another's secret\n", 403)
            return answer(request, body, number)

        return checked

    def look(request: Request, body: bytes, number: int) -> Response:
        return JSONResponse(_told(store.session(request.path_params["session"])))

    def put(request: Request, body: bytes, number: int) -> Response:
        trial = request.path_params["trial"]
        if step_of(trial, content(number)) is None:
            return PlainTextResponse(f"list {number} has no trial {trial!a}\n", 404)
        if "response" not in json_object(body):
            raise InputError("a row has a response")
        new = store.put(request.path_params["session"], trial, body.decode())
        return JSONResponse({"stored": trial}, 201 if new else 200)

    def finish(request: Request, body: bytes, number: int) -> Response:
        session = store.session(request.path_params["session"])
        missing = missing_of(content(number), [trial for trial, _, _ in session.trials])
        if missing:
            return JSONResponse({"missing": missing}, 409)
        store.finish(session.id)
        return JSONResponse({"complete": True})

    one = f"{SESSIONS}/{{session}}"
    return [
        Route(SESSIONS, threaded_endpoint(begin), methods=["POST"]),
        Route(one, threaded_endpoint(within(look))),
        Route(f"{one}/trials/{{trial}}", threaded_endpoint(within(put)), methods=["PUT"]),
        Route(f"{one}/finish", threaded_endpoint(within(finish)), methods=["POST"]),
        Route("/{path:path}", threaded_endpoint(file)),
    ]


def _told(session: Session) -> dict[str, Any]:
    return {
        "session": session.id,
        "secret": session.secret,
        "list": session.number,
        "participant": session.participant,
        "answers": {trial: {key: row.get(key) for key in TOLD} for trial, _, row in session.trials},
        "complete": session.finished_utc is not None,
    }
