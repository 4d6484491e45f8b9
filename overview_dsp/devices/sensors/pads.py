"""Reports of game pads: DualSense (Sony), Joy-Con and Pro Controller (Nintendo).

A port passes each report on after one byte with its length (`framed`).

| DualSense, little-endian | at |
|---|---|
| id 0x01, 64 bytes (USB), or 0x31, 78 bytes with a CRC-32 at the end (Bluetooth) | 0 |
| the fields below, from byte 1, or from byte 2 over Bluetooth | |
| uint8 number of the report | +6 |
| int16 x, y, z of the gyroscope, then of the accelerometer | +15, +21 |
| uint32 clock, thirds of a microsecond | +27 |
| id 0x05, 41 bytes: calibration of this pad in deg/s and g (Linux, hid-playstation.c) | 0 |

| Joy-Con, little-endian | at |
|---|---|
| id 0x30, 49 bytes or more | 0 |
| three samples, 5 ms apart, oldest first: int16 x, y, z of acceleration, of the gyroscope | 13 |

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
    INERTIAL,
    Counters,
    Decoder,
    Reading,
)

USB, BLUETOOTH, CALIBRATION, FULL = 0x01, 0x31, 0x05, 0x30
"""Report ids: DualSense over USB, over Bluetooth, its calibration; Joy-Con."""

LENGTHS = {USB: 64, BLUETOOTH: 78, CALIBRATION: 41}
LONGEST = 255
JOYCON_SHORTEST = 49

_BIT = 1.0 / 32768.0
_DUALSENSE_G, _DUALSENSE_DEG_S = 4.0 * _BIT, 2048.0 * _BIT
_JOYCON_UNITS = (8.0 * _BIT,) * 3 + (2000.0 * _BIT,) * 3
_TICKS_PER_SECOND = 3e6
_TOLERANCE = 0.5  # largest relative deviation of a pad's calibration from the nominal value
_MOTION = struct.Struct("<3h3hI")
_CALIBRATION = struct.Struct("<17h")
_SAMPLE = struct.Struct("<3h3h")


def framed(report: bytes) -> bytes:
    """Return a report as a port passes it on; empty for an invalid report."""
    return bytes([len(report)]) + report if 0 < len(report) <= LONGEST else b""


@dataclass(frozen=True)
class PadUnits:
    """Value of 1 count of each axis in deg/s and in g, and the zero of the acceleration."""

    deg_s: tuple[float, ...] = (_DUALSENSE_DEG_S,) * 3
    g: tuple[float, ...] = (_DUALSENSE_G,) * 3
    zero: tuple[float, ...] = (0.0,) * 3


def dualsense_units(report: bytes) -> PadUnits | None:
    """Return the calibration in a report of a DualSense; None if the report is invalid."""
    if len(report) != LENGTHS[CALIBRATION] or report[0] != CALIBRATION:
        return None
    numbers = _CALIBRATION.unpack_from(report, 1)
    speed = numbers[9] + numbers[10]
    gyroscope = [abs(plus) + abs(minus) for plus, minus in _pairs(numbers[3:9])]
    acceleration = _pairs(numbers[11:17])
    if not all((*gyroscope, *(plus - minus for plus, minus in acceleration))):
        return None
    deg_s = tuple(speed / one for one in gyroscope)
    g = tuple(2.0 / (plus - minus) for plus, minus in acceleration)
    ratios = [one / _DUALSENSE_DEG_S for one in deg_s] + [one / _DUALSENSE_G for one in g]
    if not all(abs(one - 1.0) <= _TOLERANCE for one in ratios):
        return None
    return PadUnits(deg_s, g, tuple(0.5 * (plus + minus) for plus, minus in acceleration))


def _pairs(numbers: Sequence[int]) -> list[tuple[int, int]]:
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def dualsense_motion(report: bytes) -> tuple[int, int, tuple[int, ...], tuple[int, ...]] | None:
    """Return number, clock, gyroscope and accelerometer of a report; None if it is invalid."""
    if not report or len(report) != LENGTHS.get(report[0], 0):
        return None
    if report[0] == BLUETOOTH:
        # the check includes 0xA1, which precedes the report on the radio link
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
    """Readings from reports that follow their lengths."""

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
                self._counters.reject(report)
            else:
                yield from found

    @abstractmethod
    def _read(self, report: bytes) -> list[Reading] | None:
        """Return the readings of one report; None for an invalid one."""


class DualSenseDecoder(_ReportDecoder):
    """Numbered readings in g, deg/s and seconds of the pad's clock."""

    def __init__(self, counters: Counters) -> None:
        super().__init__(counters)
        self._units = PadUnits()
        self._number = 0
        self._clock: int | None = None
        self._ticks = 0

    def _read(self, report: bytes) -> list[Reading] | None:
        if report[:1] == bytes([CALIBRATION]):
            units = dualsense_units(report)
            self._units = units or self._units
            return None if units is None else []
        found = dualsense_motion(report)
        if found is None:
            return None
        number, clock, gyroscope, acceleration = found
        self._number += (number - self._number) % 256
        self._ticks += 0 if self._clock is None else (clock - self._clock) % (1 << 32)
        self._clock = clock
        units = self._units
        reading = {"t_s": self._ticks / _TICKS_PER_SECOND, "sequence": float(self._number % 65_536)}
        for n in range(3):
            reading[ACCELERATION[n]] = (acceleration[n] - units.zero[n]) * units.g[n]
            reading[ANGULAR_VELOCITY[n]] = gyroscope[n] * units.deg_s[n]
        return [reading]


class JoyConDecoder(_ReportDecoder):
    """Readings in g and deg/s, three per report."""

    def _read(self, report: bytes) -> list[Reading] | None:
        if len(report) < JOYCON_SHORTEST or report[0] != FULL:
            return None
        samples = _SAMPLE.iter_unpack(report[13 : 13 + 3 * _SAMPLE.size])
        return [
            {name: n * unit for name, n, unit in zip(INERTIAL, one, _JOYCON_UNITS, strict=True)}
            for one in samples
        ]
