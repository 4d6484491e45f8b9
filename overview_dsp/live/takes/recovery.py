"""Where takes go that their own place can't hold, and which ones were cut short.

A take that grows is noted in the user's state folder until it is closed in order; what is noted
there and grows no more was cut short, and the next session says so.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import platformdirs

_numbers = itertools.count()


def state_folder() -> Path:
    """Where takes go that their own place can't hold."""
    return platformdirs.user_state_path("overview-dsp", appauthor=False) / "takes"


def other_places(path: Path) -> Iterator[Path]:
    """Names for a take that can't stay at `path`, the best first; their folders are there."""
    name = f"{path.stem}-{time.strftime('%Y%m%d-%H%M%S')}{path.suffix}"
    for folder in (state_folder(), Path(tempfile.gettempdir())):
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            yield folder / name


class GrowingNote:
    """The note that a take grows; where it can't be written, there is none.

    Thread: one, whichever.
    """

    def __init__(self, take: Path) -> None:
        self._file = -1
        self._path = state_folder() / f"{os.getpid()}-{next(_numbers)}.growing"
        with contextlib.suppress(OSError):
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o600)
            _lock(self._file)
        self.moved(take)

    def moved(self, take: Path) -> None:
        """The take grows there now."""
        with contextlib.suppress(OSError):
            os.ftruncate(self._file, 0)
            os.lseek(self._file, 0, os.SEEK_SET)
            os.write(self._file, json.dumps(str(take.absolute())).encode())

    def close(self) -> None:
        """The take is whole; may be called twice."""
        if self._file >= 0:
            with contextlib.suppress(OSError):
                self._path.unlink()
            os.close(self._file)
            self._file = -1


def take_cut_short() -> list[Path]:
    """The takes that were cut short since this was asked last, where they are still there."""
    found = []
    for note in sorted(state_folder().glob("*.growing")):
        with contextlib.suppress(OSError, ValueError):
            file = os.open(note, os.O_RDWR)
            try:
                _lock(file)  # OSError: whoever wrote it is alive
                take = Path(json.loads(os.read(file, 65_536)))
            finally:
                os.close(file)
            note.unlink()
            if take.is_file():
                found.append(take)
    return found


def _lock(file: int) -> None:
    """Lock an open file for as long as this process lives; OSError if another one has."""
    try:
        import fcntl
    except ImportError:  # a file that is open can't be deleted there
        return
    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
