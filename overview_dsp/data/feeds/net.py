"""Feeds from the network: HTTP that is asked again and again, server-sent events, WebSockets."""

from __future__ import annotations

import http.client
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from overview_dsp.data.feeds.feed_lines import MAX_LINE_BYTES
from overview_dsp.data.feeds.sources import CHUNK_BYTES, ENDS_WITHIN_S, Came, LostError, is_feed
from overview_dsp.data.readers.registry import load_timeline
from overview_dsp.errors import InputError
from overview_dsp.installation import install_command

ASK_EVERY_S = 1.0
"""How often a file is asked for; `Retry-After` is respected."""

ANSWER_WITHIN_S = 10.0
SILENT_S = 60.0
"""A stream that says nothing for so long, not even a comment, is lost."""

MAX_BYTES = 64 << 20
"""Largest file that is asked for again and again."""

MAX_MESSAGE = 16 << 20
"""Largest message of a WebSocket: it may hold many lines."""


@dataclass
class Http:
    """An address: server-sent events are listened to, any other file is asked for again."""

    name: str
    ends_within_s: float = ENDS_WITHIN_S
    _tag: str | None = field(default=None, init=False)
    _last_id: str | None = field(default=None, init=False)

    def come(self) -> Iterator[Came]:
        """What it answers."""
        self._tag = None
        while True:
            answer = self._ask()
            if answer is None:
                yield b""
                time.sleep(ASK_EVERY_S)
                continue
            with answer:
                if answer.headers.get_content_type() == "text/event-stream":
                    self._tag = None
                    yield from self._events(answer)
                    raise LostError("the stream has ended")
                data = _body(answer)
            tag = answer.headers.get("ETag") or answer.headers.get("Last-Modified")
            if is_feed(data):
                yield from _parts(data if data.endswith(b"\n") else data[: data.rfind(b"\n") + 1])
            elif data:
                try:
                    yield load_timeline(data)
                except InputError as error:
                    # half a file, perhaps: it is asked for anew
                    raise LostError(f"{error}") from None
            self._tag = tag
            time.sleep(ASK_EVERY_S)

    def _ask(self) -> Any:
        """The answer; None if nothing has changed."""
        request = urllib.request.Request(self.name)
        request.add_header("Accept", "text/event-stream, application/x-ndjson, */*;q=0.5")
        if self._tag is not None:
            by_time = self._tag.endswith("GMT")
            request.add_header("If-Modified-Since" if by_time else "If-None-Match", self._tag)
        if self._last_id is not None:
            request.add_header("Last-Event-ID", self._last_id)
        try:
            return urllib.request.urlopen(request, timeout=ANSWER_WITHIN_S)
        except urllib.error.HTTPError as error:
            with error:
                if error.code == 304:
                    return None
                after = error.headers.get("Retry-After", "")
                raise LostError(
                    f"HTTP {error.code} {error.reason}",
                    min(float(after), 600.0) if after.isdecimal() else 0.0,
                ) from None
        except (OSError, http.client.HTTPException) as error:
            raise LostError(_reason(error)) from None
        except ValueError as error:
            raise InputError(f"{self.name}: {error}") from None

    def _events(self, answer: Any) -> Iterator[Came]:
        """The data of server-sent events (WHATWG HTML, 9.2), a line of a feed each.

        An event counts when it is whole: one that is cut off is asked for again by the last id.
        """
        line, data = b"", b""
        name: str | None = None
        try:
            _set_timeout(answer, SILENT_S)
            while part := answer.readline(CHUNK_BYTES):
                # the rest of what is too long for a line isn't kept: its reader says so
                line = (line + part.rstrip(b"\r\n"))[: MAX_LINE_BYTES + 16]
                if not part.endswith(b"\n"):
                    continue
                field, _, value = line.partition(b":")
                value, line = value.removeprefix(b" "), b""
                if field == b"data":
                    data = (data + value + b"\n")[:MAX_BYTES]
                elif field == b"id" and len(value) < 256:
                    name = value.decode("latin-1")
                elif not field and not value:
                    yield data
                    self._last_id, data = name or self._last_id, b""
                else:
                    yield b""
        except (OSError, http.client.HTTPException) as error:
            raise LostError(_reason(error)) from None


@dataclass
class WebSocket:
    """A WebSocket whose messages are lines of a feed."""

    name: str
    ends_within_s: float = ENDS_WITHIN_S

    def come(self) -> Iterator[Came]:
        """What is sent."""
        try:
            from websockets.exceptions import InvalidURI, WebSocketException
            from websockets.sync.client import connect
        except ImportError:
            raise InputError(
                f"a WebSocket needs the package websockets: {install_command('web')}"
            ) from None
        try:
            with connect(
                self.name, open_timeout=ANSWER_WITHIN_S, max_size=MAX_MESSAGE, close_timeout=1.0
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
            raise LostError(_reason(error)) from None


def _parts(data: bytes) -> Iterator[bytes]:
    for start in range(0, len(data), CHUNK_BYTES):
        yield data[start : start + CHUNK_BYTES]


def _body(answer: Any) -> bytes:
    try:
        data: bytes = answer.read(MAX_BYTES + 1)
    except (OSError, http.client.HTTPException) as error:
        raise LostError(_reason(error)) from None
    if len(data) > MAX_BYTES:
        raise InputError(f"an answer of more than {MAX_BYTES >> 20} MB; serve it as a feed instead")
    return data


def _set_timeout(answer: Any, seconds: float) -> None:
    socket = getattr(getattr(answer.fp, "raw", None), "_sock", None)
    if socket is not None:
        socket.settimeout(seconds)


def _reason(error: BaseException) -> str:
    inner = error.reason if isinstance(error, urllib.error.URLError) else None
    found = inner if isinstance(inner, BaseException) else error
    return str(getattr(found, "strerror", None) or found) or type(found).__name__
