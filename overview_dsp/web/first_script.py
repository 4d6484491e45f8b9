"""The scripts as two files: a phone waits for each request, not for the bytes.

What `main.js` imports, and what that imports, goes into `first.js`: the first picture. What
`page.js` and its imports have besides, but for the kernel's own modules, goes into `rest.js`. Each
module is in a function of its own; the modules' own files then only hand on what the two have:
nothing is there twice. Scripts that are imported later stay as they are. It knows the few forms of
import and export that the page's scripts have.
"""

from __future__ import annotations

import re
from collections.abc import Container

START, FIRST = "main.js", "first.js"
PAGE, REST = "page.js", "rest.js"

_IMPORT = re.compile(r'^import ?\{([^}]*)\} from "\./([\w.]+)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export ((?:async )?function|class|const) (\w+)", re.MULTILINE)


def with_first_script(scripts: dict[str, bytes], kernel: Container[str]) -> dict[str, bytes]:
    """The scripts, by name, with the two of many and the modules that they have as a line each.

    `kernel` are modules that stay files: another thread has them too.
    """
    texts = {name: content.decode() for name, content in scripts.items()}
    first = [name for name in _needed(texts, START) if name != START]
    rest = [name for name in _needed(texts, PAGE) if name not in first and name not in kernel]
    start = _IMPORT.sub(lambda m: f'import {{{m[1]}}} from "./{FIRST}";\n', texts[START])
    made = {**texts, START: start}
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
