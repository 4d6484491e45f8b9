"""Build the kernels' machine code: `overview_dsp/kernels/objects/`.

python tools/build_objects.py [FOLDER]

numba's LLVM IR of `c_abi/entry_points.py` is compiled for each of TARGETS by the
LLVM inside llvmlite, which also loads the objects (`kernels/precompiled.py`). `objects.json` holds
digests of the sources and the objects, and the tool-chain. The same sources and tool-chain give the
same bytes.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import itertools
import json
import sys
from pathlib import Path
from typing import Any

from kernel_ir import ROOT, c_functions, machine_for, module_for, unoptimised, written_out

OUT = ROOT / "overview_dsp" / "kernels" / "objects"
TARGETS = {
    "linux-x86-64-v2": ("x86_64-unknown-linux-gnu", "x86-64-v2"),
    "linux-x86-64-v3": ("x86_64-unknown-linux-gnu", "x86-64-v3"),
    "linux-x86-64-v4": ("x86_64-unknown-linux-gnu", "x86-64-v4"),
    "linux-aarch64": ("aarch64-unknown-linux-gnu", "generic"),
}
# functions of the C library: the clock, and those that LLVM uses for loops and math.sqrt
ALLOWED = {"clock_gettime", "memset", "memcpy", "memmove", "sqrt"}


def main(folder: Path) -> None:
    folder.mkdir(exist_ok=True)
    with unoptimised():
        from c_abi.entry_points import NAMES

        from overview_dsp.kernels.precompiled import CHOICES
        from overview_dsp.kernels.sources import sources_digest

        texts = written_out(c_functions(NAMES))
        digests = {}
        for name, _, kernels in itertools.chain(*CHOICES.values()):
            triple, cpu = TARGETS[name]
            machine = machine_for(triple, cpu=cpu, reloc="pic")
            some = {kernel: text for kernel, text in texts.items() if kernel in kernels}
            module = module_for(some, machine, vectors=True, runs=3)
            check(module, name)
            out = folder / f"{name}.o"
            content = machine.emit_object(module)
            out.write_bytes(content)
            digests[name] = hashlib.sha256(content).hexdigest()
            print(f"{out}: {len(content)} bytes")
        made_from = {"kernels": sources_digest(), "toolchain": toolchain(), "objects": digests}
    text = json.dumps(made_from, indent=1) + "\n"
    (folder / "objects.json").write_text(text, encoding="utf-8", newline="\n")


def toolchain() -> dict[str, str]:
    return {part: importlib.metadata.version(part) for part in ("numba", "llvmlite")}


def check(module: Any, name: str) -> None:
    """Exit if a module calls functions of numba, which are not available to the loader."""
    called = {
        function.name
        for function in module.functions
        if function.is_declaration and not function.name.startswith("llvm.")
    }
    if not called <= ALLOWED:
        sys.exit(f"{name} calls {', '.join(sorted(called - ALLOWED))}")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]))
    else:
        main(OUT)
