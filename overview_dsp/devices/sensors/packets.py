"""Binary packets of common sensors: WitMotion over a serial port, and i2cdevlib's "teapot".

| WitMotion, 11 bytes | teapot, 14 bytes |
|---|---|
| 0x55, a kind 0x50 to 0x5F | `$`, 2 |
| four int16, little-endian | w x y z, four int16, big-endian, 1 is 16384 |
| the low byte of the sum of the ten | 0, a count, CR, LF |

The sum alone validates a WitMotion packet. A teapot packet has no sum: its fixed bytes and the
length of its quaternion, which is 1, validate it.
"""

from __future__ import annotations

import math
import struct
from abc import abstractmethod
from collections.abc import Callable, Iterator

from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    ANGULAR_VELOCITY,
    INERTIAL,
    QUATERNION,
    Counters,
    Decoder,
    Reading,
    has,
)

WIT = 11
WIT_NOTIFICATION = 20
TEAPOT = 14
LENGTH_TOLERANCE = 0.02  # largest deviation of a quaternion's length from 1
_FULL_SCALE = 32768.0
WIT_KINDS = {
    0x51: (ACCELERATION, 16.0 / _FULL_SCALE),
    0x52: (ANGULAR_VELOCITY, 2000.0 / _FULL_SCALE),
    0x53: (ANGLES, 180.0 / _FULL_SCALE),
    0x59: (QUATERNION, 1.0 / _FULL_SCALE),
}
"""Columns of a kind, and the value of 1 count: g, deg/s, degrees."""

_WIT = struct.Struct("<2x4hx")
_TEAPOT = struct.Struct(">2x4hxBxx")


def wit_packet(packet: bytes) -> Reading | None:
    """Return the data of a WitMotion packet; empty without usable data, None if it is invalid."""
    if len(packet) != WIT or packet[0] != 0x55 or packet[1] >> 4 != 5:
        return None
    if sum(packet[:-1]) & 0xFF != packet[-1]:
        return None
    columns, unit = WIT_KINDS.get(packet[1], ((), 0.0))
    return dict(
        zip(columns, (number * unit for number in _WIT.unpack(packet)), strict=False)
    )  # the fourth number of an acceleration is the temperature


def teapot_packet(packet: bytes) -> Reading | None:
    """Return the quaternion and count of a teapot packet; None if it is invalid."""
    if len(packet) != TEAPOT or packet[:2] != b"$\2" or packet[10] or packet[12:] != b"\r\n":
        return None
    *numbers, count = _TEAPOT.unpack(packet)
    quaternion = [number / 16384.0 for number in numbers]
    if abs(math.hypot(*quaternion) - 1.0) > LENGTH_TOLERANCE:
        return None
    return {"sequence": float(count), **dict(zip(QUATERNION, quaternion, strict=True))}


def packets_from_notification(notification: bytes) -> bytes:
    """Return WitMotion's Bluetooth notification (55 61 and nine int16) as its serial packets.

    A notification has no sum, as the radio link checks its data. An invalid one gives no bytes.
    """
    if len(notification) != WIT_NOTIFICATION or notification[:2] != b"\x55\x61":
        return b""
    packets = []
    for kind, at in ((0x51, 2), (0x52, 8), (0x53, 14)):
        packet = bytes([0x55, kind]) + notification[at : at + 6] + b"\0\0"
        packets.append(packet + bytes([sum(packet) & 0xFF]))
    return b"".join(packets)


class _PacketDecoder(Decoder):
    """Readings from packets of fixed length, found by their first byte."""

    def __init__(
        self, counters: Counters, first: bytes, length: int, read: Callable[[bytes], Reading | None]
    ) -> None:
        """Look for packets; `read` returns the data of a packet, None for an invalid one."""
        super().__init__(counters)
        self._first, self._length, self._read = first, length, read
        self._pending = bytearray()
        self._synchronised = False

    @abstractmethod
    def _join(self, data: Reading) -> Reading | None:
        """Return the reading that a packet's data complete, if any."""

    def _decode(self, data: bytes) -> Iterator[Reading]:
        pending = self._pending
        pending += data
        noise = bytearray()
        at = 0
        while len(pending) - at >= self._length:
            read = self._read(bytes(pending[at : at + self._length]))
            if read is None:
                # look for the next first byte
                next_at = pending.find(self._first, at + 1)
                next_at = len(pending) if next_at < 0 else next_at
                noise += pending[at:next_at]
                at = next_at
                continue
            self._count_noise(noise)
            at += self._length
            joined = self._join(read)
            if joined:
                yield joined
        self._count_noise(noise)
        del pending[:at]

    def _count_noise(self, noise: bytearray) -> None:
        if noise and self._synchronised:
            self._counters.reject(noise)
        elif noise:
            self._counters.fragments += 1
        noise.clear()
        self._synchronised = True


class WitDecoder(_PacketDecoder):
    """One reading per cycle of packets, at the packet that completes it."""

    def __init__(self, counters: Counters, columns: tuple[str, ...]) -> None:
        """Make readings with `columns`, as `wit_columns` returns them."""
        super().__init__(counters, b"\x55", WIT, wit_packet)
        self._columns = columns
        self._cycle: dict[str, float] = {}

    def _join(self, data: Reading) -> Reading | None:
        if self._columns[0] in data:
            self._cycle.clear()  # a new cycle; an incomplete one is dropped
        self._cycle.update(data)
        if self._columns[-1] not in data or not has(self._cycle, self._columns):
            return None
        joined = {name: self._cycle[name] for name in self._columns}
        self._cycle.clear()
        return joined


class TeapotDecoder(_PacketDecoder):
    """Quaternions with sequence numbers."""

    def __init__(self, counters: Counters) -> None:
        super().__init__(counters, b"$", TEAPOT, teapot_packet)
        self._number = 0

    def _join(self, data: Reading) -> Reading | None:
        # the count has eight bits, a sequence number sixteen
        self._number += (int(data["sequence"]) - self._number) % 256
        return {**data, "sequence": float(self._number % 65536)}


def wit_columns(data: bytes) -> tuple[str, ...]:
    """Return the columns of consecutive packets in `data`; empty with fewer than two packets."""
    found: set[str] = set()
    packets = 0
    at = data.find(b"\x55")
    while 0 <= at <= len(data) - WIT:
        read = wit_packet(data[at : at + WIT])
        if read is None:  # one packet without a successor doesn't count
            packets = 0 if packets < 2 else packets
            at = data.find(b"\x55", at + 1)
            continue
        packets += 1
        found.update(read)
        at += WIT
    if packets < 2:
        return ()
    if ACCELERATION[0] in found:
        return INERTIAL if ANGULAR_VELOCITY[0] in found else ACCELERATION
    return next((names for names in (QUATERNION, ANGLES) if names[0] in found), ())


def has_teapots(data: bytes) -> bool:
    """Return whether `data` has two consecutive teapot packets with consecutive counts."""
    at = data.find(b"$\2")
    while 0 <= at <= len(data) - 2 * TEAPOT:
        first = teapot_packet(data[at : at + TEAPOT])
        second = teapot_packet(data[at + TEAPOT : at + 2 * TEAPOT])
        if first and second and (second["sequence"] - first["sequence"]) % 256 == 1:
            return True
        at = data.find(b"$\2", at + 1)
    return False
