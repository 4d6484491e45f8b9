"""The scripts of the first picture as one file: a phone waits for each request, not for the bytes.

What `main.js` imports, and what that imports, goes into `first.js`, each module in a function of
its own; the modules' own files then only hand on what `first.js` has: nothing is there twice.
Scripts that are imported later stay as they are. It knows the few forms of import and export that
the page's scripts have.
"""

from __future__ import annotations

import re

START, FIRST = "main.js", "first.js"

_IMPORT = re.compile(r'^import \{([^}]*)\} from "\./([\w.]+)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export ((?:async )?function|class|const) (\w+)", re.MULTILINE)


def with_first_script(scripts: dict[str, bytes]) -> dict[str, bytes]:
    """The scripts, by name, with `first.js` and the modules that it has as a line each."""
    texts = {name: content.decode() for name, content in scripts.items()}
    order: list[str] = []

    def visit(name: str) -> None:
        for _, needed in _IMPORT.findall(texts[name]):
            visit(needed)
        if name not in order:
            order.append(name)

    visit(START)
    order.remove(START)
    parts, handed_on = [], {}
    for name in order:
        body = _IMPORT.sub(lambda m: f"const {{{m[1]}}} = {_scope(m[2])};\n", texts[name])
        names = [found[1] for found in _EXPORT.findall(body)]
        body = _EXPORT.sub(r"\1 \2", body)
        given = ", ".join(names)
        parts.append(f"const {_scope(name)} = (() => {{\n{body}return {{ {given} }};\n}})();\n")
        parts.append(f"export const {{ {given} }} = {_scope(name)};\n")
        handed_on[name] = f'export {{ {given} }} from "./{FIRST}";\n'
    start = _IMPORT.sub(lambda m: f'import {{{m[1]}}} from "./{FIRST}";\n', texts[START])
    made = {**texts, **handed_on, START: start, FIRST: "".join(parts)}
    return {name: text.encode() for name, text in made.items()}


def _scope(name: str) -> str:
    return "of_" + name.removesuffix(".js")
