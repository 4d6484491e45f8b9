"""Formats that other packages read: the entry-point group `overview_dsp.data.readers`.

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

import functools
import importlib
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from overview_dsp.data.readers.source import LoadOptions, Source
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, OverviewWarning

GROUP = "overview_dsp.readers"

_OPTIONS = frozenset({"duration_s", "value", "time", "map", "rate", "match"})
"""What a reader may take."""


@dataclass(frozen=True)
class PackageReader:
    """A reader of another package, with the face of a `formats.Format`.

    Parameters
    ----------
    name
        What an error line calls the format.
    package
        Where it is from.
    given
        What its entry point names.
    options
        The names of the `LoadOptions` it takes.
    """

    name: str
    package: str
    given: Any
    options: frozenset[str]

    def sniff(self, source: Source) -> bool:
        """Return whether it claims the file; one that fails doesn't, with a warning."""
        try:
            return bool(self.given.sniff(source.head))
        except Exception as error:
            _warn(self.package, f"failed to look at a file ({_said(error)})")
            return False

    def read(self, source: Source, options: LoadOptions) -> Timeline:
        """Read a file; InputError if it can't or gives no Timeline."""
        given = {name: getattr(options, name) for name in self.options & options.given()}
        timeline = self._asked(source, lambda: self.given.read(str(source.path), **given))
        if not isinstance(timeline, Timeline):
            raise InputError(
                f"{source.where}: the reader of {self.package} gave a {type(timeline).__name__}, "
                "not a Timeline; tell its authors"
            )
        return timeline

    @property
    def matches(self) -> Callable[[Source], list[str]] | None:
        """What lists the matches of a file, None for a format of one."""
        listing = getattr(self.given, "matches", None)
        if listing is None:
            return None
        return lambda source: [
            str(line) for line in self._asked(source, lambda: listing(str(source.path)))
        ]

    def _asked(self, source: Source, question: Callable[[], Any]) -> Any:
        try:
            return question()
        except InputError as error:
            said = str(error)
            where = "" if said.startswith(source.where) else f"{source.where}: "
            raise InputError(where + said) from error
        except Exception as error:
            raise InputError(
                f"{source.where}: the reader of {self.package} failed ({_said(error)}); tell its "
                "authors"
            ) from error


@functools.cache
def package_readers() -> tuple[PackageReader, ...]:
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
        found.append(PackageReader(str(given.name), package, given, options))
    return tuple(found)


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


def needed(module: str, purpose: str, extra: str) -> Any:
    """Import a module of one of the extras; InputError says how to install it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InputError(
            f"{purpose} needs the package {module.partition('.')[0]} ({error}); install it: pip "
            f"install 'overview-dsp[{extra}]'"
        ) from error
