"""A page as it was exported, on a web host that sends a strict policy and nothing else."""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import overview_dsp as ov
from overview_dsp.web.assets import WEB
from overview_dsp.web.static_site import write_site
from tests.web.driving import PHONE, until

POLICY = "; ".join(
    [
        "default-src 'none'",
        "script-src 'self' 'wasm-unsafe-eval'",
        *(f"{what}-src 'self'" for what in ("style", "img", "connect", "worker", "manifest")),
    ]
)

MODULES = "/modules"
"""Where a test's script imports one of the page's modules, which a folder has as a bundle."""

HELD = "/held.png"
HOLDS_S = 120.0


class Handler(SimpleHTTPRequestHandler):
    def end_headers(self) -> None:
        self.send_header("Content-Security-Policy", POLICY)
        super().end_headers()

    def translate_path(self, path: str) -> str:
        folder, _, name = path.rpartition("/")
        if folder != MODULES:
            return super().translate_path(path)
        return str(next(place / name for place in (WEB / "site", WEB) if (place / name).exists()))

    def do_GET(self) -> None:
        if self.path == HELD:  # a page that has it isn't loaded before
            self.server.released.wait(HOLDS_S)
        super().do_GET()

    def do_POST(self) -> None:
        self.server.told.put(self.rfile.read(int(self.headers["Content-Length"])))
        self.send_response(204)
        self.end_headers()

    def log_message(self, *unused: Any) -> None:
        pass


class Server(ThreadingHTTPServer):
    """`told` is what pages posted; `HELD` is answered once `released` is set."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.released = threading.Event()
        self.told: queue.Queue[bytes] = queue.Queue()

    def handle_error(self, *unused: Any) -> None:
        """A page that is closed while it loads is no fault."""


class Host:
    """`url` serves `folder` until `close`."""

    def __init__(self, folder: Path) -> None:
        self.server = Server(("127.0.0.1", 0), partial(Handler, directory=folder))
        self.thread = threading.Thread(target=self.server.serve_forever, daemon=True)
        self.thread.start()
        self.url = f"http://127.0.0.1:{self.server.server_port}/"

    def close(self) -> None:
        self.server.released.set()
        self.server.shutdown()
        self.server.server_close()
        self.thread.join()


@contextlib.contextmanager
def opened_host(folder: Path) -> Iterator[Host]:
    host = Host(folder)
    try:
        yield host
    finally:
        host.close()


@contextlib.contextmanager
def opened_page(
    chromium: Any, timeline: ov.Timeline, preset: str, folder: Path, levels: int = 0
) -> Iterator[Any]:
    """Export a timeline into a folder, and open the page on a phone; no fault may be shown."""
    write_site(timeline, ov.load_preset(preset), folder, levels=levels)
    with opened_host(folder) as host:
        context = chromium.new_context(viewport=PHONE)
        page = context.new_page()
        page.goto(host.url)
        until(page, "p.view && p.isStarted === false && (!p.info.series || p.view.points)")
        yield page
        assert page.text_content("#fault") == ""
        context.close()
