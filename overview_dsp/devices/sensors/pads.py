"""Reports of game pads to readings: DualSense (Sony), Joy-Con and Pro Controller (Nintendo).

A port hands each report over behind its length, a byte (`framed`).

| DualSense, little-endian | at |
|---|---|
| id 0x01, 64 bytes (USB), or 0x31, 78 bytes with a CRC-32 at the end (Bluetooth) | 0 |
| the fields below, from byte 1, or from byte 2 by Bluetooth | |
| uint8 number of the report | +6 |
| int16 x, y, z of the gyroscope, then of the accelerometer | +15, +21 |
| uint32 clock, thirds of a microsecond | +27 |
| id 0x05, 41 bytes: what a deg/s and a g are of this very pad (Linux, hid-playstation.c) | 0 |

| Joy-Con, little-endian | at |
|---|---|
| id 0x30, 49 bytes or more | 0 |
| three samples, 5 ms apart, the oldest first: int16 x, y, z of acceleration, then of turning | 13 |

The layouts are those of the Linux kernel's drivers (hid-playstation, hid-nintendo).
"""

from __future__ import annotations

import struct
import zlib
from abc import abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from overview_dsp.devices.sensors.reading import (
    ACCELERATION,
    ANGULAR_VELOCITY,
    Counters,
    Decoder,
    Reading,
)

USB, BLUETOOTH, TRUE_UNITS, FULL = 0x01, 0x31, 0x05, 0x30
"""Ids of reports: DualSense by wire and by radio, its own units, Joy-Con."""

LENGTHS = {USB: 64, BLUETOOTH: 78, TRUE_UNITS: 41}
LONGEST = 255
JOYCON_LEAST = 49

_SIXTEEN = 1.0 / 32768.0
_DUALSENSE_G, _DUALSENSE_DEG_S = 4.0 * _SIXTEEN, 2048.0 * _SIXTEEN
_JOYCON_COLUMNS = ACCELERATION + ANGULAR_VELOCITY
_JOYCON_UNITS = (8.0 * _SIXTEEN,) * 3 + (2000.0 * _SIXTEEN,) * 3
_TICKS_A_SECOND = 3e6
_NEAR = 0.5
"""A pad's own unit is that of its kind to this, or is no unit."""

_MOTION = struct.Struct("<3h3hI")
_UNITS = struct.Struct("<17h")
_SAMPLE = struct.Struct("<3h3h")


def framed(report: bytes) -> bytes:
    """A report as a port hands it over; nothing of one that is none."""
    return bytes([len(report)]) + report if 0 < len(report) <= LONGEST else b""


@dataclass(frozen=True)
class PadUnits:
    """What 1 of each axis is: deg/s, and g from a zero on."""

    deg_s: tuple[float, ...] = (_DUALSENSE_DEG_S,) * 3
    g: tuple[float, ...] = (_DUALSENSE_G,) * 3
    zero: tuple[float, ...] = (0.0,) * 3


def dualsense_units(report: bytes) -> PadUnits | None:
    """What a DualSense says of its own units; None if it isn't that."""
    if len(report) != LENGTHS[TRUE_UNITS] or report[0] != TRUE_UNITS:
        return None
    numbers = _UNITS.unpack_from(report, 1)
    speed = numbers[9] + numbers[10]
    turned = [abs(plus) + abs(minus) for plus, minus in _pairs(numbers[3:9])]
    both = _pairs(numbers[11:17])
    if not all((*turned, *(plus - minus for plus, minus in both))):
        return None
    deg_s = tuple(speed / one for one in turned)
    g = tuple(2.0 / (plus - minus) for plus, minus in both)
    near = [one / _DUALSENSE_DEG_S for one in deg_s] + [one / _DUALSENSE_G for one in g]
    if not all(abs(one - 1.0) <= _NEAR for one in near):
        return None
    return PadUnits(deg_s, g, tuple(0.5 * (plus + minus) for plus, minus in both))


def _pairs(numbers: Sequence[int]) -> list[tuple[int, int]]:
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def dualsense_motion(report: bytes) -> tuple[int, int, tuple[int, ...], tuple[int, ...]] | None:
    """Number, clock, gyroscope and accelerometer of a report; None if it is none, or damaged."""
    if not report or len(report) != LENGTHS.get(report[0], 0):
        return None
    if report[0] == BLUETOOTH:
        # of what went before the report on the air, 0xA1, too
        if zlib.crc32(b"\xa1" + report[:-4]) != int.from_bytes(report[-4:], "little"):
            return None
        at = 2
    elif report[0] == USB:
        at = 1
    else:
        return None
    *numbers, clock = _MOTION.unpack_from(report, at + 15)
    return report[at + 6], clock, tuple(numbers[:3]), tuple(numbers[3:])


class _ReportDecoder(Decoder):
    """Readings from reports behind their lengths."""

    def __init__(self, counters: Counters) -> None:
        super().__init__(counters)
        self._pending = bytearray()

    def _decode(self, data: bytes) -> Iterator[Reading]:
        pending = self._pending
        pending += data
        while pending and len(pending) > pending[0]:
            report = bytes(pending[1 : 1 + pending[0]])
            del pending[: 1 + pending[0]]
            found = self._read(report)
            if found is None:
                self._counters.refuse(report)
            else:
                yield from found

    @abstractmethod
    def _read(self, report: bytes) -> list[Reading] | None:
        """The readings of one report; None for one that can't be read."""


class DualSenseDecoder(_ReportDecoder):
    """Readings in g, deg/s and the pad's own seconds, numbered."""

    def __init__(self, counters: Counters) -> None:
        super().__init__(counters)
        self._units = PadUnits()
        self._number = 0
        self._clock: int | None = None
        self._ticks = 0

    def _read(self, report: bytes) -> list[Reading] | None:
        if report[:1] == bytes([TRUE_UNITS]):
            units = dualsense_units(report)
            self._units = units or self._units
            return None if units is None else []
        found = dualsense_motion(report)
        if found is None:
            return None
        number, clock, turning, pulled = found
        self._number += (number - self._number) % 256
        self._ticks += 0 if self._clock is None else (clock - self._clock) % (1 << 32)
        self._clock = clock
        units = self._units
        reading = {"t_s": self._ticks / _TICKS_A_SECOND, "sequence": float(self._number % 65_536)}
        for n in range(3):
            reading[ACCELERATION[n]] = (pulled[n] - units.zero[n]) * units.g[n]
            reading[ANGULAR_VELOCITY[n]] = turning[n] * units.deg_s[n]
        return [reading]


class JoyConDecoder(_ReportDecoder):
    """Readings in g and deg/s, three of a report."""

    def _read(self, report: bytes) -> list[Reading] | None:
        if len(report) < JOYCON_LEAST or report[0] != FULL:
            return None
        samples = _SAMPLE.iter_unpack(report[13 : 13 + 3 * _SAMPLE.size])
        return [
            {
                name: number * unit
                for name, number, unit in zip(_JOYCON_COLUMNS, numbers, _JOYCON_UNITS, strict=True)
            }
            for numbers in samples
        ]
