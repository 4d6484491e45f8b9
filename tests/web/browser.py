"""A headless Chromium with a page that has the kernel's modules."""

from __future__ import annotations

import base64
import contextlib
import shutil
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest

HERE = Path(__file__).parent
TYPES = {"html": "text/html", "js": "text/javascript", "wasm": "application/wasm"}
# what the page will be served with: nothing inline, WebAssembly allowed
POLICY = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self'"
FLAGS = [
    "--no-sandbox",  # as root
    "--autoplay-policy=no-user-gesture-required",
    "--enable-precise-memory-info",
]


class Browser:
    """A page; `given` holds the bytes that it may fetch."""

    def __init__(self, page: Any, given: dict[str, bytes]) -> None:
        self._page = page
        self._given = given

    def give(self, **named: bytes) -> None:
        self._given.update(named)

    def call(self, function: str, *arguments: Any) -> Any:
        """The answer of one of `probe.js`'s functions."""
        return self._page.evaluate(
            "async ([name, given]) => (await import('/probe.js'))[name](...given)",
            [function, list(arguments)],
        )

    def render(self, **given: Any) -> tuple[np.ndarray, dict[str, Any]]:
        """Samples, float32 (frames, 2), and what else `renderOffline` tells."""
        told = self.call("renderOffline", given)
        samples = np.frombuffer(base64.b64decode(told.pop("samples")), np.float32)
        return samples.reshape(-1, 2), told


def _handler(given: dict[str, bytes]) -> type[BaseHTTPRequestHandler]:
    package = resources.files("overview_dsp.web")

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            name = self.path.rpartition("/")[2]
            if self.path.startswith("/given/"):
                content = given.get(name)
            elif name in ("page.html", "probe.js"):
                content = (HERE / name).read_bytes()
            else:
                file = package / name
                content = file.read_bytes() if name and file.is_file() else None
            self.send_response(200 if content is not None else 404)
            self.send_header("Content-Type", TYPES.get(name.rpartition(".")[2], "text/plain"))
            self.send_header("Content-Security-Policy", POLICY)
            self.end_headers()
            self.wfile.write(content or b"")

        def log_message(self, *unused: Any) -> None:
            pass

    return Handler


@contextlib.contextmanager
def opened() -> Iterator[Browser]:
    """A browser on a page of localhost; skips where there is none."""
    api: Any = pytest.importorskip(
        "playwright.sync_api", reason="needs a driver for a browser: pip install playwright"
    )
    given: dict[str, bytes] = {
        "kernel.wasm": (resources.files("overview_dsp.web") / "kernel.wasm").read_bytes()
    }
    server = ThreadingHTTPServer(("127.0.0.1", 0), _handler(given))
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        with api.sync_playwright() as playwright:
            try:
                browser = playwright.chromium.launch(
                    executable_path=shutil.which("chromium"), args=FLAGS
                )
            except api.Error as error:
                pytest.skip(
                    "needs Chromium: apt install chromium, or playwright install chromium "
                    f"({str(error).splitlines()[0]})"
                )
            page = browser.new_page()
            page.goto(f"http://127.0.0.1:{server.server_port}/page.html")
            yield Browser(page, given)
            browser.close()
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
