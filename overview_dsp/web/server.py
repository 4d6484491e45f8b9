"""Web server in its own thread, its limits, and the addresses at which it can be reached.

A browser opens six connections and a WebSocket. Idle or slow connections must not keep other users
out. At the limit, a new connection therefore replaces the one that has been idle longest.

Thread: any; the application runs in the server's. These are its routes:

| path | answers |
|---|---|
| `/`, `/main.js`, ... | the page's files (`assets`), without a token |
| `POST /session` | 204 and the session cookie, for a valid token |
| `/control` | WebSocket that controls the host's disk (`control`) |
| `POST /host/preset` | 204: the host uses `{"preset": P}` (P as in `sound_data`) |
"""

from __future__ import annotations

import asyncio
import io
import logging
import socket
import ssl
import threading
from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import h11
import uvicorn
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route, Router, WebSocketRoute
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from overview_dsp.errors import InputError, OverviewError
from overview_dsp.web.assets import asset, served_paths
from overview_dsp.web.control import serve_input
from overview_dsp.web.messages import MAX_MESSAGE_BYTES, json_object
from overview_dsp.web.preset_data import parse_preset
from overview_dsp.web.security.auth_token import Access, parse_ip
from overview_dsp.web.security.middleware import Guard, cookie_name, threaded_endpoint

if TYPE_CHECKING:
    from overview_dsp.web.session import HostSession

MAX_CONNECTIONS = 64
MAX_PER_ADDRESS = 24
MAX_CROWD = 1024
"""Limit for a live timeline, also per address: a whole stadium may share one address."""

REQUEST_TIMEOUT_S = 10.0
"""Maximum time for a request's line and headers."""

READ_TIMEOUT_S = 20.0
"""Maximum time without reading a response (a paused film is requested again)."""

BODY_TIMEOUT_S = 2.0
"""Maximum time to read the rest of a request that was answered early."""

MAX_HEADER = 16 * 1024
"""Bytes of a request's line and headers."""


class _Deadline:
    """Closes a transport unless it is cancelled in time."""

    _handle: asyncio.TimerHandle | None = None

    def set(self, transport: asyncio.Transport, seconds: float) -> None:
        """Close `transport` after `seconds`, unless a deadline is set already."""
        if self._handle is None:
            loop = asyncio.get_running_loop()
            self._handle = loop.call_later(seconds, transport.abort)

    def cancel(self) -> None:
        """Cancel the deadline."""
        if self._handle is not None:
            self._handle.cancel()
            self._handle = None


def address_of(connection: Any) -> str:
    """Return the address of the client."""
    return connection.client[0] if connection.client else ""


def is_open(connection: Any) -> bool:
    """Return whether the connection is open."""
    return not connection.transport.is_closing()


class _SlowReaderLimit(asyncio.Protocol):
    """Protocol that closes a connection if the client doesn't read for `READ_TIMEOUT_S`."""

    transport: asyncio.Transport

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._reading = _Deadline()

    def pause_writing(self) -> None:
        """Start the deadline for a slow reader."""
        super().pause_writing()
        self._reading.set(self.transport, READ_TIMEOUT_S)

    def resume_writing(self) -> None:
        """Cancel the deadline: the client reads again."""
        super().resume_writing()
        self._reading.cancel()

    def connection_lost(self, exc: Exception | None) -> None:
        """Cancel the deadline."""
        super().connection_lost(exc)
        self._reading.cancel()


class HttpConnection(_SlowReaderLimit, H11Protocol):
    """HTTP/1.1 connection with limits."""

    def __init__(self, *arguments: Any, crowd: bool = False, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._limit = MAX_CROWD if crowd else MAX_CONNECTIONS
        self._limit_per_address = MAX_CROWD if crowd else MAX_PER_ADDRESS
        self._request = _Deadline()
        self._idle_since: float | None = None  # None: a request is being answered

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Enforce the limits, then start the deadline for a request."""
        super().connection_made(transport)
        others = [one for one in self.connections if one is not self and is_open(one)]
        of_client = [one for one in others if address_of(one) == address_of(self)]
        group = of_client if len(of_client) >= self._limit_per_address else others
        if group is of_client or len(others) >= self._limit:
            idle = {
                one: one._idle_since
                for one in group
                if isinstance(one, HttpConnection) and one._idle_since is not None
            }
            if not idle:
                transport.abort()
                return
            min(idle, key=idle.__getitem__).transport.abort()
        self._start_deadline()

    def data_received(self, data: bytes) -> None:
        """Start or cancel the deadline for a request."""
        super().data_received(data)
        self._start_deadline()

    def on_response_complete(self) -> None:
        """Start the deadline for the next request."""
        super().on_response_complete()
        self._start_deadline()

    def _start_deadline(self) -> None:
        answered = self.cycle is not None and self.cycle.response_complete
        closing = self.transport.is_closing()
        idle = self.conn.their_state is h11.IDLE and not closing
        if not idle:
            self._idle_since = None
        elif self._idle_since is None:
            self._idle_since = self.loop.time()
        if idle:
            self._request.set(self.transport, REQUEST_TIMEOUT_S)
        elif self.conn.their_state is h11.SEND_BODY and answered and not closing:
            self._request.set(self.transport, BODY_TIMEOUT_S)
        else:
            self._request.cancel()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Pass the connection to the WebSocket protocol."""
        self._request.cancel()
        super().handle_websocket_upgrade(event)

    def connection_lost(self, exc: Exception | None) -> None:
        """Cancel the deadline."""
        self._request.cancel()
        super().connection_lost(exc)


class WebSocketConnection(_SlowReaderLimit, WebSocketsSansIOProtocol):
    """WebSocket connection with limits; uvicorn closes it after an unanswered ping."""


HANDSHAKE_TIMEOUT_S = 5.0
STOP_TIMEOUT_S = 2
BACKLOG = 256
IDLE_TIMEOUT_S = 5
"""Time after which an idle connection is closed."""

PING_INTERVAL_S = 2.0
"""Interval of WebSocket pings, and the maximum time for a reply."""


def listen(host: str, port: int) -> socket.socket:
    """Return a listening socket; port 0 selects a free port.

    InputError if the address isn't local, or the port is in use or not allowed.
    """
    try:
        info = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, *_, address = info[0]
        server = socket.create_server(
            address[:2], family=socket.AddressFamily(family), backlog=BACKLOG
        )
        # asyncio sets this only for sockets that name their protocol; without it a response in
        # two parts (head and body) waits 40 ms for an acknowledgement
        server.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return server
    except (OSError, UnicodeError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"can't listen on {host} port {port}: {reason}; try another --port, or another --host"
        ) from None


class _Server(uvicorn.Server):
    """uvicorn server with a time limit for TLS handshakes."""

    def __init__(self, config: uvicorn.Config, secure: ssl.SSLContext | None, crowd: bool) -> None:
        super().__init__(config)
        self._secure = secure
        self._crowd = crowd

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start listening on the sockets."""
        config = self.config
        assert sockets is not None

        def protocol() -> asyncio.Protocol:
            return HttpConnection(
                config=config,
                server_state=self.server_state,
                app_state=self.lifespan.state,
                crowd=self._crowd,
            )

        await self.lifespan.startup()
        secure: dict[str, Any] = {}
        if self._secure is not None:
            secure = {"ssl": self._secure, "ssl_handshake_timeout": HANDSHAKE_TIMEOUT_S,
                      "ssl_shutdown_timeout": HANDSHAKE_TIMEOUT_S}  # fmt: skip
        loop = asyncio.get_running_loop()
        self.servers = [
            await loop.create_server(protocol, sock=sock, backlog=BACKLOG, **secure)
            for sock in sockets
        ]
        self.started = True


class WebServer:
    """Serves an application until it is closed."""

    def __init__(
        self,
        app: ASGIApp,
        sockets: Sequence[socket.socket],
        secure: ssl.SSLContext | None,
        report: Callable[[str], None],
        crowd: bool = False,
    ) -> None:
        """Start serving; `crowd` raises the connection limits for hundreds of pages.

        OverviewError if the server can't start.
        """
        logging.getLogger("uvicorn").propagate = False  # the guard reports failures
        logging.getLogger("uvicorn").addHandler(logging.NullHandler())
        config = uvicorn.Config(
            app,
            http=HttpConnection,
            ws=WebSocketConnection,
            loop="asyncio",
            lifespan="off",
            interface="asgi3",
            log_config=None,
            access_log=False,
            proxy_headers=False,
            server_header=False,
            ws_max_size=MAX_MESSAGE_BYTES,
            ws_ping_interval=PING_INTERVAL_S,
            ws_ping_timeout=PING_INTERVAL_S,
            ws_per_message_deflate=False,  # a small message must not expand into a large one
            timeout_keep_alive=IDLE_TIMEOUT_S,
            timeout_graceful_shutdown=STOP_TIMEOUT_S,
            h11_max_incomplete_event_size=MAX_HEADER,
        )
        self._server = _Server(config, secure, crowd)
        self._sockets = list(sockets)
        self._report = report
        self._thread = threading.Thread(target=self._run, name="web server", daemon=True)
        self._thread.start()
        while not self._server.started:
            if not self._thread.is_alive():
                raise OverviewError("the web server didn't start")
            self._thread.join(0.01)

    def _run(self) -> None:
        try:
            self._server.run(self._sockets)
        except Exception as error:
            self._report(f"the web server failed: {type(error).__name__}: {error}")

    @property
    def is_running(self) -> bool:
        """True while the server runs."""
        return self._thread.is_alive()

    def close(self) -> None:
        """Close all connections; further calls have no effect."""
        self._server.should_exit = True
        self._thread.join()


EXTERNAL_ADDRESS = {4: "192.0.2.1", 6: "2001:db8::1"}
"""Documentation addresses; the route to them reveals this machine's network address."""


def is_loopback(host: str) -> bool:
    """Return whether a host accepts connections from this machine only."""
    address = parse_ip(host)
    return host == "localhost" or (address is not None and address.is_loopback)


def machine_names() -> frozenset[str]:
    """Return the network names of this machine."""
    name = socket.gethostname().lower()
    return frozenset({name, f"{name.partition('.')[0]}.local"} - {"", ".local"})


def public_host(host: str) -> str:
    """Return the address at which other machines reach a server that listens on `host`."""
    parsed = parse_ip(host)
    if parsed is None or not parsed.is_unspecified:
        return host
    family = socket.AF_INET6 if parsed.version == 6 else socket.AF_INET
    with socket.socket(family, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((EXTERNAL_ADDRESS[parsed.version], 9))  # a datagram socket sends nothing
            return str(probe.getsockname()[0])
        except OSError:  # no network
            return "::1" if parsed.version == 6 else "127.0.0.1"


def page_url(scheme: str, host: str, port: int, token: str) -> str:
    """Return the URL of the page; the token is in the fragment, which browsers don't send."""
    name = f"[{host}]" if ":" in host else host
    return f"{scheme}://{name}:{port}/#token={token}"


def qr_text(url: str) -> str:
    """Return a URL as a QR code for a terminal."""
    import segno

    out = io.StringIO()
    segno.make(url, error="l", micro=False).terminal(out, compact=True)
    return out.getvalue()


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
        routes.append(WebSocketRoute("/control", partial(serve_input, session=session)))
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
