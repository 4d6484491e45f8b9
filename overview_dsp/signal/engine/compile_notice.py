"""Say so, once, before kernels are compiled: the first use on a machine takes a while."""

from __future__ import annotations

import sys

from overview_dsp.kernels.compiling import is_compiled
from overview_dsp.kernels.shipped import is_outdated

_announced: set[str] = set()


def announce_compile(*kernels: str) -> None:
    """A line on stderr if the first use of kernels (by name) on this machine will compile them."""
    new = set(kernels) - _announced
    if all(is_compiled(kernel) for kernel in new):
        return
    _announced.update(new)
    why = ", as its sources have changed (see tools/build_kernels.py)" if is_outdated() else ""
    print(f"compiling the engine for this machine (once, 10 to 40 s){why} ...", file=sys.stderr)
