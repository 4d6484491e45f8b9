"""Opening of data as files: paths, URLs, bytes, open files and compressed files.

Bytes, open files and URLs are copied, and compressed files (gzip, bzip2, xz, ZIP) unpacked, to a
temporary file with a size limit. A malicious megabyte can unpack to a gigabyte, so unpacking stops
at the limit, whatever size the file states. The memory for xz and ZIP is limited, too.
"""

from __future__ import annotations

import bz2
import contextlib
import gzip
import lzma
import os
import re
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from overview_dsp.data.readers.data_file import UNNAMED, DataFile, LoadOptions, signature
from overview_dsp.data.readers.tables import health, workbook
from overview_dsp.errors import InputError
from overview_dsp.installation import library_errors, require_library

MAX_MB = 256.0
"""Maximum unpacked size, MB (2**20 bytes), unless `max_mb` is set."""

MAX_SPOOLED_MB = 1024.0
"""Maximum size of an open file or the content of a URL, MB, unless `max_mb` is set."""

MAX_DIRECTORY_BYTES = 1 << 20
"""Maximum size of the directory of a ZIP archive: about ten thousand files."""

_XZ_MEMORY = 128 * 2**20
_CHUNK = 1 << 20
_ZIP_END = b"PK\x05\x06"

_GZIP, _BZIP2, _XZ, _ZIP = "gzip", "bzip2", "xz", "ZIP"
_SHEET, _HEALTH = "spreadsheet", "Apple Health"
_URL = re.compile(r"([a-z][a-z0-9+.\-]*::)*[a-z][a-z0-9+.\-]+://", re.IGNORECASE)
_SECRETS = re.compile(r"(?<=://)[^/@]*@|[?#].*")


def is_url(data: object) -> bool:
    """Return whether data are a URL: `https://...`, `s3://...`, `memory://...`."""
    return isinstance(data, str) and _URL.match(data) is not None


def is_content(data: object) -> bool:
    """Return whether data are the content of a file, or an open file."""
    return isinstance(data, bytes | bytearray | memoryview) or callable(getattr(data, "read", None))


@contextlib.contextmanager
def opened(data: Any, options: LoadOptions, missing: str = "") -> Iterator[DataFile]:
    """Yield data as a `DataFile`, from a temporary file if they are not a plain file.

    `data`: a path, a URL, the content of a file, or an open file, read from its current position.
    `options`: `max_mb`.
    `missing`: hint at the end of the error for a missing file.

    InputError: as `DataFile.open`; a URL or file that can't be opened; an archive that is damaged,
    packed twice or has several files; more data than the limit.
    """
    with contextlib.ExitStack() as stack:
        path, label = data, ""
        if is_url(data) or is_content(data):
            path, label = stack.enter_context(_spooled(data, options))
        try:
            source = DataFile.open(path, options, label)
        except InputError as error:
            hint = missing if isinstance(error.__cause__, FileNotFoundError) else ""
            raise InputError(f"{error}{hint}") from error
        packed = packing(source.head)
        names = _zip_names(source) if packed == _ZIP else []
        if _SHEETS.intersection(names) or _is_open_sheet(source, names):
            packed = _SHEET
        elif health.member(names) or (packed is None and health.is_export(source.head)):
            packed = _HEALTH
        is_arrays = len(names) > 1 and all(name.endswith(".npy") for name in names)
        if packed is not None and not is_arrays:
            folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="overview-"))
            source = _unpacked(source, packed, Path(folder))
        yield source


@contextlib.contextmanager
def _spooled(data: Any, options: LoadOptions) -> Iterator[tuple[Path, str]]:
    """Yield a temporary file with the data, and their name in error messages."""
    with contextlib.ExitStack() as stack:
        name, label = UNNAMED, "the data given"
        if is_url(data):
            label = _SECRETS.sub("", data)
            name = label.rstrip("/").rpartition("/")[2]
            data = stack.enter_context(_opened_url(data, label))
        elif not isinstance(data, bytes | bytearray | memoryview):
            file_name = getattr(data, "name", None)
            label = "the open file"
            if isinstance(file_name, str) and file_name:
                name, label = os.path.basename(file_name), file_name
        if name in ("", ".", "..") or "\0" in name:
            name = UNNAMED
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="overview-")))
        path = folder / name[-100:]
        limit_mb = options.max_mb if options.max_mb is not None else MAX_SPOOLED_MB
        beyond = f"{label}: more than the {limit_mb:g} MB that are read"
        _write(path, _parts(data, label), limit_mb, beyond)
        yield path, label


def _write(path: Path, parts: Iterable[bytes], limit_mb: float, beyond: str) -> int:
    """Write a temporary file and return its size; `beyond` is the error of a larger one."""
    size = 0
    with open(path, "wb") as target:
        for part in parts:
            size += len(part)
            if size > limit_mb * 2**20:
                raise InputError(
                    f"{beyond}; if that is intended, raise the limit with max_mb (--read max-mb=MB)"
                )
            target.write(part)
    return size


def _parts(data: Any, label: str) -> Iterator[bytes]:
    if isinstance(data, bytes | bytearray | memoryview):
        yield bytes(data)
        return
    while True:
        try:
            part = data.read(_CHUNK)
            if isinstance(part, str):
                part = part.encode("utf-8", "surrogateescape")
        # `read` of any object (a socket, an archive) may raise any error
        except Exception as error:
            raise InputError(f"{label}: can't be read ({_reason(error)})") from error
        if not isinstance(part, bytes | bytearray):
            raise InputError(f"{label}: read() gives a {type(part).__name__}, not bytes or text")
        if not part:
            return
        yield bytes(part)


@contextlib.contextmanager
def _opened_url(url: str, label: str) -> Iterator[Any]:
    fsspec = require_library("fsspec", "a URL", "urls", "save the data to a file")
    with contextlib.ExitStack() as stack:
        # every storage has its own errors; that of a missing library names the package
        with library_errors(
            lambda error: f"{label}: can't be opened ({_reason(error)}); check the address"
        ):
            stream = stack.enter_context(fsspec.open(url, "rb"))
        yield stream


def _reason(error: Exception) -> str:
    return _SECRETS.sub("", " ".join(str(error).split()))[:160] or type(error).__name__


def packing(head: bytes) -> str | None:
    """Return the compression of a file from its first bytes, None if it is not compressed."""
    if head[:3] == b"BZh" and head[3:4].isdigit() and head[4:10] in (b"1AY&SY", b"\x17rE8P\x90"):
        return _BZIP2
    return signature(head, "archive")


_DAMAGED = (zlib.error, lzma.LZMAError, zipfile.BadZipFile, OSError, ValueError, RuntimeError)
"""Errors of unpacking; an encrypted archive is a RuntimeError."""


def _unpacked(source: DataFile, packed: str, folder: Path) -> DataFile:
    source = workbook.with_sheet(source) if packed == _SHEET else source
    where, options = source.where, source.options
    limit_mb = options.max_mb if options.max_mb is not None else MAX_MB
    if packed not in _READERS:
        raise InputError(f"{where}: a {packed} archive can't be read; unpack it first")
    # readers use the name as title: "match.json" for "match.json.gz"
    name = Path(source.path.name).stem
    target = folder / ("data" if name in ("", ".", "..") else name)
    if target == source.path:  # of an archive in an archive
        target = folder / f"{name}.csv"
    beyond = f"{where}: unpacks to more than the {limit_mb:g} MB that are read"
    try:
        size = _write(target, _READERS[packed](source), limit_mb, beyond)
    except InputError:  # a ValueError too
        raise
    except EOFError as error:
        raise InputError(f"{where}: the {packed} file is cut off; get it again") from error
    except _DAMAGED as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"{where}: can't be unpacked ({packed}: {reason}); get it again"
        ) from error
    if size == 0:
        raise InputError(f"{where}: contains an empty file; check how it was made")
    inner = DataFile.open(target, options)
    if packed != _HEALTH and health.is_export(inner.head):
        inner = replace(inner, label=source.label or where)
        return replace(_unpacked(inner, _HEALTH, folder), origin=source.path, label=source.label)
    if packing(inner.head) is not None:
        raise InputError(f"{where}: contains another compressed file; unpack it first")
    inner = replace(inner, notes=source.notes, sheets=source.sheets, sheet=source.sheet)
    return replace(inner, origin=source.path, label=source.label)


def _streamed(open_file: Callable[..., Any], source: DataFile) -> Iterator[bytes]:
    with open_file(source.path, "rb") as stream:
        yield from iter(lambda: stream.read(_CHUNK), b"")


def _xz(source: DataFile) -> Iterator[bytes]:
    # not lzma.open, which takes as much memory as the file requests
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


def _zip(source: DataFile) -> Iterator[bytes]:
    with zipfile.ZipFile(source.path) as archive:
        members = [
            member
            for member in archive.infolist()
            if not member.is_dir()
            and not member.filename.startswith("__MACOSX/")
            and not member.filename.rsplit("/", 1)[-1].startswith(".")
        ]
        names = {member.filename for member in members}
        if documents := names & _DOCUMENTS.keys():
            raise InputError(
                f"{source.where}: {_DOCUMENTS[documents.pop()]}; save its table as CSV"
            )
        if len(members) != 1:
            raise InputError(
                f"{source.where}: a ZIP archive (or a document made of one) of {len(members)} "
                "files; unpack it and name one of them"
            )
        if members[0].flag_bits & 1:
            raise InputError(f"{source.where}: the ZIP archive is encrypted; unpack it first")
        try:
            with archive.open(members[0]) as stream:
                yield from iter(lambda: stream.read(_CHUNK), b"")
        except NotImplementedError as error:
            raise InputError(
                f"{source.where}: a ZIP archive of a kind that isn't read ({error}); unpack it "
                "first"
            ) from error


_SHEETS = frozenset({"xl/workbook.xml", "xl/workbook.bin"})
"""Files of spreadsheets in ZIP format."""

_DOCUMENTS = {
    "Index/Document.iwa": "a Numbers or Pages file",
    "word/document.xml": "a Word document",
    "content.xml": "an OpenDocument text, drawing or presentation",
}
"""Other documents in ZIP format, by a file that each kind contains."""


def _is_open_sheet(source: DataFile, names: list[str]) -> bool:
    """Return whether an archive is an OpenDocument spreadsheet."""
    if not {"content.xml", "mimetype"} <= {*names}:
        return False
    try:
        with zipfile.ZipFile(source.path) as archive, archive.open("mimetype") as stream:
            return b"spreadsheet" in stream.read(100)
    except _DAMAGED:
        return False


def _health(source: DataFile) -> Iterator[bytes]:
    if packing(source.head) is None:
        yield from health.csv_parts(_streamed(open, source), source.where)
        return
    with zipfile.ZipFile(source.path) as archive:
        name = health.member(archive.namelist()) or ""
        with archive.open(name) as stream:
            yield from health.csv_parts(iter(lambda: stream.read(_CHUNK), b""), source.where)


def _zip_names(source: DataFile) -> list[str]:
    """Return the names of the files in a ZIP archive; none if it is damaged.

    InputError: the directory of the archive alone would take much memory.
    """
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
    try:
        with zipfile.ZipFile(source.path) as archive:
            return archive.namelist()
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        return []  # unpacking raises the error


_READERS: dict[str, Callable[[DataFile], Iterator[bytes]]] = {
    _GZIP: partial(_streamed, gzip.open),
    _BZIP2: partial(_streamed, bz2.open),
    _XZ: _xz,
    _ZIP: _zip,
    _SHEET: workbook.csv_parts,
    _HEALTH: _health,
}
