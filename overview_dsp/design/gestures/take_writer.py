"""Writer of recorded takes during a session; the file is complete after each append.

The CSV file is that of `recorded_take.py`. Until `finish`, its JSON file has one object per line:
the head, then each change with its sample, and the number of played samples (`{"sample": 48000}`).
`finish` replaces the lines by the usual document. An interrupted take can be read too.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from overview_dsp.design.gestures.recorded_take import COLUMNS, VERSION, event_line, save_document
from overview_dsp.errors import InputError, OutputError
from overview_dsp.files.atomic import output_error, output_errors

Event = tuple[int, int, float, bool]
"""Sample, source (index of `SOURCES`), theta2 (rad), touching."""


class TakeWriter:
    """Open CSV and JSON files of a take.

    Thread: any single one.
    """

    def __init__(self, path: str | os.PathLike[str], sample_rate: float, about: Mapping[str, Any]):
        """Begin a take; an existing one is renamed (`take.1.csv`); InputError or OutputError."""
        self.path = Path(path)
        self.played = 0
        self._rate = sample_rate
        self._about = dict(about)
        self._changes: list[tuple[int, Mapping[str, Any]]] = []
        self._last: Event = (-1, 0, 0.0, False)
        with output_errors(self.path):
            rename_existing(self.path)
            # the JSON first, so that the CSV is never without it
            self._beside = _Lines(self.path.with_suffix(".json"))
            self._lines = _Lines(self.path)
            head = {"overview_take": VERSION, "sample_rate": sample_rate, **about}
            self._beside.append(_json_line(head))
            self._lines.append(",".join(COLUMNS) + "\n")

    @property
    def played_s(self) -> float:
        """Played duration, s."""
        return self.played / self._rate

    def append(
        self, events: Sequence[Event], changes: Sequence[tuple[int, Mapping[str, Any]]], played: int
    ) -> None:
        """Write events and changes in order, and the number of played samples.

        OSError if a file cannot be written or has been deleted; earlier lines stay complete.
        """
        marks = self._beside.size, self._lines.size
        try:
            self._beside.append(
                "".join(_json_line({"sample": sample, **what}) for sample, what in changes)
                + (_json_line({"sample": played}) if played > self.played else "")
            )
            self._lines.append("".join(event_line(event, self._rate) for event in events))
        except OSError:
            self._beside.cut(marks[0])
            self._lines.cut(marks[1])
            raise
        self.played = max(self.played, played)
        self._changes += changes
        self._last = events[-1] if events else self._last

    def finish(self) -> None:
        """Write the last line, which repeats the last event, and the usual document; close.

        If the document cannot be written, the lines stay. OSError if the last line cannot be
        written.
        """
        last, source, theta2, touching = self._last
        if last < self.played:
            self.append([(self.played, source, theta2, touching)], (), self.played)
        # otherwise another file has this name now
        if self._beside.is_named and self._lines.is_named:
            with contextlib.suppress(InputError, OutputError):
                save_document(self.path, self._rate, self._about, self._changes)
        self.close()

    def close(self) -> None:
        """Close both files without further writing."""
        self._beside.close()
        self._lines.close()

    def continue_at(self, path: Path) -> TakeWriter:
        """Copy this take to another path and continue there; InputError, OutputError."""
        other = TakeWriter(path, self._rate, self._about)
        try:
            other._beside.replace(self._beside)
            other._lines.replace(self._lines)
        except OSError as error:
            other.discard()
            raise output_error(path, error) from error
        other.played, other._last = self.played, self._last
        other._changes = list(self._changes)
        self.close()
        return other

    def discard(self) -> None:
        """Delete both files."""
        self.close()
        for path in (self.path, self.path.with_suffix(".json")):
            path.unlink(missing_ok=True)


class _Lines:
    """Text file to which complete lines are appended."""

    def __init__(self, path: Path) -> None:
        self._path = path
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        self._file = os.open(path, flags, 0o666)  # -1 when closed
        self.size = 0

    @property
    def is_named(self) -> bool:
        """True if the path still refers to this file."""
        try:
            return os.path.samestat(os.fstat(self._file), os.stat(self._path))
        except OSError:
            return False

    def append(self, text: str) -> None:
        """Write lines; after an OSError, an incomplete line may follow the earlier ones."""
        if os.fstat(self._file).st_nlink == 0:
            raise FileNotFoundError(errno.ENOENT, "the file has been deleted", str(self._path))
        self._write(text.encode())

    def _write(self, data: bytes) -> None:
        # a full disk may accept a part of the data before it reports an error
        os.lseek(self._file, self.size, os.SEEK_SET)
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(self._file, rest) :]
        self.size += len(data)

    def cut(self, size: int) -> None:
        """Truncate the file to `size` bytes."""
        # the disk may be gone; a reader ignores an incomplete line
        with contextlib.suppress(OSError):
            os.ftruncate(self._file, size)
        self.size = size

    def replace(self, other: _Lines) -> None:
        """Copy the contents of another file."""
        self.cut(0)
        os.lseek(other._file, 0, os.SEEK_SET)
        while part := os.read(other._file, min(1 << 20, other.size - self.size)):
            self._write(part)

    def close(self) -> None:
        """Close the file; may be called twice."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1


def rename_existing(path: Path) -> None:
    """Rename an existing take and its JSON file to a free name; OSError."""
    both = [one for one in (path, path.with_suffix(".json")) if os.path.lexists(one)]
    if not both:
        return
    number = 1
    while any(os.path.lexists(_numbered(path, number, one)) for one in (".json", path.suffix)):
        number += 1
    for one in both:
        os.rename(one, _numbered(path, number, one.suffix))


def free_name(path: Path) -> Path:
    """Return a free name for a take: take.csv, take-2.csv and so on."""
    number, found = 1, path
    while any(os.path.lexists(one) for one in (found, found.with_suffix(".json"))):
        number += 1
        found = path.with_name(f"{path.stem}-{number}{path.suffix}")
    return found


def _numbered(path: Path, number: int, suffix: str) -> Path:
    return path.with_name(f"{path.stem}.{number}{suffix}")


def _json_line(what: Mapping[str, Any]) -> str:
    return json.dumps(what, ensure_ascii=False, allow_nan=False) + "\n"
