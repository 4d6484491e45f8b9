"""The page's own files, the same for every timeline: a fixed table, nothing else of this machine's
disk can be asked for.
"""

from __future__ import annotations

import hashlib
import re
import zlib
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
    "deflated": "application/octet-stream",
    "webmanifest": "application/manifest+json",
}

KERNEL_FILES = (
    *("kernel.js", "kernel.wasm", "kernel_node.js", "layout.js", "processor.js", "unpack.js"),
)
KERNEL_DEFLATED = "kernel.deflated"
"""`kernel.wasm` as the page has it: a quarter of its bytes."""

START = "index.html"
STUDY_SHARES = ("style.css", "icon.svg", "worker.js", "kernel.wasm")
"""What a study's page has of this one, besides the scripts that its own import."""

FOLDER_ONLY = ("worker.js",)
"""Keeps a folder for use without a network; what a server sends isn't to outlive it."""

SERVER_ONLY = (
    *("served.js", "bench.js", "bench_drawing.js", "bench_rows.js", "film.js"),
    *("preset_link.js", "host_sound.js", "link.js"),
)
"""What only a server's page can use: fetched there once the picture is drawn, in no folder."""

LIVE_ONLY = ("live.js",)
"""Fetched for a timeline that grows."""


_IMPORTED = re.compile(rb'from "\./([\w.]+)"')


@cache
def page_files() -> dict[str, bytes]:
    """The files by their path in a folder, as short as they go."""
    package = resources.files(__package__)
    files = {name: package / name for name in KERNEL_FILES}
    for one in sorted((package / "site").iterdir(), key=lambda file: file.name):
        if one.is_file():
            files[one.name] = one
    read = {name: file.read_bytes() for name, file in files.items()}
    read[KERNEL_DEFLATED] = zlib.compress(read.pop("kernel.wasm"), 9)
    read["layout.js"] = numbers_used(read["layout.js"], read["kernel.js"], read["kernel_node.js"])
    page = {name: shortened(name, content) for name, content in read.items()}
    scripts = {name: content for name, content in page.items() if name.endswith(".js")}
    return {**page, **with_first_script(scripts, KERNEL_FILES)}


def folder_files(*, live: bool) -> dict[str, bytes]:
    """The files of a folder by their path; `live`: of a timeline that grows."""
    left_out = SERVER_ONLY if live else (*SERVER_ONLY, *LIVE_ONLY)
    return {name: file for name, file in page_files().items() if name not in left_out}


def study_files() -> dict[str, bytes]:
    """The files of a study's page (`study/`) by their path in a folder, and what they share."""
    package = resources.files(__package__)
    own = {one.name: one for one in (package / "study").iterdir() if one.is_file()}
    vendored = {f"jspsych/{one.name}": one for one in (package / "study" / "jspsych").iterdir()}
    files = {name: file.read_bytes() for name, file in {**own, **vendored}.items()}
    wanted = [*STUDY_SHARES, *_imported(files)]
    while wanted:
        name = wanted.pop()
        if name not in files:
            at = package / name if name in KERNEL_FILES else package / "site" / name
            files[name] = at.read_bytes()
            wanted += _imported({name: files[name]})
    return {name: shortened(name, file) if "/" not in name else file
            for name, file in sorted(files.items())}  # fmt: skip


def _imported(files: dict[str, bytes]) -> list[str]:
    """What scripts import that lie in no folder of their own."""
    return [
        found.decode()
        for name, file in files.items()
        if name.endswith(".js") and "/" not in name
        for found in _IMPORTED.findall(file)
    ]


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
