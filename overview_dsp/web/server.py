"""The server: an application on a socket, in a thread of its own.

Thread: any; the application runs in the server's.

Where the server is reached: addresses and names of this machine, the address to open, its QR.
"""

from __future__ import annotations

import asyncio
import io
import ipaddress
import logging
import socket
import ssl
import threading
from collections.abc import Callable, Sequence
from typing import Any

import uvicorn
from starlette.types import ASGIApp

from overview_dsp.errors import InputError, OverviewError
from overview_dsp.web.connections import MAX_HEADER, HttpConnection, WebSocketConnection
from overview_dsp.web.messages import MAX_MESSAGE_BYTES

HANDSHAKE_WITHIN_S = 5.0
STOP_WITHIN_S = 2
BACKLOG = 256
IDLE_S = 5
"""A connection between two requests is kept so long."""

PING_S = 2.0
"""A WebSocket is pinged so often, and closed if it hasn't answered in as long."""


def listen(host: str, port: int) -> socket.socket:
    """A listening socket; port 0 is any free one.

    Raises
    ------
    InputError
        No such address here, or a port that is taken or not allowed.
    """
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, *_, address = found[0]
        server = socket.create_server(
            address[:2], family=socket.AddressFamily(family), backlog=BACKLOG
        )
        # asyncio does so only for sockets that name their protocol: an answer in two parts
        # (head and body) would wait 40 ms for the first one's acknowledgement
        server.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return server
    except (OSError, UnicodeError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"can't listen on {host} port {port}: {reason}; try another --port, or another --host"
        ) from None


class _Server(uvicorn.Server):
    """uvicorn's, with a limit on how long a TLS handshake takes."""

    def __init__(self, config: uvicorn.Config, secure: ssl.SSLContext | None, crowd: bool) -> None:
        super().__init__(config)
        self._secure = secure
        self._crowd = crowd

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listen."""
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
            secure = {"ssl": self._secure, "ssl_handshake_timeout": HANDSHAKE_WITHIN_S,
                      "ssl_shutdown_timeout": HANDSHAKE_WITHIN_S}  # fmt: skip
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
        note: Callable[[str], None],
        crowd: bool = False,
    ) -> None:
        """Serve from now on; `crowd`: hundreds of pages.

        Raises
        ------
        OverviewError
            The server didn't start.
        """
        logging.getLogger("uvicorn").propagate = False  # the guard reports what failed
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
            ws_ping_interval=PING_S,
            ws_ping_timeout=PING_S,
            ws_per_message_deflate=False,  # a small message must not unpack into a large one
            timeout_keep_alive=IDLE_S,
            timeout_graceful_shutdown=STOP_WITHIN_S,
            h11_max_incomplete_event_size=MAX_HEADER,
        )
        self._server = _Server(config, secure, crowd)
        self._sockets = list(sockets)
        self._note = note
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
            self._note(f"the web server failed: {type(error).__name__}: {error}")

    @property
    def running(self) -> bool:
        """Whether it serves."""
        return self._thread.is_alive()

    def close(self) -> None:
        """End all connections; may be called twice."""
        self._server.should_exit = True
        self._thread.join()


ANYWHERE = {4: "192.0.2.1", 6: "2001:db8::1"}
"""Addresses of documents: our address on the route to one is the one the network uses."""


def is_loopback(host: str) -> bool:
    """Whether a host to listen on is only reached from this machine."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def own_names() -> frozenset[str]:
    """This machine's names, as networks know them."""
    name = socket.gethostname().lower()
    return frozenset({name, f"{name.partition('.')[0]}.local"} - {"", ".local"})


def reached_at(host: str) -> str:
    """The address by which others reach a server that listens on `host`."""
    try:
        found = ipaddress.ip_address(host)
    except ValueError:
        return host
    if not found.is_unspecified:
        return host
    family = socket.AF_INET6 if found.version == 6 else socket.AF_INET
    with socket.socket(family, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((ANYWHERE[found.version], 9))  # a datagram socket: nothing is sent
            return str(probe.getsockname()[0])
        except OSError:  # no network
            return "::1" if found.version == 6 else "127.0.0.1"


def page_address(scheme: str, host: str, port: int, token: str) -> str:
    """The address to open; the token stands where browsers don't send it."""
    name = f"[{host}]" if ":" in host else host
    return f"{scheme}://{name}:{port}/#token={token}"


def qr_text(address: str) -> str:
    """An address as a QR code for a terminal."""
    import segno

    out = io.StringIO()
    segno.make(address, error="l", micro=False).terminal(out, compact=True)
    return out.getvalue()
