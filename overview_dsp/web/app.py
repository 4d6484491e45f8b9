"""Routes of the web application; other paths are not found.

| path | answers |
|---|---|
| `/`, `/main.js`, ... | the page's files (`assets`), without a token |
| `POST /session` | 204 and the session cookie, for a valid token |
| `/control` | WebSocket that controls the host's disk (`control`) |
| `POST /host/preset` | 204: the host uses `{"preset": P}` (P as in `sound_data`) |

Thread: the server's.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route, Router, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket

from overview_dsp.errors import InputError
from overview_dsp.web.assets import asset, served_paths
from overview_dsp.web.control import serve_input
from overview_dsp.web.messages import json_object
from overview_dsp.web.preset_data import parse_preset
from overview_dsp.web.security.auth_token import Access
from overview_dsp.web.security.middleware import Guard, cookie_name, threaded_endpoint

if TYPE_CHECKING:
    from overview_dsp.web.session import HostSession


def make_app(
    access: Access,
    names: Collection[str],
    report: Callable[[str], None],
    session: HostSession | None = None,
    data_routes: Collection[BaseRoute] = (),
    public: Collection[str] | None = None,
) -> ASGIApp:
    """Return the application with its access checks.

    `names`: host names of this machine; its addresses are always accepted.
    `report`: receives a message for each failed request.
    `session`: session that plays on this machine; None if the page plays.
    `public`: paths of another page that need no token; its files are in `data_routes`.
    """

    def open_session(request: Request) -> Response:
        response = Response(status_code=204)
        response.set_cookie(
            cookie_name(request.scope),
            access.session,
            path="/",
            secure=request.url.scheme == "https",
            httponly=True,
            samesite="strict",
        )
        return response

    async def control(websocket: WebSocket) -> None:
        assert session is not None
        await serve_input(websocket, session)

    def use(request: Request, body: bytes) -> Response:
        assert session is not None
        fields = json_object(body)
        if fields.keys() != {"preset"}:
            raise InputError("the body must have the key preset")
        session.use(parse_preset(fields["preset"]))
        return Response(status_code=204)

    routes: list[BaseRoute] = []
    if public is None:
        public = served_paths()
        routes += [Route(path, _send_asset) for path in public]
    routes += [Route("/session", open_session, methods=["POST"]), *data_routes]
    if session is not None:
        routes.append(WebSocketRoute("/control", control))
        routes.append(Route("/host/preset", threaded_endpoint(use), methods=["POST"]))
    # a router alone: the guard reports failures
    app = Router(routes, redirect_slashes=False)
    return Guard(app, access, names, public, report)


def _send_asset(request: Request) -> Response:
    content, kind, tag = asset(request.url.path)
    headers = {"etag": tag, "cache-control": "no-cache"}
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers=headers)
    return Response(content, headers=headers, media_type=kind)
