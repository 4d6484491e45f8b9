"""WFDB header files (.hea), which describe a record; validated before any signal is read.

Format: header(5) of the WFDB Applications Guide, https://physionet.org/physiotools/wag/header-5.htm.
A record line is followed by one line per signal or per segment. `#` begins a comment.
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
from overview_dsp.errors import InputError, quoted

MAX_HEADER_BYTES = 1 << 20
MAX_SIGNALS = 1024
MAX_FRAME = 65_536
"""Maximum number of samples per frame, all signals together."""

DEFAULT_RATE = 250.0
"""Frame rate, Hz, of a header without one (header(5))."""

NO_FILE = "~"
"""File name of a signal or segment without data."""

BYTES: dict[str, Fraction | None] = {
    "8": Fraction(1), "16": Fraction(2), "24": Fraction(3), "32": Fraction(4), "61": Fraction(2),
    "80": Fraction(1), "160": Fraction(2), "212": Fraction(3, 2), "310": Fraction(4, 3),
    "311": Fraction(4, 3), "508": None, "516": None, "524": None,
}  # fmt: skip
"""Supported formats and their bytes per sample; None: compressed (FLAC)."""

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
    """Signal of a record: `per_frame` samples per frame, data from `offset` bytes in the file."""

    name: str
    file: str
    format: str
    per_frame: int = 1
    offset: int = 0
    units: str = "mV"


@dataclass(frozen=True)
class Header:
    """Content of a header.

    `path`: path of the header file.
    `name`: name of the record.
    `rate`: frame rate, Hz.
    `frames`: number of frames; None if the header does not contain it.
    `signals`: signals in the order of the file; empty for a record of segments.
    `segments`: record name or `~`, and number of frames, of each segment in order.
    `start`: date and time of frame 0; None if the header lacks one of them.
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
        """Path of the header for messages."""
        return printable_path(self.path)

    def path_of(self, name: str) -> Path:
        """Return the path of a file of the record."""
        return self.path.parent / name

    def files(self) -> Iterator[tuple[str, list[HeaderSignal], Fraction | None]]:
        """Yield each signal file, its signals, and its bytes per frame (None: compressed)."""
        for file in dict.fromkeys(signal.file for signal in self.signals if signal.file != NO_FILE):
            group = [signal for signal in self.signals if signal.file == file]
            size = BYTES[group[0].format]
            yield file, group, size and size * sum(signal.per_frame for signal in group)


def looks_like_header(text: str) -> bool:
    """Return whether text begins with a record line and the line of its first signal."""
    lines = [line.strip() for line in text.splitlines()[:200]]
    lines = [line for line in lines if line and not line.startswith("#")]
    record = _RECORD.fullmatch(lines[0]) if lines else None
    if record is None:
        return False
    if record["segments"]:
        return len(lines) > 1 and _SEGMENT.fullmatch(lines[1]) is not None
    if int(record["signals"][:9]) == 0:  # a record with annotations only
        return len(lines) == 1 and record["rate"] is not None
    signal = _SIGNAL.fullmatch(lines[1]) if len(lines) > 1 else None
    # two rows of a number table match the patterns too
    table = re.compile(r"[-+\d.eE\s]*").fullmatch(lines[0] + lines[-1 if signal is None else 1])
    return signal is not None and signal["format"] in {*BYTES, "0"} and table is None


def read_header(path: Path) -> Header:
    """Read a header and check that its signal files exist and are long enough.

    InputError: a line or value is invalid, a format is not supported, or a signal file is in
    another folder, missing or too short. The message contains the line number.
    """
    where = printable_path(path)
    with validation.prefix_errors(f"{where}: "):
        header = parse_header(_text(path), path)
        _check_files(header)
    return header


def parse_header(text: str, path: Path) -> Header:
    """Return the Header of a header file's text; the InputError contains the line number."""
    lines = [
        (number, line.strip())
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise InputError("the header is empty; it must begin with name, signals, rate, length")
    number, line = lines[0]
    with validation.prefix_errors(f"line {number}: "):
        found = _match(_RECORD, line, "a record line", "100 2 360 650000")
        count = _whole(found["signals"], "the number of signals", MAX_SIGNALS)
        written = found["rate"]
        rate = DEFAULT_RATE if written is None else as_number(written)
        if rate is None or not 1e-3 <= rate <= 1e6:
            raise InputError(f"the rate is {quoted(written)}; must be 0.001 to 1000000 Hz")
        rate = float(rate)
        frames = _whole(found["length"], "the length", 10**15) if found["length"] else None
        # a layout header, which names the signals of a record in segments, has no frames
        if frames == 0 and not all(f"\n{NO_FILE} " in f"\n{line}" for _, line in lines[1:]):
            raise InputError("the length is 0 frames; write the length after the rate, or omit it")
        start = _start(found["time"], found["date"])
        segments = _whole(found["segments"], "the number of segments", 10**6) or None
    if segments is not None:
        return Header(path, found["name"], rate, frames, (), _segments(lines[1:], segments), start)
    if len(lines) - 1 < count:
        raise InputError(
            f"line {number} lists {count} signals, but {len(lines) - 1} signal lines follow; the "
            "header is incomplete: download it again"
        )
    signals: list[HeaderSignal] = []
    for number, line in lines[1 : 1 + count]:
        with validation.prefix_errors(f"line {number}: "):
            signals.append(_signal(line, len(signals), signals))
    if sum(signal.per_frame for signal in signals) > MAX_FRAME:
        raise InputError(
            f"a frame has more than {MAX_FRAME} samples, the maximum; the file is not a heart "
            "recording"
        )
    return Header(path, found["name"], rate, frames, tuple(signals), (), start)


def _signal(line: str, index: int, before: list[HeaderSignal]) -> HeaderSignal:
    found = _match(_SIGNAL, line, "a signal line", "100.dat 212 200 11 1024 995 -22131 0 MLII")
    name = found["file"]
    if name != NO_FILE and not _FILE_NAME.fullmatch(name):
        raise InputError(
            f"the signal file is {quoted(name)}; must be a plain name without a folder: put the "
            "file into the folder of the header"
        )
    kind = str(int(found["format"][:9]))
    if name != NO_FILE and kind not in BYTES:
        raise InputError(f"the signal format is {kind}; must be one of {', '.join(BYTES)}")
    frame = _whole(found["frame"] or "1", "samples per frame", MAX_FRAME)
    offset = _whole(found["offset"] or "0", "the byte offset", 10**15)
    if frame == 0:
        raise InputError("the samples per frame are 0; remove x0")
    if found["gain"] is not None and as_number(found["gain"]) is None:
        raise InputError(f"the gain is {quoted(found['gain'])}; must be a number")
    earlier = next((other for other in before if other.file == name != NO_FILE), None)
    if earlier is not None and earlier.format != kind:
        raise InputError(
            f"{name} has format {kind}; must be {earlier.format}, as in an earlier line"
        )
    offset = offset if earlier is None else earlier.offset
    return HeaderSignal(
        found["name"] or f"signal {index + 1}", name, kind, frame, offset, found["units"] or "mV"
    )


def _segments(lines: list[tuple[int, str]], count: int) -> tuple[tuple[str, int], ...]:
    if len(lines) < count:
        raise InputError(
            f"the header lists {count} segments, but {len(lines)} segment lines follow; it is "
            "incomplete: download it again"
        )
    segments = []
    for number, line in lines[:count]:
        with validation.prefix_errors(f"line {number}: "):
            found = _match(_SEGMENT, line, "a segment line", "100_0001 3600")
            segments.append((found["name"], _whole(found["length"], "the length", 10**15)))
    return tuple(segments)


def _check_files(header: Header) -> None:
    """Raise InputError if a signal file is missing or too short."""
    for file, group, frame_bytes in header.files():
        try:
            status = header.path_of(file).stat()
        except OSError as error:
            raise InputError(
                f"the signal file {file} cannot be opened ({error.strerror}); it must be in the "
                "folder of the header"
            ) from error
        if not stat.S_ISREG(status.st_mode):
            raise InputError(f"{file} is not a regular file; copy the data of the record there")
        if frame_bytes is None or header.frames is None:
            continue
        needed = group[0].offset + math.floor(header.frames * frame_bytes)
        if status.st_size < needed:
            raise InputError(
                f"{file} has {status.st_size} bytes, but {header.frames} frames require {needed}; "
                "the file is truncated or the header is wrong: download both again"
            )


def frames_in_files(header: Header) -> int | None:
    """Return the number of complete frames in the shortest signal file; None if unknown."""
    counts = []
    for file, group, frame_bytes in header.files():
        if frame_bytes is not None:
            data = max(0, header.path_of(file).stat().st_size - group[0].offset)
            counts.append(math.floor(data / frame_bytes))
    return min(counts, default=None)


def _text(path: Path) -> str:
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise InputError("not a regular file; specify the header of the record")
        with open(path, "rb") as stream:
            data = stream.read(MAX_HEADER_BYTES + 1)
    except OSError as error:
        raise InputError(f"the header cannot be read ({error.strerror})") from error
    if len(data) > MAX_HEADER_BYTES:
        raise InputError(
            f"the header has more than {MAX_HEADER_BYTES >> 20} MB, the maximum of a WFDB header"
        )
    # names and comments of old records have unknown code pages; all other parts are ASCII
    return data.decode("ascii", "replace")


def _match(pattern: re.Pattern[str], line: str, name: str, example: str) -> re.Match[str]:
    match = pattern.fullmatch(line)
    if match is None:
        raise InputError(f"{quoted(line)} isn't {name}; example: {example}")
    return match


def _whole(digits: str | None, name: str, maximum: int) -> int:
    if not digits:
        return 0
    # Python rejects the conversion of thousands of digits
    if not re.fullmatch(r"\d+", digits, re.ASCII) or len(digits) > 18 or int(digits) > maximum:
        raise InputError(f"{name} is {quoted(digits)}; must be a whole number up to {maximum}")
    return int(digits)


def _start(clock: str | None, day: str | None) -> datetime | None:
    """Return the date and time of the start; None if one of them is missing."""
    if clock is None or day is None:
        return None
    # mm:ss and ss are allowed too
    seconds, date = clock_s(clock if ":" in clock else f"0:{clock}"), moment(day, "dmy")
    if seconds is None or seconds >= 86_400.0 or date is None or day.count("/") != 2:
        raise InputError(
            f"the start is {quoted(clock)} {quoted(day)}; must have the form hh:mm:ss dd/mm/yyyy"
        )
    return date.to_datetime() + timedelta(seconds=seconds)
