"""The data of a page: the timeline it shows.

Thread: the server's workers.
"""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route

from overview_dsp.timeline import Timeline
from overview_dsp.web.asked import answering, whole_number, window
from overview_dsp.web.timeline_data import COLUMNS, timeline_data


def data_routes(timeline: Timeline) -> list[BaseRoute]:
    """Routes under `/data`."""

    def show(request: Request, body: bytes) -> Response:
        columns = whole_number(request, "columns", COLUMNS)
        return JSONResponse(timeline_data(timeline, window(request, timeline), columns))

    return [Route("/data/timeline", answering(show))]
