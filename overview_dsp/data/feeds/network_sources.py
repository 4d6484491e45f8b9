"""Network sources of a live timeline: HTTP polling, server-sent events, WebSockets."""

from __future__ import annotations

import codecs
import http.client
import os
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass, field
from email.message import Message
from typing import Any
from urllib.parse import urlsplit

from overview_dsp.data.feeds import sources
from overview_dsp.data.feeds.feed_lines import MAX_LINE_BYTES
from overview_dsp.data.readers.registry import load_timeline
from overview_dsp.errors import InputError
from overview_dsp.installation import install_command

POLL_EVERY_S = 1.0  # shortest interval at which a file is requested, s, and its default
SERVICE_EVERY_S = 30.0
"""Default interval at which a document of a live service is requested, s."""

KEYS = {
    "v3.football.api-sports.io": ("x-apisports-key", "API_FOOTBALL_KEY"),
    "api.football-data.org": ("X-Auth-Token", "FOOTBALL_DATA_TOKEN"),
    "api.openligadb.de": ("", ""),
}
"""Header of the key and environment variable that holds it, by the host of a live service.

The key is sent to this host only, not to one that the host redirects to.
"""

_REMAINING = {
    "X-Requests-Available-Minute": 60.0,
    "X-RateLimit-Remaining": 60.0,
    "x-ratelimit-requests-remaining": 3600.0,
}
"""Wait, s, when the number of remaining requests in this header of a response is 0."""

RESPONSE_TIMEOUT_S = 10.0
STREAM_TIMEOUT_S = 60.0
"""Time without data, not even a comment, after which a stream is lost, s."""

MAX_BYTES = 64 << 20  # maximum size of a file that is requested repeatedly
MAX_MESSAGE_BYTES = 16 << 20
"""Maximum size of a WebSocket message or a server-sent event, which may hold many lines."""


@dataclass
class Http(sources.Source):
    """URL of server-sent events, or of any other file, which is requested repeatedly.

    `every_s`: interval of the requests, s; None: 30 for a live service, else 1. Longer waits that a
    server demands are respected. After the end of a match in progress no request follows.
    """

    name: str
    every_s: float | None = None
    _tag: str | None = field(default=None, init=False)
    _last_id: str | None = field(default=None, init=False)

    def read(self) -> Iterator[sources.Received]:
        """Yield the events of a stream, or the file each time it changes."""
        self._tag = None
        host = urlsplit(self.name).hostname or ""
        every_s = self.every_s or (SERVICE_EVERY_S if host in KEYS else POLL_EVERY_S)
        in_progress = False
        while True:
            response = self._request(*KEYS.get(host, ("", "")), every_s)
            if response is None:
                yield b""
                yield from _wait(every_s)
                continue
            with response:
                if response.headers.get_content_type() == "text/event-stream":
                    self._tag = None
                    yield from self._events(response)
                    raise sources.LostError("the stream has ended")
                data = _body(response)
            wait_s = _required_wait_s(response.headers, every_s)
            tag = response.headers.get("ETag") or response.headers.get("Last-Modified")
            if sources.is_feed(data):
                yield from _parts(data if data.endswith(b"\n") else data[: data.rfind(b"\n") + 1])
            elif data:
                try:
                    timeline = load_timeline(data)
                except InputError as error:
                    # the file may be incomplete, so it is requested again
                    raise sources.LostError(f"{error}", wait_s) from None
                yield timeline
                if in_progress and timeline.known_until_s is None:
                    yield b'{"end": %r}\n' % timeline.duration_s
                    return
                in_progress = timeline.known_until_s is not None
            self._tag = tag
            yield from _wait(wait_s)

    def _request(self, header: str, variable: str, every_s: float) -> Any:
        """Return the response, None if unchanged; `header` and `variable` of the key may be ""."""
        key = os.environ.get(variable, "").strip() if variable else ""
        request = urllib.request.Request(self.name)
        if key:
            request.add_unredirected_header(header, key)
        request.add_header("Accept", "text/event-stream, application/x-ndjson, */*;q=0.5")
        if self._tag is not None:
            by_time = self._tag.endswith("GMT")
            request.add_header("If-Modified-Since" if by_time else "If-None-Match", self._tag)
        if self._last_id is not None:
            request.add_header("Last-Event-ID", self._last_id)
        try:
            return urllib.request.urlopen(request, timeout=RESPONSE_TIMEOUT_S)
        except urllib.error.HTTPError as error:
            with error:
                if error.code == 304:
                    return None
                if error.code in (401, 403) and variable:
                    remedy = "its key was rejected" if key else "set it to your key"
                    raise InputError(
                        f"{self.name}: HTTP {error.code}; environment variable {variable}: {remedy}"
                    ) from None
                least_s = every_s if error.code == 429 else 0.0
                wait_s = _required_wait_s(error.headers, least_s)
                raise sources.LostError(f"HTTP {error.code} {error.reason}", wait_s) from None
        except (OSError, http.client.HTTPException) as error:
            raise sources.LostError(_reason(error)) from None
        except ValueError as error:
            raise InputError(f"{self.name}: {error}") from None

    def _events(self, response: Any) -> Iterator[sources.Received]:
        """Yield the data of server-sent events (WHATWG HTML, 9.2), one feed line per event.

        Only complete events are yielded. After a new connection the server repeats an incomplete
        event, because the request contains the id of the last complete one.
        """
        line, data, size = b"", list[bytes](), 0
        event_id: str | None = None
        try:
            socket = getattr(getattr(response.fp, "raw", None), "_sock", None)
            if socket is not None:
                socket.settimeout(STREAM_TIMEOUT_S)
            while part := response.readline(sources.CHUNK_BYTES):
                # cut just above the limit, so that the feed format rejects the line
                line = (line + part.rstrip(b"\r\n"))[: MAX_LINE_BYTES + 16]
                if not part.endswith(b"\n"):
                    continue
                field, _, value = line.removeprefix(codecs.BOM_UTF8).partition(b":")
                value, line = value.removeprefix(b" "), b""
                if field == b"data":
                    size += len(value) + 1
                    if size > MAX_MESSAGE_BYTES:
                        raise sources.LostError(
                            f"a server-sent event has more than {MAX_MESSAGE_BYTES >> 20} MB, "
                            "the maximum; end each event with an empty line"
                        )
                    data.append(value + b"\n")
                elif field == b"id" and len(value) < 256:
                    event_id = value.decode("latin-1")
                elif not field and not value:
                    lines = b"".join(data)
                    is_one = len(data) > 1 and sources.is_json(lines)
                    yield lines.replace(b"\n", b" ") + b"\n" if is_one else lines
                    self._last_id, data, size = event_id or self._last_id, [], 0
                else:
                    yield b""
        except (OSError, http.client.HTTPException) as error:
            raise sources.LostError(_reason(error)) from None


@dataclass
class WebSocket(sources.Source):
    """URL of a WebSocket whose messages are lines of a feed."""

    name: str

    def read(self) -> Iterator[sources.Received]:
        """Yield the messages."""
        try:
            from websockets.exceptions import InvalidURI, WebSocketException
            from websockets.sync.client import connect
        except ImportError:
            raise InputError(
                f"{self.name}: a WebSocket requires the package websockets: "
                f"{install_command('web')}"
            ) from None
        try:
            with connect(
                self.name,
                open_timeout=RESPONSE_TIMEOUT_S,
                max_size=MAX_MESSAGE_BYTES,
                close_timeout=1.0,
            ) as socket:
                while True:
                    try:
                        message = socket.recv(timeout=1.0)
                    except TimeoutError:
                        yield None
                        continue
                    data = message.encode() if isinstance(message, str) else message
                    yield from _parts(data if data.endswith(b"\n") else data + b"\n")
        except InvalidURI as error:
            raise InputError(f"{self.name}: {error}") from None
        except (OSError, WebSocketException) as error:
            raise sources.LostError(_reason(error)) from None


def _required_wait_s(headers: Message, least_s: float) -> float:
    """Return the wait before the next request that a server demands, at least `least_s`, s."""
    waits = [least_s]
    after = headers.get("Retry-After", "")
    if after.isdecimal():
        waits.append(min(float(after), 600.0))
    reset = headers.get("X-RequestCounter-Reset", "")
    for name, wait_s in _REMAINING.items():
        if headers.get(name, "").strip() == "0":
            waits.append(float(reset) if reset.isdecimal() else wait_s)
    return max(waits)


def _wait(seconds: float) -> Iterator[None]:
    """Yield None at intervals, so that a follower can stop in between."""
    until = time.monotonic() + seconds
    while (left := until - time.monotonic()) > 0.0:
        time.sleep(min(left, 0.25))
        yield None


def _parts(data: bytes) -> Iterator[bytes]:
    for start in range(0, len(data), sources.CHUNK_BYTES):
        yield data[start : start + sources.CHUNK_BYTES]


def _body(response: Any) -> bytes:
    try:
        data: bytes = response.read(MAX_BYTES + 1)
    except (OSError, http.client.HTTPException) as error:
        raise sources.LostError(_reason(error)) from None
    if len(data) > MAX_BYTES:
        raise InputError(
            f"the response has more than {MAX_BYTES >> 20} MB, the maximum; serve a feed instead"
        )
    return data


def _reason(error: BaseException) -> str:
    inner = error.reason if isinstance(error, urllib.error.URLError) else None
    cause = inner if isinstance(inner, BaseException) else error
    return str(getattr(cause, "strerror", None) or cause) or type(cause).__name__
