"""Packed bytes and patches as a page reads them, as `sound_data` documents them."""

from __future__ import annotations

import struct
import zlib

import numpy as np


def unpacked(packed: bytes) -> bytes:
    """As `sound_data` says, column by column."""
    order, *planes = zlib.decompress(packed)
    if order == 8:
        return predicted(bytes(planes))
    columns = np.array(planes, np.uint8).reshape(8, -1).T.copy().view("<u8").ravel()
    columns = (columns >> np.uint64(1)) ^ (np.uint64(0) - (columns & np.uint64(1)))
    for _ in range(order):
        columns = np.cumsum(columns, dtype=np.uint64)
    return columns.tobytes()


def predicted(planes: bytes) -> bytes:
    count = (len(planes) - 8) // 9
    (step,) = struct.unpack("<d", planes[9 * count :])
    ranks = np.frombuffer(planes, np.int8, count, 8 * count).tolist()
    made = bytearray()
    for i in range(count):
        coded = sum(planes[i + k * count] << 8 * k for k in range(8))
        found = 0.0
        if i > 1:
            a, b = struct.unpack_from("<2d", made, 8 * i - 16)
            x = step * ranks[i]
            growth = 1 + x * (1 + x / 2 * (1 + x / 3 * (1 + x / 4)))
            with np.errstate(all="ignore"):
                found = float(np.float64(b) * (np.float64(b) / np.float64(a)) * growth)
        found = found if 0.0 < found < np.inf else 0.0
        bits = int.from_bytes(struct.pack("<d", found), "little")
        made += ((bits + ((coded >> 1) ^ -(coded & 1))) % 2**64).to_bytes(8, "little")
    return bytes(made)


def patched(base: bytes, patch: bytes, length: int) -> bytes:
    """As `live.js` and `data.js` do it."""
    base = base[:length].ljust(length, b"\0")
    words = np.frombuffer(patch, "<u4")
    if words[0] == 1:
        return patch[8:]
    made, at = np.frombuffer(base, "<u4").copy(), 2
    for _ in range(words[1]):
        column, count = words[at : at + 2]
        made[2 * column : 2 * (column + count)] = words[at + 2 : at + 2 + 2 * count]
        at += 2 + 2 * count
    return made.tobytes()


def updated(base: bytes, update: dict[str, object], patch: bytes) -> bytes:
    """The surface change after an update of a live timeline."""
    return unpacked(patch) if update.get("packed") else patched(base, patch, update["bytes"])
