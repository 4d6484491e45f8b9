"""How kernels are compiled: one policy for all of them."""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Callable
from functools import cache, update_wrapper
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import platformdirs
from numba.extending import typeof_impl

from overview_dsp.errors import require_internals

NUMBA = "numba>=0.61,<0.69"
"""As pyproject.toml has it. What `kernels` use of numba's inside may change with any version, so a
new one is let in when the tests have passed with it."""

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
# numba sets its options as attributes at run time
_config: Any = numba.config

Function = TypeVar("Function", bound=Callable[..., Any])

# numba counts a negative index from the array's end, which costs three instructions wherever the
# compiler can't see a sign: `array[i & NOT_NEGATIVE]` shows it
NOT_NEGATIVE = 0x7FFFFFFFFFFFFFFF

OPTIONS: dict[str, Any] = {
    # Python's model would raise, print and take the GIL on a division by zero
    "error_model": "numpy",
    "boundscheck": False,
    # reordered or fused arithmetic would differ between runners
    "fastmath": False,
    "nogil": True,
}


# a C function has no GIL to give up
_GIL_KEPT = {key: value for key, value in OPTIONS.items() if key != "nogil"}


@cache
def sources_digest() -> str:
    """Digest of every kernel source file, however its lines end."""
    digest = hashlib.sha256()
    folder = Path(__file__).parent
    for source in sorted(folder.rglob("*.py")):
        digest.update(source.relative_to(folder).as_posix().encode())
        digest.update(source.read_bytes().replace(b"\r\n", b"\n"))
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """The folder of compiled kernels: `NUMBA_CACHE_DIR` if set, else the user's cache folder.

    One for each state of the sources: numba's cache watches only a function's own file.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    root = Path(chosen) if chosen else Path(platformdirs.user_cache_dir("overview-dsp"))
    return root / f"kernels-{sources_digest()}-{numba.__version__}"


def runs_as_python() -> bool:
    """Whether kernels aren't compiled at all (`NUMBA_DISABLE_JIT`)."""
    return bool(_config.DISABLE_JIT)


def is_compiled(function: str = "process") -> bool:
    """Whether the first use of a kernel will compile nothing: it is on disk, or runs as Python."""
    from overview_dsp.kernels import precompiled

    if runs_as_python() or precompiled.usable(function):
        return True
    folder = cache_folder()
    return folder.is_dir() and any(folder.rglob(f"*.{function}-*.nbc"))


def inlined(function: Function) -> Function:
    """Compile a function for other kernels to call: inlined, with no door to Python.

    Python calls its plain form, `function.py_func`.
    """
    inlined: dict[str, Any] = {
        "forceinline": True,
        "no_cpython_wrapper": True,
        "no_cfunc_wrapper": True,
    }
    compiled: Function = numba.njit(**OPTIONS, **inlined)(function)
    return compiled


def outlined(function: Function) -> Function:
    """Compile a function for other kernels to call, not inlined: for what is large and rare."""
    bare: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    compiled: Function = numba.njit(**OPTIONS, **bare)(function)
    return compiled


class EntryPoint:
    """A function that Python calls and kernels may: in the package's machine code, or numba's.

    `py_func` is its plain Python form, `compiled` numba's dispatcher.
    """

    def __init__(self, function: Callable[..., Any], compiled: Any) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self.compiled = compiled
        self._call: Callable[..., Any] | None = None

    def __call__(self, *arguments: Any) -> Any:
        """Call it; the first call of all looks where."""
        if self._call is None:
            from overview_dsp.kernels.precompiled import precompiled_function

            self._call = precompiled_function(self.py_func.__name__) or self.compiled
        return self._call(*arguments)


@typeof_impl.register(EntryPoint)
def _type_of_entry_point(entry: EntryPoint, context: Any) -> Any:
    return numba.typeof(entry.compiled)


def entry_point(function: Function) -> Function:
    """Compile a function that Python calls, and keep its machine code on disk."""
    kept = _kept(function, lambda cache: numba.njit(cache=cache, **OPTIONS))
    return cast(Function, EntryPoint(function, kept))


def briefly_called(function: Function) -> Function:
    """As `entry_point`, of a few instructions: giving the GIL up, and back, would take longer."""
    kept = _kept(function, lambda cache: numba.njit(cache=cache, **_GIL_KEPT))
    return cast(Function, EntryPoint(function, kept))


def c_callback(signature: Any, function: Callable[..., Any]) -> Any:
    """Compile a C function (`.address`), and keep its machine code on disk."""
    return _kept(function, lambda cache: numba.cfunc(signature, cache=cache, **_GIL_KEPT))


def _kept(function: Any, compiler: Callable[[bool], Any]) -> Any:
    before = _config.CACHE_DIR
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        cache = os.access(folder, os.W_OK)
    except OSError:
        cache = False
    if not cache:
        warnings.warn(
            f"{folder}: can't keep compiled kernels there, so each start compiles anew; "
            "set NUMBA_CACHE_DIR to a folder you may write to",
            RuntimeWarning,
            stacklevel=3,
        )
    try:
        # numba takes the folder at decoration; other users of numba keep theirs
        _config.CACHE_DIR = str(folder)
        return compiler(cache)(function)
    finally:
        _config.CACHE_DIR = before
