"""Binary packets of common sensors: WitMotion's over serial, and i2cdevlib's "teapot".

| WitMotion, 11 bytes | teapot, 14 bytes |
|---|---|
| 0x55, a kind 0x50 to 0x5F | `$`, 2 |
| four int16, little-endian | w x y z, four int16, big-endian, 1 is 16384 |
| the low byte of the sum of the ten | 0, a count, CR, LF |

WitMotion's is accepted by its sum alone. A teapot has no sum: its fixed bytes and the quaternion's
length, which is 1, are its check.
"""

from __future__ import annotations

import math
import struct
from abc import abstractmethod
from collections.abc import Iterator

from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGLES,
    ANGULAR_VELOCITY,
    QUATERNION,
    Counters,
    Decoder,
    Reading,
)

WIT = 11
WIT_NOTIFIED = 20
TEAPOT = 14
UNIT_LENGTH = 0.02
"""A quaternion's length may be off by so much."""

_FULL = 32768.0
WIT_KINDS = {
    0x51: (ACCELERATION, 16.0 / _FULL),
    0x52: (ANGULAR_VELOCITY, 2000.0 / _FULL),
    0x53: (ANGLES, 180.0 / _FULL),
    0x59: (QUATERNION, 1.0 / _FULL),
}
"""What a kind's numbers are, and what 1 of them is: g, deg/s, degrees."""

_WIT = struct.Struct("<2x4hx")
_TEAPOT = struct.Struct(">2x4hxBxx")


def wit_packet(packet: bytes) -> Reading | None:
    """What a packet of WitMotion's says: empty if nothing of use, None if its sum is wrong."""
    if len(packet) != WIT or packet[0] != 0x55 or packet[1] >> 4 != 5:
        return None
    if sum(packet[:-1]) & 0xFF != packet[-1]:
        return None
    columns, unit = WIT_KINDS.get(packet[1], ((), 0.0))
    return dict(
        zip(columns, (number * unit for number in _WIT.unpack(packet)), strict=False)
    )  # an acceleration's fourth is the temperature


def teapot_packet(packet: bytes) -> Reading | None:
    """The quaternion and count of a teapot; None if anything about it is wrong."""
    if len(packet) != TEAPOT or packet[:2] != b"$\2" or packet[10] or packet[12:] != b"\r\n":
        return None
    *numbers, count = _TEAPOT.unpack(packet)
    quaternion = [number / 16384.0 for number in numbers]
    if abs(math.hypot(*quaternion) - 1.0) > UNIT_LENGTH:
        return None
    return {"sequence": float(count), **dict(zip(QUATERNION, quaternion, strict=True))}


def as_wit_packets(notification: bytes) -> bytes:
    """A notification of WitMotion's by Bluetooth (55 61 and nine int16) as its wire's packets.

    It has no sum, as the radio checks what it carries; nothing if it isn't one.
    """
    if len(notification) != WIT_NOTIFIED or notification[:2] != b"\x55\x61":
        return b""
    packets = []
    for kind, at in ((0x51, 2), (0x52, 8), (0x53, 14)):
        packet = bytes([0x55, kind]) + notification[at : at + 6] + b"\0\0"
        packets.append(packet + bytes([sum(packet) & 0xFF]))
    return b"".join(packets)


class _PacketDecoder(Decoder):
    """Readings from packets of fixed length, found by their first byte."""

    def __init__(self, counters: Counters, first: bytes, length: int) -> None:
        super().__init__(counters)
        self._first, self._length = first, length
        self._pending = bytearray()
        self._found = False

    @abstractmethod
    def _read(self, packet: bytes) -> Reading | None:
        """What a packet says, None if it is none."""

    @abstractmethod
    def _joined(self, reading: Reading) -> Reading | None:
        """The reading that a packet completes, if it does."""

    def _decode(self, data: bytes) -> Iterator[Reading]:
        pending = self._pending
        pending += data
        noise = bytearray()
        at = 0
        while len(pending) - at >= self._length:
            read = self._read(bytes(pending[at : at + self._length]))
            if read is None:
                # look for the next start behind a byte that is none
                further = pending.find(self._first, at + 1)
                further = len(pending) if further < 0 else further
                noise += pending[at:further]
                at = further
                continue
            self._give_up(noise)
            at += self._length
            joined = self._joined(read)
            if joined:
                yield joined
        self._give_up(noise)
        del pending[:at]

    def _give_up(self, noise: bytearray) -> None:
        if noise and self._found:
            self._counters.refuse(noise)
        elif noise:
            self._counters.fragments += 1
        noise.clear()
        self._found = True


class WitDecoder(_PacketDecoder):
    """One reading of each round of packets, at the one that completes it."""

    def __init__(self, counters: Counters, columns: tuple[str, ...]) -> None:
        """`columns`: what a reading is made of, as `wit_columns`."""
        super().__init__(counters, b"\x55", WIT)
        self._columns = columns
        self._round: dict[str, float] = {}

    def _read(self, packet: bytes) -> Reading | None:
        return wit_packet(packet)

    def _joined(self, reading: Reading) -> Reading | None:
        if self._columns[0] in reading:
            self._round.clear()  # a round begins; what a lost packet left undone is given up
        self._round.update(reading)
        if self._columns[-1] not in reading or any(n not in self._round for n in self._columns):
            return None
        joined = {name: self._round[name] for name in self._columns}
        self._round.clear()
        return joined


class TeapotDecoder(_PacketDecoder):
    """Quaternions, numbered."""

    def __init__(self, counters: Counters) -> None:
        super().__init__(counters, b"$", TEAPOT)
        self._number = 0

    def _read(self, packet: bytes) -> Reading | None:
        return teapot_packet(packet)

    def _joined(self, reading: Reading) -> Reading | None:
        # the count has eight bits, a sequence number sixteen
        self._number += (int(reading["sequence"]) - self._number) % 256
        return {**reading, "sequence": float(self._number % 65536)}


def wit_columns(data: bytes) -> tuple[str, ...]:
    """The columns of a reading from packets on end in `data`; empty if it has fewer than two."""
    said: set[str] = set()
    packets = 0
    at = data.find(b"\x55")
    while 0 <= at <= len(data) - WIT:
        read = wit_packet(data[at : at + WIT])
        # on end: a second one follows, or one went before
        if read is None:
            packets = 0 if packets < 2 else packets
            at = data.find(b"\x55", at + 1)
            continue
        packets += 1
        said.update(read)
        at += WIT
    if packets < 2:
        return ()
    if ACCELERATION[0] in said:
        both = ANGULAR_VELOCITY[0] in said
        return ACCELERATION + ANGULAR_VELOCITY if both else ACCELERATION
    return next((names for names in (QUATERNION, ANGLES) if names[0] in said), ())


def teapots_on_end(data: bytes) -> bool:
    """Whether two teapots on end, their counts going on by one, are in `data`."""
    at = data.find(b"$\2")
    while 0 <= at <= len(data) - 2 * TEAPOT:
        first = teapot_packet(data[at : at + TEAPOT])
        second = teapot_packet(data[at + TEAPOT : at + 2 * TEAPOT])
        if first and second and (second["sequence"] - first["sequence"]) % 256 == 1:
            return True
        at = data.find(b"$\2", at + 1)
    return False
