"""The kernel's bytes, packed for the way to a phone: every bit is there again (`unpack.js`).

Packed are, by zlib's deflate:

    uint8 order; the first byte of every column of 8, the second of every column, ...

of columns that were, as int64 that wrap around, replaced `order` times by their differences to the
column before, and then by (n << 1) ^ (n >> 63), so that small negative ones are small too. A
friction table's neighbours are numbers of almost the same bits, on almost a straight line.
"""

from __future__ import annotations

import zlib

import numpy as np

ORDERS = range(8)
QUICK, BEST = 1, 9
"""zlib's levels."""


def packed(raw: bytes) -> bytes:
    """Bytes, a multiple of 8 of them, packed."""
    planes = [_planes(np.frombuffer(raw, "<i8"), order) for order in ORDERS]
    return zlib.compress(min(planes, key=lambda one: len(zlib.compress(one, QUICK))), BEST)


def _planes(columns: np.ndarray, order: int) -> bytes:
    for _ in ORDERS[:order]:
        columns = np.diff(columns, prepend=np.int64(0))
    small = (columns << 1) ^ (columns >> 63)
    return bytes([order]) + small.view(np.uint8).reshape(-1, 8).T.tobytes()
