"""The errors a person can cause, each one clear line: what, where, what is allowed, what to try."""

from __future__ import annotations


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
