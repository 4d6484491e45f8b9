"""Write the numbers of kernels/layout.py for other languages: the pages' and the C peer's.

python tools/write_layout.py [FOLDER]

`layout.js` goes to overview_dsp/web/, with the numbers of export/browser_memory.py, and `layout.h`
to tools/peers/; or both to FOLDER.
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
JS = "// Made by tools/write_layout.py from kernels/layout.py and export/browser_memory.py.\n\n"
C = """/* Made by tools/write_layout.py from kernels/layout.py. */
#ifndef LAYOUT_H
#define LAYOUT_H
"""


def main(folder: Path | None) -> None:
    sys.path.insert(0, str(ROOT))
    for path, text in (
        (ROOT / "overview_dsp" / "web" / "layout.js", javascript()),
        (ROOT / "tools" / "peers" / "layout.h", c_header()),
    ):
        out = path if folder is None else folder / path.name
        out.write_text(text, encoding="utf-8", newline="\n")


def javascript() -> str:
    from overview_dsp.export.browser_memory import encoding_numbers, layout_digest, layout_numbers
    from overview_dsp.gestures import SOURCES

    low, high = (
        int.from_bytes(layout_digest()[at : at + 4], "little", signed=True) for at in (0, 4)
    )
    names = ", ".join(f'"{name}"' for name in SOURCES)
    text = JS + table("L", layout_numbers()) + "// encoding.py\n"
    text += table("ENCODING", encoding_numbers())
    text += f"export const SOURCES = Object.freeze([{names}]);\n\n"
    text += "// of a memory that this layout fits, its low and its high half\n"
    text += f"export const DIGEST = Object.freeze([{low}, {high}]);\n"
    return text


def table(name: str, numbers: dict[str, int]) -> str:
    lines = "".join(f"  {key}: {value},\n" for key, value in numbers.items())
    return f"export const {name} = Object.freeze({{\n{lines}}});\n\n"


def c_header() -> str:
    from overview_dsp.export.browser_memory import layout_numbers

    lines = "".join(f"    {key} = {value},\n" for key, value in layout_numbers().items())
    return f"{C}enum {{\n{lines}}};\n#endif\n"


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
