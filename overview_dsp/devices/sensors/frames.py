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
| 1 | kind: 1 acceleration, 2 the same and angular velocity, 3 roll, 4 encoder, 5 potentiometer, |
|   | 6 and 7 a knob that runs the surface itself (`firmware/knob/surface.h`) |
| 2 | sequence number, counting up by one a sample, modulo 65536 |
| 4 | stamp: the sensor's clock, microseconds, modulo 2^32 |
| 12 | six int16 (ax ay az gx gy gz; kind 1: the last three 0), or one int32 (thousandths of a |
|   | degree, counts, wiper) and eight bytes of 0; kind 6 two int32 (theta2 and the disk's surface |
|   | angle, microradians) and two int16 (torque, 1e-5 N m; stretch, 1e-4 rad); kind 7 three |
|   | uint16, four bytes and an uint16 (`KNOB_STATE`) |

What the check promises, of bits in the order a UART sends them: a burst of up to 16 bits anywhere,
a frame's end included, is never taken for a sample. Within a frame the check is over the bytes as
they are sent (over the payload, one wrong bit could move a zero and spread through all of it); the
fixed length refuses whatever a lost or an invented zero makes. After the last wrong byte at most
one frame is lost.

Consistent Overhead Byte Stuffing: bytes without a zero, so that a zero ends a frame.

Each zero is replaced by the distance to the next one, and the first distance goes before.
Source: S. Cheshire, M. Baker, "Consistent Overhead Byte Stuffing", IEEE/ACM Trans. Networking 7(2),
1999.

CRC-16/X-25 (the frame check of HDLC and PPP, RFC 1662 appendix C.2).

Polynomial x^16 + x^12 + x^5 + 1, least significant bit first, start and final XOR 0xFFFF; its check
value of b"123456789" is 0x906E. A polynomial of degree 16 with a constant term divides no burst of
up to 16 bits. Least significant bit first is the order in which a UART sends, so that a burst on
the wire is a burst in the code: a CRC the other way round sees up to 24 bits of it.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

from overview_dsp.devices.sensors.lines import Pieces
from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGULAR_VELOCITY,
    Counters,
    Decoder,
    Reading,
)

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


POLYNOMIAL = 0x8408  # bit-reversed 0x1021


def _step(value: int) -> int:
    for _ in range(8):
        value = value >> 1 ^ (POLYNOMIAL if value & 1 else 0)
    return value


_TABLE = tuple(_step(value) for value in range(256))


def crc16(data: bytes | bytearray) -> int:
    """The check of `data`, 0 to 65535."""
    register = 0xFFFF
    for byte in data:
        register = register >> 8 ^ _TABLE[(register ^ byte) & 0xFF]
    return register ^ 0xFFFF


PAYLOAD = 19
FRAME = PAYLOAD + 1 + 3
"""Bytes of a frame before its zero."""

KNOB_MOTION = ("theta2_rad", "surface_rad", "torque_nm", "stretch_rad")
"""Of a knob with the surface on its board: the hand's angle, the disk's, the motor's torque, how
far the spring between them is stretched, which is less than they are apart where its clutch slips.
"""

KNOB_STATE = ("knob_points", "knob_hz", "knob_missing", "knob_filling", "knob_table", "knob_disk",
              "knob_level", "knob_refused")  # fmt: skip
"""Points of its table, steps a second, the first part that hasn't come, of which table; the table
and the disk it uses, how much torque there may be (of 255), frames it refused."""

_SIX = struct.Struct("<BHI6h")
_ONE = struct.Struct("<BHIi8x")
_MOTION = struct.Struct("<BHI2i2h")
_STATE = struct.Struct("<BHI3H4BH")
_WHOLE = (1.0,) * 8
_LAYOUTS = {
    1: (ACCELERATION, _SIX, _WHOLE),
    2: (ACCELERATION + ANGULAR_VELOCITY, _SIX, _WHOLE),
    3: (("roll_deg",), _ONE, (1e-3,)),
    4: (("count",), _ONE, _WHOLE),
    5: (("pot",), _ONE, _WHOLE),
    6: (KNOB_MOTION, _MOTION, (1e-6, 1e-6, 1e-5, 1e-4)),
    7: (KNOB_STATE, _STATE, _WHOLE),
}
"""By kind: what it says, how it is packed, what 1 of each is."""


def encode_frame(kind: int, sequence: int, stamp_us: int, values: tuple[int, ...]) -> bytes:
    """One frame with its zero: what a device sends. `values` as the payload holds them."""
    head = (kind, sequence & 0xFFFF, stamp_us & 0xFFFFFFFF)
    packing = _LAYOUTS[kind][1]
    if packing is _SIX:
        values = (*values, *(0,) * (6 - len(values)))
    return framed(packing.pack(*head, *values))


def framed(payload: bytes) -> bytes:
    """At most 253 bytes as a frame with its zero."""
    encoded = encode(payload)
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
    payload = decode(frame[:-3])
    if payload is None or len(payload) != PAYLOAD or payload[0] not in _LAYOUTS:
        return None
    columns, packing, units = _LAYOUTS[payload[0]]
    _, sequence, stamp, *numbers = packing.unpack(payload)
    if any(numbers[len(columns) :]) or (packing is _ONE and any(payload[-8:])):
        return None
    reading = {"sequence": float(sequence), "t_us": float(stamp)}
    reading.update(
        (name, number * unit) for name, number, unit in zip(columns, numbers, units, strict=False)
    )
    return reading


class FrameDecoder(Decoder):
    """Readings from frames."""

    def __init__(self, counters: Counters) -> None:
        super().__init__(counters)
        self._pieces = Pieces(FRAME)

    def _decode(self, data: bytes) -> Iterator[Reading]:
        for frame, left_out, first in self._pieces.ended(data, b"\0"):
            reading = decode_frame(frame)
            if reading is not None:
                yield reading
            elif first:
                self._counters.fragments += bool(frame)
            elif frame:
                self._counters.refuse(frame)
                self._counters.noise_bytes += left_out
