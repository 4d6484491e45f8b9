"""Phone apps that provide sensor data by HTTP: phyphox as a server, Sensor Logger as a client."""

from __future__ import annotations

import http.client
import json
import re
import threading
import time
import urllib.parse
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from overview_dsp.devices.sensors.app_json import LONGEST
from overview_dsp.errors import InputError
from overview_dsp.live.ports.osc import parse_address
from overview_dsp.live.ports.port import Port, PortLostError, QueuedPort

ANSWER_WITHIN_S = 2.0
REQUEST_EVERY_S = 0.01
"""Shortest interval between two requests to phyphox."""

MAX_ANSWER = 1 << 20
MAX_QUEUED = 64
"""Maximum number of queued batches."""

_MEASURED = re.compile(r"(acc|gyr)[a-z]*?_?([xyzt]|time)$", re.IGNORECASE)


class PhyphoxPort(Port):
    """Client of phyphox's remote access, which starts the experiment and requests its new data."""

    def __init__(self, address: str) -> None:
        """Connect to `http://HOST:PORT`.

        InputError: no answer, or the experiment has no accelerometer.
        """
        self.name = address
        parts = urllib.parse.urlsplit(address)
        try:
            host, port = parts.hostname, parts.port or 80
        except ValueError:
            host, port = None, 0
        if not host or parts.scheme != "http":
            raise InputError(f"{address} must be the URL that phyphox shows, http://PHONE:8080")
        self._connection = http.client.HTTPConnection(host, port, timeout=ANSWER_WITHIN_S)
        self._request_at = 0.0
        try:
            names = _buffers(self._request("/config"))
            if not any(name.lower().startswith("acc") for name in names):
                raise InputError(
                    f"{address}: the experiment has no accelerometer; open Acceleration (with g) "
                    "in phyphox"
                )
            self._path = "/get?" + "&".join(urllib.parse.quote(name) for name in names)
            self._request("/control?cmd=start")
        except PortLostError as error:
            self.close()
            raise InputError(
                f"{error}; enable remote access in phyphox, and use the same network"
            ) from None
        except InputError:
            self.close()
            raise

    def _request(self, path: str) -> bytes:
        try:
            self._connection.request("GET", path)
            answer = self._connection.getresponse()
            body = answer.read(MAX_ANSWER)
        except (OSError, http.client.HTTPException) as error:
            self._connection.close()
            raise PortLostError(f"{self.name}: {error or type(error).__name__}") from None
        if answer.status != 200:
            raise PortLostError(f"{self.name}: {path}: HTTP {answer.status} {answer.reason}")
        return body

    def receive(self, wait_s: float) -> list[bytes]:
        """Return the latest data as one line; PortLostError if the phone doesn't answer."""
        time.sleep(max(0.0, self._request_at - time.monotonic()))
        self._request_at = time.monotonic() + REQUEST_EVERY_S
        return [_line(self._request(self._path))]

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()


def _buffers(config: bytes) -> list[str]:
    try:
        names = [str(one["name"]) for one in json.loads(config)["buffers"]]
    except (ValueError, KeyError, TypeError, RecursionError):
        raise PortLostError("the answer isn't from phyphox") from None
    return [name for name in names if _MEASURED.fullmatch(name)]


def _line(body: bytes) -> bytes:
    """Return a body as one line; line ends within JSON become blanks."""
    return body.replace(b"\r", b" ").replace(b"\n", b" ") + b"\n"


class PostPort(QueuedPort):
    """HTTP server for the batches that an app posts (Sensor Logger), one line per batch."""

    def __init__(self, text: str) -> None:
        """Listen at `PORT` of this machine, or `HOST:PORT`; InputError if that fails."""
        super().__init__(f"post:{text}", MAX_QUEUED)
        put = self.put

        class Handler(BaseHTTPRequestHandler):
            timeout = 10.0
            protocol_version = "HTTP/1.1"

            def log_message(self, *arguments: object) -> None:
                """Log nothing."""

            def do_POST(self) -> None:
                """Queue a batch."""
                length = self.headers.get("Content-Length", "")
                if not length.isdecimal() or len(length) > 9 or int(length) > LONGEST:
                    self.close_connection = True
                    self._answer(
                        413, f"a batch must have at most {LONGEST} bytes; send more often\n"
                    )
                    return
                put(_line(self.rfile.read(int(length))))
                self._answer(200, "")

            def _answer(self, status: int, text: str) -> None:
                self.send_response(status)
                self.send_header("Content-Length", str(len(text)))
                self.end_headers()
                self.wfile.write(text.encode())

        try:
            self._server = ThreadingHTTPServer(parse_address(text), Handler)
        except OSError as error:
            raise InputError(f"{self.name}: can't be opened ({error.strerror or error})") from None
        self._server.daemon_threads = True
        threading.Thread(
            target=self._server.serve_forever, args=(0.05,), name="posted batches", daemon=True
        ).start()

    @property
    def address(self) -> tuple[str, int]:
        """Host and port of the server."""
        host, port = self._server.server_address[:2]
        return str(host), int(port)

    def close(self) -> None:
        """Stop the server."""
        self._server.shutdown()
        self._server.server_close()
