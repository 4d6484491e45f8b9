"""The page's own files, the same for every timeline: a fixed table, nothing else of this machine's
disk can be asked for.
"""

from __future__ import annotations

import hashlib
import re
from functools import cache
from importlib import resources

TYPES = {
    "html": "text/html; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "svg": "image/svg+xml",
    "png": "image/png",
    "wasm": "application/wasm",
    "webmanifest": "application/manifest+json",
}

KERNEL_FILES = ("kernel.js", "kernel.wasm", "kernel_node.js", "layout.js", "processor.js")
START = "index.html"
FOLDER_ONLY = ("worker.js",)
"""Keeps a folder for use without a network; what a server sends isn't to outlive it."""


_COMMENTS = {
    # those on lines of their own, so that nothing within a text is taken for one
    "js": re.compile(rb"^[ \t]*(//[^\n]*|/\*\*.*?\*/)\n", re.MULTILINE | re.DOTALL),
    "css": re.compile(rb"[ \t]*/\*.*?\*/\n?", re.DOTALL),
}


@cache
def page_files() -> dict[str, bytes]:
    """The files by their path in a folder, without comments: a page on a phone is waited for."""
    package = resources.files(__package__)
    files = {name: package / name for name in KERNEL_FILES}
    for one in sorted((package / "site").iterdir(), key=lambda file: file.name):
        if one.is_file():
            files[one.name] = one
    return {name: _without_comments(name, file.read_bytes()) for name, file in files.items()}


def _without_comments(name: str, content: bytes) -> bytes:
    comments = _COMMENTS.get(name.rpartition(".")[2])
    return content if comments is None else comments.sub(b"", content)


def served_paths() -> tuple[str, ...]:
    """The paths at which a server has them."""
    names = (name for name in page_files() if name not in FOLDER_ONLY)
    return tuple("/" if name == START else f"/{name}" for name in names)


@cache
def asset(path: str) -> tuple[bytes, str, str]:
    """Bytes, type and ETag of a path of `served_paths`."""
    name = START if path == "/" else path.removeprefix("/")
    content = page_files()[name]
    tag = f'"{hashlib.sha256(content).hexdigest()[:16]}"'
    return content, TYPES[name.rpartition(".")[2]], tag
