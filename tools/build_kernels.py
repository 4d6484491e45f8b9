"""Build all precompiled forms of the kernels: WebAssembly, C, and machine code.

python tools/build_kernels.py
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
TOOLS = ("build_wasm.py", "build_c.py", "build_objects.py", "write_layout.py", "bundle_page.py")


def main() -> None:
    # each in a process of its own: with numba's settings as it needs them
    for tool in TOOLS:
        subprocess.run([sys.executable, str(HERE / tool)], check=True)


if __name__ == "__main__":
    main()
