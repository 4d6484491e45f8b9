"""The errors a person can cause, each one clear line: what, where, what is allowed, what to try."""

from __future__ import annotations

import reprlib
from collections.abc import Iterable
from types import ModuleType


class OverviewError(Exception):
    """Base of every error this package raises on purpose; `str()` is one line.

    `exit_code` is what the command line ends with.
    """

    exit_code = 1

    def __init__(self, message: str) -> None:
        super().__init__(" ".join(message.split()))


class InputError(OverviewError, ValueError):
    """Something given (a file, a value, a name) can't be used; nothing was changed."""

    exit_code = 2


class OutputError(OverviewError):
    """An output could not be written (a full disk, say); no partial file is left."""

    exit_code = 1


class NotPreparedError(OverviewError, RuntimeError):
    """The engine was used before `prepare`, or with a larger block than prepared."""


class OverviewWarning(UserWarning):
    """Something a person should know: an unknown event kind, a clamped value."""


_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 60


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """A hint with the nearest known name, or all of them when they are few."""
    import difflib

    names = list(known)
    near = difflib.get_close_matches(name, names, 1, 0.6)
    if near:
        return f"; did you mean {near[0]!r}?"
    return f"; known: {', '.join(names)}" if len(names) <= 16 else ""


def shown(value: object) -> str:
    """A value as an error line shows it: short, on one line, whatever it is."""
    try:
        return _SHORT.repr(value)
    except (ValueError, RecursionError):  # an int of thousands of digits, a bottomless list
        return f"a {type(value).__name__} too large to show"


def require_internals(module: ModuleType, names: Iterable[str], requirement: str) -> None:
    """Check that a module has the parts of its inside that are used here.

    `names` are attributes, `a.b` that of one. `requirement` is what pip is to install: the versions
    that are known to work.

    Raises
    ------
    OverviewError
        One is missing: this version has changed what no version promises to keep.
    """
    for name in names:
        found: object = module
        for part in name.split("."):
            if not hasattr(found, part):
                package = module.__name__.partition(".")[0]
                raise OverviewError(
                    f"{package} {_version(package)} is installed, which has no "
                    f"{module.__name__}.{name}; known to work is {requirement}: "
                    f"pip install '{requirement}'"
                )
            found = getattr(found, part)


def _version(package: str) -> str:
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "of an unknown version"
