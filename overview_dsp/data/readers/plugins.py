"""File formats of other packages: the entry-point group `overview_dsp.readers`.

The object of an entry point (usually a module) has

- `name`: name of the format in error messages;
- `sniff(head: bytes) -> bool`: whether a file with these first bytes (64 kB) has the format;
- `read(path: str, **options) -> Timeline`: raises InputError for errors in the file;
- `options` (optional): options of `load_timeline` that it takes, such as `("rate", "value")`;
- `matches(path: str) -> list of str` (optional): one line per match in a file of several.

These formats are tried before those of this package. A reader that can't be loaded is left out
with one warning. An error that is not an InputError is reported with the name of the package.
"""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Iterable, Iterator
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from overview_dsp.data.readers.data_file import DataFile, Format, LoadOptions
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, warn

GROUP = "overview_dsp.readers"

_OPTIONS = frozenset({"duration_s", "value", "time", "map", "rate", "match"})
"""Options that a reader may take."""


@functools.cache
def package_readers() -> tuple[Format, ...]:
    """Return the formats of installed packages, sorted by name."""
    found = []
    for point in sorted(entry_points(group=GROUP), key=lambda point: (_package(point), point.name)):
        package = _package(point)
        try:
            reader = point.load()
            missing = [n for n in ("name", "sniff", "read") if not hasattr(reader, n)]
            options = _option_names(getattr(reader, "options", ()))
        except Exception as error:  # its import may raise any error
            _warn(package, f"can't be loaded ({_error_text(error)})")
            continue
        if missing:
            _warn(package, f"has no {' and no '.join(missing)}")
            continue
        found.append(_format_of(reader, package, options))
    return tuple(found)


def _format_of(reader: Any, package: str, options: frozenset[str]) -> Format:
    """Return the format of an entry point; errors of its reader become one line."""

    def sniff(source: DataFile) -> bool:
        try:
            return bool(reader.sniff(source.head))
        except Exception as error:  # then the file is not of this format
            _warn(package, f"failed to look at a file ({_error_text(error)})")
            return False

    def read(source: DataFile, options_set: LoadOptions) -> Timeline:
        taken = {name: getattr(options_set, name) for name in options & options_set.names_set()}
        with _one_line(source, package):
            timeline = reader.read(str(source.path), **taken)
        if not isinstance(timeline, Timeline):
            raise InputError(
                f"{source.where}: the reader of {package} gave a {type(timeline).__name__}, not a "
                "Timeline; report this to its authors"
            )
        return timeline

    def matches(source: DataFile) -> list[str]:
        with _one_line(source, package):
            return [str(line) for line in reader.matches(str(source.path))]

    several = getattr(reader, "matches", None) is not None
    return Format(str(reader.name), sniff, read, options, matches if several else None)


@contextlib.contextmanager
def _one_line(source: DataFile, package: str) -> Iterator[None]:
    try:
        yield
    except InputError as error:
        message = str(error)
        where = "" if message.startswith(source.where) else f"{source.where}: "
        raise InputError(where + message) from error
    except Exception as error:
        raise InputError(
            f"{source.where}: the reader of {package} failed ({_error_text(error)}); "
            "report this to its authors"
        ) from error


def _option_names(names: Iterable[object]) -> frozenset[str]:
    options = frozenset(str(name) for name in names)
    if unknown := sorted(options - _OPTIONS):
        raise InputError(f"unknown: {', '.join(unknown)}; known: {', '.join(sorted(_OPTIONS))}")
    return options


def _package(point: EntryPoint) -> str:
    return f"{point.dist.name if point.dist is not None else point.value} ({point.name})"


def _warn(package: str, what: str) -> None:
    warn(f"the reader of {package} {what}; it is left out", 3)


def _error_text(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:200]
