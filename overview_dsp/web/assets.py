"""The page's own files, the same for every timeline: a fixed table, nothing else of this machine's
disk can be asked for.
"""

from __future__ import annotations

import hashlib
from functools import cache
from importlib import resources

from overview_dsp.web.first_script import with_first_script
from overview_dsp.web.shortening import numbers_used, shortened

TYPES = {
    "html": "text/html; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "svg": "image/svg+xml",
    "png": "image/png",
    "wasm": "application/wasm",
    "webmanifest": "application/manifest+json",
}

KERNEL_FILES = (
    *("kernel.js", "kernel.wasm", "kernel_node.js", "layout.js", "processor.js", "unpack.js"),
)
START = "index.html"
FOLDER_ONLY = ("worker.js",)
"""Keeps a folder for use without a network; what a server sends isn't to outlive it."""

SERVER_ONLY = (
    *("served.js", "bench.js", "bench_drawing.js", "bench_rows.js", "film.js"),
    *("preset_link.js", "host_sound.js", "link.js"),
)
"""What only a server's page can use: fetched there once the picture is drawn, in no folder."""

LIVE_ONLY = ("live.js",)
"""Fetched for a timeline that grows."""


@cache
def page_files() -> dict[str, bytes]:
    """The files by their path in a folder, as short as they go."""
    package = resources.files(__package__)
    files = {name: package / name for name in KERNEL_FILES}
    for one in sorted((package / "site").iterdir(), key=lambda file: file.name):
        if one.is_file():
            files[one.name] = one
    read = {name: file.read_bytes() for name, file in files.items()}
    read["layout.js"] = numbers_used(read["layout.js"], read["kernel.js"], read["kernel_node.js"])
    page = {name: shortened(name, content) for name, content in read.items()}
    scripts = {name: content for name, content in page.items() if name.endswith(".js")}
    return {**page, **with_first_script(scripts, KERNEL_FILES)}


def folder_files(*, live: bool) -> dict[str, bytes]:
    """The files of a folder by their path; `live`: of a timeline that grows."""
    left_out = SERVER_ONLY if live else (*SERVER_ONLY, *LIVE_ONLY)
    return {name: file for name, file in page_files().items() if name not in left_out}


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
