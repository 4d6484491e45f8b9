"""Outputs that are whole or absent: written beside their place, then renamed into it."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import uuid
from collections.abc import Iterator
from pathlib import Path

from overview_dsp.errors import InputError, OutputError

_DISK_ERRORS = {errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EFBIG}


def output_error(path: Path, error: OSError) -> InputError | OutputError:
    """The one-line error for a failed write: the disk's fault (exit 1) or the caller's (exit 2)."""
    reason = error.strerror or str(error) or type(error).__name__
    if error.errno in _DISK_ERRORS:
        return OutputError(f"{path}: {reason}; nothing was left behind, free some space and retry")
    return InputError(f"{path}: can't be written ({reason}); choose a folder you may write to")


_inputs: set[tuple[int, int]] = set()


def protect_input(path: str | os.PathLike[str]) -> None:
    """Let no output of this process take the place of this file, if there is one.

    For what a command reads, until it ends (`unprotect_inputs`): one wrong name, and it would be lost.
    """
    found = _identity(path)
    if found is not None:
        _inputs.add(found)


def unprotect_inputs() -> None:
    """Outputs may take the place of any file again."""
    _inputs.clear()


def _identity(path: str | os.PathLike[str]) -> tuple[int, int] | None:
    try:
        found = os.stat(path)
    except (OSError, ValueError):  # no such file, or no name at all
        return None
    return found.st_dev, found.st_ino


def _refuse_input(target: Path) -> None:
    if _identity(target) in _inputs:
        raise InputError(
            f"{target}: this command reads it, so it would be lost; name another output"
        )


def require_writable(path: str | os.PathLike[str]) -> None:
    """Refuse early, with InputError, a file that could not be written at the end."""
    target = Path(path)
    _refuse_input(target)
    if os.path.isdir(target):
        raise InputError(f"{target}: is a folder; name a file in it")
    if not os.path.isdir(target.parent):
        raise InputError(f"{target}: there is no folder {target.parent}; make it first")
    if not os.access(target.parent, os.W_OK):
        raise InputError(f"{target}: can't be written; choose a folder you may write to")


_temporaries: set[Path] = set()


def _temporary(target: Path, suffix: str = "") -> Path:
    """A name for a temporary file or folder beside a target, noted before it is there."""
    # the stem is left out: with it, a name that fits its folder could become too long
    path = target.parent / f".overview-{uuid.uuid4().hex[:12]}{suffix}"
    _temporaries.add(path)
    return path


def _remove(path: Path | None) -> None:
    if path is None:
        return
    with contextlib.suppress(OSError):  # it may never have been made
        if os.path.isdir(path):
            shutil.rmtree(path, ignore_errors=True)
        else:
            os.unlink(path)
    _temporaries.discard(path)


def remove_temporaries() -> None:
    """Delete what a writer that was stopped anywhere has left, in this process."""
    for path in list(_temporaries):
        _remove(path)


@contextlib.contextmanager
def atomic_file(path: str | os.PathLike[str], private: bool = False) -> Iterator[Path]:
    """Give a temporary path beside `path`; rename it into place on success, delete it otherwise.

    The temporary name keeps the suffix, so a writer that looks at it chooses the same format. A
    `private` file may be read by its owner only.

    Raises
    ------
    InputError
        The folder doesn't exist or can't be written, or the file is one to `protect_input`.
    OutputError
        The disk is full or broken.
    """
    target = Path(path)
    if "\0" in str(target):
        raise InputError(f"{str(target)!r}: can't be written (a zero byte in the name)")
    _refuse_input(target)
    # os.path: a name that is too long is no folder, where pathlib raises
    if os.path.isdir(target):
        raise InputError(f"{target}: is a folder; name a file in it")
    temporary = _temporary(target, target.suffix)
    try:
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
        yield temporary
        with open(temporary, "rb") as written:
            os.fsync(written.fileno())
        if not private:
            umask = os.umask(0)
            os.umask(umask)
            os.chmod(temporary, 0o666 & ~umask)
        os.replace(temporary, target)
    except OSError as error:
        raise output_error(target, error) from error
    finally:
        _remove(temporary)


def make_folder(path: str | os.PathLike[str]) -> Path:
    """Make a folder for outputs, with its parents; InputError if that can't be."""
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise output_error(folder, error) from error
    return folder


@contextlib.contextmanager
def atomic_folder(path: str | os.PathLike[str], ours: str) -> Iterator[Path]:
    """Give a temporary folder beside `path`; rename it into place on success, delete it otherwise.

    A folder that is there already is replaced if it is empty or holds the file `ours`.

    Raises
    ------
    InputError
        It can't be written, or holds something else.
    OutputError
        The disk is full or broken.
    """
    target = Path(path)
    old = None
    try:
        if os.path.lexists(target):
            if not target.is_dir():
                raise InputError(f"{target}: is a file; name a folder")
            if any(target.iterdir()) and not (target / ours).is_file():
                raise InputError(
                    f"{target}: holds other files, which would be lost; name an empty or new folder"
                )
        target = target.absolute()
        temporary = _temporary(target)
        temporary.mkdir(mode=0o700)
    except (OSError, ValueError) as error:  # ValueError: a zero byte
        if isinstance(error, OSError):
            raise output_error(target, error) from error
        raise InputError(f"{str(target)!r}: can't be written ({error})") from error
    try:
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(temporary, 0o777 & ~umask)
        if target.exists():
            old = _temporary(target)
            os.replace(target, old)
        os.replace(temporary, target)
    except OSError as error:
        raise output_error(target, error) from error
    finally:
        if old is not None and not target.exists():
            os.replace(old, target)
        _remove(temporary)
        _remove(old)
