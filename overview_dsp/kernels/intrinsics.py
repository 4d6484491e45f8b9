"""Compiler interface for functions that emit their own LLVM instructions.

These parts of numba and llvmlite are not stable, so this module checks for them on import.

Thread: main.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import llvmlite.ir
import numba.core.base
from numba import extending

from overview_dsp.errors import require_internals
from overview_dsp.kernels.compiling import NUMBA

require_internals(
    numba,
    (
        "extending.intrinsic",
        "extending.overload",
        "extending.type_callable",
        "extending.lower_builtin",
        "extending.register_model",
        "extending.models.PrimitiveModel",
        "core.base.BaseContext.cast",
        "core.base.BaseContext.make_array",
        "core.base.BaseContext.make_tuple",
        "core.base.BaseContext.get_dummy_value",
        "types.Type",
        "types.UniTuple",
    ),
    NUMBA,
)
require_internals(
    llvmlite.ir,
    (
        "IRBuilder.load_atomic",
        "IRBuilder.store_atomic",
        "IRBuilder.shuffle_vector",
        "IRBuilder.extract_element",
        "IRBuilder.insert_element",
        "VectorType.as_pointer",
        "Undefined",
    ),
    NUMBA,  # each version of which goes with one of llvmlite
)

# numba's own are untyped
_extending: Any = extending
overload = _extending.overload
type_callable = _extending.type_callable
lower_builtin = _extending.lower_builtin
register_model = _extending.register_model
models = _extending.models


def intrinsic(function: Callable[..., Any]) -> Any:
    """Declare a function that emits LLVM instructions; its first argument is the compiler's."""
    return _extending.intrinsic(function)


def column_pointer(context: Any, builder: Any, of_array: Any, array: Any, at: Any) -> Any:
    """Return a pointer to element `at` >= 0 of an array."""
    data = context.make_array(of_array)(context, builder, array).data
    return builder.gep(data, [at])
