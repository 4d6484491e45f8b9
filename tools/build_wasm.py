"""Build the browser's kernel: `overview_dsp/web/kernel.wasm`, from the Python kernels.

python tools/build_wasm.py [OUT.wasm]

Needs `pip install ziglang` (for wasm-ld). numba's LLVM IR of
`overview_dsp.kernels.device.browser.render` is compiled for wasm32 by the LLVM inside llvmlite. The
module exports `render`, its memory and `__heap_base`, from where on the memory is free, and imports
nothing. The same tool-chain (named in the file's own section `toolchain`) gives the same bytes.
"""

from __future__ import annotations

import importlib.metadata
import json
import os
import re
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
KERNEL = ROOT / "overview_dsp" / "web" / "kernel.wasm"
TRIPLE = "wasm32-unknown-unknown"
STACK_BYTES = 16384
PARTS = ("numba", "llvmlite", "ziglang")
SECTION = "toolchain"


def main(out: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        # before numba is imported: host-optimised code would get into the IR, from the cache too
        os.environ.update(NUMBA_OPT="0", NUMBA_CACHE_DIR=folder, NUMBA_DISABLE_JIT="0")
        # unoptimised code isn't worth keeping
        warnings.filterwarnings("ignore", message="Cannot cache compiled function")
        sys.path.insert(0, str(ROOT))
        object_file = Path(folder) / "kernel.o"
        object_file.write_bytes(compiled())
        linked = Path(folder) / "kernel.wasm"
        link(object_file, linked)
        module = linked.read_bytes() + custom_section(SECTION, json.dumps(toolchain()).encode())
    check(module)
    out.write_bytes(module)
    print(f"{out}: {len(module)} bytes, {toolchain()}")


def toolchain() -> dict[str, str]:
    return {part: importlib.metadata.version(part) for part in PARTS}


def compiled() -> bytes:
    """The kernel as a WebAssembly object file."""
    from overview_dsp.kernels.device.browser import SIGNATURE, render

    module, machine = cross_compiled(render, SIGNATURE, "render", TRIPLE)
    return machine.emit_object(module)


def cross_compiled(
    function: Any, signature: Any, name: str, triple: str, speed_level: int = 3
) -> tuple[Any, Any]:
    """A C function, called `name`, for another machine: llvmlite's module and target machine.

    NUMBA_OPT must be 0, from before numba is imported.
    """
    import llvmlite.binding as llvm
    import numba

    from overview_dsp.kernels.compiling import OPTIONS

    options = {key: value for key, value in OPTIONS.items() if key != "nogil"}
    function = numba.cfunc(signature, **options)(function)
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple(triple).create_target_machine(
        opt=3, reloc="static", codemodel="default"
    )
    ir = function.inspect_llvm()
    ir = re.sub(r'target triple = "[^"]*"', f'target triple = "{triple}"', ir)
    ir = re.sub(r'target datalayout = "[^"]*"', f'target datalayout = "{machine.target_data}"', ir)
    ir = ir.replace(f"@{function.native_name}(", f"@{name}(")
    module = llvm.parse_assembly(ir)
    module.verify()
    for value in (*module.functions, *module.global_variables):
        if not value.is_declaration and value.name != name:
            value.linkage = "internal"
    tuning = llvm.create_pipeline_tuning_options(speed_level)
    tuning.loop_vectorization = tuning.slp_vectorization = False
    # what reference counting leaves behind goes only in the second run
    for _ in range(2):
        passes = llvm.create_pass_builder(machine, tuning)
        passes.getModulePassManager().run(module, passes)
    return module, machine


def link(source: Path, target: Path) -> None:
    command = [
        sys.executable, "-m", "ziglang", "wasm-ld", "--no-entry", "--export=render",
        "--export=__heap_base", "--strip-all", "-z", f"stack-size={STACK_BYTES}",
        str(source), "-o", str(target),
    ]  # fmt: skip
    subprocess.run(command, check=True)


def custom_section(name: str, content: bytes) -> bytes:
    """Bytes that a WebAssembly module may carry and every reader passes over."""
    body = leb(len(name)) + name.encode() + content
    return b"\0" + leb(len(body)) + body


def leb(number: int) -> bytes:
    """An unsigned integer as WebAssembly writes it: 7 bits a byte, lowest first."""
    out = bytearray()
    while number > 127:
        out.append(number & 127 | 128)
        number >>= 7
    return bytes([*out, number])


def check(module: bytes) -> None:
    """Nothing may be imported: no libm, no Python."""
    at = 8
    while at < len(module):
        section, at = module[at], at + 1
        size, shift = 0, 0
        while True:
            byte, at = module[at], at + 1
            size |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                break
        if section == 2:
            sys.exit(f"the kernel imports something: {module[at : at + size]!r}")
        at += size


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else KERNEL)
