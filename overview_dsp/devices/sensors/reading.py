"""One sample of a sensor, the counters of a stream, and the base class of the decoders."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from overview_dsp.files.toml import load_toml

COLUMNS: Mapping[str, str] = load_toml(__file__, "quantities.toml")
"""Names of the quantities that a sensor can send, each in the sensor's own unit."""

ACCELERATION = ("ax", "ay", "az")
ANGULAR_VELOCITY = ("gx", "gy", "gz")
INERTIAL = ACCELERATION + ANGULAR_VELOCITY
QUATERNION = ("qw", "qx", "qy", "qz")
ANGLES = ("angle_1", "angle_2", "angle_3")
SKIPPED = "_"  # name of a column that isn't read; the only name that may occur several times
STAMPS = ("t_us", "t_ms", "t_s")
Reading = Mapping[str, float]  # one sample: values by the names of `COLUMNS`; all finite


def touch_state(reading: Reading) -> bool | None:
    """Return whether the device is touched; None if the sensor doesn't detect touch."""
    return reading["touch"] > 0.5 if "touch" in reading else None


@dataclass(frozen=True)
class AngleSample:
    """Time (s), theta2 (rad), whether a tap-tap ended then, and the touch if the sensor has one.

    `reliable` is False where theta2 is held because it isn't known.
    """

    time_s: float
    theta2: float
    tapped: bool = False
    touch: bool | None = None
    reliable: bool = True


def has(reading: Collection[str], columns: Iterable[str]) -> bool:
    """Return whether `reading` has all of `columns`."""
    return all(name in reading for name in columns)


@dataclass
class Counters:
    """Counts of received data and of its faults; no fault ends a session.

    `received_bytes`, `readings`: received bytes, and readings decoded from them.
    `fragments`: pieces at the start of a stream that were already under way when it was opened.
    `damaged`: invalid frames or lines: a wrong check, a wrong length, a word instead of a number.
    `noise_bytes`: bytes in those.
    `lost`: samples missing according to the sequence numbers.
    `repeated`: samples that came twice; the second is dropped.
    `disordered`: samples with a stamp before the previous one; dropped.
    `clock_wraps`, `clock_restarts`: times the sensor's clock passed its highest count, or started
        again.
    `implausible`: samples beyond the range of the sensor; dropped.
    `overrun_bytes`: bytes dropped because they arrived faster than they were read.
    """

    received_bytes: int = 0
    readings: int = 0
    fragments: int = 0
    damaged: int = 0
    noise_bytes: int = 0
    lost: int = 0
    repeated: int = 0
    disordered: int = 0
    clock_wraps: int = 0
    clock_restarts: int = 0
    implausible: int = 0
    overrun_bytes: int = 0

    def reject(self, piece: bytes | bytearray) -> None:
        """Count an invalid piece of the stream."""
        self.damaged += 1
        self.noise_bytes += len(piece)


class Decoder(ABC):
    """Incremental decoder: bytes, split anywhere, to readings."""

    def __init__(self, counters: Counters) -> None:
        """Count received data and faults in `counters`."""
        self._counters = counters

    def feed(self, data: bytes) -> list[Reading]:
        """Return the readings that these bytes complete."""
        self._counters.received_bytes += len(data)
        readings = list(self._decode(data))
        self._counters.readings += len(readings)
        return readings

    @abstractmethod
    def _decode(self, data: bytes) -> Iterable[Reading]:
        """Return the readings as `feed` does, without counting them."""
