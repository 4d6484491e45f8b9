"""A WAV file's bytes from its samples, packed all at once.

libsndfile packs a sample at a time and hands on 8 KB at a time: for short sounds in memory that
takes several times as long. The header is its own, so the bytes are too.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

PACKED = {"PCM_16": 2, "PCM_24": 3, "PCM_32": 4}
"""Bytes of a sample, for the subtypes that are packed here."""

_NO_DATA = b"data" + struct.pack("<I", 0)


def with_samples(empty: bytes, subtype: str, samples: NDArray[Any]) -> bytes | None:
    """The WAV file without samples that `empty` is, with samples; None if it isn't that simple.

    Parameters
    ----------
    empty : bytes
        A header whose last chunk is the data's.
    subtype : str
        One of `PACKED`.
    samples : int16 or int32 (frames, channels)
        Whole steps in the upper bits.
    """
    data = _packed(samples, PACKED[subtype])
    size = len(empty) + len(data) + len(data) % 2
    if not (empty[:4] == b"RIFF" and empty.endswith(_NO_DATA) and size < 2**32):
        return None
    head = b"RIFF" + struct.pack("<I", size - 8) + empty[8:-4] + struct.pack("<I", len(data))
    return head + data + bytes(len(data) % 2)


def _packed(samples: NDArray[Any], width: int) -> bytes:
    little = np.ascontiguousarray(samples, samples.dtype.newbyteorder("<"))
    if little.itemsize == width:
        return little.tobytes()
    given = little.view(np.uint8).reshape(-1, little.itemsize)
    packed = np.empty((len(given), width), np.uint8)
    for place in range(width):
        packed[:, place] = given[:, place - width]
    return packed.tobytes()
