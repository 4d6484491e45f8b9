"""Compressed files (gzip, bzip2, xz, ZIP), unpacked within a limit for as long as they are read.

A megabyte of a bomb unpacks to a gigabyte, so unpacking stops at the limit whatever the file says
of its size; xz and ZIP may not take memory of their choice either.
"""

from __future__ import annotations

import bz2
import contextlib
import gzip
import lzma
import os
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import IO

from overview_dsp.data.readers.source import LoadOptions, Source
from overview_dsp.errors import InputError

MAX_MB = 256.0
"""What a compressed file may unpack to, MB (2**20 bytes), without `max_mb`."""

MAX_DIRECTORY_BYTES = 1 << 20
"""Largest table of contents of a ZIP archive that is read: some ten thousand files."""

_XZ_MEMORY = 128 * 2**20
_CHUNK = 1 << 20
_ZIP_END = b"PK\x05\x06"

_GZIP, _BZIP2, _XZ, _ZIP = "gzip", "bzip2", "xz", "ZIP"
_MARKS = (
    (b"\x1f\x8b\x08", _GZIP),
    (b"\xfd7zXZ\x00", _XZ),
    (b"PK\x03\x04", _ZIP),
    (b"PK\x05\x06", _ZIP),
    (b"\x28\xb5\x2f\xfd", "Zstandard"),
    (b"7z\xbc\xaf\x27\x1c", "7z"),
    (b"Rar!\x1a\x07", "RAR"),
)


def packing(head: bytes) -> str | None:
    """Return how a file is compressed, by its first bytes; None if it isn't."""
    if head[:3] == b"BZh" and head[3:4].isdigit() and head[4:10] in (b"1AY&SY", b"\x17rE8P\x90"):
        return _BZIP2
    return next((name for mark, name in _MARKS if head.startswith(mark)), None)


@contextlib.contextmanager
def opened(path: str | os.PathLike[str], options: LoadOptions, label: str = "") -> Iterator[Source]:
    """Give a file as a `Source`, a compressed one unpacked into a temporary file.

    `label` is what error lines call it, in place of its path.

    Raises
    ------
    InputError
        As `Source.open`; a damaged archive, one of several files, one packed twice, one that
        unpacks to more than the limit (the line has it and the option that raises it).
    """
    source = Source.open(path, options, label)
    packed = packing(source.head)
    if packed is None or (packed == _ZIP and _is_arrays(source)):
        yield source
        return
    with tempfile.TemporaryDirectory(prefix="overview-") as folder:
        yield _unpacked(source, packed, Path(folder))


def _unpacked(source: Source, packed: str, folder: Path) -> Source:
    where, options = source.where, source.options
    limit_mb = options.max_mb if options.max_mb is not None else MAX_MB
    if packed not in _READERS:
        raise InputError(f"{where}: a {packed} archive can't be read; unpack it first")
    # the name a reader takes as the title, "match.json" of "match.json.gz"
    name = Path(source.path.name).stem
    target = folder / ("data" if name in ("", ".", "..") else name)
    size = 0
    try:
        with open(target, "wb") as stream:
            for data in _READERS[packed](source):
                size += len(data)
                if size > limit_mb * 2**20:
                    raise InputError(
                        f"{where}: unpacks to more than the {limit_mb:g} MB that are read; raise "
                        "the limit with max_mb (--max-mb) if that is what it should hold"
                    )
                stream.write(data)
    except InputError:  # a ValueError too
        raise
    except EOFError as error:
        raise InputError(f"{where}: the {packed} file is cut off; get it again") from error
    except (zlib.error, lzma.LZMAError, zipfile.BadZipFile, OSError, ValueError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"{where}: can't be unpacked ({packed}: {reason}); get it again"
        ) from error
    if size == 0:
        raise InputError(f"{where}: holds an empty file; check how it was made")
    inner = Source.open(target, options)
    if packing(inner.head) is not None:
        raise InputError(f"{where}: holds another compressed file; unpack it first")
    return replace(inner, origin=source.path, label=source.label)


def _gzip(source: Source) -> Iterator[bytes]:
    with gzip.open(source.path, "rb") as stream:
        yield from _chunks(stream)


def _bzip2(source: Source) -> Iterator[bytes]:
    with bz2.open(source.path, "rb") as stream:
        yield from _chunks(stream)


def _xz(source: Source) -> Iterator[bytes]:
    # by hand: lzma.open takes as much memory as the file asks for
    with open(source.path, "rb") as stream:
        rest = b""
        decompressor = lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=_XZ_MEMORY)
        while True:
            if decompressor.eof:
                rest = decompressor.unused_data.lstrip(b"\0") or stream.read(_CHUNK).lstrip(b"\0")
                if not rest:
                    return
                decompressor = lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=_XZ_MEMORY)
            elif decompressor.needs_input:
                rest = stream.read(_CHUNK)
                if not rest:
                    raise EOFError
            data = decompressor.decompress(rest, _CHUNK)
            rest = b""
            if data:
                yield data


def _zip(source: Source) -> Iterator[bytes]:
    _check_directory(source)
    with zipfile.ZipFile(source.path) as archive:
        members = [
            member
            for member in archive.infolist()
            if not member.is_dir()
            and not member.filename.startswith("__MACOSX/")
            and not member.filename.rsplit("/", 1)[-1].startswith(".")
        ]
        names = {member.filename for member in members}
        if sheets := names & _SHEETS.keys():
            raise InputError(f"{source.where}: {_SHEETS[sheets.pop()]}: save the sheet as CSV")
        if len(members) != 1:
            raise InputError(
                f"{source.where}: a ZIP archive (or a document made of one) of {len(members)} "
                "files; unpack it and name one of them"
            )
        if members[0].flag_bits & 1:
            raise InputError(f"{source.where}: the ZIP archive is encrypted; unpack it first")
        try:
            with archive.open(members[0]) as stream:
                yield from _chunks(stream)
        except NotImplementedError as error:
            raise InputError(
                f"{source.where}: a ZIP archive of a kind that isn't read ({error}); unpack it "
                "first"
            ) from error


_SHEETS = {
    "xl/workbook.xml": "an Excel workbook",
    "xl/workbook.bin": "an Excel workbook",
    "content.xml": "an OpenDocument file",
    "Index/Document.iwa": "a Numbers or Pages file",
    "word/document.xml": "a Word document",
}
"""What is packed like an archive and is a document, by a file that each one has."""


def _is_arrays(source: Source) -> bool:
    """Return whether a ZIP archive is NumPy's of several arrays, which is read packed."""
    _check_directory(source)
    try:
        with zipfile.ZipFile(source.path) as archive:
            names = archive.namelist()
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        return False  # said when it is unpacked
    return len(names) > 1 and all(name.endswith(".npy") for name in names)


def _check_directory(source: Source) -> None:
    """Refuse an archive whose table of contents alone would take much memory."""
    with open(source.path, "rb") as stream:
        stream.seek(max(0, source.size - 65_536 - 22))
        tail = stream.read(65_536 + 22)
    at = tail.rfind(_ZIP_END)
    size = int.from_bytes(tail[at + 12 : at + 16], "little") if at >= 0 else 0
    if size > MAX_DIRECTORY_BYTES:
        raise InputError(
            f"{source.where}: a ZIP archive of too many files (their list has {size} bytes); "
            "unpack it and name one of them"
        )


def _chunks(stream: IO[bytes] | gzip.GzipFile | bz2.BZ2File) -> Iterator[bytes]:
    while data := stream.read(_CHUNK):
        yield data


_READERS: dict[str, Callable[[Source], Iterator[bytes]]] = {
    _GZIP: _gzip,
    _BZIP2: _bzip2,
    _XZ: _xz,
    _ZIP: _zip,
}
