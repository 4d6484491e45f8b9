"""The binary frame: fixed length, checked, resynchronised at every zero.

A frame is 24 bytes, the last a zero and no other:

| bytes | what |
|---|---|
| 20 | COBS of the 19 bytes of the payload |
| 3 | CRC-16/X-25 of those 20, 7 bits a byte, lowest first, bit 7 set (so that none is zero) |
| 1 | 0 |

The payload, little-endian:

| bytes | what |
|---|---|
| 1 | kind: 1 acceleration, 2 the same and angular velocity, 3 roll, 4 encoder, 5 potentiometer |
| 2 | sequence number, counting up by one a sample, modulo 65536 |
| 4 | stamp: the sensor's clock, microseconds, modulo 2^32 |
| 12 | six int16 (ax ay az gx gy gz; kind 1: the last three 0), or one int32 (thousandths of a |
|   | degree, counts, wiper) and eight bytes of 0 |

What the check promises, of bits in the order a UART sends them: a burst of up to 16 bits anywhere,
a frame's end included, is never taken for a sample. Within a frame the check is over the bytes as
they are sent (over the payload, one wrong bit could move a zero and spread through all of it); the
fixed length refuses whatever a lost or an invented zero makes. After the last wrong byte at most
one frame is lost.
"""

from __future__ import annotations

import struct

from overview_dsp.sensors import cobs
from overview_dsp.sensors.crc import crc16
from overview_dsp.sensors.pieces import Pieces
from overview_dsp.sensors.reading import ACCELERATION, ANGULAR_VELOCITY, Counters, Reading

PAYLOAD = 19
FRAME = PAYLOAD + 1 + 3
"""Bytes of a frame before its zero."""

KINDS = {
    1: ACCELERATION,
    2: ACCELERATION + ANGULAR_VELOCITY,
    3: ("roll_deg",),
    4: ("count",),
    5: ("pot",),
}
_SIX = struct.Struct("<BHI6h")
_ONE = struct.Struct("<BHIi8x")
_MILLIDEGREE = 1e-3


def encode_frame(kind: int, sequence: int, stamp_us: int, values: tuple[int, ...]) -> bytes:
    """One frame with its zero: what a device sends. `values` as the payload holds them."""
    head = (kind, sequence & 0xFFFF, stamp_us & 0xFFFFFFFF)
    if kind in (1, 2):
        payload = _SIX.pack(*head, *values, *(0,) * (6 - len(values)))
    else:
        payload = _ONE.pack(*head, *values)
    encoded = cobs.encode(payload)
    check = crc16(encoded)
    return encoded + bytes(0x80 | check >> shift & 0x7F for shift in (0, 7, 14)) + b"\0"


def decode_frame(frame: bytes | bytearray) -> Reading | None:
    """The reading of one frame without its zero; None if anything about it is wrong."""
    if len(frame) != FRAME:
        return None
    check = crc16(frame[:-3])
    for at, shift in ((-3, 0), (-2, 7), (-1, 14)):
        if frame[at] != 0x80 | check >> shift & 0x7F:
            return None
    payload = cobs.decode(frame[:-3])
    if payload is None or len(payload) != PAYLOAD or payload[0] not in KINDS:
        return None
    columns = KINDS[payload[0]]
    if len(columns) > 1:
        _, sequence, stamp, *numbers = _SIX.unpack(payload)
        if any(numbers[len(columns) :]):
            return None
        values = [float(number) for number in numbers]
    else:
        if any(payload[-8:]):
            return None
        _, sequence, stamp, number = _ONE.unpack(payload)
        values = [number * _MILLIDEGREE if columns == ("roll_deg",) else float(number)]
    reading = {"sequence": float(sequence), "t_us": float(stamp)}
    reading.update(zip(columns, values, strict=False))
    return reading


class FrameDecoder:
    """Frames from bytes that come in any cuts."""

    def __init__(self, counters: Counters) -> None:
        """What is wrong is counted in `counters`."""
        self._counters = counters
        self._pieces = Pieces(FRAME)

    def feed(self, data: bytes) -> list[Reading]:
        """The readings that these bytes complete."""
        self._counters.received_bytes += len(data)
        readings = []
        for frame, left_out, first in self._pieces.ended(data, b"\0"):
            reading = decode_frame(frame)
            if reading is not None:
                readings.append(reading)
            elif first:
                self._counters.fragments += bool(frame)
            elif frame:
                self._counters.refuse(frame)
                self._counters.noise_bytes += left_out
        self._counters.readings += len(readings)
        return readings
