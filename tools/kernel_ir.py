"""LLVM module of the kernels' C functions, the input of the build tools."""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).resolve().parents[1]


@contextmanager
def unoptimised() -> Iterator[Path]:
    """Provide an empty folder for a build, with numba's optimisation switched off.

    Before numba is imported: host-optimised code would get into the IR, from its cache too.
    """
    if "numba" in sys.modules:
        raise RuntimeError("numba is imported already")
    with TemporaryDirectory() as folder:
        os.environ.update(NUMBA_OPT="0", NUMBA_CACHE_DIR=folder, NUMBA_DISABLE_JIT="0")
        # unoptimised code isn't worth keeping
        warnings.filterwarnings("ignore", message="Cannot cache compiled function")
        sys.path.insert(0, str(ROOT))
        yield Path(folder)


def c_functions(functions: Mapping[str, tuple[Any, Any]]) -> dict[str, Any]:
    """Return each function (Python function and signature) as numba's C function."""
    import numba

    from overview_dsp.kernels.compiling import OPTIONS

    options = {key: value for key, value in OPTIONS.items() if key != "nogil"}
    return {
        name: numba.cfunc(signature, **options)(function)
        for name, (function, signature) in functions.items()
    }


def written_out(functions: Mapping[str, Any]) -> dict[str, str]:
    """Return the IR of each C function by its new name."""
    return {
        name: made.inspect_llvm().replace(f"@{made.native_name}(", f"@{name}(")
        for name, made in functions.items()
    }


def module_for(
    texts: Mapping[str, str],
    machine: Any,
    vectors: bool = False,
    speed_level: int = 3,
    runs: int = 2,
) -> Any:
    """Return an llvmlite module of the functions, optimised for a target machine.

    What reference counting leaves behind goes only in the second of `runs`, of lanes in the third.
    """
    import llvmlite.binding as llvm

    module = None
    for text in texts.values():
        text = re.sub(r'target triple = "[^"]*"', f'target triple = "{machine.triple}"', text)
        text = re.sub(
            r'target datalayout = "[^"]*"', f'target datalayout = "{machine.target_data}"', text
        )
        parsed = llvm.parse_assembly(text)
        if module is None:
            module = parsed
        else:
            module.link_in(parsed)
    assert module is not None
    module.verify()
    for value in (*module.functions, *module.global_variables):
        if not value.is_declaration and value.name not in texts:
            value.linkage = "internal"
    tuning = llvm.create_pipeline_tuning_options(speed_level)
    tuning.loop_vectorization = vectors
    # it would pack the numbers that a sample hands to the next, which then waits for the unpacking
    tuning.slp_vectorization = False
    for _ in range(runs):
        passes = llvm.create_pass_builder(machine, tuning)
        passes.getModulePassManager().run(module, passes)
    return module


def machine_for(triple: str, **options: Any) -> Any:
    """Return llvmlite's target machine."""
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    return llvm.Target.from_triple(triple).create_target_machine(opt=3, **options)
