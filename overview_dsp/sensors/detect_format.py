"""What a stream of bytes is, detected from its content where that is safe."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from overview_dsp.sensors.frames import FrameDecoder
from overview_dsp.sensors.json_lines import reading_of
from overview_dsp.sensors.lines import LineDecoder, LineSplitter
from overview_dsp.sensors.reading import ACCELERATION, ANGULAR_VELOCITY, Counters, Reading
from overview_dsp.sensors.text_lines import columns_of, numbers_of
from overview_dsp.sensors.text_lines import reading_of as text_reading_of

Format = Literal["frames", "json", "text"]

FRAMES = 2
LINES = 5
"""So many in a row say what a stream is: frames are checked, lines are not."""

ENOUGH = 4096
"""Bytes in which nothing was understood that say that nothing will be."""


class Decoder(Protocol):
    """Bytes in, readings out."""

    def feed(self, data: bytes) -> list[Reading]:
        """The readings that these bytes complete."""


@dataclass(frozen=True)
class DetectedFormat:
    """What a stream is: its format, and for text its columns."""

    format: Format
    columns: tuple[str, ...] = ()

    def decoder(self, counters: Counters) -> Decoder:
        """What reads such a stream."""
        if self.format == "frames":
            return FrameDecoder(counters)
        if self.format == "json":
            return LineDecoder(counters, reading_of)
        return LineDecoder(counters, lambda line: text_reading_of(line, self.columns))

    def __str__(self) -> str:
        names = {"frames": "binary frames", "json": "JSON lines", "text": "lines of "}
        return names[self.format] + ",".join(self.columns)


def detect(data: bytes) -> DetectedFormat | str | None:
    """What a stream is from the bytes so far, why it can't be detected, or None: not yet."""
    if len(FrameDecoder(Counters()).feed(data)) >= FRAMES:
        return DetectedFormat("frames")
    counters = Counters()
    lines = LineSplitter(counters).feed(data)
    if len(lines) < LINES:
        return _unknown(data)
    latest = lines[-LINES:]
    if all(reading_of(line) is not None for line in latest):
        return DetectedFormat("json")
    rows = [numbers_of(line) for line in latest]
    counts = {len(row) for row in rows if row is not None}
    if None in rows or len(counts) != 1:
        return _unknown(data)
    headers = [found for found in map(columns_of, lines) if found is not None]
    return _text(latest, counts.pop(), headers[-1] if headers else ())


def _unknown(data: bytes) -> str | None:
    if len(data) < ENOUGH:
        return None
    return (
        f"{len(data)} bytes, and no frame or line that is understood; is the speed (--baud) the "
        "device's? its format can be said with --sensor FILE.toml"
    )


def _text(lines: list[str], count: int, header: tuple[str, ...]) -> DetectedFormat | str:
    if len(header) == count:
        return DetectedFormat("text", header)
    if count == len(ACCELERATION):
        return DetectedFormat("text", ACCELERATION)
    if count == len(ACCELERATION + ANGULAR_VELOCITY):
        return DetectedFormat("text", ACCELERATION + ANGULAR_VELOCITY)
    example = lines[-1][:60]
    if count > 1:
        return (
            f"lines of {count} numbers ({example!r}): which is which? say it with --sensor "
            'FILE.toml (columns = ["t_us", "ax", ...]) or send a line of the names first'
        )
    values = [float(line) for line in lines]
    if all("." in line for line in lines) and all(abs(value) <= 180.0 for value in values):
        return DetectedFormat("text", ("roll_deg",))
    return (
        f"lines of one number ({example!r}): degrees, an encoder's count or a potentiometer? "
        "say it with --sensor roll, --sensor encoder or --sensor potentiometer"
    )
