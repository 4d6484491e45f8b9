"""The errors a person can cause, each a clear line: what, where, what is allowed, what to try.

A file that no reader claims has a second line with what it comes nearest to.

::

    Exception                                                     exit code of `overview`
    └── OverviewError              raised on purpose; catch this one        1
        ├── InputError             also a ValueError: a file, value or name 2
        ├── OutputError            a full disk, a place that is read-only   1
        ├── NotPreparedError       also a RuntimeError: `prepare` first     1
        └── PortLostError          (live) a device was unplugged            1
    UserWarning
    └── OverviewWarning            a line on standard error                 0

A wrong option ends `overview` with 2 as well, Ctrl-C with 130. Any other exception but an OSError
is a fault of this program; with `--debug` it is shown whole.
"""

from __future__ import annotations

import reprlib
from collections.abc import Iterable
from numbers import Rational, Real
from types import ModuleType


class OverviewError(Exception):
    """Base of every error this package raises on purpose; `str()` is one line, or two.

    Parameters
    ----------
    message : str
        What is wrong, where, what is allowed, what to try.
    fix : str
        A second line, where what to try needs one.

    Attributes
    ----------
    exit_code : int
        What the command line ends with.

    Examples
    --------
    >>> try:
    ...     ov.sweep(-1.0)
    ... except ov.OverviewError as error:
    ...     print(error)
    a sweep's duration -1 s is out of range; it is more than 0 and up to 86400 s
    """

    exit_code = 1

    def __init__(self, message: str, fix: str = "") -> None:
        lines = (" ".join(line.split()) for line in (message, fix))
        super().__init__("\n".join(line for line in lines if line))


class InputError(OverviewError, ValueError):
    """Something given (a file, a value, a name) can't be used; nothing was changed.

    Parameters
    ----------
    message : str
        What is wrong, where, what is allowed, what to try.
    fix : str
        A second line, where what to try needs one.
    line, column, value, note : int or None, str, object, str
        Of a cell in a table: its line (or row), the column's header, what it holds, and what is
        wrong with that. None and empty for any other error.

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
    """An output could not be written (a full disk, say); no partial file is left.

    Parameters
    ----------
    message : str
        What could not be written, and why.
    fix : str
        A second line, where what to try needs one.

    Examples
    --------
    >>> issubclass(ov.OutputError, ov.OverviewError)
    True
    """

    exit_code = 1


class NotPreparedError(OverviewError, RuntimeError):
    """The engine was used before `prepare`, or with a larger block than prepared.

    Parameters
    ----------
    message : str
        What to call.
    fix : str
        A second line, where what to try needs one.

    Examples
    --------
    >>> ov.Engine(football, match).reset()
    Traceback (most recent call last):
    overview_dsp.errors.NotPreparedError: the engine is not prepared; call prepare(sample_rate=...)
    """


class OverviewWarning(UserWarning):
    """Something a person should know: an unknown event kind, a clamped value.

    Examples
    --------
    >>> import warnings
    >>> warnings.simplefilter("error", ov.OverviewWarning)  # to stop at them
    >>> warnings.simplefilter("default", ov.OverviewWarning)
    """


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
    if isinstance(value, Real) and not isinstance(value, Rational):
        value = float(value)  # numpy's too, without their type
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
