"""A web site on this machine with the package's files and what a test gives it."""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
TYPES = {"html": "text/html", "js": "text/javascript", "wasm": "application/wasm"}
# what the page will be served with: nothing inline, WebAssembly allowed
POLICY = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self'"


class Site:
    """`given` holds the bytes that the page may fetch, `answers` what it posts."""

    def __init__(self) -> None:
        package = resources.files("overview_dsp.web")
        self.given = {"kernel.wasm": (package / "kernel.wasm").read_bytes()}
        self.answers: queue.Queue[bytes] = queue.Queue()
        self.server = ThreadingHTTPServer(("127.0.0.1", 0), self._handler(package))

    def url(self, path: str) -> str:
        return f"http://127.0.0.1:{self.server.server_port}/{path}"

    def _handler(self, package: Any) -> type[BaseHTTPRequestHandler]:
        given, answers = self.given, self.answers

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                name = self.path.rpartition("/")[2]
                if self.path.startswith("/given/"):
                    content = given.get(name)
                else:
                    here = HERE / "page" / name
                    file = here if here.is_file() else package / name
                    content = file.read_bytes() if name and file.is_file() else None
                self.send_response(200 if content is not None else 404)
                self.send_header("Content-Type", TYPES.get(name.rpartition(".")[2], "text/plain"))
                self.send_header("Content-Security-Policy", POLICY)
                self.end_headers()
                self.wfile.write(content or b"")

            def do_POST(self) -> None:
                answers.put(self.rfile.read(int(self.headers["Content-Length"])))
                self.send_response(204)
                self.end_headers()

            def log_message(self, *unused: Any) -> None:
                pass

        return Handler


@contextlib.contextmanager
def opened_site() -> Iterator[Site]:
    site = Site()
    thread = threading.Thread(target=site.server.serve_forever, daemon=True)
    thread.start()
    try:
        yield site
    finally:
        site.server.shutdown()
        site.server.server_close()
        thread.join()
