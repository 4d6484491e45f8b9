"""Write `overview_dsp/web/layout.js`: the kernel's memory layout for the page.

python tools/write_layout_js.py [OUT.js]
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LAYOUT = ROOT / "overview_dsp" / "web" / "layout.js"
HEAD = """// Made by tools/write_layout_js.py from overview_dsp/kernels/layout.py.

"""


def main(out: Path) -> None:
    sys.path.insert(0, str(ROOT))
    from overview_dsp.gestures import SOURCES
    from overview_dsp.web.encoding import layout_digest, layout_numbers

    low, high = (
        int.from_bytes(layout_digest()[at : at + 4], "little", signed=True) for at in (0, 4)
    )
    lines = [f"  {name}: {value}," for name, value in layout_numbers().items()]
    names = ", ".join(f'"{name}"' for name in SOURCES)
    text = HEAD + "export const L = Object.freeze({\n" + "\n".join(lines) + "\n});\n\n"
    text += f"export const SOURCES = Object.freeze([{names}]);\n\n"
    text += "// of a memory that this layout fits, its low and its high half\n"
    text += f"export const DIGEST = Object.freeze([{low}, {high}]);\n"
    out.write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else LAYOUT)
