"""MPEG audio without a tag (MP3, MP2): detected by two frames that follow each other.

ISO/IEC 11172-3 and 13818-3: a frame's header gives its length.
"""

from __future__ import annotations

import mmap

_V1, _V2, _V25 = 3, 2, 0
_L1, _L2, _L3 = 3, 2, 1
_RATES = {
    _V1: (44_100, 48_000, 32_000),
    _V2: (22_050, 24_000, 16_000),
    _V25: (11_025, 12_000, 8000),
}
# kbit/s for the bitrate indices 1 to 14
_KBITS = {
    (True, _L1): (32, 64, 96, 128, 160, 192, 224, 256, 288, 320, 352, 384, 416, 448),
    (True, _L2): (32, 48, 56, 64, 80, 96, 112, 128, 160, 192, 224, 256, 320, 384),
    (True, _L3): (32, 40, 48, 56, 64, 80, 96, 112, 128, 160, 192, 224, 256, 320),
    (False, _L1): (32, 48, 56, 64, 80, 96, 112, 128, 144, 160, 176, 192, 224, 256),
    (False, _L2): (8, 16, 24, 32, 40, 48, 56, 64, 80, 96, 112, 128, 144, 160),
    (False, _L3): (8, 16, 24, 32, 40, 48, 56, 64, 80, 96, 112, 128, 144, 160),
}


def frame_bytes(header: bytes) -> int | None:
    """Return the length of the frame that begins with these four bytes, None if none does."""
    if len(header) < 4 or header[0] != 0xFF or header[1] & 0xE0 != 0xE0:
        return None
    version, layer = header[1] >> 3 & 3, header[1] >> 1 & 3
    bitrate, rate, padded = header[2] >> 4, header[2] >> 2 & 3, header[2] >> 1 & 1
    if version not in _RATES or layer == 0 or bitrate in (0, 15) or rate == 3:
        return None
    bits = 1000 * _KBITS[version == _V1, layer][bitrate - 1]
    hz = _RATES[version][rate]
    if layer == _L1:
        return (12 * bits // hz + padded) * 4
    return (72 if layer == _L3 and version != _V1 else 144) * bits // hz + padded


def begins_with_frames(head: bytes) -> bool:
    """Return whether a file begins with two frames of one kind."""
    length = frame_bytes(head[:4])
    if length is None:
        return False
    following = head[length : length + 4]
    return frame_bytes(following) is not None and (head[1], head[2] & 0x0C) == (
        following[1],
        following[2] & 0x0C,
    )


def frames_of(data: mmap.mmap) -> tuple[float, bool]:
    """Return how long a file's frames last, s, and whether the last one is whole.

    (0, True) where its frames don't follow each other.
    """
    at, seconds = _behind_tag(data), 0.0
    while at + 4 <= len(data):
        header = data[at : at + 4]
        length = frame_bytes(header)
        if length is None:
            # a tag behind the last frame; anything else isn't a plain row of frames
            return (seconds, True) if header[:3] in (b"TAG", b"APE", b"ID3") else (0.0, True)
        if at + length > len(data):
            return seconds, False
        version, layer, rate = header[1] >> 3 & 3, header[1] >> 1 & 3, header[2] >> 2 & 3
        samples = 384 if layer == _L1 else 576 if layer == _L3 and version != _V1 else 1152
        seconds += samples / _RATES[version][rate]
        at += length
    return seconds, at == len(data)


def _behind_tag(data: mmap.mmap) -> int:
    """Where an ID3v2 tag at the beginning ends (ISO 646 bytes of seven bits)."""
    if data[:3] != b"ID3":
        return 0
    size = 0
    for byte in data[6:10]:
        size = size << 7 | byte & 0x7F
    return 10 + size
