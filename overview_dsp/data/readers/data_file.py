"""Data files, load options and file formats. A file is read, decoded and parsed only once.

Nesting level and memory of JSON are computed before it is parsed, from its brackets, commas and
quotes. The parser recurses at every bracket and creates an object for every value, so a file of a
few megabytes can overflow the stack or take gigabytes.

XML is passed on only as safe text: UTF-8, without a document type.
"""

from __future__ import annotations

import codecs
import json
import os
import re
import stat
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, quoted
from overview_dsp.files.toml import load_toml

MAX_TEXT_BYTES = 256 * 1024 * 1024
"""Maximum size of a streamed text file, unless `max_mb` is set."""

MAX_WHOLE_BYTES = 64 * 1024 * 1024
"""Maximum size of a text file (JSON, CSV) that is read as a whole, unless `max_mb` is set. As text
it takes up to four times as much memory, and more when parsed."""

HEAD_BYTES = 65_536
"""Size of the first part of a file, from which its format is detected."""

WINDOWS = "cp1252"
"""Encoding of text that is not UTF-8, from old spreadsheets."""

READ_AS_WINDOWS = "the file isn't UTF-8; read as Windows-1252"
"""Note of a timeline from such a text."""

MAX_DEPTH = 64
"""Maximum nesting level, unless `max_depth` is set: ten times that of the known formats."""

DEEPEST = 500
"""Maximum of `max_depth`: the stack of the parser overflows at about twice that level."""

PARSED_MB = 576.0
"""Maximum memory of a parsed file, MB; raised together with a maximum file size above 64 MB."""

PARSED_PER_MB = 9
"""Maximum memory of a parsed file, as a multiple of the maximum file size."""

# bytes, measured with Python 3.11 on 64 bits, a copy of each number included
_OBJECT_BYTES, _LIST_BYTES, _VALUE_BYTES, _TEXT_BYTES = 240, 72, 72, 60
_JSON_CHUNK = 1 << 20
_JSON_ESCAPED = re.compile(rb"\\.", re.DOTALL)

CONTROL = {chr(code) for code in (*range(9), *range(14, 28), 127)}

_STAMPED = re.compile(
    r"\[(\d+:\d|\d{1,4}([./-])\d{1,2}\2\d|\d\d/[A-Z]|(?!NaN|Inf)[A-Z][A-Za-z]+[ \]])", re.ASCII
)
"""Beginning of a chapter (`[0:12]`) or a log line (`[03.05.24, 18:20]`, `[Wed Oct`)."""


def _is_json(text: str) -> bool:
    begins = text.lstrip()[:16]
    return begins[:1] in ("{", "[") and not _STAMPED.match(begins)


UNNAMED = "unnamed"
"""Name of the file for data without a name."""

_XML_DECLARATION = re.compile(r"\s*<\?xml\b[^>]{0,200}\?>")
_XML_ROOT = re.compile(r"<([A-Za-z_][\w.:-]{0,99})[\s/>]")
_XML_ASIDE = re.compile(r"<!--.*?-->|<\?.*?\?>", re.S)

_SIGNATURES = {
    kind: [(mark.encode("latin-1"), offset, name) for mark, offset, name in rows]
    for kind, rows in load_toml(__file__, "signatures.toml").items()
}


def signature(head: bytes, kind: str) -> str | None:
    """Return what a file is by its first bytes, by a table of `signatures.toml`, else None."""
    known = _SIGNATURES[kind]
    return next((name for mark, at, name in known if head.startswith(mark, at)), None)


@dataclass(frozen=True)
class LoadOptions:
    """Options for loading a file; each format lists those that it takes.

    `duration_s`: length of the timeline, s, for a file without it.
    `value`, `time`: names of the columns with the values and the times.
    `map`: mapping to intensity: `level`, `change`, `activity`, `volatility`, `count`, or a column.
    `kind`, `label`: names of the columns with the kinds and the labels of events.
    `rate`: sample rate, Hz, for a file without times.
    `match`: match in a file of several: its number (from 1), or words of its description.
    `max_mb`: maximum file size, MB (2**20 bytes), instead of that of the format.
    `progress`: called with the fraction of the file that is read, 0 to 1, by slow formats.
    `max_depth`: maximum nesting level of JSON, instead of `MAX_DEPTH`.
    `group`: text of one of the series of `load_timelines` in each column, by index of the column.
    """

    duration_s: float | None = None
    value: str | None = None
    time: str | None = None
    map: str | None = None
    rate: float | None = None
    match: str | None = None
    max_mb: float | None = None
    progress: Callable[[float], None] | None = field(default=None, compare=False)
    max_depth: int | None = None
    kind: str | None = None
    label: str | None = None
    group: Mapping[int, str] | None = None

    def names_set(self) -> frozenset[str]:
        """Return the names of the options that users set, except `progress`."""
        names = {name for name, value in vars(self).items() if value is not None}
        return frozenset(names - {"progress", "group"})

    @property
    def counts(self) -> bool:
        """True if rows may have to be counted (`map` is `count` or `count:WINDOW`)."""
        return self.map is not None and self.map.partition(":")[0].strip().lower() == "count"

    def report_progress(self, part: float) -> None:
        """Report the fraction of the file that is read, 0 to 1."""
        if self.progress is not None:
            self.progress(part)


def printable_path(path: str | os.PathLike[str]) -> str:
    """Return a path as printable text, with escapes for bytes that are not UTF-8."""
    return os.fsencode(path).decode("utf-8", "backslashreplace")


def text_encoding(data: bytes) -> str:
    """Return the encoding of the byte order mark, UTF-8 without one."""
    return signature(data, "encoding") or "utf-8"


def decode_text(data: bytes, where: str, encoding: str = "") -> str:
    """Decode UTF-8, or UTF-16/32 with a byte order mark; InputError for other bytes."""
    try:
        return data.decode(encoding or text_encoding(data))
    except UnicodeDecodeError as error:
        raise InputError(
            f"{where}: byte {error.start} isn't {error.encoding} text ({error.reason}); save the "
            "file as UTF-8"
        ) from error


@dataclass(frozen=True)
class Extent:
    """Nesting level, and upper estimate of the memory of the parsed document."""

    depth: int
    parsed_bytes: int


def extent(text: str, deepest: int = DEEPEST) -> Extent:
    """Measure the nesting level and the memory of JSON; stop at a level above `deepest`.

    For broken JSON the result is arbitrary; the parser reports the error.
    """
    depth = highest = objects = lists = values = quotes = 0
    in_text, escaping = 0, False
    for start in range(0, len(text), _JSON_CHUNK):
        data = text[start : start + _JSON_CHUNK].encode("utf-8", "surrogatepass")
        if escaping:
            data = data[1:]
        data = _JSON_ESCAPED.sub(b"", data)
        escaping = data.endswith(b"\\")
        marks = np.frombuffer(data, dtype=np.uint8)
        quote = marks == ord('"')
        inside = (np.cumsum(quote) + in_text) & 1
        bare = np.where(inside == 1, np.uint8(0), marks)
        opens_object, opens_list = bare == ord("{"), bare == ord("[")
        steps = (opens_object | opens_list).astype(np.int8)
        steps -= (bare == ord("}")) | (bare == ord("]"))
        levels = np.cumsum(steps, dtype=np.int64) + depth
        if len(levels):
            highest = max(highest, int(levels.max()))
            depth, in_text = int(levels[-1]), int(inside[-1])
        objects += int(np.count_nonzero(opens_object))
        lists += int(np.count_nonzero(opens_list))
        values += int(np.count_nonzero(bare == ord(",")))
        quotes += int(np.count_nonzero(quote))
        if highest > deepest:
            break
    parsed = objects * _OBJECT_BYTES + lists * _LIST_BYTES + values * _VALUE_BYTES
    return Extent(highest, parsed + quotes // 2 * _TEXT_BYTES)


def check_extent(text: str, where: str, limit_mb: float, max_depth: int | None = None) -> None:
    """Raise InputError for JSON that is nested too deep or would take too much memory.

    `text`: the file's text.
    `where`: beginning of the error message.
    `limit_mb`: maximum file size, MB. Parsed, `PARSED_PER_MB` as much is allowed, at least
    `PARSED_MB`.
    `max_depth`: maximum nesting level, instead of `MAX_DEPTH`.

    InputError: too deep or too large; the message has the limit and the option that raises it.
    """
    allowed = max_depth if max_depth is not None else MAX_DEPTH
    found = extent(text, allowed)
    if found.depth > allowed:
        raise InputError(
            f"{where}: JSON nested too deep (more than {allowed} levels); a timeline needs four: "
            "correct the file, or raise the limit with max_depth (--read max-depth=LEVELS), to "
            f"{DEEPEST} at most"
        )
    budget = max(PARSED_MB, limit_mb * PARSED_PER_MB)
    if found.parsed_bytes > budget * 2**20:
        raise InputError(
            f"{where}: its content would take about {found.parsed_bytes / 2**20:.0f} MB of "
            f"memory, more than {budget:.0f} MB; cut it into parts, or raise the limit with max_mb "
            f"(--read max-mb=MB), to {found.parsed_bytes / 2**20 / PARSED_PER_MB + 1.0:.0f}"
        )


def parse_json(text: str, where: str) -> object:
    """Parse JSON; every error is an InputError with the location.

    NaN, Infinity and numbers too large for a float become non-finite floats, which readers reject
    with their location. A repeated key in an object is an error, since it is ambiguous.

    InputError: broken or truncated JSON (line and column), a repeated key, or nesting too deep to
    parse.
    """

    def whole(digits: str) -> int | float:
        # as a float such an int is infinite, and Python rejects one of more than 4300 digits
        return int(digits) if len(digits) < sys.float_info.max_10_exp else float(digits)

    def unique(pairs: list[tuple[str, object]]) -> dict[str, object]:
        table = dict(pairs)
        if len(table) != len(pairs):
            twice = next(key for key, n in Counter(key for key, _ in pairs).items() if n > 1)
            raise InputError(f"{where}: the key {quoted(twice)} is given twice; remove one")
        return table

    try:
        return json.loads(text, parse_int=whole, object_pairs_hook=unique)
    except json.JSONDecodeError as error:
        cut = error.pos >= len(text.rstrip()) or error.msg.startswith("Unterminated")
        advice = "the file seems cut off: get it again" if cut else "correct it there"
        raise InputError(
            f"{where}: broken JSON at line {error.lineno}, column {error.colno} ({error.msg}); "
            f"{advice}"
        ) from error
    except RecursionError as error:
        raise InputError(
            f"{where}: JSON nested too deep for this machine's stack; a timeline needs four levels"
        ) from error
    except MemoryError as error:
        raise InputError(
            f"{where}: too large for this machine's memory; cut it into parts"
        ) from error


@dataclass(frozen=True)
class DataFile:
    """A regular, non-empty file.

    `path`: path of the file.
    `size`: size in bytes.
    `head`: first bytes, up to `HEAD_BYTES`, for detecting the format.
    `options`: load options, which some formats depend on.
    `origin`: compressed file that was unpacked to `path`, or None.
    `label`: name of the data in error messages, if they are not a file of the user.
    `notes`: notes of the timeline about how the file was opened.
    `sheets`, `sheet`: sheets of a workbook, and that which an option has chosen.
    """

    path: Path
    size: int
    head: bytes
    options: LoadOptions = field(default_factory=LoadOptions)
    origin: Path | None = None
    label: str = ""
    notes: tuple[str, ...] = ()
    sheets: tuple[str, ...] = ()
    sheet: str = ""

    @classmethod
    def open(
        cls, path: str | os.PathLike[str], options: LoadOptions | None = None, label: str = ""
    ) -> DataFile:
        """Read the first bytes of a file, which error messages call `label`, if set.

        InputError: the file is missing, a folder or device, empty, or unreadable.
        """
        where = label or printable_path(path)
        try:
            status = os.stat(path)
            if stat.S_ISDIR(status.st_mode):
                raise InputError(f"{where}: is a folder; name a file in it")
            if not stat.S_ISREG(status.st_mode):
                raise InputError(f"{where}: isn't a regular file; save the data to a file first")
            with open(path, "rb") as stream:
                head = stream.read(HEAD_BYTES)
        except InputError:  # a ValueError too
            raise
        except FileNotFoundError as error:
            raise InputError(f"{where}: no such file; check the path") from error
        except PermissionError as error:
            raise InputError(f"{where}: no permission to read it; change its rights") from error
        except (OSError, ValueError) as error:  # ValueError: a NUL in the path
            reason = getattr(error, "strerror", None) or str(error)
            raise InputError(f"{where}: can't be read ({reason}); check the path") from error
        if not head:
            raise InputError(f"{where}: is empty; check how it was made, or get it again")
        return cls(Path(path), status.st_size, head, options or LoadOptions(), label=label)

    @property
    def where(self) -> str:
        """Printable path: the beginning of error messages."""
        return self.label or printable_path(self.origin or self.path)

    @property
    def folder(self) -> Path:
        """Folder of the file, where related files are searched."""
        return (self.origin or self.path).parent

    @property
    def stem(self) -> str:
        """Name of the file without suffix: the default title."""
        name = Path(printable_path(self.path.name)).stem
        return "" if self.label and name == UNNAMED else name

    @cached_property
    def encoding(self) -> str | None:
        """Encoding of the file, None if it is not text.

        It is that of the byte order mark, else UTF-8, else Windows-1252 (old spreadsheets, `°C`;
        never JSON).
        """
        marked = text_encoding(self.head)
        if self._decoded(marked) is not None:
            return marked
        text = self._decoded(WINDOWS) if marked == "utf-8" else None
        if text is None or CONTROL & set(text) or _is_json(text):
            return None
        return WINDOWS

    def _decoded(self, encoding: str) -> str | None:
        decoder = codecs.getincrementaldecoder(encoding)()
        try:
            # not final: the head may end inside a character
            return decoder.decode(self.head, final=self.size <= len(self.head))
        except UnicodeDecodeError:
            return None

    @cached_property
    def head_text(self) -> str | None:
        """First part of the file as text, None for binary data."""
        text = None if self.encoding is None else self._decoded(self.encoding)
        return None if text is None or "\0" in text else text

    @property
    def looks_like_json(self) -> bool:
        """True if the file is text that begins with a bracket of JSON."""
        return self.head_text is not None and _is_json(self.head_text)

    @cached_property
    def text(self) -> str:
        """Whole file as text; InputError if it is too large (`text_limit_mb`) or not text."""
        self.require_size(self.text_limit_mb, "cut it into parts, keep fewer points")
        try:
            with open(self.path, "rb") as stream:
                # not more than the initial size, if the file grows
                return decode_text(stream.read(self.size), self.where, self.encoding or "")
        except OSError as error:
            raise InputError(f"{self.where}: can't be read ({error.strerror})") from error
        except MemoryError as error:
            raise InputError(
                f"{self.where}: too large for this machine's memory; cut it into parts"
            ) from error

    def require_size(self, limit_mb: float, remedy: str) -> None:
        """Raise InputError with a remedy if the file is larger than a limit."""
        if self.size > limit_mb * 2**20:
            raise InputError(
                f"{self.where}: {self.size / 2**20:.0f} MB, more than the {limit_mb:g} MB that "
                f"are read; {remedy}, or raise the limit with max_mb (--read max-mb=MB)"
            )

    @property
    def text_limit_mb(self) -> float:
        """Maximum size of a text, MB: `max_mb`, else `MAX_WHOLE_BYTES`."""
        max_mb = self.options.max_mb
        return max_mb if max_mb is not None else MAX_WHOLE_BYTES / 2**20

    @cached_property
    def json(self) -> object:
        """Parsed JSON document; raises the errors of `check_extent` and `parse_json`."""
        check_extent(self.text, self.where, self.text_limit_mb, self.options.max_depth)
        return parse_json(self.text, self.where)

    @property
    def xml_root(self) -> str:
        """Name of the root element of an XML file, without prefix; "" for other files."""
        if self.head_text is None or not self.head_text.lstrip().startswith("<"):
            return ""
        found = _XML_ROOT.search(_XML_ASIDE.sub("", self.head_text))
        return found[1].rpartition(":")[2] if found else ""

    @property
    def xml_text(self) -> str:
        """Text of an XML file without its declaration, whose encoding may be wrong after decoding.

        InputError for a document type: its entities can expand to gigabytes or read other files,
        and no supported format has one.
        """
        text = self.text
        if "<!DOCTYPE" in text or "<!ENTITY" in text:
            raise InputError(
                "the XML has a document type (<!DOCTYPE ...>), which may expand to gigabytes; "
                "remove it"
            )
        return _XML_DECLARATION.sub("", text, count=1)


@dataclass(frozen=True)
class Format:
    """A file format and its reader.

    `name`: name of the format in error messages.
    `sniff`: function that detects the format from the content, never from the name of the file.
    `read`: function that returns the Timeline.
    `options`: names of the `LoadOptions` that the format takes.
    `matches`: function that returns one line per match, in order, for files of several matches.
    `open_table`: function that returns the table of a file, for tables whose columns may
    distinguish series.

    Errors of these functions may begin with the path of the file; otherwise, it is added.
    """

    name: str
    sniff: Callable[[DataFile], bool]
    read: Callable[[DataFile, LoadOptions], Timeline]
    options: frozenset[str] = frozenset()
    matches: Callable[[DataFile], list[str]] | None = None
    open_table: Callable[[DataFile], Any] | None = None
