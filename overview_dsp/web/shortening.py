"""The page's own text files without what only their readers need: a phone waits for each byte."""

from __future__ import annotations

import re

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
