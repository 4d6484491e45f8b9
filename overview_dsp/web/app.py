"""The application: which path answers what. Everything not named here is not found.

| path | answers |
|---|---|
| `/`, `/main.js`, ... | the page's files (`assets`), to anyone |
| `POST /session` | 204 and the session's cookie, to whoever has the token |
| `/control` | a hand on the host's disk (`control`), where the host plays |
| `POST /host/preset` | 204: the host plays with `{"preset": P}` (P as in `sound_data`) |

Thread: the server's.
"""

from __future__ import annotations

from collections.abc import Callable, Collection

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route, Router, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket

from overview_dsp.errors import InputError
from overview_dsp.web.assets import asset, served_paths
from overview_dsp.web.control import Session, serve_hand
from overview_dsp.web.messages import json_object
from overview_dsp.web.preset_data import preset_given
from overview_dsp.web.security.auth_token import Access
from overview_dsp.web.security.middleware import Guard, cookie_name
from overview_dsp.web.security.request_body import answering


def make_app(
    access: Access,
    names: Collection[str],
    note: Callable[[str], None],
    session: Session | None = None,
    more: Collection[BaseRoute] = (),
    public: Collection[str] | None = None,
) -> ASGIApp:
    """The application behind its guard.

    Parameters
    ----------
    names
        Host names of this machine, besides its addresses.
    note
        Receives a line about what failed.
    session
        What sounds here; None if only the page sounds.
    more
        Routes of the data.
    public
        Where `more` is another page with its files: those of its paths that anyone may get.
    """

    def enter(request: Request) -> Response:
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
        await serve_hand(websocket, session)

    def use(request: Request, body: bytes) -> Response:
        assert session is not None
        asked = json_object(body)
        if asked.keys() != {"preset"}:
            raise InputError("the body has the key preset")
        session.use(preset_given(asked["preset"]))
        return Response(status_code=204)

    routes: list[BaseRoute] = []
    if public is None:
        public = served_paths()
        routes += [Route(path, _send_asset) for path in public]
    routes += [Route("/session", enter, methods=["POST"]), *more]
    if session is not None:
        routes.append(WebSocketRoute("/control", control))
        routes.append(Route("/host/preset", answering(use), methods=["POST"]))
    # a router alone: the guard reports what fails
    app = Router(routes, redirect_slashes=False)
    return Guard(app, access, names, public, note)


def _send_asset(request: Request) -> Response:
    content, kind, tag = asset(request.url.path)
    headers = {"etag": tag, "cache-control": "no-cache"}
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers=headers)
    return Response(content, headers=headers, media_type=kind)
