"""Code blocks of Markdown pages, with what a comment before each says about it.

`<!-- needs: WHAT -->` before a block names what it needs besides this package;
`<!-- file: NAME -->` makes the block a file that later blocks of the page read.
"""

from __future__ import annotations

import re
import textwrap
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted(
    path.relative_to(ROOT)
    for path in (*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"))
    if not {"_build", "_generated", "gallery", "generated"} & set(path.parts)
)
_BLOCK = re.compile(
    r"(?:^[ ]*<!-- (?P<mark>\w+): (?P<value>[^\n]*?) -->\n)?"
    r"^(?P<indent>[ ]*)(?P<fence>`{3,})(?P<language>[^\n`]*)\n(?P<text>.*?)^(?P=indent)(?P=fence)$",
    re.M | re.S,
)
_ANY_MARK = re.compile(r"^[ ]*<!-- (?:needs|file)\b[^\n]*$", re.M)


@dataclass(frozen=True)
class Block:
    """A fenced block: its page, first line, language, text, and what it needs or is called."""

    page: Path
    line: int
    language: str
    text: str
    needs: str = ""
    file: str = ""

    @property
    def name(self) -> str:
        return f"{self.page.as_posix()}:{self.line}"


def blocks_of(page: Path, text: str) -> list[Block]:
    """The blocks of a page; ValueError for a mark that is not directly before a block."""
    found, used = [], 0
    for match in _BLOCK.finditer(text):
        mark, value = match["mark"] or "", match["value"] or ""
        if mark not in ("", "needs", "file"):
            raise ValueError(f"{page}: no mark is called {mark!r}")
        used += bool(mark)
        line = text.count("\n", 0, match.start("fence")) + 1
        body = textwrap.dedent(match["text"])
        found.append(
            Block(page, line, match["language"].strip(), body, **({mark: value} if mark else {}))
        )
    if used != len(_ANY_MARK.findall(text)):
        raise ValueError(f"{page}: a mark stands alone; put it on the line before its block")
    return found


def all_blocks() -> list[Block]:
    """Of every page, in order."""
    return [
        block
        for page in PAGES
        for block in blocks_of(page, (ROOT / page).read_text(encoding="utf-8"))
    ]
