"""Machine code that comes with the package, made beforehand from these very sources.

Loading it takes milliseconds where compiling takes 10 to 40 s. It is used on the processors that it
was made for, and only while it is what the sources give (`objects/objects.json` has their digest);
otherwise, and where `OVERVIEW_JIT` is set, numba compiles them as before, with the same bits.

Thread: any (loading), as the kernel says (what is loaded).
"""

from __future__ import annotations

import ctypes
import json
import os
import platform
import sys
import threading
from collections.abc import Callable, Mapping
from functools import cache
from importlib import resources
from types import SimpleNamespace
from typing import Any

import cffi
import llvmlite.binding as llvm

from overview_dsp.kernels.compiling import runs_as_python, sources_digest

FORCED = "OVERVIEW_JIT"
"""The environment variable that has numba compile everything."""

X86_64_V2 = frozenset(("cx16", "popcnt", "sse3", "sse4.1", "sse4.2", "ssse3"))
X86_64_V3 = X86_64_V2 | {"avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"}
X86_64_V4 = X86_64_V3 | {"avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl"}

_DECLARED = {
    "process": "int32_t(*)(void *, void *, int64_t, int64_t, void *, int64_t)",
    "process_lanes": "int32_t(*)(void *, int64_t, void *, int64_t, void *, int64_t)",
    "reset": "int32_t(*)(void *)",
    "tactor_stage": "int32_t(*)(void *, void *, void *, int64_t)",
    "derive": "int32_t(*)(void *)",
    "derive_clicks": "int32_t(*)(void *, int64_t)",
    "derive_actuator": "int32_t(*)(void *, int64_t, double)",
    "drive_block": "int32_t(*)(void *, int64_t, void *, int64_t, int64_t, int64_t)",
    "finish_block": "int32_t(*)(void *, void *, int64_t, int64_t)",
    "push_control": "int32_t(*)(void *, int64_t, int64_t, double, int64_t)",
    "acquired": "int64_t(*)(void *, int64_t)",
    "publish": "int32_t(*)(void *, int64_t, int64_t)",
}
"""As `c_abi/entry_points.py` has them."""

_LOADING = threading.Lock()

KERNELS = frozenset((*_DECLARED, "callback"))
"""The kernels that there is machine code of."""

LANES = frozenset(("process_lanes",))
CHOICES: Mapping[tuple[str, str], tuple[tuple[str, frozenset[str], frozenset[str]], ...]] = {
    ("linux", "x86_64"): (
        # eight voices fill its registers; a single one is slower with its masks
        ("linux-x86-64-v4", X86_64_V4, LANES),
        ("linux-x86-64-v3", X86_64_V3, KERNELS),
        ("linux-x86-64-v2", X86_64_V2, KERNELS),
    ),
    ("linux", "aarch64"): (("linux-aarch64", frozenset(), KERNELS),),
}
"""By system and processor: objects, the best first, the features each needs, the kernels in it."""


def manifest() -> dict[str, Any]:
    """What the objects are made from: `kernels` (the sources' digest) and `toolchain`."""
    text = (_folder() / "objects.json").read_text(encoding="utf-8")
    found: dict[str, Any] = json.loads(text)
    return found


def is_outdated() -> bool:
    """Whether the sources have changed since the machine code was made of them."""
    return bool(manifest()["kernels"] != sources_digest())


@cache
def usable(kernel: str = "process") -> str | None:
    """The object with a kernel for this processor, by its name, or None: then numba compiles."""
    if runs_as_python() or os.environ.get(FORCED) or is_outdated():
        return None
    choices = CHOICES.get((sys.platform, platform.machine()), ())
    features = llvm.get_host_cpu_features() if choices else {}
    for name, needed, kernels in choices:
        if kernel in kernels and all(features.get(feature) for feature in needed):
            return name
    return None


def precompiled_function(kernel: str) -> Callable[..., Any] | None:
    """A kernel, to be called as numba's is, from the machine code that came with the package."""
    name = usable(kernel) if kernel in _DECLARED else None
    if name is None:
        return None
    ffi = cffi.FFI()
    call = ffi.cast(_DECLARED[kernel], _address(name, kernel))
    return _ADAPTERS[kernel](call, ffi.from_buffer)


def precompiled_callback() -> Any:
    """The native callback as numba's is (`.address`, `.ctypes`), or None."""
    name = usable("callback")
    if name is None:
        return None
    at = _address(name, "callback")
    pointer, count = ctypes.c_void_p, ctypes.c_ulong
    kind = ctypes.CFUNCTYPE(ctypes.c_int, pointer, pointer, count, pointer, count, pointer)
    return SimpleNamespace(address=at, ctypes=kind(at))


def _address(name: str, kernel: str) -> int:
    # two threads that load at once would each have an engine, and a cache keeps but one of them
    with _LOADING:
        return int(_loaded(name).get_function_address(kernel))


@cache
def _loaded(name: str) -> Any:
    """The engine that holds an object's machine code, for as long as the process lives."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    content = (_folder() / f"{name}.o").read_bytes()
    engine.add_object_file(llvm.ObjectFileRef.from_data(content))
    engine.finalize_object()
    return engine


def _folder() -> Any:
    return resources.files("overview_dsp.kernels") / "objects"


# a kernel's arrays of one memory are views of the first
_ADAPTERS: dict[str, Callable[[Any, Any], Callable[..., Any]]] = {
    "process": lambda call, at: (
        lambda f64, i64, u64, out, frames, channels, trace, traced: call(
            at(f64), at(out), frames, channels, at(trace), traced
        )
    ),
    "process_lanes": lambda call, at: (
        lambda f64, i64, u64, count, out, frames, trace, traced: call(
            at(f64), count, at(out), frames, at(trace), traced
        )
    ),
    "reset": lambda call, at: lambda f64, i64, u64: call(at(f64)),
    "tactor_stage": lambda call, at: (
        lambda f64, torque, out: call(at(f64), at(torque), at(out), len(torque))
    ),
    "derive": lambda call, at: lambda f64, i64: call(at(f64)),
    "derive_clicks": lambda call, at: lambda f64, i64, slot: call(at(f64), slot),
    "derive_actuator": lambda call, at: lambda f64, start, rate: call(at(f64), start, rate),
    "drive_block": lambda call, at: (
        lambda f64, i64, start, out, frames, channels, channel: call(
            at(f64), start, at(out), frames, channels, channel
        )
    ),
    "finish_block": lambda call, at: (
        lambda f64, i64, out, frames, channels: call(at(f64), at(out), frames, channels) != 0
    ),
    "push_control": lambda call, at: (
        lambda f64, i64, source, stamp, theta2, touching: (
            call(at(f64), source, stamp, theta2, touching) != 0
        )
    ),
    "acquired": lambda call, at: lambda i64, column: call(at(i64), column),
    "publish": lambda call, at: lambda i64, column, value: call(at(i64), column, value),
}
