"""The page's files, which are the same for every timeline.

They form a fixed table, so a request can't reach any other file of the machine. Scripts and style
are those of `bundle/`, which `tools/bundle_page.py` makes of `*.js` and `site/`. The other files
come from `site/`.
"""

from __future__ import annotations

import hashlib
import re
import zlib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

WEB = Path(__file__).parent

TYPES = {
    "html": "text/html; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "txt": "text/plain; charset=utf-8",
    "svg": "image/svg+xml",
    "png": "image/png",
    "wasm": "application/wasm",
    "deflated": "application/octet-stream",
    "webmanifest": "application/manifest+json",
}

KERNEL_DEFLATED = "kernel.deflated"
"""Compressed `kernel.wasm`, a quarter of its size."""

START = "index.html"
FOLDER_ONLY = "worker.js"
"""Service worker for offline use of a static folder."""

OTHER_PAGES = ("served.js", "served.css", "gallery.css")
"""Features that need a server, loaded after the picture is drawn, and the gallery's style."""

LIVE_ONLY = "live.js"
"""Script for a live timeline."""

_IMPORT = re.compile(rb'from "\./([\w.]+)"')


@cache
def page_files() -> dict[str, bytes]:
    """Return the page's files by their path in a folder."""
    files = {file.name: file.read_bytes() for file in (WEB / "site").iterdir()}
    files = {name: file for name, file in files.items() if not name.endswith((".js", ".css"))}
    for suffix in ("js", "css"):
        files |= {file.name: file.read_bytes() for file in (WEB / "bundle").glob(f"*.{suffix}")}
    files[START] = re.sub(rb"(?m)^ +", b"", files[START])  # browsers collapse the indentation
    files[KERNEL_DEFLATED] = zlib.compress((WEB / "kernel.wasm").read_bytes(), 9)
    return dict(sorted(files.items()))


def folder_files(*, live: bool) -> dict[str, bytes]:
    """Return the files of a static folder by their path; `live`: for a live timeline."""
    excluded = OTHER_PAGES if live else (*OTHER_PAGES, LIVE_ONLY)
    return {name: file for name, file in page_files().items() if name not in excluded}


def other_page_files(own: Mapping[str, bytes], shared: Iterable[str]) -> dict[str, bytes]:
    """Return the files of another page and the shared files of this one, by their path.

    `own` has the other page's files by path. It uses the `shared` files of this page in addition
    to imported modules.
    """
    files = dict(own)
    pending = [*shared, *(one for name, file in own.items() for one in _imports(name, file))]
    while pending:
        name = pending.pop()
        if name not in files:
            folder = WEB if (WEB / name).is_file() else WEB / "site"
            files[name] = (folder / name).read_bytes()
            pending += _imports(name, files[name])
    return dict(sorted(files.items()))


def _imports(name: str, file: bytes) -> list[str]:
    """Return the modules that a top-level script imports."""
    if not name.endswith(".js") or "/" in name:
        return []
    return [name.decode() for name in _IMPORT.findall(file)]


def served_paths() -> tuple[str, ...]:
    """Return the URL paths of the files on a server."""
    names = (name for name in page_files() if name != FOLDER_ONLY)
    return tuple("/" if name == START else f"/{name}" for name in names)


@cache
def asset(path: str) -> tuple[bytes, str, str]:
    """Return bytes, type and ETag of one of `served_paths`."""
    name = START if path == "/" else path.removeprefix("/")
    content = page_files()[name]
    tag = f'"{hashlib.sha256(content).hexdigest()[:16]}"'
    return content, TYPES[name.rpartition(".")[2]], tag
