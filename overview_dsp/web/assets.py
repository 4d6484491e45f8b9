"""The files of the page: a fixed table, nothing else of this machine's disk can be asked for."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib import resources

HTML = "text/html; charset=utf-8"
SCRIPT = "text/javascript; charset=utf-8"
STYLE = "text/css; charset=utf-8"
PICTURE = "image/svg+xml"
WASM = "application/wasm"

# path: (file in this package, type)
ASSETS = {
    "/": ("page/index.html", HTML),
    "/page/style.css": ("page/style.css", STYLE),
    "/page/icon.svg": ("page/icon.svg", PICTURE),
    "/page/main.js": ("page/main.js", SCRIPT),
    "/page/session.js": ("page/session.js", SCRIPT),
    "/page/link.js": ("page/link.js", SCRIPT),
    "/page/hand.js": ("page/hand.js", SCRIPT),
    "/page/view.js": ("page/view.js", SCRIPT),
    "/kernel.js": ("kernel.js", SCRIPT),
    "/kernel_node.js": ("kernel_node.js", SCRIPT),
    "/layout.js": ("layout.js", SCRIPT),
    "/processor.js": ("processor.js", SCRIPT),
    "/kernel.wasm": ("kernel.wasm", WASM),
}


@cache
def asset(path: str) -> tuple[bytes, str, str]:
    """Bytes, type and ETag of a path of `ASSETS`."""
    name, kind = ASSETS[path]
    content = resources.files(__package__).joinpath(name).read_bytes()
    return content, kind, f'"{hashlib.sha256(content).hexdigest()[:16]}"'
