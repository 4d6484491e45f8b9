"""Build the browser's kernel: `overview_dsp/web/kernel.wasm`, from the Python kernels.

python tools/build_wasm.py [OUT.wasm]

Needs `pip install ziglang` (for wasm-ld). numba's LLVM IR of `c_abi/browser.py`
is compiled for wasm32 by the LLVM inside llvmlite. The module exports its functions, its memory and
`__heap_base`, from where on the memory is free, and imports nothing. Its section `sources` is the
kernels' digest. The same tool-chain (in its section `toolchain`) gives the same bytes.
"""

from __future__ import annotations

import importlib.metadata
import json
import subprocess
import sys
from pathlib import Path

from kernel_ir import ROOT, c_functions, machine_for, module_for, unoptimised, written_out

KERNEL = ROOT / "overview_dsp" / "web" / "kernel.wasm"
TRIPLE = "wasm32-unknown-unknown"
STACK_BYTES = 16384
PARTS = ("numba", "llvmlite", "ziglang")


def main(out: Path) -> None:
    with unoptimised() as folder:
        from c_abi.browser import NAMES

        from overview_dsp.kernels.sources import sources_digest

        machine = machine_for(TRIPLE, reloc="static", codemodel="default")
        module = module_for(written_out(c_functions(NAMES)), machine)
        object_file = folder / "kernel.o"
        object_file.write_bytes(machine.emit_object(module))
        linked = folder / "kernel.wasm"
        link(object_file, linked, list(NAMES))
        built = linked.read_bytes()
    built += custom_section("sources", sources_digest().encode())
    built += custom_section("toolchain", json.dumps(toolchain()).encode())
    check(built)
    out.write_bytes(built)
    print(f"{out}: {len(built)} bytes, {toolchain()}")


def toolchain() -> dict[str, str]:
    return {part: importlib.metadata.version(part) for part in PARTS}


def link(source: Path, target: Path, functions: list[str]) -> None:
    command = [
        sys.executable, "-m", "ziglang", "wasm-ld", "--no-entry",
        *(f"--export={name}" for name in [*functions, "__heap_base"]), "--strip-all",
        "-z", f"stack-size={STACK_BYTES}", str(source), "-o", str(target),
    ]  # fmt: skip
    subprocess.run(command, check=True)


def custom_section(name: str, content: bytes) -> bytes:
    """Return a custom section of a WebAssembly module, which readers ignore."""
    body = leb(len(name)) + name.encode() + content
    return b"\0" + leb(len(body)) + body


def leb(number: int) -> bytes:
    """Encode an unsigned integer as LEB128: 7 bits per byte, lowest first."""
    out = bytearray()
    while number > 127:
        out.append(number & 127 | 128)
        number >>= 7
    return bytes([*out, number])


def check(module: bytes) -> None:
    """Exit if the module imports functions, such as those of libm."""
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
