"""The binary frame: fixed length, checked, resynchronised at every zero.

A frame is 24 bytes; only the last one is zero:

| bytes | content |
|---|---|
| 20 | COBS of the 19 bytes of the payload |
| 3 | CRC-16/X-25 of those 20, 7 bits per byte, lowest first, bit 7 set (so that none is zero) |
| 1 | 0 |

The payload, little-endian:

| bytes | content |
|---|---|
| 1 | kind: 1 acceleration, 2 the same and angular velocity, 3 roll, 4 encoder, 5 potentiometer, |
|   | 6 and 7 a knob that runs the surface itself (`firmware/knob/surface.h`) |
| 2 | sequence number, counting up by one per sample, modulo 65536 |
| 4 | stamp: the sensor's clock, microseconds, modulo 2^32 |
| 12 | six int16 (ax ay az gx gy gz; kind 1: the last three 0), or one int32 (thousandths of a |
|   | degree, counts, wiper) and eight bytes of 0; kind 6 two int32 (theta2 and the disk's surface |
|   | angle, microradians) and two int16 (torque, 1e-5 N m; stretch, 1e-4 rad); kind 7 three |
|   | uint16, four bytes and an uint16 (`KNOB_STATE`) |

The check detects every burst of up to 16 wrong bits in the order of a UART, also at a frame's end.
Within a frame the check covers the bytes as sent: over the payload, one wrong bit could move a zero
and spread through all of it. The fixed length rejects frames with a lost or an added zero. After
the last wrong byte at most one frame is lost.

COBS (Consistent Overhead Byte Stuffing) removes the zeros of a payload, so that a zero can end a
frame. It replaces each zero by the distance to the next one and puts the first distance in front.
Source: S. Cheshire, M. Baker, "Consistent Overhead Byte Stuffing", IEEE/ACM Trans. Networking 7(2),
1999.

CRC-16/X-25 is the frame check of HDLC and PPP (RFC 1662 appendix C.2). Its polynomial is
x^16 + x^12 + x^5 + 1, least significant bit first; start and final XOR are 0xFFFF. The check value
of b"123456789" is 0x906E. A polynomial of degree 16 with a constant term divides no burst of up to
16 bits. A UART sends the least significant bit first, so a burst on the wire is a burst in the
code. A CRC in the opposite order would see up to 24 bits of it.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

from overview_dsp.devices.sensors.lines import StreamSplitter
from overview_dsp.devices.sensors.reading import ACCELERATION, INERTIAL, Counters, Decoder, Reading

LONGEST = 253  # maximum payload of a frame, bytes: one code block, one byte of overhead


def encode(data: bytes) -> bytes:
    """Return `data` (at most 253 bytes) without zeros, one byte longer."""
    assert len(data) <= LONGEST
    return b"".join(bytes([len(run) + 1]) + run for run in data.split(b"\0"))


def decode(encoded: bytes | bytearray) -> bytes | None:
    """Return the original of encoded bytes; None if the encoding is invalid."""
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


def _table_entry(value: int) -> int:
    for _ in range(8):
        value = value >> 1 ^ (POLYNOMIAL if value & 1 else 0)
    return value


_TABLE = tuple(map(_table_entry, range(256)))


def crc16(data: bytes | bytearray) -> int:
    """Return the check of `data`, 0 to 65535."""
    register = 0xFFFF
    for byte in data:
        register = register >> 8 ^ _TABLE[(register ^ byte) & 0xFF]
    return register ^ 0xFFFF


PAYLOAD = 19
FRAME = PAYLOAD + 1 + 3  # length of a frame without its zero, bytes

KNOB_MOTION = ("theta2_rad", "surface_rad", "torque_nm", "stretch_rad")
"""Motion of a knob with the surface on its board: angle of the knob, angle of the disk, torque of
the motor, and stretch of the spring between them (less than their distance where its clutch slips).
"""

KNOB_STATE = ("knob_points", "knob_hz", "knob_missing", "knob_filling", "knob_table", "knob_disk",
              "knob_level", "knob_rejected")  # fmt: skip
"""State of such a knob: points of its table, steps per second, the first missing part, the table
that it receives, the table and the disk in use, the torque limit (255 = all), rejected frames."""

_SIX = struct.Struct("<BHI6h")
_ONE = struct.Struct("<BHIi8x")
_MOTION = struct.Struct("<BHI2i2h")
_STATE = struct.Struct("<BHI3H4BH")
_WHOLE = (1.0,) * 8
_LAYOUTS = {
    1: (ACCELERATION, _SIX, _WHOLE),
    2: (INERTIAL, _SIX, _WHOLE),
    3: (("roll_deg",), _ONE, (1e-3,)),
    4: (("count",), _ONE, _WHOLE),
    5: (("pot",), _ONE, _WHOLE),
    6: (KNOB_MOTION, _MOTION, (1e-6, 1e-6, 1e-5, 1e-4)),
    7: (KNOB_STATE, _STATE, _WHOLE),
}
"""Columns, packing and value of 1 count in each column, by kind."""


def framed(payload: bytes) -> bytes:
    """Return at most 253 bytes as a frame with its zero."""
    encoded = encode(payload)
    return encoded + _check_bytes(encoded) + b"\0"


def _check_bytes(encoded: bytes | bytearray) -> bytes:
    check = crc16(encoded)
    return bytes(0x80 | check >> shift & 0x7F for shift in (0, 7, 14))


def decode_frame(frame: bytes | bytearray) -> Reading | None:
    """Return the reading of one frame without its zero; None if the frame is invalid."""
    if len(frame) != FRAME or frame[-3:] != _check_bytes(frame[:-3]):
        return None
    payload = decode(frame[:-3])
    if payload is None or len(payload) != PAYLOAD or payload[0] not in _LAYOUTS:
        return None
    columns, packing, units = _LAYOUTS[payload[0]]
    _, sequence, stamp, *numbers = packing.unpack(payload)
    if any(numbers[len(columns) :]) or (packing is _ONE and any(payload[-8:])):
        return None
    counts = zip(columns, numbers, units, strict=False)
    values = {name: count * unit for name, count, unit in counts}
    return {"sequence": float(sequence), "t_us": float(stamp), **values}


class FrameDecoder(Decoder):
    """Readings from frames."""

    def __init__(self, counters: Counters) -> None:
        super().__init__(counters)
        self._splitter = StreamSplitter(FRAME)

    def _decode(self, data: bytes) -> Iterator[Reading]:
        for frame, omitted, first in self._splitter.split(data, b"\0"):
            reading = decode_frame(frame)
            if reading is not None:
                yield reading
            elif first:
                self._counters.fragments += bool(frame)
            elif frame:
                self._counters.reject(frame)
                self._counters.noise_bytes += omitted
