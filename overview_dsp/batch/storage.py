"""A place for files: a folder, or anything that fsspec opens (`s3://...`, `memory://...`).

What is put appears whole or not at all. In a folder that takes a temporary file and a rename;
object stores do it by themselves.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from overview_dsp.batch.extra import library
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import output_error

UNFINISHED = ".unfinished"
"""The folder of files that are being written; what lies there after a crash is thrown away."""


def is_address(text: str) -> bool:
    """Whether a text is an address (`scheme://...`) and no path."""
    return "://" in text


class Storage:
    """A folder or an address, from any process that reaches it."""

    def __init__(self, where: str) -> None:
        """`where` is a path or an address; nothing is touched yet."""
        self.where = where
        self._path = None if is_address(where) else Path(where)
        self._fs: Any = None
        self._root = where
        if self._path is None:
            fsspec = library("fsspec")
            try:
                self._fs, self._root = fsspec.core.url_to_fs(where)
            except (ValueError, ImportError, OSError) as error:
                raise InputError(f"{where}: can't be opened ({error})") from None
        self._made: set[str] = set()

    @property
    def of_one_process(self) -> bool:
        """Whether other processes see nothing of it."""
        return self._path is None and self.where.startswith("memory://")

    def _remote(self, name: str) -> str:
        return f"{self._root.rstrip('/')}/{name}"

    def put(self, name: str, data: bytes) -> None:
        """Write a file of the place, whole.

        Raises
        ------
        InputError, OutputError
            It can't be written there; the disk is full.
        """
        folder = name.rpartition("/")[0]
        try:
            if self._path is None:
                if folder not in self._made:
                    self._fs.makedirs(self._remote(folder).rstrip("/"), exist_ok=True)
                    self._made.add(folder)
                self._fs.pipe_file(self._remote(name), data)
                return
            for last in (False, False, False, True):
                try:
                    self._make_folders(folder)
                    self._put_in_folder(name, data)
                    return
                except FileNotFoundError:  # somebody has deleted what this process made
                    if last:
                        raise
                    self._made.clear()
        except OSError as error:
            raise output_error(Path(self.where, name), error) from error

    def _make_folders(self, folder: str) -> None:
        assert self._path is not None
        for needed in (folder, UNFINISHED):
            if needed not in self._made:
                (self._path / needed).mkdir(parents=True, exist_ok=True)
                self._made.add(needed)

    def _put_in_folder(self, name: str, data: bytes) -> None:
        assert self._path is not None
        # paths as text: a study has many files
        temporary = os.path.join(self._path, UNFINISHED, uuid.uuid4().hex)
        try:
            with open(temporary, "wb") as file:
                file.write(data)
            os.replace(temporary, os.path.join(self._path, name))
        except BaseException:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(temporary)
            raise

    def get(self, name: str) -> bytes:
        """A file's bytes.

        Raises
        ------
        FileNotFoundError
            It isn't there.
        InputError
            It can't be read.
        """
        try:
            if self._path is None:
                data: bytes = self._fs.cat_file(self._remote(name))
                return data
            return (self._path / name).read_bytes()
        except FileNotFoundError:
            raise
        except OSError as error:
            raise self._unreadable(name, error) from None

    def _unreadable(self, name: str, error: OSError) -> InputError:
        return InputError(f"{self.where}/{name}: can't be read ({error.strerror or error})")

    def sizes(self, folder: str) -> dict[str, int]:
        """The files in a folder of the place and those below it: name in the place to bytes.

        InputError if they can't be read.
        """
        if self._path is None:
            root = self._root.rstrip("/") + "/"
            try:
                found = self._fs.find(root + folder, detail=True)
            except FileNotFoundError:
                return {}
            return {
                path.lstrip("/")[len(root.lstrip("/")) :]: int(info["size"])
                for path, info in found.items()
            }
        start = len(os.path.join(self._path, ""))
        found = _files(os.path.join(self._path, folder))
        try:
            return {file.path[start:].replace(os.sep, "/"): file.stat().st_size for file in found}
        except OSError as error:
            raise self._unreadable(folder, error) from None

    def remove(self, names: list[str]) -> None:
        """Delete files; those that aren't there are left alone."""
        for name in names:
            with contextlib.suppress(FileNotFoundError):
                if self._path is None:
                    self._fs.rm_file(self._remote(name))
                else:
                    (self._path / name).unlink()

    def clean(self) -> None:
        """Throw away what a crash left unfinished."""
        if self._path is not None:
            shutil.rmtree(self._path / UNFINISHED, ignore_errors=True)


def _files(folder: str) -> Iterator[os.DirEntry[str]]:
    """The files in a folder, if there is one, and in those below it."""
    with (
        contextlib.suppress(FileNotFoundError, NotADirectoryError),
        os.scandir(folder) as entries,
    ):
        for entry in entries:
            if entry.is_dir():
                yield from _files(entry.path)
            elif entry.is_file():
                yield entry


def read_text(where: str) -> str:
    """The text of a file or an address; InputError if it can't be read or is no text."""
    try:
        if is_address(where):
            with library("fsspec").open(where, "rb") as file:
                data: bytes = file.read()
        else:
            data = Path(where).read_bytes()
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{where}: not UTF-8 text (byte {error.start})") from None
    except (OSError, ValueError, ImportError) as error:
        reason = getattr(error, "strerror", None) or error or type(error).__name__
        raise InputError(f"{where}: can't be read ({reason})") from None


@contextlib.contextmanager
def local_copy(where: str) -> Iterator[str]:
    """A path to a file: itself, or a copy of an address with those of the same stem beside it."""
    if not is_address(where):
        yield where
        return
    fsspec = library("fsspec")
    with tempfile.TemporaryDirectory(prefix="overview-") as folder:
        try:
            fs, path = fsspec.core.url_to_fs(where)
            stem = path.rpartition(".")[0] or path
            for one in sorted({path, *fs.glob(f"{stem}.*")}):
                fs.get_file(one, os.path.join(folder, one.rpartition("/")[2]))
        except (OSError, ValueError, ImportError) as error:
            reason = getattr(error, "strerror", None) or error or type(error).__name__
            raise InputError(f"{where}: can't be read ({reason})") from None
        yield os.path.join(folder, path.rpartition("/")[2])
