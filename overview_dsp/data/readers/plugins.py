"""Formats that other packages read: the entry-point group `overview_dsp.readers`.

What an entry point names (a module will do) has

- `name`: what an error line calls the format;
- `sniff(head: bytes) -> bool`: whether a file that begins so is in it; up to 64 kB, cheap;
- `read(path: str, **options) -> Timeline`: InputError for what is wrong with the file;
- `options` (optional): which of those of `load_timeline` it takes, such as `("rate", "value")`;
- `matches(path: str) -> list of str` (optional): a line on each of several in a file.

They are asked before the formats of this package. A reader that can't be loaded is warned of once
and left out; an error of one that isn't an InputError becomes a line that names the package.
"""

from __future__ import annotations

import contextlib
import functools
import importlib
import warnings
from collections.abc import Iterable, Iterator
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from overview_dsp.data.readers.data_file import DataFile, Format, LoadOptions
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, OverviewWarning

GROUP = "overview_dsp.readers"

_OPTIONS = frozenset({"duration_s", "value", "time", "map", "rate", "match"})
"""What a reader may take."""


@functools.cache
def package_readers() -> tuple[Format, ...]:
    """Return the readers of installed packages, in the order of their names."""
    found = []
    for point in sorted(entry_points(group=GROUP), key=lambda point: (_package(point), point.name)):
        package = _package(point)
        try:
            given = point.load()
            missing = [n for n in ("name", "sniff", "read") if not hasattr(given, n)]
            options = _option_names(getattr(given, "options", ()))
        except Exception as error:  # whatever its import meets
            _warn(package, f"can't be loaded ({_said(error)})")
            continue
        if missing:
            _warn(package, f"has no {' and no '.join(missing)}")
            continue
        found.append(_format_of(given, package, options))
    return tuple(found)


def _format_of(given: Any, package: str, options: frozenset[str]) -> Format:
    """Return the format of what an entry point names; its reader fails with one line."""

    def sniff(source: DataFile) -> bool:
        try:
            return bool(given.sniff(source.head))
        except Exception as error:  # it doesn't claim the file, then
            _warn(package, f"failed to look at a file ({_said(error)})")
            return False

    def read(source: DataFile, asked: LoadOptions) -> Timeline:
        taken = {name: getattr(asked, name) for name in options & asked.given()}
        with _one_line(source, package):
            timeline = given.read(str(source.path), **taken)
        if not isinstance(timeline, Timeline):
            raise InputError(
                f"{source.where}: the reader of {package} gave a {type(timeline).__name__}, not a "
                "Timeline; tell its authors"
            )
        return timeline

    def matches(source: DataFile) -> list[str]:
        with _one_line(source, package):
            return [str(line) for line in given.matches(str(source.path))]

    several = getattr(given, "matches", None) is not None
    return Format(str(given.name), sniff, read, options, matches if several else None)


@contextlib.contextmanager
def _one_line(source: DataFile, package: str) -> Iterator[None]:
    try:
        yield
    except InputError as error:
        said = str(error)
        where = "" if said.startswith(source.where) else f"{source.where}: "
        raise InputError(where + said) from error
    except Exception as error:
        raise InputError(
            f"{source.where}: the reader of {package} failed ({_said(error)}); tell its authors"
        ) from error


def _option_names(names: Iterable[object]) -> frozenset[str]:
    given = frozenset(str(name) for name in names)
    if unknown := sorted(given - _OPTIONS):
        raise InputError(f"options {', '.join(unknown)}; known are {', '.join(sorted(_OPTIONS))}")
    return given


def _package(point: EntryPoint) -> str:
    return f"{point.dist.name if point.dist is not None else point.value} ({point.name})"


def _warn(package: str, what: str) -> None:
    warnings.warn(f"the reader of {package} {what}: left out", OverviewWarning, stacklevel=4)


def _said(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:200]


def require_package(module: str, purpose: str, extra: str) -> Any:
    """Import a module of one of the extras; InputError says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InputError(
            f"{purpose} needs the package {module.partition('.')[0]} ({error}); install it: pip "
            f"install 'overview-dsp[{extra}]'"
        ) from error
