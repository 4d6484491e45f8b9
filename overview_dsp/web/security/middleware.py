"""The door: every request is checked here before anything looks at it.

In this order: is the Host ours, does a page of ours ask, is it let in, is it small enough, does it
come fast enough. Every answer, a refusal too, gets the security headers. What fails behind the
door is one line for whoever runs the server, and 500 for who asked.

Thread: the server's.

The headers of every answer: what a page of ours may do, and that nobody else may use it.

What a request says about where it comes from: the Host it asked, the Origin it was sent by.

A foreign page can make a browser send requests here. The Host check stops one whose name was
pointed at this machine (DNS rebinding), the Origin check everything else that could change or read
something.
"""

from __future__ import annotations

import asyncio
import ipaddress
from collections.abc import Callable, Collection, Mapping
from http.cookies import CookieError, SimpleCookie

from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware.body_limit import RequestBodyLimitMiddleware
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from overview_dsp.web.security.auth_token import WRONG_WITHIN_S, Access, Verdict

POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self' 'wasm-unsafe-eval'",  # WebAssembly, and no inline script
        "style-src 'self'",
        "img-src 'self'",
        "media-src 'self'",
        "connect-src 'self'",
        "worker-src 'self'",
        "manifest-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)

SECURITY = {
    "content-security-policy": POLICY,
    # both together isolate the page, which gives it exact clocks and shared memory
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-embedder-policy": "require-corp",
    "cross-origin-resource-policy": "same-origin",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "permissions-policy": "accelerometer=(self), gyroscope=(self), magnetometer=(self), "
    "camera=(), microphone=(), geolocation=(), usb=(), payment=()",
    "cache-control": "no-store",
}
"""`cache-control` is only for answers that say nothing about it themselves."""

PORTS = {"http": 80, "ws": 80, "https": 443, "wss": 443}
PAGE_SCHEME = {"http": "http", "ws": "http", "https": "https", "wss": "https"}


def host_is_ours(
    host: str, scheme: str, arrived_at: tuple[str, int], names: Collection[str]
) -> bool:
    """Whether a Host header names the very address a request arrived at, or one of `names`."""
    name, port = _parts(host, PORTS[scheme])
    address = _address(arrived_at[0])
    if name is None or port != arrived_at[1] or address is None:
        return False
    literal = _address(name)
    if literal is not None:
        return literal == address
    return name in names or (name == "localhost" and address.is_loopback)


def origin_is_ours(headers: Mapping[str, str], scheme: str, must_be_given: bool) -> bool:
    """Whether a request was sent by a page of ours (`Origin`, `Sec-Fetch-Site`).

    The Host header must have been found ours before.
    """
    origin = headers.get("origin")
    if origin is None:
        if must_be_given:
            return False
    elif origin.lower() != f"{PAGE_SCHEME[scheme]}://{headers.get('host', '').lower()}":
        return False
    return headers.get("sec-fetch-site", "same-origin") in ("same-origin", "none")


def _parts(host: str, default: int) -> tuple[str | None, int]:
    """Name (lower case, without brackets) and port of a Host header; no name if it isn't one."""
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
    try:
        found = ipaddress.ip_address(text.partition("%")[0])
    except ValueError:
        return None
    mapped = found.ipv4_mapped if isinstance(found, ipaddress.IPv6Address) else None
    return mapped or found


MAX_BODY = 1_000_000
"""Bytes of a request's body: as large as a preset file may be."""

BODY_WITHIN_S = 10.0

REFUSED = {
    Verdict.MISSING: (401, "open the address that `overview` printed: it holds the token"),
    Verdict.WRONG: (401, "the token isn't that of this run; open the address printed last"),
    Verdict.LIMITED: (429, f"too many wrong tokens; wait {WRONG_WITHIN_S:.0f} s"),
}


class Guard:
    """An ASGI application in front of another one.

    Parameters
    ----------
    names
        Host names of this machine, besides its addresses.
    public
        Paths that anyone may get: the page without any data.
    note
        Receives a line about what failed.
    """

    def __init__(
        self,
        app: ASGIApp,
        access: Access,
        names: Collection[str],
        public: Collection[str],
        note: Callable[[str], None],
    ) -> None:
        self._app = RequestBodyLimitMiddleware(app, MAX_BODY)
        self._access = access
        self._names = names
        self._public = public
        self._note = note

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check, then pass on."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        started = False

        async def answer(message: Message) -> None:
            nonlocal started
            if message["type"] in ("http.response.start", "websocket.http.response.start"):
                headers = MutableHeaders(scope=message)
                for name, value in SECURITY.items():
                    headers.setdefault(name, value)
            if message["type"] != "websocket.close":
                started = True
            await send(message)

        refusal = self._refusal(scope)
        if refusal is not None:
            await refuse(scope, answer, *refusal)
            return
        inner = _in_time(receive) if scope["type"] == "http" else receive
        try:
            await self._app(scope, inner, answer)
        except TimeoutError:
            if not started:
                await refuse(scope, answer, 408, f"a request arrives in {BODY_WITHIN_S:.0f} s")
        except Exception as error:
            # escaped: a path may hold what a terminal obeys
            self._note(f"{scope['path']!a}: {type(error).__name__}: {str(error)!a}")
            if not started:
                await refuse(scope, answer, 500, "failed; the server's log says why")

    def _refusal(self, scope: Scope) -> tuple[int, str] | None:
        """Status and line for a request that is not let in; None for one that is."""
        headers = Headers(scope=scope)
        hosts = headers.getlist("host")
        scheme = scope["scheme"]
        if len(hosts) != 1 or not host_is_ours(hosts[0], scheme, scope["server"], self._names):
            return 421, "this server goes by the address that `overview` printed"
        is_socket = scope["type"] == "websocket"
        reads = not is_socket and scope["method"] in ("GET", "HEAD")
        if reads and scope["path"] in self._public:
            return None
        if len(headers.getlist("origin")) > 1 or not origin_is_ours(headers, scheme, not reads):
            return 403, "only the page of this server may ask that"
        length = headers.get("content-length", "0")
        if not length.isdecimal() or len(length) > 9 or int(length) > MAX_BODY:
            return 413, f"a request holds up to {MAX_BODY:,} bytes"
        client = scope["client"]
        verdict = self._access.check(
            _bearer(headers),
            _cookie(headers, cookie_name(scope)),
            client[0] if client else "",
        )
        return REFUSED.get(verdict)


def cookie_name(scope: Scope) -> str:
    """The session cookie's name: cookies don't know ports, so it does.

    With https its prefix makes browsers refuse one that another host or plain http has set.
    """
    name = f"overview-{scope['server'][1]}"
    return f"__Host-{name}" if scope["scheme"] in ("https", "wss") else name


async def refuse(scope: Scope, send: Send, status: int, line: str) -> None:
    """Answer a request, or a WebSocket's, with one line, and close its connection."""
    kind = "websocket.http.response" if scope["type"] == "websocket" else "http.response"
    body = (line + "\n").encode()
    headers = [
        (b"content-type", b"text/plain; charset=utf-8"),
        (b"content-length", str(len(body)).encode()),
        (b"connection", b"close"),
    ]
    if status == 401:
        headers.append((b"www-authenticate", b"Bearer"))
    if status == 429:
        headers.append((b"retry-after", f"{WRONG_WITHIN_S:.0f}".encode()))
    await send({"type": f"{kind}.start", "status": status, "headers": headers})
    await send({"type": f"{kind}.body", "body": body})


def _bearer(headers: Headers) -> str | None:
    scheme, _, token = headers.get("authorization", "").partition(" ")
    return token if scheme.lower() == "bearer" and token else None


def _cookie(headers: Headers, name: str) -> str | None:
    try:
        found = SimpleCookie(headers.get("cookie", "")).get(name)
    except CookieError:
        return None
    return None if found is None else found.value


def _in_time(receive: Receive) -> Receive:
    """Return `receive` for a body that must come within `BODY_WITHIN_S`."""
    complete = False
    until = asyncio.get_running_loop().time() + BODY_WITHIN_S

    async def in_time() -> Message:
        nonlocal complete
        if complete:  # only waits for the end of the connection
            return await receive()
        async with asyncio.timeout_at(until):
            message = await receive()
        complete = not message.get("more_body", False)
        return message

    return in_time
