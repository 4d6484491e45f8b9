"""Lanes: one number of each of `SIMD_WIDTH` voices as a single value.

Kernels are written for single float64 values. With lanes the same functions process all voices
at once with vector instructions: operators, `abs`, `min`, `max`, `sqrt`, and the
functions below. Each lane gets the bits that the operation gives a single number.

In plain Python lanes are arrays. Functions that arrays do not support are for compiled code only.

Thread: audio.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types

from overview_dsp.kernels.intrinsics import (
    column_pointer,
    intrinsic,
    lower_builtin,
    models,
    overload,
    register_model,
    type_callable,
)

SIMD_WIDTH = 8
RARELY = (1, 2000)  # weights of a rare branch

_INDEX = ir.IntType(32)
_WORD = ir.IntType(64)
_ELEMENT = {"float64": ir.DoubleType(), "uint64": _WORD, "bool": ir.IntType(1)}


class _Lanes(types.Type):
    """The type of `SIMD_WIDTH` numbers of one kind."""

    def __init__(self, element: str) -> None:
        super().__init__(name=f"lanes({element})")
        self.vector = ir.VectorType(_ELEMENT[element], SIMD_WIDTH)


FLOATS, WORDS, MASK = _Lanes("float64"), _Lanes("uint64"), _Lanes("bool")


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, type_: _Lanes) -> None:
        super().__init__(manager, type_, type_.vector)


def _in_all(context: Any, builder: Any, value: Any, type_: Any, lanes: _Lanes) -> Any:
    """Return lanes unchanged, or a number as lanes."""
    if isinstance(type_, _Lanes):
        return value
    number = types.float64 if lanes is FLOATS else types.uint64
    value = context.cast(builder, value, type_, number)
    undefined = ir.Constant(lanes.vector, ir.Undefined)
    first = builder.insert_element(undefined, value, ir.Constant(_INDEX, 0))
    return builder.shuffle_vector(first, undefined, _order([0] * SIMD_WIDTH))


def _order(lanes: list[int]) -> Any:
    return ir.Constant(ir.VectorType(_INDEX, len(lanes)), lanes)


def _binary(function: Any, of: _Lanes, result: _Lanes, emit: Callable[..., Any]) -> None:
    """Define an operator of two lanes, or of lanes and a number."""
    numbers = (types.Float, types.Integer) if of is FLOATS else (types.Integer,)

    @type_callable(function)
    def typed(context: Any) -> Any:
        def typer(a: Any, b: Any) -> Any:
            both = (a, b)
            fits = of in both and all(one is of or isinstance(one, numbers) for one in both)
            return result if fits else None

        return typer

    def lowered(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        a, b = (
            _in_all(context, builder, value, given, of)
            for value, given in zip(args, signature.args, strict=True)
        )
        return emit(builder, a, b)

    lower_builtin(function, of, of)(lowered)
    for number in numbers:
        lower_builtin(function, of, number)(lowered)
        lower_builtin(function, number, of)(lowered)


def _compare(sign: str) -> Callable[..., Any]:
    return lambda builder, a, b: builder.fcmp_ordered(sign, a, b)


def _instruction(name: str) -> Callable[..., Any]:
    return lambda builder, a, b: getattr(builder, name)(a, b)


def _extreme(sign: str) -> Callable[..., Any]:
    # like numba's `min` and `max`: the first, unless the second is beyond it
    return lambda builder, a, b: builder.select(builder.fcmp_ordered(sign, b, a), b, a)


for _function, _name in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _binary(_function, FLOATS, FLOATS, _instruction(_name))
for _function, _sign in (
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.eq, "=="),
):
    _binary(_function, FLOATS, MASK, _compare(_sign))
_binary(max, FLOATS, FLOATS, _extreme(">"))
_binary(min, FLOATS, FLOATS, _extreme("<"))
for _function, _name in (
    (operator.add, "add"),
    (operator.sub, "sub"),
    (operator.mul, "mul"),
    (operator.or_, "or_"),
    (operator.and_, "and_"),
    (operator.xor, "xor"),
    (operator.lshift, "shl"),
    (operator.rshift, "lshr"),
):
    _binary(_function, WORDS, WORDS, _instruction(_name))


def _unary(function: Any, emit: Callable[..., Any]) -> None:
    @type_callable(function)
    def typed(context: Any) -> Any:
        return lambda x: FLOATS if x is FLOATS else None

    @lower_builtin(function, FLOATS)
    def lowered(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return emit(builder, args[0])


def _called(name: str) -> Callable[..., Any]:
    """Return an emitter of an LLVM function that is one instruction on every machine."""
    name = f"llvm.{name}.v{SIMD_WIDTH}f64"

    def emit(builder: Any, x: Any) -> Any:
        function = builder.module.globals.get(name)
        if function is None:
            kind = ir.FunctionType(FLOATS.vector, [FLOATS.vector])
            function = ir.Function(builder.module, kind, name)
        return builder.call(function, [x])

    return emit


_unary(abs, _called("fabs"))
_unary(math.sqrt, _called("sqrt"))
_unary(operator.neg, lambda builder, x: builder.fneg(x))


# --- what kernels call ----------------------------------------------------------------------------


def choose(condition, yes, no):
    """Return `yes` where the condition holds, else `no`, for numbers or lanes. Computes both."""
    return yes if condition else no


def rarely(condition, yes, no):
    """Return `choose(condition, yes, no)` for floats and a rare condition.

    It is a single branch for all lanes, so that later operations need not wait for the condition,
    as they would for a selection.
    """
    return yes if condition else no


def any_of(condition):
    """Return whether a condition holds for a number or for any lane."""
    return condition


def bits_of(x):
    """Return the 64 bits of a float64 as an integer."""
    return np.float64(x).view(np.int64)


def from_bits(word):
    """Return the float64 of 64 bits."""
    return np.int64(word).view(np.float64)


def count(word):
    """Return the float64 of an unsigned integer below 2**53."""
    return float(np.int64(word))


def load(f64, at):
    """Load lanes from `SIMD_WIDTH` columns from `at` on, float64."""
    return f64[at : at + SIMD_WIDTH].copy()


def store(f64, at, value):
    """Store lanes, or a number for all lanes, in `SIMD_WIDTH` columns from `at` on."""
    f64[at : at + SIMD_WIDTH] = value


@intrinsic
def _select(typing: Any, condition: Any, yes: Any, no: Any) -> Any:
    of = WORDS if WORDS in (yes, no) else FLOATS

    def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        _, given_yes, given_no = signature.args
        yes = _in_all(context, builder, args[1], given_yes, of)
        no = _in_all(context, builder, args[2], given_no, of)
        return builder.select(args[0], yes, no)

    return of(MASK, yes, no), emit


@overload(choose)
def _choose(condition, yes, no):
    if condition is MASK:
        return lambda condition, yes, no: _select(condition, yes, no)
    return lambda condition, yes, no: yes if condition else no


def _branched(builder: Any, condition: Any, chosen: Callable[[], Any], otherwise: Any) -> Any:
    """Emit a rare branch to `chosen`."""
    before = builder.block
    seldom = builder.append_basic_block("seldom")
    after = builder.append_basic_block("after")
    # weights on the branch itself, since LLVM drops `expect` intrinsics too early
    builder.cbranch(condition, seldom, after).set_weights(RARELY)
    builder.position_at_end(seldom)
    replaced = chosen()
    builder.branch(after)
    builder.position_at_end(after)
    result = builder.phi(otherwise.type)
    result.add_incoming(otherwise, before)
    result.add_incoming(replaced, seldom)
    return result


@intrinsic
def _rarely(typing: Any, condition: Any, yes: Any, no: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        condition, yes, no = args
        return _branched(builder, condition, lambda: yes, no)

    return types.float64(types.boolean, types.float64, types.float64), emit


@intrinsic
def _rarely_of_lanes(typing: Any, condition: Any, yes: Any, no: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        condition, yes, no = args
        yes = _in_all(context, builder, yes, signature.args[1], FLOATS)
        some = _in_any(builder, condition)
        return _branched(builder, some, lambda: builder.select(condition, yes, no), no)

    return FLOATS(MASK, yes, FLOATS), emit


@overload(rarely)
def _of_rarely(condition, yes, no):
    if condition is MASK:
        return lambda condition, yes, no: _rarely_of_lanes(condition, yes, no)
    return lambda condition, yes, no: _rarely(condition, yes, no)


def _in_any(builder: Any, condition: Any) -> Any:
    bits = ir.IntType(SIMD_WIDTH)
    return builder.icmp_unsigned("!=", builder.bitcast(condition, bits), ir.Constant(bits, 0))


@intrinsic
def _any(typing: Any, condition: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _in_any(builder, args[0])

    return types.boolean(condition), emit


@overload(any_of)
def _any_of(condition):
    if condition is MASK:
        return lambda condition: _any(condition)
    return lambda condition: condition


def _seen_as(source: _Lanes, target: _Lanes, instruction: str) -> Any:
    @intrinsic
    def seen(typing: Any, x: Any) -> Any:
        def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return getattr(builder, instruction)(args[0], target.vector)

        return target(source), emit

    return seen


_as_words = _seen_as(FLOATS, WORDS, "bitcast")
_as_floats = _seen_as(WORDS, FLOATS, "bitcast")
_counted = _seen_as(WORDS, FLOATS, "uitofp")


@overload(bits_of)
def _bits_of(x):
    if x is FLOATS:
        return lambda x: _as_words(x)
    return lambda x: np.float64(x).view(np.int64)


@overload(from_bits)
def _from_bits(word):
    if word is WORDS:
        return lambda word: _as_floats(word)
    return lambda word: np.int64(word).view(np.float64)


@overload(count)
def _count(word):
    if word is WORDS:
        return lambda word: _counted(word)
    return lambda word: float(np.int64(word))


def _loading(of: _Lanes) -> Any:
    @intrinsic
    def loaded(typing: Any, f64: Any, at: Any) -> Any:
        def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            place = column_pointer(context, builder, signature.args[0], *args)
            return builder.load(builder.bitcast(place, of.vector.as_pointer()), align=8)

        return of(f64, types.int64), emit

    return loaded


_load_floats = _loading(FLOATS)
load_words = _loading(WORDS)
"""`load` of words: `load_words(m, at)`. Compiled code only."""


@intrinsic
def _store(typing: Any, f64: Any, at: Any, value: Any) -> Any:
    of = WORDS if value is WORDS else FLOATS

    def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = column_pointer(context, builder, signature.args[0], *args[:2])
        value = _in_all(context, builder, args[2], signature.args[2], of)
        builder.store(value, builder.bitcast(place, of.vector.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.void(f64, types.int64, value), emit


@intrinsic
def store_pairs(typing: Any, f64: Any, at: Any, stride: Any, first: Any, second: Any) -> Any:
    """Store two numbers of each lane as adjacent float32. Compiled code only.

    `store_pairs(f64, at, stride, first, second)` stores those of lane i in `at + i * stride` and
    the following float.
    """

    def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        f64, at, stride, first, second = args
        single = ir.VectorType(ir.FloatType(), SIMD_WIDTH)
        first, second = (builder.fptrunc(one, single) for one in (first, second))
        order = _order([i + half for i in range(SIMD_WIDTH) for half in (0, SIMD_WIDTH)])
        pairs = builder.bitcast(builder.shuffle_vector(first, second, order), WORDS.vector)
        for lane in range(SIMD_WIDTH):
            pair = builder.extract_element(pairs, ir.Constant(_INDEX, lane))
            place = column_pointer(context, builder, signature.args[0], f64, at)
            builder.store(pair, builder.bitcast(place, _WORD.as_pointer()), align=4)
            at = builder.add(at, stride)
        return context.get_dummy_value()

    return types.void(f64, types.int64, types.int64, FLOATS, FLOATS), emit


@overload(load)
def _of_load(f64, at):
    return lambda f64, at: _load_floats(f64, at)


@overload(store)
def _of_store(f64, at, value):
    return lambda f64, at, value: _store(f64, at, value)
