"""What kernels write out as LLVM instructions of their own: the compiler's side of it.

Thread: main.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import extending


def intrinsic(function: Callable[..., Any]) -> Any:
    """What the compiler writes out where it is called; its first argument is the compiler's."""
    return extending.intrinsic(function)


def column_pointer(
    context: Any, builder: ir.IRBuilder, of_array: Any, array: Any, at: Any
) -> ir.Value:
    """Where an array has its element `at`, which is not negative."""
    data = context.make_array(of_array)(context, builder, array).data
    return builder.gep(data, [at])
