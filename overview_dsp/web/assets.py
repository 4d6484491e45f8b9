"""The page's own files, the same for every timeline: a fixed table, nothing else of this machine's
disk can be asked for.

The scripts and the style are those of `bundle/`, which `tools/bundle_page.py` makes of `*.js` and
`site/`; the other files are as they are in `site/`.
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
    "svg": "image/svg+xml",
    "png": "image/png",
    "wasm": "application/wasm",
    "deflated": "application/octet-stream",
    "webmanifest": "application/manifest+json",
}

KERNEL_DEFLATED = "kernel.deflated"
"""`kernel.wasm` as the page has it: a quarter of its bytes."""

START = "index.html"
FOLDER_ONLY = "worker.js"
"""Keeps a folder for use without a network; what a server sends isn't to outlive it."""

SERVER_ONLY = "served.js"
"""What only a server's page can use: fetched there once the picture is drawn, in no folder."""

LIVE_ONLY = "live.js"
"""Fetched for a timeline that grows."""

_IMPORTED = re.compile(rb'from "\./([\w.]+)"')


@cache
def page_files() -> dict[str, bytes]:
    """Return the files by their path in a folder."""
    files = {file.name: file.read_bytes() for file in (WEB / "site").iterdir()}
    files = {name: file for name, file in files.items() if not name.endswith((".js", ".css"))}
    for suffix in ("js", "css"):
        files |= {file.name: file.read_bytes() for file in (WEB / "bundle").glob(f"*.{suffix}")}
    files[KERNEL_DEFLATED] = zlib.compress((WEB / "kernel.wasm").read_bytes(), 9)
    return dict(sorted(files.items()))


def folder_files(*, live: bool) -> dict[str, bytes]:
    """Return the files of a folder by their path; `live`: of a timeline that grows."""
    left_out = (SERVER_ONLY,) if live else (SERVER_ONLY, LIVE_ONLY)
    return {name: file for name, file in page_files().items() if name not in left_out}


def page_with(own: Mapping[str, bytes], shared: Iterable[str]) -> dict[str, bytes]:
    """Return the files of another page and those that it shares of this one, by their path.

    Parameters
    ----------
    own : mapping of str to bytes
        The other page's files.
    shared : iterable of str
        Files of this page that the other names, besides the modules that its own import.
    """
    files = dict(own)
    wanted = [*shared, *(found for name, file in own.items() for found in _imported(name, file))]
    while wanted:
        name = wanted.pop()
        if name not in files:
            folder = WEB if (WEB / name).is_file() else WEB / "site"
            files[name] = (folder / name).read_bytes()
            wanted += _imported(name, files[name])
    return dict(sorted(files.items()))


def _imported(name: str, file: bytes) -> list[str]:
    """Return what a script that lies in no folder of its own imports."""
    if not name.endswith(".js") or "/" in name:
        return []
    return [found.decode() for found in _IMPORTED.findall(file)]


def served_paths() -> tuple[str, ...]:
    """The paths at which a server has them."""
    names = (name for name in page_files() if name != FOLDER_ONLY)
    return tuple("/" if name == START else f"/{name}" for name in names)


@cache
def asset(path: str) -> tuple[bytes, str, str]:
    """Bytes, type and ETag of a path of `served_paths`."""
    name = START if path == "/" else path.removeprefix("/")
    content = page_files()[name]
    tag = f'"{hashlib.sha256(content).hexdigest()[:16]}"'
    return content, TYPES[name.rpartition(".")[2]], tag
