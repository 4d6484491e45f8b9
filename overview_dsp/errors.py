"""Errors for users: one line with the location, the problem, the allowed values and a remedy.

If no reader accepts a file, a second line names the nearest format.

::

    Exception                                                     exit code of `overview`
    └── OverviewError              base of all errors of this package       1
        ├── InputError             also a ValueError: a wrong argument      2
        ├── OutputError            the disk is full or read-only            1
        ├── NotPreparedError       also a RuntimeError: call `prepare`      1
        └── PortLostError          (live) a device was unplugged            1
    UserWarning
    └── OverviewWarning            a note on standard error                 0

The exit code of a wrong option is 2, too, and that of Ctrl-C is 130. Any other exception except
OSError is a bug of this program; `--debug` shows its traceback.
"""

from __future__ import annotations

import reprlib
import warnings
from collections.abc import Iterable
from numbers import Rational, Real
from operator import attrgetter
from types import ModuleType


class OverviewError(Exception):
    """Base class of all errors of this package; `str()` is one line, or two.

    Parameters
    ----------
    message : str
        Location, problem, allowed values and remedy.
    fix : str
        Second line with a longer remedy.

    Attributes
    ----------
    exit_code : int
        Exit code of the command line.

    Examples
    --------
    >>> try:
    ...     ov.sweep(-1.0)
    ... except ov.OverviewError as error:
    ...     print(error)
    a sweep's duration -1 s is out of range; allowed: more than 0 and up to 86400 s
    """

    exit_code = 1

    def __init__(self, message: str, fix: str = "") -> None:
        lines = (" ".join(line.split()) for line in (message, fix))
        super().__init__("\n".join(line for line in lines if line))


class InputError(OverviewError, ValueError):
    """A file, value or name can't be used; nothing was changed.

    Parameters
    ----------
    message : str
        Location, problem, allowed values and remedy.
    fix : str
        Second line with a longer remedy.
    line, column, value, note : int or None, str, object, str
        Location of a cell in a table: line (or row), header of the column, value, and the problem
        with it. None and empty for any other error.

    Examples
    --------
    >>> ov.tap(1.5)
    Traceback (most recent call last):
    overview_dsp.errors.InputError: a tap's position 1.5 is out of range; ...
    """

    exit_code = 2

    def __init__(
        self,
        message: str,
        fix: str = "",
        *,
        line: int | None = None,
        column: str = "",
        value: object = None,
        note: str = "",
    ) -> None:
        super().__init__(message, fix)
        self.line, self.column, self.value, self.note = line, column, value, note


class OutputError(OverviewError):
    """An output can't be written (a full disk, say); no partial file is left.

    Parameters
    ----------
    message : str
        Output and reason.
    fix : str
        Second line with a longer remedy.

    Examples
    --------
    >>> issubclass(ov.OutputError, ov.OverviewError)
    True
    """

    exit_code = 1


class NotPreparedError(OverviewError, RuntimeError):
    """The engine is not prepared, or a block is larger than prepared.

    Parameters
    ----------
    message : str
        Method to call first.
    fix : str
        Second line with a longer remedy.

    Examples
    --------
    >>> ov.Engine(football, match).reset()
    Traceback (most recent call last):
    overview_dsp.errors.NotPreparedError: the engine is not prepared; call prepare(sample_rate=...)
    """


class OverviewWarning(UserWarning):
    """A problem that stops nothing: an unknown event kind, a clamped value.

    Examples
    --------
    >>> import warnings
    >>> warnings.simplefilter("error", ov.OverviewWarning)  # makes them errors
    >>> warnings.simplefilter("default", ov.OverviewWarning)
    """


MAX_HINTS = 3  # most names in the hint of an unknown name

HINT_RANGE = 0.1
"""Names this much less similar than the nearest one are in the hint, too (difflib's ratio)."""

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 60


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return the nearest known names as a hint, or all names if there are few."""
    import difflib

    names = list(known)
    near = difflib.get_close_matches(name, names, MAX_HINTS, 0.6)
    ratios = [difflib.SequenceMatcher(None, one, name).ratio() for one in near]
    near = [one for one, ratio in zip(near, ratios, strict=True) if ratio > ratios[0] - HINT_RANGE]
    if near:
        return f"; did you mean {' or '.join(map(repr, near))}?"
    return f"; known: {', '.join(names)}" if len(names) <= 16 else ""


def quoted(value: object) -> str:
    """Return any value as a short text in one line, for an error message."""
    if isinstance(value, Real) and not isinstance(value, Rational):
        value = float(value)  # also of numpy, whose repr has a type
    try:
        return _SHORT.repr(value)
    except (ValueError, RecursionError):  # an int with thousands of digits, a recursive list
        return f"a {type(value).__name__} too large to show"


def printable(text: str) -> str:
    """Return a text with spaces for unprintable characters, so that none controls a terminal."""
    return "".join(mark if mark.isprintable() else " " for mark in text)


def warn(message: str, level: int = 1) -> None:
    """Show an OverviewWarning; its location is `level` calls above the function that warns."""
    warnings.warn(message, OverviewWarning, stacklevel=level + 2)


def require_internals(module: ModuleType, names: Iterable[str], requirement: str) -> None:
    """Check that a module has the private attributes that this package uses.

    `names` are attributes; `a.b` is the attribute `b` of `a`. `requirement` has the versions that
    are known to work, for pip. OverviewError if an attribute is missing in the installed version.
    """
    for name in names:
        try:
            attrgetter(name)(module)
        except AttributeError:
            package = module.__name__.partition(".")[0]
            raise OverviewError(
                f"{package} {_version(package)} has no {module.__name__}.{name}; install a "
                f"version that is known to work: pip install '{requirement}'"
            ) from None


def _version(package: str) -> str:
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "of an unknown version"
