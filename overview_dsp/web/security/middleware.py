"""Access checks and security headers of every request, and endpoints that run in a thread.

The checks are, in order: the Host header, the Origin, the size, the token, and the time to receive
the body. Every response has the security headers. An exception in the application is reported to
the server's log, and the client receives status 500.

A page of another site can make a browser send requests to this server. The Host check rejects names
that another site pointed at this machine (DNS rebinding). The Origin check rejects all other
requests of foreign pages that could read or change data.

Thread: the server's.
"""

from __future__ import annotations

import asyncio
import ipaddress
from collections.abc import Awaitable, Callable, Collection, Mapping
from http.cookies import CookieError, SimpleCookie

from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware.body_limit import RequestBodyLimitMiddleware
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from overview_dsp.errors import InputError, OverviewError
from overview_dsp.files.toml import load_toml
from overview_dsp.web.security.auth_token import WRONG_TOKEN_WINDOW_S, Access, Verdict, parse_ip

_HEADERS = load_toml(__file__, "headers.toml")
POLICY = "; ".join(f"{name} {source}" for name, source in _HEADERS["policy"].items())
SECURITY_HEADERS: dict[str, str] = {"content-security-policy": POLICY, **_HEADERS["headers"]}
"""Defaults; a response may set its own `cache-control`."""

PORTS = {"http": 80, "ws": 80, "https": 443, "wss": 443}
PAGE_SCHEME = {"http": "http", "ws": "http", "https": "https", "wss": "https"}


def host_is_ours(
    host: str, scheme: str, arrived_at: tuple[str, int], names: Collection[str]
) -> bool:
    """Return whether a Host header names the address of arrival or one of `names`."""
    name, port = _split_host(host, PORTS[scheme])
    address = _address(arrived_at[0])
    if name is None or port != arrived_at[1] or address is None:
        return False
    literal = _address(name)
    if literal is not None:
        return literal == address
    return name in names or (name == "localhost" and address.is_loopback)


def origin_is_ours(headers: Mapping[str, str], scheme: str, is_required: bool) -> bool:
    """Return whether a page of this server sent the request (`Origin`, `Sec-Fetch-Site`).

    The Host header must have been checked before.
    """
    origin = headers.get("origin")
    if origin is None:
        if is_required:
            return False
    elif origin.lower() != f"{PAGE_SCHEME[scheme]}://{headers.get('host', '').lower()}":
        return False
    return headers.get("sec-fetch-site", "same-origin") in ("same-origin", "none")


def _split_host(host: str, default: int) -> tuple[str | None, int]:
    """Return name (lower case, without brackets) and port of a Host header; None if invalid."""
    name, colon, port = host.lower().rpartition(":")
    if not colon or name.count("[") != name.count("]"):  # no port, or a colon inside brackets
        name, port = host.lower(), str(default)
    if name.startswith("[") and name.endswith("]"):
        name = name[1:-1]
    elif ":" in name:
        return None, 0
    if not (port.isascii() and port.isdecimal() and len(port) <= 5):
        return None, 0
    return name, int(port)


def _address(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    parsed = parse_ip(text)
    mapped = parsed.ipv4_mapped if isinstance(parsed, ipaddress.IPv6Address) else None
    return mapped or parsed


MAX_BODY = 1_000_000
"""Maximum size of a request's body in bytes: that of a preset file."""

BODY_TIMEOUT_S = 10.0

REJECTIONS = {
    Verdict.MISSING: (401, "the token is missing; open the URL that `overview` printed"),
    Verdict.WRONG: (401, "the token is of another run; open the URL printed last"),
    Verdict.LIMITED: (429, f"too many wrong tokens; wait {WRONG_TOKEN_WINDOW_S:.0f} s"),
}


class Guard:
    """ASGI application that checks each request to another one.

    `names`: host names of this machine; its addresses are always accepted.
    `public`: paths that need no token: the page without data.
    `report`: receives a message for each exception.
    """

    def __init__(
        self,
        app: ASGIApp,
        access: Access,
        names: Collection[str],
        public: Collection[str],
        report: Callable[[str], None],
    ) -> None:
        self._app = RequestBodyLimitMiddleware(app, MAX_BODY)
        self._access = access
        self._names = names
        self._public = public
        self._report = report

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check a request, then pass it on."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        started = False

        async def answer(message: Message) -> None:
            nonlocal started
            if message["type"] in ("http.response.start", "websocket.http.response.start"):
                headers = MutableHeaders(scope=message)
                for name, value in SECURITY_HEADERS.items():
                    headers.setdefault(name, value)
            if message["type"] != "websocket.close":
                started = True
            await send(message)

        rejection = self._rejection(scope)
        if rejection is not None:
            await rejected(*rejection)(scope, receive, answer)
            return
        inner = _with_timeout(receive) if scope["type"] == "http" else receive
        try:
            await self._app(scope, inner, answer)
        except TimeoutError:
            if not started:
                message = f"the request took too long; the limit is {BODY_TIMEOUT_S:.0f} s"
                await rejected(408, message)(scope, receive, answer)
        except Exception as error:
            # escaped: a path may contain terminal control codes
            self._report(f"{scope['path']!a}: {type(error).__name__}: {str(error)!a}")
            if not started:
                failure = rejected(500, "internal error; see the server's log")
                await failure(scope, receive, answer)

    def _rejection(self, scope: Scope) -> tuple[int, str] | None:
        """Return status and message of a rejected request; None for an accepted one."""
        headers = Headers(scope=scope)
        hosts = headers.getlist("host")
        scheme = scope["scheme"]
        if len(hosts) != 1 or not host_is_ours(hosts[0], scheme, scope["server"], self._names):
            return 421, "unknown host name; open the URL that `overview` printed"
        is_socket = scope["type"] == "websocket"
        reads = not is_socket and scope["method"] in ("GET", "HEAD")
        if reads and scope["path"] in self._public:
            return None
        if len(headers.getlist("origin")) > 1 or not origin_is_ours(headers, scheme, not reads):
            return 403, "only the page of this server may send this request"
        length = headers.get("content-length", "0")
        if not length.isdecimal() or len(length) > 9 or int(length) > MAX_BODY:
            return 413, f"the request is too large; the limit is {MAX_BODY:,} bytes"
        client = scope["client"]
        verdict = self._access.check(
            _bearer(headers), _cookie(headers, cookie_name(scope)), client[0] if client else ""
        )
        return REJECTIONS.get(verdict)


def cookie_name(scope: Scope) -> str:
    """Return the name of the session cookie; it contains the port, unlike the cookie's scope.

    With https, its prefix makes browsers reject cookies of another host or of plain http.
    """
    name = f"overview-{scope['server'][1]}"
    return f"__Host-{name}" if scope["scheme"] in ("https", "wss") else name


def rejected(status: int, message: str) -> Response:
    """Return an answer of one line, after which the connection is closed."""
    headers = {"connection": "close"}
    if status == 401:
        headers["www-authenticate"] = "Bearer"
    if status == 429:
        headers["retry-after"] = f"{WRONG_TOKEN_WINDOW_S:.0f}"
    return PlainTextResponse(message + "\n", status, headers)


def _bearer(headers: Headers) -> str | None:
    scheme, _, token = headers.get("authorization", "").partition(" ")
    return token if scheme.lower() == "bearer" and token else None


def _cookie(headers: Headers, name: str) -> str | None:
    try:
        parsed = SimpleCookie(headers.get("cookie", "")).get(name)
    except CookieError:
        return None
    return None if parsed is None else parsed.value


def _with_timeout(receive: Receive) -> Receive:
    """Return `receive` with a time limit of `BODY_TIMEOUT_S` for the body."""
    complete = False
    until = asyncio.get_running_loop().time() + BODY_TIMEOUT_S

    async def receive_in_time() -> Message:
        nonlocal complete
        if complete:  # this only waits for the end of the connection
            return await receive()
        async with asyncio.timeout_at(until):
            message = await receive()
        complete = not message.get("more_body", False)
        return message

    return receive_in_time


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
