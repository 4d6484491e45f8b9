"""Precompiled machine code of the kernels, shipped with the package.

Loading takes milliseconds, compiling 10 to 40 s. The machine code is used on supported processors
if it belongs to the present sources and is complete (`objects/objects.json` has digests of both).
Otherwise, and if `OVERVIEW_JIT` is set, numba compiles the kernels, with the same bits.

Thread: any for loading; the loaded functions have the threads of their kernels.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import os
import platform
import sys
import threading
import warnings
from collections.abc import Callable, Mapping
from functools import cache
from importlib import resources
from types import SimpleNamespace
from typing import Any

import cffi
import llvmlite.binding as llvm

from overview_dsp.errors import OverviewWarning
from overview_dsp.kernels.sources import runs_as_python, sources_digest

FORCED = "OVERVIEW_JIT"
"""Environment variable that forces compilation by numba."""

X86_64_V2 = frozenset(("cx16", "popcnt", "sse3", "sse4.1", "sse4.2", "ssse3"))
X86_64_V3 = X86_64_V2 | {"avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"}
X86_64_V4 = X86_64_V3 | {"avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl"}

Adapter = Callable[[Any, Any], Callable[..., Any]]
# a kernel's arrays of one memory are views of the first
_FUNCTIONS: dict[str, tuple[str, Adapter]] = {
    "process": (
        "int32_t(*)(void *, void *, int64_t, int64_t, void *, int64_t)",
        lambda call, at: (
            lambda f64, i64, u64, out, frames, channels, trace, traced: call(
                at(f64), at(out), frames, channels, at(trace), traced
            )
        ),
    ),
    "process_lanes": (
        "int32_t(*)(void *, int64_t, void *, int64_t, void *, int64_t)",
        lambda call, at: (
            lambda f64, i64, u64, count, out, frames, trace, traced: call(
                at(f64), count, at(out), frames, at(trace), traced
            )
        ),
    ),
    "reset": (
        "int32_t(*)(void *)",
        lambda call, at: lambda f64, i64, u64: call(at(f64)),
    ),
    "tactor_stage": (
        "int32_t(*)(void *, void *, void *, int64_t)",
        lambda call, at: lambda f64, torque, out: call(at(f64), at(torque), at(out), len(torque)),
    ),
    "derive": (
        "int32_t(*)(void *)",
        lambda call, at: lambda f64, i64: call(at(f64)),
    ),
    "derive_clicks": (
        "int32_t(*)(void *, int64_t)",
        lambda call, at: lambda f64, i64, slot: call(at(f64), slot),
    ),
    "derive_actuator": (
        "int32_t(*)(void *, int64_t, double)",
        lambda call, at: lambda f64, start, rate: call(at(f64), start, rate),
    ),
    "drive_block": (
        "int32_t(*)(void *, int64_t, void *, int64_t, int64_t, int64_t)",
        lambda call, at: (
            lambda f64, i64, start, out, frames, channels, channel: call(
                at(f64), start, at(out), frames, channels, channel
            )
        ),
    ),
    "finish_block": (
        "int32_t(*)(void *, void *, int64_t, int64_t)",
        lambda call, at: (
            lambda f64, i64, out, frames, channels: call(at(f64), at(out), frames, channels) != 0
        ),
    ),
    "split_block": (
        "int32_t(*)(void *, void *, void *, int64_t, int64_t, void *)",
        lambda call, at: (
            lambda i64, r, ri, out, frames, channels, trace: call(
                at(i64), at(r), at(out), frames, channels, at(trace)
            )
        ),
    ),
    "push_control": (
        "int32_t(*)(void *, int64_t, int64_t, double, int64_t)",
        lambda call, at: (
            lambda f64, i64, source, stamp, theta2, touching: (
                call(at(f64), source, stamp, theta2, touching) != 0
            )
        ),
    ),
    "acquired": (
        "int64_t(*)(void *, int64_t)",
        lambda call, at: lambda i64, column: call(at(i64), column),
    ),
    "publish": (
        "int32_t(*)(void *, int64_t, int64_t)",
        lambda call, at: lambda i64, column, value: call(at(i64), column, value),
    ),
}
"""C declaration and adapter of each function in `tools/c_abi/entry_points.py`."""

_LOADING = threading.Lock()

KERNELS = frozenset((*_FUNCTIONS, "callback"))
"""Kernels with precompiled machine code."""

LANES = frozenset(("process_lanes",))
CHOICES: Mapping[tuple[str, str], tuple[tuple[str, frozenset[str], frozenset[str]], ...]] = {
    ("linux", "x86_64"): (
        # for eight voices only; a single voice is slower with its masks
        ("linux-x86-64-v4", X86_64_V4, LANES),
        ("linux-x86-64-v3", X86_64_V3, KERNELS),
        ("linux-x86-64-v2", X86_64_V2, KERNELS),
    ),
    ("linux", "aarch64"): (("linux-aarch64", frozenset(), KERNELS),),
}
"""By system and processor: objects from best to worst, required features, and kernels."""


@cache
def manifest() -> dict[str, Any]:
    """Return the origin of the objects: `kernels` (digest of the sources), `toolchain`, `objects`.

    It is empty, with a warning, if the file is damaged.
    """
    try:
        origin: dict[str, Any] = json.loads((_folder() / "objects.json").read_bytes())
        if not isinstance(origin["objects"], dict):
            raise TypeError
    except (OSError, ValueError, KeyError, TypeError):
        _note_damaged("objects.json")
        return {}
    return origin


def is_outdated() -> bool:
    """Return whether the sources have changed since the objects were compiled."""
    return bool(manifest().get("kernels") != sources_digest())


@cache
def _content(name: str) -> bytes | None:
    """Return an object's bytes, or None with a warning if they are not those that were compiled."""
    try:
        content: bytes = (_folder() / f"{name}.o").read_bytes()
    except OSError:
        content = b""
    if hashlib.sha256(content).hexdigest() == manifest()["objects"].get(name):
        return content
    _note_damaged(f"{name}.o")
    return None


def _note_damaged(name: str) -> None:
    warnings.warn(
        f"{_folder() / name}: damaged, so its machine code is not used and kernels may have to be "
        "compiled; reinstall overview-dsp",
        OverviewWarning,
        stacklevel=2,
    )


@cache
def usable(kernel: str = "process") -> str | None:
    """Return the name of the object with a kernel for this processor, or None."""
    if runs_as_python() or os.environ.get(FORCED) or is_outdated():
        return None
    choices = CHOICES.get((sys.platform, platform.machine()), ())
    features = llvm.get_host_cpu_features() if choices else {}
    for name, needed, kernels in choices:
        fits = kernel in kernels and all(features.get(feature) for feature in needed)
        if fits and _content(name) is not None:
            return name
    return None


def precompiled_function(kernel: str) -> Callable[..., Any] | None:
    """Return a precompiled kernel with the signature of numba's, or None."""
    name = usable(kernel) if kernel in _FUNCTIONS else None
    if name is None:
        return None
    ffi = cffi.FFI()
    declaration, adapter = _FUNCTIONS[kernel]
    return adapter(ffi.cast(declaration, _address(name, kernel)), ffi.from_buffer)


def precompiled_callback() -> Any:
    """Return the precompiled callback with numba's interface (`.address`, `.ctypes`), or None."""
    name = usable("callback")
    if name is None:
        return None
    at = _address(name, "callback")
    pointer, count = ctypes.c_void_p, ctypes.c_ulong
    kind = ctypes.CFUNCTYPE(ctypes.c_int, pointer, pointer, count, pointer, count, pointer)
    return SimpleNamespace(address=at, ctypes=kind(at))


def _address(name: str, kernel: str) -> int:
    # without the lock, two threads could each load an engine, of which the cache holds only one
    with _LOADING:
        return int(_loaded(name).get_function_address(kernel))


@cache
def _loaded(name: str) -> Any:
    """Load an object for the lifetime of the process."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(_content(name)))
    engine.finalize_object()
    return engine


def _folder() -> Any:
    return resources.files("overview_dsp.kernels") / "objects"
