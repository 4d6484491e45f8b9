"""What a sensor says at one instant, and what was counted on the way there."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

COLUMNS: Mapping[str, str] = {
    "t_us": "the sensor's clock, microseconds",
    "t_ms": "the sensor's clock, milliseconds",
    "t_s": "the sensor's clock, seconds",
    "sequence": "number of the sample, counting up, modulo 65536",
    "ax": "acceleration along the sensor's x; upwards is positive at rest",
    "ay": "acceleration along y",
    "az": "acceleration along z",
    "gx": "angular velocity about the sensor's x, right-handed",
    "gy": "angular velocity about y",
    "gz": "angular velocity about z",
    "qw": "orientation of the sensor towards the earth, a quaternion: its real part",
    "qx": "its part along x",
    "qy": "its part along y",
    "qz": "its part along z",
    "angle_1": "the first of three angles, degrees; which is the twist is found by turning once",
    "angle_2": "the second",
    "angle_3": "the third",
    "roll_deg": "roll, degrees: 0 face up, 180 or -180 face down",
    "count": "counts of an encoder",
    "pot": "wiper of a potentiometer",
    "motor_target": "target that a motor applies, A or V",
    "shaft_rad": "angle of a motor's shaft, rad",
    "touch": "1 while the hand holds on, else 0",
}
"""Names of what a sensor may say, each in the sensor's own unit."""

ACCELERATION = ("ax", "ay", "az")
ANGULAR_VELOCITY = ("gx", "gy", "gz")
QUATERNION = ("qw", "qx", "qy", "qz")
ANGLES = ("angle_1", "angle_2", "angle_3")
SKIPPED = "_"
"""The name of a column that isn't read; the only one that may come twice."""

STAMPS = ("t_us", "t_ms", "t_s")

Reading = Mapping[str, float]
"""One sample: values by the names of `COLUMNS`; all finite."""


@dataclass
class Counters:
    """What came and what was wrong with it; nothing of this stops a session.

    Attributes
    ----------
    received_bytes, readings
        Received, and understood of them.
    fragments
        Pieces at the start of a stream, cut in two by the moment of listening.
    damaged
        Frames or lines that are none: a failing check, a wrong length, a word for a number.
    noise_bytes
        Bytes in those.
    lost
        Samples missing by the sequence numbers.
    repeated
        Samples that came twice; the second is dropped.
    disordered
        Samples with a stamp before the last one's; dropped.
    clock_wraps, clock_restarts
        The sensor's clock passed its highest count, or began again.
    implausible
        Samples beyond what the sensor can say; dropped.
    overrun_bytes
        Bytes given up because more came than could be read.
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

    def refuse(self, piece: bytes | bytearray) -> None:
        """Count a piece that is no reading."""
        self.damaged += 1
        self.noise_bytes += len(piece)


class Decoder(ABC):
    """Readings from bytes that come in any cuts."""

    def __init__(self, counters: Counters) -> None:
        """What comes, and what is wrong with it, is counted in `counters`."""
        self._counters = counters

    def feed(self, data: bytes) -> list[Reading]:
        """The readings that these bytes complete."""
        self._counters.received_bytes += len(data)
        readings = list(self._decode(data))
        self._counters.readings += len(readings)
        return readings

    @abstractmethod
    def _decode(self, data: bytes) -> Iterable[Reading]:
        """As `feed`, which counts."""
