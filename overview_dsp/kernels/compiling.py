"""Compilation of kernels with one set of options."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from functools import update_wrapper
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import platformdirs
from numba.extending import typeof_impl

from overview_dsp.errors import require_internals
from overview_dsp.kernels import precompiled
from overview_dsp.kernels.sources import CONFIG, runs_as_python, sources_digest

NUMBA = "numba>=0.61,<0.69"
"""Supported versions, as in pyproject.toml. Internals of numba may change with any version, so a
new version is allowed after the tests have passed with it."""

require_internals(
    numba,
    (
        "config.CACHE_DIR",
        "config.DISABLE_JIT",
        "carray",
        "types.ExternalFunction",
        "extending.typeof_impl",
    ),
    NUMBA,
)
Function = TypeVar("Function", bound=Callable[..., Any])

# numba checks for negative indices with three instructions unless the compiler knows the sign:
# `array[i & NOT_NEGATIVE]` avoids them
NOT_NEGATIVE = 0x7FFFFFFFFFFFFFFF

OPTIONS: dict[str, Any] = {
    # the Python error model would raise and take the GIL on a division by zero
    "error_model": "numpy",
    "boundscheck": False,
    # reordered or fused arithmetic would differ between runners
    "fastmath": False,
    "nogil": True,
}


# C functions do not hold the GIL
_GIL_HELD = {key: value for key, value in OPTIONS.items() if key != "nogil"}


def cache_folder() -> Path:
    """Return the folder of compiled kernels: `NUMBA_CACHE_DIR` or the user's cache folder.

    Its name depends on all sources, since numba's cache watches only a function's own file.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    root = Path(chosen) if chosen else Path(platformdirs.user_cache_dir("overview-dsp"))
    return root / f"kernels-{sources_digest()}-{numba.__version__}"


def is_compiled(function: str = "process") -> bool:
    """Return whether using a kernel needs no compilation."""
    if runs_as_python() or precompiled.usable(function):
        return True
    folder = cache_folder()
    return folder.is_dir() and any(folder.rglob(f"*.{function}-*.nbc"))


def inlined(function: Function) -> Function:
    """Compile a function to be inlined in other kernels.

    Python can only call its plain form, `function.py_func`.
    """
    inlined: dict[str, Any] = {
        "forceinline": True,
        "no_cpython_wrapper": True,
        "no_cfunc_wrapper": True,
    }
    compiled: Function = numba.njit(**OPTIONS, **inlined)(function)
    return compiled


def outlined(function: Function) -> Function:
    """Compile a function to be called by other kernels without inlining: large or rarely used."""
    wrapped: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    compiled: Function = numba.njit(**OPTIONS, **wrapped)(function)
    return compiled


class EntryPoint:
    """Kernel that Python can call: precompiled machine code, or numba's.

    `py_func` is its plain Python form, `compiled` is numba's dispatcher.
    """

    def __init__(self, function: Callable[..., Any], compiled: Any) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self.compiled = compiled
        self._call: Callable[..., Any] | None = None

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel; the first call selects the machine code."""
        if self._call is None:
            self._call = precompiled.precompiled_function(self.py_func.__name__) or self.compiled
        return self._call(*arguments)


@typeof_impl.register(EntryPoint)
def _type_of_entry_point(entry: EntryPoint, context: Any) -> Any:
    return numba.typeof(entry.compiled)


def entry_point(function: Function) -> Function:
    """Compile a function that Python calls, with a cache on disk."""
    compiled = _compiled_on_disk(function, lambda cache: numba.njit(cache=cache, **OPTIONS))
    return cast(Function, EntryPoint(function, compiled))


def briefly_called(function: Function) -> Function:
    """Compile a short `entry_point` that keeps the GIL, as releasing it would take longer."""
    compiled = _compiled_on_disk(function, lambda cache: numba.njit(cache=cache, **_GIL_HELD))
    return cast(Function, EntryPoint(function, compiled))


def c_callback(signature: Any, function: Callable[..., Any]) -> Any:
    """Compile a C function (`.address`), with a cache on disk."""
    return _compiled_on_disk(
        function, lambda cache: numba.cfunc(signature, cache=cache, **_GIL_HELD)
    )


def _compiled_on_disk(function: Any, compiler: Callable[[bool], Any]) -> Any:
    before = CONFIG.CACHE_DIR
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        cache = os.access(folder, os.W_OK)
    except OSError:
        cache = False
    if not cache:
        warnings.warn(
            f"{folder}: not writable, so kernels are compiled on each start; "
            "set NUMBA_CACHE_DIR to a writable folder",
            RuntimeWarning,
            stacklevel=3,
        )
    try:
        # numba reads the folder at decoration; other users of numba keep theirs
        CONFIG.CACHE_DIR = str(folder)
        return compiler(cache)(function)
    finally:
        CONFIG.CACHE_DIR = before
