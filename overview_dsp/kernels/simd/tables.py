"""Table look-ups with one table and one position per lane. Compiled code only.

Lane i's table begins at column `starts[first + i]`, plus `offset` columns. The index is the whole
part of a position from 0 to 2**31.

Thread: audio.
"""

from __future__ import annotations

from functools import reduce
from typing import Any

from llvmlite import ir
from numba import types

from overview_dsp.kernels.intrinsics import column_pointer, intrinsic
from overview_dsp.kernels.simd.vector import FLOATS, MASK, SIMD_WIDTH

_INDEX = ir.IntType(32)
_WORD = ir.IntType(64)


def _whole(builder: Any, position: Any) -> Any:
    """Return the whole parts in 32 bits, for which all machines have an instruction."""
    return builder.fptosi(position, ir.VectorType(_INDEX, SIMD_WIDTH))


def _columns(context: Any, builder: Any, signature: Any, args: Any, size: int) -> list[Any]:
    """Return pointers to each lane's entry of 2**size columns (size < 0: one for 2**-size
    positions).

    `args` are an array, starts, first, offset, whole parts.
    """
    array, starts, first, offset, whole = args
    found = []
    for lane in range(SIMD_WIDTH):
        number = builder.zext(builder.extract_element(whole, ir.Constant(_INDEX, lane)), _WORD)
        move = builder.shl if size > 0 else builder.lshr
        number = move(number, ir.Constant(_WORD, abs(size)))
        slot = builder.add(first, ir.Constant(_WORD, lane))
        start = builder.load(column_pointer(context, builder, signature.args[1], starts, slot))
        at = builder.add(builder.add(start, offset), number)
        found.append(column_pointer(context, builder, signature.args[0], array, at))
    return found


def _order(lanes: Any) -> Any:
    lanes = list(lanes)
    return ir.Constant(ir.VectorType(_INDEX, len(lanes)), lanes)


@intrinsic
def load_pairs(typing: Any, f64: Any, starts: Any, first: Any, position: Any) -> Any:
    """Look up pairs: return the whole parts, the first and the second numbers.

    `load_pairs(f64, starts, first, position)`.
    """

    def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        whole = _whole(builder, args[3])
        pair = ir.VectorType(ir.DoubleType(), 2).as_pointer()
        args_of = (*args[:3], ir.Constant(_WORD, 0), whole)
        found = [
            builder.load(builder.bitcast(at, pair), align=8)
            for at in _columns(context, builder, signature, args_of, 1)
        ]
        while len(found) > 1:  # two by two into one vector
            order = _order(range(2 * found[0].type.count))
            found = [
                builder.shuffle_vector(*found[i : i + 2], order) for i in range(0, len(found), 2)
            ]
        undefined = ir.Constant(found[0].type, ir.Undefined)
        one, other = (
            builder.shuffle_vector(found[0], undefined, _order(range(i, 2 * SIMD_WIDTH, 2)))
            for i in (0, 1)
        )
        floor = builder.sitofp(whole, FLOATS.vector)
        return context.make_tuple(builder, signature.return_type, (floor, one, other))

    return types.UniTuple(FLOATS, 3)(f64, starts, types.int64, FLOATS), emit


@intrinsic
def gather(typing: Any, f64: Any, starts: Any, first: Any, offset: Any, position: Any) -> Any:
    """Look up numbers: `gather(f64, starts, first, offset, position)`."""

    def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        args_of = (*args[:4], _whole(builder, args[4]))
        found = ir.Constant(FLOATS.vector, ir.Undefined)
        for lane, at in enumerate(_columns(context, builder, signature, args_of, 0)):
            found = builder.insert_element(found, builder.load(at), ir.Constant(_INDEX, lane))
        return found

    return FLOATS(f64, starts, types.int64, types.int64, FLOATS), emit


def marking(size: int) -> Any:
    """Return look-ups of marks, 0 or 1, one for each 2**size positions.

    These are `marked(i64, starts, first, offset, position)`, which lanes are marked, and
    `any_marked` with the same arguments, which is faster.
    """

    def marks(context: Any, builder: Any, signature: Any, args: Any) -> list[Any]:
        args_of = (*args[:4], _whole(builder, args[4]))
        return [builder.load(at) for at in _columns(context, builder, signature, args_of, -size)]

    @intrinsic
    def marked(typing: Any, i64: Any, starts: Any, first: Any, offset: Any, position: Any) -> Any:
        def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            found = ir.Constant(MASK.vector, ir.Undefined)
            for lane, mark in enumerate(marks(context, builder, signature, args)):
                bit = builder.trunc(mark, ir.IntType(1))
                found = builder.insert_element(found, bit, ir.Constant(_INDEX, lane))
            return found

        return MASK(i64, starts, types.int64, types.int64, FLOATS), emit

    @intrinsic
    def any_marked(typing: Any, i64: Any, starts: Any, first: Any, offset: Any, x: Any) -> Any:
        def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            some = reduce(builder.or_, marks(context, builder, signature, args))
            return builder.trunc(some, ir.IntType(1))

        return types.boolean(i64, starts, types.int64, types.int64, FLOATS), emit

    return marked, any_marked
