"""Fallback folders for takes, and recovery of interrupted takes.

While a take is recorded, a marker file in the user's state folder holds its path. A marker whose
process has ended belongs to an interrupted take, which the next session reports.
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
    """Return the folder for takes that can't be written to their own folder."""
    return platformdirs.user_state_path("overview-dsp", appauthor=False) / "takes"


def fallback_paths(path: Path) -> Iterator[Path]:
    """Yield other paths for a take that can't be written to `path`; create their folders."""
    name = f"{path.stem}-{time.strftime('%Y%m%d-%H%M%S')}{path.suffix}"
    for folder in (state_folder(), Path(tempfile.gettempdir())):
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            yield folder / name


class RecordingMarker:
    """Marker file of a take that is being recorded; a file that can't be written is left out.

    Thread: any one thread.
    """

    def __init__(self, take: Path) -> None:
        self._file = -1
        self._path = state_folder() / f"{os.getpid()}-{next(_numbers)}.growing"
        with contextlib.suppress(OSError):
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o600)
            _lock(self._file)
        self.write(take)

    def write(self, take: Path) -> None:
        """Write the present path of the take to the marker."""
        with contextlib.suppress(OSError):
            os.ftruncate(self._file, 0)
            os.lseek(self._file, 0, os.SEEK_SET)
            os.write(self._file, json.dumps(str(take.absolute())).encode())

    def close(self) -> None:
        """Remove the marker after the take was saved; repeated calls do nothing."""
        if self._file >= 0:
            with contextlib.suppress(OSError):
                self._path.unlink()
            os.close(self._file)
            self._file = -1


def pop_interrupted_takes() -> list[Path]:
    """Return interrupted takes that still exist, and remove their markers."""
    found = []
    for marker in sorted(state_folder().glob("*.growing")):
        with contextlib.suppress(OSError, ValueError):
            file = os.open(marker, os.O_RDWR)
            try:
                _lock(file)  # OSError: the process that records the take is running
                take = Path(json.loads(os.read(file, 65_536)))
            finally:
                os.close(file)
            marker.unlink()
            if take.is_file():
                found.append(take)
    return found


def _lock(file: int) -> None:
    """Lock an open file until this process ends; OSError if another process has locked it."""
    try:
        import fcntl
    except ImportError:  # Windows, where an open file can't be deleted
        return
    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
