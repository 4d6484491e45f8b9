"""Write the numbers of kernels/layout.py and export/browser_memory.py, and the parameters.

python tools/write_layout.py [LAYOUT.js]
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
JS = "// Made by tools/write_layout.py from kernels/layout.py and export/browser_memory.py.\n\n"
OUT = ROOT / "overview_dsp" / "web" / "layout.js"


def main(out: Path) -> None:
    sys.path.insert(0, str(ROOT))
    out.write_text(javascript(), encoding="utf-8", newline="\n")


def javascript() -> str:
    from overview_dsp.design.gestures import SOURCES
    from overview_dsp.offline.export.browser_memory import (
        encoding_numbers,
        layout_digest,
        layout_numbers,
    )
    from overview_dsp.signal.engine.coefficients import KERNEL_RANGES

    low, high = (
        int.from_bytes(layout_digest()[at : at + 4], "little", signed=True) for at in (0, 4)
    )
    names = ", ".join(f'"{name}"' for name in SOURCES)
    text = JS + table("L", layout_numbers()) + "// encoding.py\n"
    text += table("ENCODING", encoding_numbers())
    text += f"export const SOURCES = Object.freeze([{names}]);\n\n"
    text += "// what may be set while it plays: number, lowest and highest value\n"
    rows = {id: [number, *of] for number, (id, of) in enumerate(KERNEL_RANGES.items())}
    lines = "".join(f'  "{id}": [{", ".join(map(str, row))}],\n' for id, row in rows.items())
    text += f"export const PARAMETERS = Object.freeze({{\n{lines}}});\n\n"
    text += "// low and high half of the digest of an engine's memory with this layout\n"
    text += f"export const DIGEST = Object.freeze([{low}, {high}]);\n"
    return text


def table(name: str, numbers: dict[str, int]) -> str:
    lines = "".join(f"  {key}: {value},\n" for key, value in numbers.items())
    return f"export const {name} = Object.freeze({{\n{lines}}});\n\n"


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else OUT)
