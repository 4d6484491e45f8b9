"""WFDB header files (.hea): what a record holds, checked before any signal is read.

Format: header(5) of the WFDB Applications Guide, https://physionet.org/physiotools/wag/header-5.htm.
A record line, then one line a signal (or a segment); `#` begins a comment.
"""

from __future__ import annotations

import math
import re
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta
from fractions import Fraction
from pathlib import Path

from overview_dsp import validation
from overview_dsp.data.readers.data_file import printable_path
from overview_dsp.data.readers.tables.time_column import as_number
from overview_dsp.data.timeline.time_parsing import clock_s, moment
from overview_dsp.errors import InputError, shown

MAX_HEADER_BYTES = 1 << 20
MAX_SIGNALS = 1024
MAX_FRAME = 65_536
"""Most samples of one frame, all signals together."""

DEFAULT_RATE = 250.0
"""Frames a second where the header gives none (header(5))."""

NO_FILE = "~"
"""The name of a signal or segment that isn't there."""

BYTES: dict[str, Fraction | None] = {
    "8": Fraction(1), "16": Fraction(2), "24": Fraction(3), "32": Fraction(4), "61": Fraction(2),
    "80": Fraction(1), "160": Fraction(2), "212": Fraction(3, 2), "310": Fraction(4, 3),
    "311": Fraction(4, 3), "508": None, "516": None, "524": None,
}  # fmt: skip
"""Formats that can be read and their bytes a sample; None = compressed (FLAC)."""

_RECORD = re.compile(
    r"""(?P<name>[-\w]+)(?:/(?P<segments>\d+))?
    \s+(?P<signals>\d+)
    (?:\s+(?P<rate>\S+?)(?:/(?P<counter>[^\s(]*)(?:\([^\s)]*\))?)?
    (?:\s+(?P<length>\S+)
    (?:\s+(?P<time>\S+)
    (?:\s+(?P<date>\S+))?)?)?)?\s*""",
    re.VERBOSE | re.ASCII,
)
_SIGNAL = re.compile(
    r"""(?P<file>\S+)\s+(?P<format>\d+)(?:x(?P<frame>\d+))?(?::(?P<skew>\d+))?(?:\+(?P<offset>\d+))?
    (?:\s+(?P<gain>[^\s(/]+)(?:\((?P<baseline>-?\d+)\))?(?:/(?P<units>\S+))?
    (?:\s+-?\d+){0,5}
    (?:\s+(?P<name>\S.*?))?)?\s*""",
    re.VERBOSE | re.ASCII,
)
_SEGMENT = re.compile(r"(?P<name>~|[-\w]+)\s+(?P<length>\d+)\s*", re.ASCII)
_FILE_NAME = re.compile(r"[-\w]+(\.[-\w]+)*", re.ASCII)


@dataclass(frozen=True)
class HeaderSignal:
    """One signal of a record.

    `frame` samples are stored each frame; `offset` is where the file's data begin, bytes.
    """

    name: str
    file: str
    format: str
    frame: int = 1
    offset: int = 0
    units: str = "mV"


@dataclass(frozen=True)
class Header:
    """What a header says.

    Parameters
    ----------
    path
        The header file.
    name
        The record's name.
    rate
        Frames a second.
    frames
        Length, None where the header leaves it to the signal files.
    signals
        In the order of the file; none for a record of segments.
    segments
        (record name or `~`, frames), in order.
    start
        The date and time of frame 0, where both are there.
    """

    path: Path
    name: str
    rate: float
    frames: int | None
    signals: tuple[HeaderSignal, ...] = ()
    segments: tuple[tuple[str, int], ...] = ()
    start: datetime | None = None

    @property
    def where(self) -> str:
        """The path, printable."""
        return printable_path(self.path)

    def beside(self, name: str) -> Path:
        """Return the path of a file of the record."""
        return self.path.parent / name

    def files(self) -> Iterator[tuple[str, list[HeaderSignal], Fraction | None]]:
        """Yield each signal file, its signals, and its bytes a frame (None: compressed)."""
        for file in dict.fromkeys(signal.file for signal in self.signals if signal.file != NO_FILE):
            group = [signal for signal in self.signals if signal.file == file]
            size = BYTES[group[0].format]
            yield file, group, size and size * sum(signal.frame for signal in group)


def looks_like_header(text: str) -> bool:
    """Return whether text begins as a header: a record line and a line for its first signal."""
    lines = [line.strip() for line in text.splitlines()[:200]]
    lines = [line for line in lines if line and not line.startswith("#")]
    record = _RECORD.fullmatch(lines[0]) if lines else None
    if record is None:
        return False
    if record["segments"]:
        return len(lines) > 1 and _SEGMENT.fullmatch(lines[1]) is not None
    if int(record["signals"][:9]) == 0:  # annotations alone
        return len(lines) == 1 and record["rate"] is not None
    signal = _SIGNAL.fullmatch(lines[1]) if len(lines) > 1 else None
    # two rows of a table of numbers look like it too
    table = re.compile(r"[-+\d.eE\s]*").fullmatch(lines[0] + lines[-1 if signal is None else 1])
    return signal is not None and signal["format"] in {*BYTES, "0"} and table is None


def read_header(path: Path) -> Header:
    """Read a header and check that the files it names are there and long enough.

    Raises
    ------
    InputError
        Names the line: a line or value that is none, a signal file outside the record's folder,
        missing or too short, a format that can't be read.
    """
    where = printable_path(path)
    with validation.located(f"{where}: "):
        header = parse_header(_text(path), path)
        _check_files(header)
    return header


def parse_header(text: str, path: Path) -> Header:
    """Make a Header of a header file's text; InputError names the line."""
    lines = [
        (number, line.strip())
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise InputError("no record line; a header begins with name, signals, rate, length")
    number, line = lines[0]
    with validation.located(f"line {number}: "):
        found = _matched(_RECORD, line, "a record line", "100 2 360 650000")
        count = _whole(found["signals"], "the number of signals", MAX_SIGNALS)
        rate = _rate(found["rate"])
        frames = _whole(found["length"], "the length", 10**15) if found["length"] else None
        # a layout header, which names the signals of a record in segments, has no frames
        if frames == 0 and not all(f"\n{NO_FILE} " in f"\n{line}" for _, line in lines[1:]):
            raise InputError(
                "the length is 0 frames; write the length after the rate, or leave it out"
            )
        start = _start(found["time"], found["date"])
        segments = _whole(found["segments"], "the number of segments", 10**6) or None
    if segments is not None:
        return Header(path, found["name"], rate, frames, (), _segments(lines[1:], segments), start)
    if len(lines) - 1 < count:
        raise InputError(
            f"line {number} announces {count} signals and {len(lines) - 1} follow; the header is "
            "cut off, get it again"
        )
    signals: list[HeaderSignal] = []
    for number, line in lines[1 : 1 + count]:
        with validation.located(f"line {number}: "):
            signals.append(_signal(line, len(signals), signals))
    if sum(signal.frame for signal in signals) > MAX_FRAME:
        raise InputError(f"more than {MAX_FRAME} samples a frame; this is no record of a heart")
    return Header(path, found["name"], rate, frames, tuple(signals), (), start)


def _signal(line: str, index: int, before: list[HeaderSignal]) -> HeaderSignal:
    found = _matched(_SIGNAL, line, "a signal line", "100.dat 212 200 11 1024 995 -22131 0 MLII")
    name = found["file"]
    if name != NO_FILE and not _FILE_NAME.fullmatch(name):
        raise InputError(
            f"the signal file {shown(name)} is no plain name; a record's files lie beside "
            "its header: put them there and name them without a folder"
        )
    kind = str(int(found["format"][:9]))
    if name != NO_FILE and kind not in BYTES:
        raise InputError(f"signal format {kind} can't be read; known are {', '.join(BYTES)}")
    frame = _whole(found["frame"] or "1", "samples a frame", MAX_FRAME)
    offset = _whole(found["offset"] or "0", "the byte offset", 10**15)
    if frame == 0:
        raise InputError("0 samples a frame; leave the x0 out")
    if found["gain"] is not None and as_number(found["gain"]) is None:
        raise InputError(f"the gain {shown(found['gain'])} isn't a number")
    earlier = next((other for other in before if other.file == name != NO_FILE), None)
    if earlier is not None and earlier.format != kind:
        raise InputError(f"{name} has format {kind} here and {earlier.format} before")
    offset = offset if earlier is None else earlier.offset
    return HeaderSignal(
        found["name"] or f"signal {index + 1}", name, kind, frame, offset, found["units"] or "mV"
    )


def _segments(lines: list[tuple[int, str]], count: int) -> tuple[tuple[str, int], ...]:
    if len(lines) < count:
        raise InputError(
            f"{count} segments are announced and {len(lines)} follow; the header is cut off, get "
            "it again"
        )
    segments = []
    for number, line in lines[:count]:
        with validation.located(f"line {number}: "):
            found = _matched(_SEGMENT, line, "a segment line", "100_0001 3600")
            segments.append((found["name"], _whole(found["length"], "the length", 10**15)))
    return tuple(segments)


def _check_files(header: Header) -> None:
    """Refuse a record whose signal files aren't there or end too early."""
    for file, group, frame_bytes in header.files():
        try:
            status = header.beside(file).stat()
        except OSError as error:
            raise InputError(
                f"the signal file {file} can't be opened ({error.strerror}); it belongs beside the "
                "header"
            ) from error
        if not stat.S_ISREG(status.st_mode):
            raise InputError(f"{file} isn't a regular file; copy the record's data there")
        if frame_bytes is None or header.frames is None:
            continue
        needed = group[0].offset + math.floor(header.frames * frame_bytes)
        if status.st_size < needed:
            raise InputError(
                f"{file} has {status.st_size} bytes and {header.frames} frames take {needed}; the "
                "file is cut off or the header wrong: get both again"
            )


def frames_in_files(header: Header) -> int | None:
    """Return how many whole frames the shortest signal file holds; None if that can't be known."""
    counts = []
    for file, group, frame_bytes in header.files():
        if frame_bytes is not None:
            data = max(0, header.beside(file).stat().st_size - group[0].offset)
            counts.append(math.floor(data / frame_bytes))
    return min(counts, default=None)


def _text(path: Path) -> str:
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise InputError("isn't a regular file; name the record's header")
        with open(path, "rb") as stream:
            data = stream.read(MAX_HEADER_BYTES + 1)
    except OSError as error:
        raise InputError(f"the header can't be read ({error.strerror})") from error
    if len(data) > MAX_HEADER_BYTES:
        raise InputError(f"more than {MAX_HEADER_BYTES >> 20} MB; this is no WFDB header")
    # names and comments of old records come in any code page; what matters is ASCII
    return data.decode("ascii", "replace")


def _matched(pattern: re.Pattern[str], line: str, what: str, example: str) -> re.Match[str]:
    found = pattern.fullmatch(line)
    if found is None:
        raise InputError(f"{shown(line)} isn't {what}; such as: {example}")
    return found


def _whole(digits: str | None, what: str, most: int) -> int:
    if not digits:
        return 0
    # cut: Python refuses to make ints of thousands of digits
    if not re.fullmatch(r"\d+", digits, re.ASCII) or len(digits) > 18 or int(digits) > most:
        raise InputError(f"{what} is {shown(digits)}; it is a whole number up to {most}")
    return int(digits)


def _rate(words: str | None) -> float:
    if words is None:
        return DEFAULT_RATE
    rate = as_number(words)
    if rate is None or not 1e-3 <= rate <= 1e6:
        raise InputError(f"the rate is {shown(words)}; it is 0.001 to 1000000 a second")
    return float(rate)


def _start(clock: str | None, day: str | None) -> datetime | None:
    """Return the start where both parts are there; a time of day alone is no moment."""
    if clock is None or day is None:
        return None
    # mm:ss and ss are allowed too
    at, on = clock_s(clock if ":" in clock else f"0:{clock}"), moment(day, "dmy")
    if at is None or at >= 86_400.0 or on is None or day.count("/") != 2:
        raise InputError(f"the start {shown(clock)} {shown(day)} is no hh:mm:ss dd/mm/yyyy")
    return on.to_datetime() + timedelta(seconds=at)
