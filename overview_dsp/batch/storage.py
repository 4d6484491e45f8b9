"""Output folder: a local one, or a URL that fsspec opens (`s3://...`, `memory://...`).

A written file appears complete or not at all. A local folder needs a temporary file and a rename
for that; an object store does it by itself.
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

from overview_dsp.errors import InputError
from overview_dsp.files.atomic import output_errors
from overview_dsp.installation import require_package

UNFINISHED = ".unfinished"  # folder of incomplete files, which the next run deletes after a crash


def is_url(text: str) -> bool:
    """Return whether `text` is a URL (`scheme://...`)."""
    return "://" in text


def fsspec() -> Any:
    """Import fsspec; InputError if it is missing."""
    return require_package("fsspec", "overview batch", "batch")


class Storage:
    """A folder or a URL, for any process that can open it."""

    def __init__(self, where: str) -> None:
        """Prepare a path or a URL; nothing is created yet."""
        self.where = where
        self._path = None if is_url(where) else Path(where)
        self._fs: Any = None
        self._root = where
        if self._path is None:
            core = fsspec().core
            try:
                self._fs, self._root = core.url_to_fs(where)
            except (ValueError, ImportError, OSError) as error:
                raise InputError(f"{where}: can't be opened ({error})") from None
        self._made: set[str] = set()

    def _remote(self, name: str) -> str:
        return f"{self._root.rstrip('/')}/{name}"

    def put(self, name: str, data: bytes) -> None:
        """Write a file, complete or not at all; InputError or OutputError."""
        folder = name.rpartition("/")[0]
        with output_errors(Path(self.where, name)):
            if self._path is None:
                if folder not in self._made:
                    self._fs.makedirs(self._remote(folder).rstrip("/"), exist_ok=True)
                    self._made.add(folder)
                self._fs.pipe_file(self._remote(name), data)
                return
            for last in (False, False, False, True):
                try:
                    for needed in {folder, UNFINISHED} - self._made:
                        (self._path / needed).mkdir(parents=True, exist_ok=True)
                        self._made.add(needed)
                    self._put_in_folder(name, data)
                    return
                except FileNotFoundError:  # another process deleted a folder of this one
                    if last:
                        raise
                    self._made.clear()

    def _put_in_folder(self, name: str, data: bytes) -> None:
        assert self._path is not None
        # paths as text: a grid has many files
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
        """Read a file; FileNotFoundError if it doesn't exist, InputError if it can't be read."""
        try:
            if self._path is None:
                return bytes(self._fs.cat_file(self._remote(name)))
            return (self._path / name).read_bytes()
        except FileNotFoundError:
            raise
        except OSError as error:
            raise _unreadable(f"{self.where}/{name}", error) from None

    def sizes(self, folder: str) -> dict[str, int]:
        """Return the sizes (bytes) of all files below `folder`, by name; InputError."""
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
            raise _unreadable(f"{self.where}/{folder}", error) from None

    def remove(self, names: list[str]) -> None:
        """Delete files; missing files are ignored."""
        for name in names:
            with contextlib.suppress(FileNotFoundError):
                if self._path is None:
                    self._fs.rm_file(self._remote(name))
                else:
                    (self._path / name).unlink()

    def clean(self) -> None:
        """Delete the incomplete files of a crash."""
        if self._path is not None:
            shutil.rmtree(self._path / UNFINISHED, ignore_errors=True)


def _files(folder: str) -> Iterator[os.DirEntry[str]]:
    """Yield the files in a folder and below it; none if the folder doesn't exist."""
    with contextlib.suppress(FileNotFoundError, NotADirectoryError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir():
                yield from _files(entry.path)
            elif entry.is_file():
                yield entry


def read_text(where: str) -> str:
    """Read the text of a file or a URL; InputError if it can't be read or isn't UTF-8."""
    try:
        if is_url(where):
            with fsspec().open(where, "rb") as file:
                data: bytes = file.read()
        else:
            data = Path(where).read_bytes()
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{where}: not UTF-8 text (byte {error.start})") from None
    except (OSError, ValueError, ImportError) as error:
        raise _unreadable(where, error) from None


def _unreadable(where: str, error: Exception) -> InputError:
    if isinstance(error, InputError):
        return error
    reason = getattr(error, "strerror", None) or error or type(error).__name__
    return InputError(f"{where}: can't be read ({reason})")


@contextlib.contextmanager
def local_copy(where: str) -> Iterator[str]:
    """Yield a local path: the path itself, or a copy of a URL and of the files with its stem."""
    if not is_url(where):
        yield where
        return
    with tempfile.TemporaryDirectory(prefix="overview-") as folder:
        try:
            fs, path = fsspec().core.url_to_fs(where)
            stem = path.rpartition(".")[0] or path
            for one in sorted({path, *fs.glob(f"{stem}.*")}):
                fs.get_file(one, os.path.join(folder, one.rpartition("/")[2]))
        except (OSError, ValueError, ImportError) as error:
            raise _unreadable(where, error) from None
        yield os.path.join(folder, path.rpartition("/")[2])
