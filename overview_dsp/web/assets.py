"""The page's own files, the same for every timeline: a fixed table, nothing else of this machine's
disk can be asked for.

The kernel's bytes, packed for the way to a phone: every bit is there again (`unpack.js`).

Packed are, by zlib's deflate:

    uint8 order; the first byte of every column of 8, the second of every column, ...

of columns that were, as int64 that wrap around, replaced `order` times by their differences to the
column before, and then by (n << 1) ^ (n >> 63), so that small negative ones are small too. A
friction table's neighbours are numbers of almost the same bits, on almost a straight line.

The scripts as two files: a phone waits for each request, not for the bytes.

What `main.js` imports, and what that imports, goes into `first.js`: the first picture. What
`page.js` and its imports have besides, but for the kernel's own modules, goes into `rest.js`. Each
module is in a function of its own; the modules' own files then only hand on what the two have:
nothing is there twice. Scripts that are imported later stay as they are. It knows the few forms of
import and export that the page's scripts have.

The page's own text files without what only their readers need: a phone waits for each byte.
"""

from __future__ import annotations

import hashlib
import re
import zlib
from collections.abc import Container, Iterable, Mapping
from functools import cache
from importlib import resources

import numpy as np

ORDERS = range(8)
QUICK, BEST = 1, 9
"""zlib's levels."""


def packed(raw: bytes) -> bytes:
    """Bytes, a multiple of 8 of them, packed."""
    planes = [_planes(np.frombuffer(raw, "<i8"), order) for order in ORDERS]
    return zlib.compress(min(planes, key=lambda one: len(zlib.compress(one, QUICK))), BEST)


def _planes(columns: np.ndarray, order: int) -> bytes:
    for _ in ORDERS[:order]:
        columns = np.diff(columns, prepend=np.int64(0))
    small = (columns << 1) ^ (columns >> 63)
    return bytes([order]) + small.view(np.uint8).reshape(-1, 8).T.tobytes()


MAIN, FIRST = "main.js", "first.js"
PAGE, REST = "page.js", "rest.js"

_IMPORT = re.compile(r'^import ?\{([^}]*)\} from "\./([\w.]+)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export ((?:async )?function|class|const) (\w+)", re.MULTILINE)


def with_first_script(scripts: dict[str, bytes], kernel: Container[str]) -> dict[str, bytes]:
    """The scripts, by name, with the two of many and the modules that they have as a line each.

    `kernel` are modules that stay files: another thread has them too.
    """
    texts = {name: content.decode() for name, content in scripts.items()}
    first = [name for name in _needed(texts, MAIN) if name != MAIN]
    rest = [name for name in _needed(texts, PAGE) if name not in first and name not in kernel]
    start = _IMPORT.sub(lambda m: f'import {{{m[1]}}} from "./{FIRST}";\n', texts[MAIN])
    made = {**texts, MAIN: start}
    home = dict.fromkeys(first, FIRST)
    for into, names in ((FIRST, first), (REST, rest)):
        home |= dict.fromkeys(names, into)
        outside: dict[str, None] = {}
        parts = []
        for name in names:
            body, exported = _as_function(texts[name], into, home, outside)
            given = ", ".join(exported)
            parts.append(f"const {_scope(name)} = (() => {{\n{body}return {{ {given} }};\n}})();\n")
            parts.append(f"export const {{ {given} }} = {_scope(name)};\n")
            made[name] = f'export {{ {given} }} from "./{into}";\n'
        heads = [f'import * as {_scope(name)} from "./{name}";\n' for name in outside]
        made[into] = "".join([*heads, *parts])
    return {name: text.encode() for name, text in made.items()}


def _needed(texts: dict[str, str], name: str) -> list[str]:
    """A script and what it imports, each after what it needs."""
    order: list[str] = []

    def visit(one: str) -> None:
        for _, needed in _IMPORT.findall(texts[one]):
            visit(needed)
        if one not in order:
            order.append(one)

    visit(name)
    return order


def _as_function(
    text: str, into: str, home: dict[str, str], outside: dict[str, None]
) -> tuple[str, list[str]]:
    """A module's body with its imports taken from scopes, and the names that it exports.

    `home` says which file has a module; those besides `into` are added to `outside`.
    """

    def taken(found: re.Match[str]) -> str:
        there = home.get(found[2], found[2])
        if there != into:
            outside[there] = None
        return f"const {{{found[1]}}} = {_scope(found[2] if there == into else there)};\n"

    body = _IMPORT.sub(taken, text)
    return _EXPORT.sub(r"\1 \2", body), [found[1] for found in _EXPORT.findall(body)]


def _scope(name: str) -> str:
    return "of_" + name.removesuffix(".js")


_COMMENTS = {
    # those on lines of their own, and those that end a line of code: none of these has " // "
    # and types beside an expression
    "js": re.compile(
        rb"^[ \t]*(?://[^\n]*|/\*\*(?:(?!\*/).)*\*/)\n|/\*\* @type [^*]*\*/ ?|[ \t]+// [^\n]*$",
        re.MULTILINE | re.DOTALL,
    ),
    "css": re.compile(rb"/\*.*?\*/", re.DOTALL),
    "html": re.compile(rb"<!--.*?-->", re.DOTALL),
}
_INDENTED = re.compile(rb"^[ \t]+|\n(?=\n)", re.MULTILINE)
# a line of code without texts or regular expressions; not + and -, of which two are another sign
_CODE = re.compile(rb"^[^\"'`/\n]+$", re.MULTILINE)
_SPACED = re.compile(rb" ?([=<>!&|?:,;{}()*]+) ?")
_NUMBER = re.compile(rb"^ *(\w+): ?\d+,\n", re.MULTILINE)
_RULES = re.compile(rb"\s*([{};,])\s*|(?<=:)\s+")


def shortened(name: str, content: bytes) -> bytes:
    """A file's content, to the same effect."""
    suffix = name.rpartition(".")[2]
    if suffix not in _COMMENTS:
        return content
    text = _INDENTED.sub(b"", _COMMENTS[suffix].sub(b"", content))
    if suffix == "js":
        return _CODE.sub(lambda line: _SPACED.sub(rb"\1", line[0]), text)
    return _RULES.sub(rb"\1", text) if suffix == "css" else text


def numbers_used(layout: bytes, *scripts: bytes) -> bytes:
    """`layout.js` with those numbers of the memory's layout alone that scripts name."""
    named = {name for script in scripts for name in re.findall(rb"\bL\.(\w+)", script)}
    table, end, rest = layout.partition(b"});")
    kept = _NUMBER.sub(lambda one: one[0] if one[1] in named else b"", table)
    return kept + end + rest


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


def page_with(own: Mapping[str, bytes], shared: Iterable[str]) -> dict[str, bytes]:
    """Return the files of another page and those that it shares of this one, by their path.

    Parameters
    ----------
    own : mapping of str to bytes
        The other page's files; those in a subfolder are not shortened.
    shared : iterable of str
        Files of this page that the other names, besides the scripts that its own import.
    """
    package = resources.files(__package__)
    files = dict(own)
    wanted = [*shared, *_imported(files)]
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
