"""What a request asks for, checked: one clear line for what it isn't."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable
from typing import Any, NoReturn

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response

from overview_dsp.errors import InputError, OverviewError

Answer = Callable[[Request, bytes], Response]


def answering(answer: Answer) -> Callable[[Request], Awaitable[Response]]:
    """An endpoint of a function that takes its time: in a thread; bad input is 400 and a line."""

    async def endpoint(request: Request) -> Response:
        body = await request.body()
        try:
            return await run_in_threadpool(answer, request, body)
        except InputError as error:
            return PlainTextResponse(f"{error}\n", 400)
        except OverviewError as error:
            return PlainTextResponse(f"{error}\n", 503)

    return endpoint


def json_object(body: bytes) -> dict[str, Any]:
    """The JSON object of a body."""

    def refuse(name: str) -> NoReturn:
        raise InputError(f"{name} is no number of JSON's")

    try:
        found = json.loads(body.decode(), parse_constant=refuse)
    except InputError:
        raise
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise InputError("the body is a JSON object")
    return found
