"""Consistent Overhead Byte Stuffing: bytes without a zero, so that a zero ends a frame.

Each zero is replaced by the distance to the next one, and the first distance goes before.
Source: S. Cheshire, M. Baker, "Consistent Overhead Byte Stuffing", IEEE/ACM Trans. Networking 7(2),
1999.
"""

from __future__ import annotations

LONGEST = 253
"""Bytes of a frame here: one code block, one byte of overhead."""


def encode(data: bytes) -> bytes:
    """`data` (at most 253 bytes) without zeros, one byte longer."""
    assert len(data) <= LONGEST
    return b"".join(bytes([len(run) + 1]) + run for run in data.split(b"\0"))


def decode(encoded: bytes | bytearray) -> bytes | None:
    """The bytes that were encoded; None if these never were."""
    runs = []
    at = 0
    while at < len(encoded):
        code = encoded[at]
        if code == 0 or at + code > len(encoded):
            return None
        runs.append(bytes(encoded[at + 1 : at + code]))
        at += code
    return b"\0".join(runs) if runs else None
