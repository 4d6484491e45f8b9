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
| id 0x21, with 0x10 at 14: bytes read from its memory: address, count, the bytes | 15, 19, 20 |

The layouts and the scales are those of the Linux kernel's drivers (hid-playstation, hid-nintendo).
A Joy-Con has 4096 per g and 14.247 per deg/s (a count is 15 % more than 2000 deg/s / 32768). Its
memory has four int16 x, y, z of a calibration: offset and scale of the acceleration, then of the
gyroscope, at 0x6020 by the maker and, if 0xB2 0xA1 precede it, at 0x8028 by the user.
"""

from __future__ import annotations

import struct
import zlib
from abc import abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from overview_dsp.devices.sensors.reading import INERTIAL, Counters, Decoder, Reading

USB, BLUETOOTH, CALIBRATION, FULL, REPLY = 0x01, 0x31, 0x05, 0x30, 0x21
"""Report ids: DualSense over USB, over Bluetooth, its calibration; Joy-Con, and its replies."""

READ_MEMORY, FACTORY, USER, USER_MARK = 0x10, 0x6020, 0x8026, b"\xb2\xa1"
JOYCON_MEMORY = ((FACTORY, 24), (USER, 26))  # address and count of a Joy-Con's calibrations

LENGTHS = {USB: 64, BLUETOOTH: 78, CALIBRATION: 41}
LONGEST = 255
JOYCON_SHORTEST = 49

_BIT = 1.0 / 32768.0
_DUALSENSE_UNITS = (4.0 * _BIT,) * 3 + (2048.0 * _BIT,) * 3
_JOYCON_UNITS = (1.0 / 4096.0,) * 3 + (1.0 / 14.247,) * 3
_MEMORY = struct.Struct("<12h")
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
    """Value of 1 count of each axis of `INERTIAL` (g, deg/s), and the axes' zeros."""

    values: tuple[float, ...]
    zeros: tuple[float, ...] = (0.0,) * 6

    def reading(self, counts: Sequence[int]) -> dict[str, float]:
        """Return the reading of the counts of all axes."""
        axes = zip(INERTIAL, counts, self.zeros, self.values, strict=True)
        return {name: (n - zero) * value for name, n, zero, value in axes}


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
    values = (*g, *deg_s)
    nominal = zip(values, _DUALSENSE_UNITS, strict=True)
    if not all(abs(one / unit - 1.0) <= _TOLERANCE for one, unit in nominal):
        return None
    zeros = (0.5 * (plus + minus) for plus, minus in acceleration)
    return PadUnits(values, (*zeros, 0.0, 0.0, 0.0))


def _pairs(numbers: Sequence[int]) -> list[tuple[int, int]]:
    return list(zip(numbers[::2], numbers[1::2], strict=True))


def dualsense_motion(report: bytes) -> tuple[int, int, list[int]] | None:
    """Return number, clock and counts of the axes of a report; None if it is invalid."""
    at = {USB: 1, BLUETOOTH: 2}.get(report[0]) if report else None
    if at is None or len(report) != LENGTHS[report[0]]:
        return None
    # the check includes 0xA1, which precedes the report on the radio link
    check = int.from_bytes(report[-4:], "little")
    if report[0] == BLUETOOTH and zlib.crc32(b"\xa1" + report[:-4]) != check:
        return None
    *numbers, clock = _MOTION.unpack_from(report, at + 15)
    return report[at + 6], clock, numbers[3:] + numbers[:3]


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
        self._units = PadUnits(_DUALSENSE_UNITS)
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
        number, clock, counts = found
        self._number += (number - self._number) % 256
        self._ticks += 0 if self._clock is None else (clock - self._clock) % (1 << 32)
        self._clock = clock
        stamps = {"t_s": self._ticks / _TICKS_PER_SECOND, "sequence": float(self._number % 65_536)}
        return [stamps | self._units.reading(counts)]


def joycon_units(report: bytes) -> tuple[int, PadUnits] | None:
    """Return the address and the calibration in a reply; None without one."""
    address = int.from_bytes(report[15:19], "little")
    if report[14:15] != bytes([READ_MEMORY]) or (address, report[19]) not in JOYCON_MEMORY:
        return None
    data, mark = report[20 : 20 + report[19]], USER_MARK if address == USER else b""
    if not data.startswith(mark) or len(data) < len(mark) + _MEMORY.size:
        return None
    numbers = _MEMORY.unpack_from(data, len(mark))
    offsets, scales = (*numbers[:3], *numbers[6:9]), (*numbers[3:6], *numbers[9:12])
    ranges = [(scale, scale - offset) for offset, scale in zip(offsets, scales, strict=True)]
    if not all(span and abs(scale / span - 1.0) <= _TOLERANCE for scale, span in ranges):
        return None
    units = tuple(u * scale / span for u, (scale, span) in zip(_JOYCON_UNITS, ranges, strict=True))
    return address, PadUnits(units, (0.0, 0.0, 0.0, *offsets[3:]))


class JoyConDecoder(_ReportDecoder):
    """Readings in g and deg/s, three per report; a calibration of the user precedes the maker's."""

    def __init__(self, counters: Counters) -> None:
        super().__init__(counters)
        self._calibrations = {0: PadUnits(_JOYCON_UNITS)}

    def _read(self, report: bytes) -> list[Reading] | None:
        if len(report) < JOYCON_SHORTEST or report[0] not in (FULL, REPLY):
            return None
        if report[0] == REPLY:
            if (found := joycon_units(report)) is not None:
                self._calibrations[found[0]] = found[1]
            return []
        units = self._calibrations[max(self._calibrations)]
        samples = _SAMPLE.iter_unpack(report[13 : 13 + 3 * _SAMPLE.size])
        return [units.reading(one) for one in samples]
