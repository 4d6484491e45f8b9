"""A file being looked at (read, decoded and parsed once), what may be asked of it, and a format.

How deep and how large JSON is, is counted before it is parsed. The parser goes down a level for
every bracket and makes an object for every value: a file of a few megabytes can end the stack or
take gigabytes. Both are known from its brackets, commas and quotes.

XML is read as text that no parser can be harmed by: UTF-8, without a document type.
"""

from __future__ import annotations

import codecs
import json
import os
import re
import stat
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown

MAX_TEXT_BYTES = 256 * 1024 * 1024
"""Largest text file that is read as a stream without `max_mb`."""

MAX_WHOLE_BYTES = 64 * 1024 * 1024
"""Largest text file (JSON, CSV) that is read as a whole without `max_mb`: as text it takes up to
four times that in memory, parsed several times."""

HEAD_BYTES = 65_536
"""How much of a file the readers see before one of them claims it."""

WINDOWS = "cp1252"
"""The encoding of text that isn't UTF-8: old spreadsheets'."""

READ_AS_WINDOWS = "the file isn't UTF-8; read as Windows-1252"
"""What a timeline notes then."""

MAX_DEPTH = 64
"""Deepest nesting that is read without `max_depth`: ten times what the known formats need."""

MOST_DEPTH = 500
"""Deepest nesting `max_depth` may allow: the parser's own stack ends at about twice that."""

PARSED_MB = 576.0
"""What a file holds may take in memory, MB; a limit of size above the usual 64 MB raises it too."""

PARSED_TIMES = 9
"""So many times the limit of its size is what it may take then."""

# bytes, measured with Python 3.11 on 64 bits, a copy of each number included
_OBJECT_BYTES, _LIST_BYTES, _VALUE_BYTES, _TEXT_BYTES = 240, 72, 72, 60
_JSON_CHUNK = 1 << 20
_JSON_ESCAPED = re.compile(rb"\\.", re.DOTALL)

CONTROL = {chr(code) for code in (*range(9), *range(14, 28), 127)}

_STAMPED = re.compile(
    r"\[(\d+:\d|\d{1,4}([./-])\d{1,2}\2\d|\d\d/[A-Z]|(?!NaN|Inf)[A-Z][A-Za-z]+[ \]])", re.ASCII
)
"""What a chapter (`[0:12]`) or a line of a log (`[03.05.24, 18:20]`, `[Wed Oct`) begins with."""

UNNAMED = "unnamed"
"""The name of a file that stands for data without one."""

_XML_DECLARATION = re.compile(r"\s*<\?xml\b[^>]{0,200}\?>")
_XML_ROOT = re.compile(r"<([A-Za-z_][\w.:-]{0,99})[\s/>]")
_XML_ASIDE = re.compile(r"<!--.*?-->|<\?.*?\?>", re.S)

_BOMS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    # UTF-32 first: its mark begins with UTF-16's
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


@dataclass(frozen=True)
class LoadOptions:
    """What a caller may add to a file; each format says which options it takes.

    Parameters
    ----------
    duration_s
        Length of the timeline, for a file that doesn't hold it.
    value, time
        Names of the columns with the values and the times.
    map
        What becomes the intensity: `level`, `change`, `activity`, `volatility`, `count`, or a
        column.
    kind, label
        Names of the columns with the kinds and the labels of events.
    rate
        Samples a second, for a file without times.
    match
        Which of the matches in a file: its number (from 1), or words of its line.
    max_mb
        Megabytes (2**20 bytes) a file may have, in place of the format's own limit.
    progress
        Called with the part of the file that is read, 0 to 1, by formats that may take long.
    max_depth
        Levels of nesting that JSON may have, in place of the usual limit.
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

    def given(self) -> frozenset[str]:
        """Return the names of the options that were set and say something about the data."""
        names = {name for name, value in vars(self).items() if value is not None}
        return frozenset(names - {"progress"})

    @property
    def counts(self) -> bool:
        """Whether a table's rows may be what is asked for (`map` is `count`, with or without :)."""
        return self.map is not None and self.map.partition(":")[0].strip().lower() == "count"

    def report_progress(self, part: float) -> None:
        """Report how much is read, 0 to 1."""
        if self.progress is not None:
            self.progress(part)


def shown_path(path: str | os.PathLike[str]) -> str:
    """Return printable text of a path, bytes that aren't UTF-8 escaped."""
    return os.fsencode(path).decode("utf-8", "backslashreplace")


def text_encoding(data: bytes) -> str:
    """Return the encoding that a byte order mark gives, UTF-8 without one."""
    return next((name for mark, name in _BOMS if data.startswith(mark)), "utf-8")


def decode_text(data: bytes, where: str, encoding: str = "") -> str:
    """Decode UTF-8 (with or without a byte order mark) or UTF-16/32 with one; InputError if not."""
    try:
        return data.decode(encoding or text_encoding(data))
    except UnicodeDecodeError as error:
        raise InputError(
            f"{where}: byte {error.start} isn't {error.encoding} text ({error.reason}); save the "
            "file as UTF-8"
        ) from error


@dataclass(frozen=True)
class Extent:
    """Levels of nesting, and bytes that the parsed document takes, roughly and at most."""

    depth: int
    parsed_bytes: int


def extent(text: str, deepest: int = MOST_DEPTH) -> Extent:
    """Count a text's nesting and values; stops counting where it is nested deeper than `deepest`.

    What isn't JSON gets some count too: the parser says where it is broken.
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
    """Refuse JSON that is nested too deep or would take too much memory.

    Parameters
    ----------
    text
        The file's text.
    where
        How the error line begins.
    limit_mb
        What the file may have, MB; parsed it may have `PARSED_TIMES` as many, or `PARSED_MB`.
    max_depth
        Levels it may have, in place of `MAX_DEPTH`.

    Raises
    ------
    InputError
        Too deep or too large; the line has the limit and the option that raises it.
    """
    allowed = max_depth if max_depth is not None else MAX_DEPTH
    found = extent(text, allowed)
    if found.depth > allowed:
        raise InputError(
            f"{where}: JSON nested too deep (more than {allowed} levels); a timeline needs four: "
            "correct the file, or raise the limit with max_depth (--read max-depth=LEVELS), to "
            f"{MOST_DEPTH} at most"
        )
    budget = max(PARSED_MB, limit_mb * PARSED_TIMES)
    if found.parsed_bytes > budget * 2**20:
        raise InputError(
            f"{where}: what it holds would take about {found.parsed_bytes / 2**20:.0f} MB of "
            f"memory, more than {budget:.0f} MB; cut it into parts, or raise the limit with max_mb "
            f"(--read max-mb=MB), to {found.parsed_bytes / 2**20 / PARSED_TIMES + 1.0:.0f}"
        )


def parse_json(text: str, where: str) -> object:
    """Parse JSON text into Python objects, failing with a place and never with a traceback.

    NaN and Infinity literals and numbers beyond a float become floats that aren't finite: the
    reader that knows the place of each value refuses them there. A key given twice in an object
    is an error, since which of the two is meant can't be known.

    Raises
    ------
    InputError
        Broken or cut-off JSON (line and column), a key given twice, nesting too deep to follow.
    """

    def whole(digits: str) -> int | float:
        # Python refuses to make ints of more than 4300 digits; a float of them is infinite
        return int(digits) if len(digits) < 400 else float(digits)

    def unique(pairs: list[tuple[str, object]]) -> dict[str, object]:
        table = dict(pairs)
        if len(table) != len(pairs):
            keys = [key for key, _ in pairs]
            twice = next(key for key in keys if keys.count(key) > 1)
            raise InputError(f"{where}: the key {shown(twice)} is given twice; remove one")
        return table

    try:
        document: object = json.loads(text, parse_int=whole, object_pairs_hook=unique)
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
    return document


@dataclass(frozen=True)
class DataFile:
    """A regular, non-empty file.

    Parameters
    ----------
    path
        Where it is.
    size
        Bytes.
    head
        Its first bytes, up to `HEAD_BYTES`, for detecting the format.
    options
        What the caller added, for formats that the data alone doesn't distinguish.
    origin
        The compressed file that was unpacked to `path`, None for any other.
    label
        What error lines call the data, where they aren't a file of the caller's.
    """

    path: Path
    size: int
    head: bytes
    options: LoadOptions = field(default_factory=LoadOptions)
    origin: Path | None = None
    label: str = ""

    @classmethod
    def open(
        cls, path: str | os.PathLike[str], options: LoadOptions | None = None, label: str = ""
    ) -> DataFile:
        """Look at a file, which error lines call `label` if that is given.

        Raises
        ------
        InputError
            Missing, a folder or device, empty, unreadable.
        """
        where = label or shown_path(path)
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
            raise InputError(f"{where}: no permission to read it; ask for it or copy it") from error
        except (OSError, ValueError) as error:  # ValueError: a NUL in the path
            reason = getattr(error, "strerror", None) or str(error)
            raise InputError(f"{where}: can't be read ({reason}); check the path") from error
        if not head:
            raise InputError(f"{where}: is empty; check how it was made, or get it again")
        return cls(Path(path), status.st_size, head, options or LoadOptions(), label=label)

    @property
    def where(self) -> str:
        """The path, printable: what an error line begins with."""
        return self.label or shown_path(self.origin or self.path)

    @property
    def folder(self) -> Path:
        """Where companions of the file lie."""
        return (self.origin or self.path).parent

    @property
    def stem(self) -> str:
        """The file's name without its suffix: the title where the file holds none."""
        name = Path(shown_path(self.path.name)).stem
        return "" if self.label and name == UNNAMED else name

    @cached_property
    def encoding(self) -> str | None:
        """The head's encoding, None for what is no text.

        A byte order mark gives it; else UTF-8, else Windows-1252 (old spreadsheets, `°C`), in which
        no JSON is written.
        """
        marked = text_encoding(self.head)
        if self._decoded(marked) is not None:
            return marked
        text = self._decoded(WINDOWS) if marked == "utf-8" else None
        if text is None or CONTROL & set(text) or text.lstrip()[:1] in ("{", "["):
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
        """The head as text, None for binary data."""
        text = None if self.encoding is None else self._decoded(self.encoding)
        return None if text is None or "\0" in text else text

    @property
    def looks_like_json(self) -> bool:
        """True if the file is text whose first character is a bracket JSON begins with."""
        if self.head_text is None:
            return False
        begins = self.head_text.lstrip()[:16]
        return begins[:1] in ("{", "[") and not _STAMPED.match(begins)

    @cached_property
    def text(self) -> str:
        """The whole file as text; InputError if too large (`text_limit_mb`) or not text."""
        limit_mb = self.text_limit_mb
        if self.size > limit_mb * 2**20:
            raise InputError(
                f"{self.where}: {self.size / 2**20:.0f} MB, more than the {limit_mb:g} MB that "
                "are read; cut it into parts, keep fewer points, or raise the limit with max_mb "
                "(--read max-mb=MB)"
            )
        try:
            with open(self.path, "rb") as stream:
                # no more than was seen, should the file be growing
                return decode_text(stream.read(self.size), self.where, self.encoding or "")
        except OSError as error:
            raise InputError(f"{self.where}: can't be read ({error.strerror})") from error
        except MemoryError as error:
            raise InputError(
                f"{self.where}: too large for this machine's memory; cut it into parts"
            ) from error

    @property
    def text_limit_mb(self) -> float:
        """How large a text may be, MB: `max_mb`, else `MAX_WHOLE_BYTES`."""
        given = self.options.max_mb
        return given if given is not None else MAX_WHOLE_BYTES / 2**20

    @cached_property
    def json(self) -> object:
        """The file parsed as JSON; errors as `check_extent` (before it is parsed), `parse_json`."""
        check_extent(self.text, self.where, self.text_limit_mb, self.options.max_depth)
        return parse_json(self.text, self.where)

    @property
    def xml_root(self) -> str:
        """The name of an XML file's outermost element without its prefix, "" for no XML."""
        if self.head_text is None or not self.head_text.lstrip().startswith("<"):
            return ""
        found = _XML_ROOT.search(_XML_ASIDE.sub("", self.head_text))
        return found[1].rpartition(":")[2] if found else ""

    @property
    def xml_text(self) -> str:
        """An XML file's text without its declaration, as what it was decoded by may differ.

        InputError for a document type: its entities can make gigabytes of a few lines or read
        other files, and no format that is read here has one.
        """
        text = self.text
        if "<!DOCTYPE" in text or "<!ENTITY" in text:
            raise InputError(
                f"{self.where}: the XML has a document type (<!DOCTYPE ...>), which may hide a "
                "bomb; remove it"
            )
        return _XML_DECLARATION.sub("", text, count=1)


@dataclass(frozen=True)
class Format:
    """A file format and its reader.

    Parameters
    ----------
    name
        What an error line calls it.
    sniff
        Whether the source is in this format; cheap, never by the file's name.
    read
        Makes the Timeline; errors begin with the file's path.
    options
        The names of the `LoadOptions` it takes.
    matches
        For files of several matches: gives a line on each, in the order of their numbers.
    """

    name: str
    sniff: Callable[[DataFile], bool]
    read: Callable[[DataFile, LoadOptions], Timeline]
    options: frozenset[str] = frozenset()
    matches: Callable[[DataFile], list[str]] | None = None
