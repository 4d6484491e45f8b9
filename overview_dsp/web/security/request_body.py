"""The answer to a request that takes its time: in a thread, with one clear line for bad input."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

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
