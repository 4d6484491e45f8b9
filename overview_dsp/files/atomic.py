"""Atomic outputs: files and folders that appear complete or not at all."""

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
    """Return the error for a failed write: OutputError for the disk, InputError for the caller."""
    reason = error.strerror or str(error) or type(error).__name__
    if error.errno in _DISK_ERRORS:
        return OutputError(f"{path}: {reason}; nothing was left behind, free some space and retry")
    return InputError(f"{path}: can't be written ({reason}); choose a folder you may write to")


@contextlib.contextmanager
def output_errors(path: Path) -> Iterator[None]:
    """Raise the `output_error` of any failed write inside."""
    try:
        yield
    except OSError as error:
        raise output_error(path, error) from error


_inputs: set[tuple[int, int]] = set()


def protect_input(path: str | os.PathLike[str]) -> None:
    """Refuse outputs of this process that would overwrite this file, until `unprotect_inputs`."""
    found = _identity(path)
    if found is not None:
        _inputs.add(found)


def unprotect_inputs() -> None:
    """Allow outputs to overwrite any file again."""
    _inputs.clear()


def _identity(path: str | os.PathLike[str]) -> tuple[int, int] | None:
    try:
        found = os.stat(path)
    except (OSError, ValueError):  # no such file, or not a valid name
        return None
    return found.st_dev, found.st_ino


def _require_output(target: Path) -> None:
    """Check that a file is neither an input of this command nor a folder; InputError otherwise."""
    if _identity(target) in _inputs:
        raise InputError(f"{target}: is an input of this command; name another output")
    # os.path: pathlib raises for a name that is too long
    if os.path.isdir(target):
        raise InputError(f"{target}: is a folder; name a file in it")


def require_writable(path: str | os.PathLike[str]) -> None:
    """Check before long work that a file can be written; InputError otherwise."""
    target = Path(path)
    _require_output(target)
    if not os.path.isdir(target.parent):
        raise InputError(f"{target}: no folder {target.parent}; make it first")
    if not os.access(target.parent, os.W_OK):
        raise InputError(f"{target}: can't be written; choose a folder you may write to")


_temporaries: set[Path] = set()


def _temporary(target: Path, suffix: str = "") -> Path:
    """Return the name of a temporary file or folder beside a target, and register it."""
    # without the stem, which could make the name too long
    path = target.parent / f".overview-{uuid.uuid4().hex[:12]}{suffix}"
    _temporaries.add(path)
    return path


def _remove(path: Path | None) -> None:
    if path is None:
        return
    with contextlib.suppress(OSError):  # it may not exist
        if os.path.isdir(path):
            shutil.rmtree(path, ignore_errors=True)
        else:
            os.unlink(path)
    _temporaries.discard(path)


def remove_temporaries() -> None:
    """Delete the temporary files and folders of this process."""
    for path in list(_temporaries):
        _remove(path)


def _umask() -> int:
    umask = os.umask(0)
    os.umask(umask)
    return umask


@contextlib.contextmanager
def atomic_file(path: str | os.PathLike[str], private: bool = False) -> Iterator[Path]:
    """Yield a temporary path; rename it to `path` on success, delete it otherwise.

    It has the suffix of `path`, from which some writers choose their format. Only the owner can
    read a `private` file. InputError if the folder doesn't exist or can't be written, or the file
    is a protected input; OutputError if the disk is full or broken.
    """
    target = Path(path)
    if "\0" in str(target):
        raise InputError(f"{str(target)!r}: can't be written (a zero byte in the name)")
    _require_output(target)
    temporary = _temporary(target, target.suffix)
    try:
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
        yield temporary
        with open(temporary, "rb") as written:
            os.fsync(written.fileno())
        if not private:
            os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, target)
    except OSError as error:
        raise output_error(target, error) from error
    finally:
        _remove(temporary)


def write_file(path: str | os.PathLike[str], content: str | bytes, private: bool = False) -> None:
    """Write a file by `atomic_file`, text as UTF-8."""
    data = content.encode() if isinstance(content, str) else content
    with atomic_file(path, private) as temporary:
        temporary.write_bytes(data)


def make_folder(path: str | os.PathLike[str]) -> Path:
    """Make a folder for outputs, with its parents; InputError if that fails."""
    folder = Path(path)
    with output_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
    return folder


@contextlib.contextmanager
def atomic_folder(path: str | os.PathLike[str], marker: str) -> Iterator[Path]:
    """Yield a temporary folder; rename it to `path` on success, delete it otherwise.

    An existing folder is replaced if it is empty or contains the file `marker`. InputError if the
    folder can't be written, or contains other files; OutputError if the disk is full or broken.
    """
    target = Path(path)
    old = None
    try:
        if os.path.lexists(target):
            if not target.is_dir():
                raise InputError(f"{target}: is a file; name a folder")
            if any(target.iterdir()) and not (target / marker).is_file():
                raise InputError(f"{target}: contains other files; name an empty or new folder")
        target = target.absolute()
        temporary = _temporary(target)
        temporary.mkdir(mode=0o700)
    except OSError as error:
        raise output_error(target, error) from error
    except ValueError as error:  # a zero byte
        raise InputError(f"{str(target)!r}: can't be written ({error})") from error
    try:
        yield temporary
        os.chmod(temporary, 0o777 & ~_umask())
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
