"""Bytes, open files and addresses, spooled into a temporary file for as long as they are read."""

from __future__ import annotations

import contextlib
import os
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from overview_dsp.data.readers.source import UNNAMED, LoadOptions
from overview_dsp.errors import InputError

MAX_MB = 1024.0
"""What an open file or an address may hold, MB (2**20 bytes), without `max_mb`."""

_CHUNK = 1 << 20
_URL = re.compile(r"([a-z][a-z0-9+.\-]*::)*[a-z][a-z0-9+.\-]+://", re.IGNORECASE)
_SECRETS = re.compile(r"(?<=://)[^/@]*@|[?#].*")
_INSTALL = 'an address needs fsspec: pip install "overview-dsp[urls]", or save the data to a file'


def is_url(data: object) -> bool:
    """Return whether data are given by an address: `https://...`, `s3://...`, `memory://...`."""
    return isinstance(data, str) and _URL.match(data) is not None


def is_content(data: object) -> bool:
    """Return whether data are a file's content or an open file."""
    return isinstance(data, bytes | bytearray | memoryview) or callable(getattr(data, "read", None))


@contextlib.contextmanager
def spooled(data: Any, options: LoadOptions) -> Iterator[tuple[Path, str]]:
    """Give a temporary file with the data, and what error lines call them.

    Parameters
    ----------
    data
        What `is_url` or `is_content` says yes to; an open file is read from where it stands.
    options
        `max_mb`.

    Raises
    ------
    InputError
        More than the limit, an address that can't be opened, a file that can't be read.
    """
    with contextlib.ExitStack() as stack:
        name, label = UNNAMED, "the data given"
        if is_url(data):
            label = _SECRETS.sub("", data)
            name = label.rstrip("/").rpartition("/")[2]
            data = stack.enter_context(_opened(data, label))
        elif not isinstance(data, bytes | bytearray | memoryview):
            given = getattr(data, "name", None)
            label = "the open file"
            if isinstance(given, str) and given:
                name, label = os.path.basename(given), given
        if name in ("", ".", "..") or "\0" in name:
            name = UNNAMED
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="overview-")))
        path = folder / name[-100:]
        _write(path, data, label, options.max_mb if options.max_mb is not None else MAX_MB)
        yield path, label


def _write(path: Path, data: Any, label: str, limit_mb: float) -> None:
    size = 0
    with open(path, "wb") as target:
        for part in _parts(data, label):
            size += len(part)
            if size > limit_mb * 2**20:
                raise InputError(
                    f"{label}: more than the {limit_mb:g} MB that are read; raise the limit with "
                    "max_mb (--max-mb) if that is what it should hold"
                )
            target.write(part)


def _parts(data: Any, label: str) -> Iterator[bytes]:
    if isinstance(data, bytes | bytearray | memoryview):
        yield bytes(data)
        return
    while True:
        try:
            part = data.read(_CHUNK)
            if isinstance(part, str):
                part = part.encode("utf-8", "surrogateescape")
        # whatever lies behind a `read` may fail in its own way: a socket, a closed file, an archive
        except Exception as error:
            raise InputError(f"{label}: can't be read ({_reason(error)})") from error
        if not isinstance(part, bytes | bytearray):
            raise InputError(f"{label}: read() gives a {type(part).__name__}, not bytes or text")
        if not part:
            return
        yield bytes(part)


@contextlib.contextmanager
def _opened(url: str, label: str) -> Iterator[Any]:
    try:
        import fsspec
    except ImportError as error:
        raise InputError(_INSTALL) from error
    with contextlib.ExitStack() as stack:
        try:
            stream = stack.enter_context(fsspec.open(url, "rb"))
        # each kind of storage has errors of its own; a missing library says what to install
        except Exception as error:
            raise InputError(
                f"{label}: can't be opened ({_reason(error)}); check the address"
            ) from error
        yield stream


def _reason(error: Exception) -> str:
    return _SECRETS.sub("", " ".join(str(error).split()))[:160] or type(error).__name__
