"""Endpoints that run in a thread and report invalid input in one line."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response

from overview_dsp.errors import InputError, OverviewError

Answer = Callable[[Request, bytes], Response]


def threaded_endpoint(answer: Answer) -> Callable[[Request], Awaitable[Response]]:
    """Return an endpoint that runs `answer` in a thread; invalid input is status 400."""

    async def endpoint(request: Request) -> Response:
        body = await request.body()
        try:
            return await run_in_threadpool(answer, request, body)
        except InputError as error:
            return PlainTextResponse(f"{error}\n", 400)
        except OverviewError as error:
            return PlainTextResponse(f"{error}\n", 503)

    return endpoint
