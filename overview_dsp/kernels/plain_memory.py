"""Views of a memory block at a plain pointer.

Thread: any.
"""

from __future__ import annotations

import numba
import numpy as np
from numba.core import cgutils

from overview_dsp.kernels import layout
from overview_dsp.kernels.compiling import inlined
from overview_dsp.kernels.intrinsics import intrinsic

carray = getattr(numba, "carray")  # noqa: B009 - numba does not export it to type checkers


@inlined
def views(memory):
    """Return a block of `layout.TOTAL` columns as float64, int64 and uint64 arrays."""
    return (
        carray(memory, (layout.TOTAL,), np.float64),
        carray(memory, (layout.TOTAL,), np.int64),
        carray(memory, (layout.TOTAL,), np.uint64),
    )


@intrinsic
def pointer_at(context, address):
    """Return the plain pointer to an address, an int64."""

    def generate(_context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return numba.types.voidptr(numba.types.int64), generate
