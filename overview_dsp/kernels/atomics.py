"""Atomic loads and stores that order the memory accesses of writer and reader threads.

A ring or log of the memory block has one writer and one reader. The writer fills entries and then
publishes their count with `store_release`; the reader gets the count with `load_acquire` and then
reads entries, and returns them in the same way. Without this, processors other than x86 may show
the count before the entries, and a compiler may move either past the other.

Plain Python, and WebAssembly with its one thread, have plain loads and stores.

Thread: any.
"""

from __future__ import annotations

from typing import Any

from numba import types

from overview_dsp.kernels.compiling import briefly_called
from overview_dsp.kernels.intrinsics import column_pointer, intrinsic, overload

COLUMN_BYTES = 8


def load_acquire(i64, at):
    """Read column `at`; later reads are not moved before it."""
    return i64[at]


def store_release(i64, at, value):
    """Write column `at`; earlier reads and writes are not moved after it."""
    i64[at] = value


@intrinsic
def _load(typing: Any, i64: Any, at: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = column_pointer(context, builder, signature.args[0], *args)
        return builder.load_atomic(place, "acquire", COLUMN_BYTES)

    return types.int64(i64, types.int64), emit


@intrinsic
def _store(typing: Any, i64: Any, at: Any, value: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = column_pointer(context, builder, signature.args[0], *args[:2])
        builder.store_atomic(args[2], place, "release", COLUMN_BYTES)
        return context.get_dummy_value()

    return types.void(i64, types.int64, types.int64), emit


@overload(load_acquire)
def _load_acquire(i64, at):
    return lambda i64, at: _load(i64, at)


@overload(store_release)
def _store_release(i64, at, value):
    return lambda i64, at, value: _store(i64, at, value)


@briefly_called
def acquired(i64, at):
    """`load_acquire` for callers in Python: i64 is int64 [layout.TOTAL]."""
    return load_acquire(i64, at)


@briefly_called
def publish(i64, at, value):
    """`store_release` for callers in Python: i64 is int64 [layout.TOTAL]."""
    store_release(i64, at, value)
