"""Feed servers that can be killed."""

from __future__ import annotations

import contextlib
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer


def wait_until(condition, seconds=60.0):
    """Return whether a condition becomes true; the timeout allows for a busy machine."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        if condition():
            return True
        time.sleep(0.01)
    return condition()


class FeedServer:
    """HTTP server of a feed: `/feed` has its lines and an ETag, `/events` server-sent events.

    Only the first `available` lines are served. `kill` closes the connections abruptly.
    """

    def __init__(self, port=0):
        self.lines, self.available, self.requests, self.statuses = [], 0, [], []
        self.port = port
        self._server = None

    @property
    def address(self):
        return f"http://127.0.0.1:{self.port}"

    def start(self):
        outer = self

        class Handler(BaseHTTPRequestHandler):
            def log_message(self, *arguments):
                pass

            def do_GET(self):
                outer.requests.append(dict(self.headers))
                with contextlib.suppress(OSError):
                    if self.path == "/events":
                        self._events()
                    elif self.path == "/busy":
                        self.send_error(503)
                    else:
                        self._file()

            def _file(self):
                body = "".join(outer.lines[: outer.available]).encode()
                tag = f'"{len(body)}"'
                same = self.headers.get("If-None-Match") == tag
                outer.statuses.append(304 if same else 200)
                self.send_response(outer.statuses[-1])
                self.send_header("ETag", tag)
                self.send_header("Content-Length", str(0 if same else len(body)))
                self.end_headers()
                self.wfile.write(b"" if same else body)

            def _events(self):
                self.send_response(200)
                self.send_header("Content-Type", "text/event-stream")
                self.end_headers()
                sent = int(self.headers.get("Last-Event-ID", 0))
                while not outer.killed.is_set():
                    self.wfile.write(b": alive\n\n")
                    count = outer.available  # the test may add more at any time
                    for n in range(sent, count):
                        data = outer.lines[n].rstrip()
                        event = f"id: {n + 1}\ndata: {data}\n\n".encode()
                        if outer.killed.is_set():  # in the middle of an event
                            self.wfile.write(event[: n % len(event)])
                            return
                        self.wfile.write(event)
                    sent = count
                    time.sleep(0.01)

        self.killed = threading.Event()
        ThreadingHTTPServer.allow_reuse_address = True
        self._server = ThreadingHTTPServer(("127.0.0.1", self.port), Handler)
        self._server.daemon_threads = True
        self.port = self._server.server_port
        threading.Thread(target=self._server.serve_forever, args=(0.01,), daemon=True).start()
        return self

    def kill(self):
        self.killed.set()
        self._server.shutdown()
        self._server.server_close()


@contextlib.contextmanager
def event_stream(write):
    """Serve server-sent events: `write(file)` writes them; yields the address."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/event-stream; charset=utf-8")
            self.end_headers()
            with contextlib.suppress(OSError):
                write(self.wfile)

        def log_message(self, *arguments):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/"
    finally:
        server.shutdown()
        server.server_close()
