"""Trace files: .npz or .csv, written block by block in constant memory, whole or absent."""

from __future__ import annotations

import contextlib
import tempfile
import zipfile
from pathlib import Path
from types import TracebackType
from typing import IO

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.files.atomic import output_error, whole_file
from overview_dsp.kernels.layout import TRACE_COLUMNS

SUFFIXES = (".npz", ".csv")


class TraceWriter:
    """Writes trace blocks; with no path it does nothing.

    A .npz needs each column in one piece, so columns wait in temporary files beside the target.
    """

    def __init__(self, path: Path | None) -> None:
        """InputError if the suffix is neither .npz nor .csv."""
        if path is not None and path.suffix.lower() not in SUFFIXES:
            raise InputError(f"{path}: a trace is written as {' or '.join(SUFFIXES)}")
        self._path = path
        self._stack = contextlib.ExitStack()
        self._columns: list[IO[bytes]] = []
        self._target: Path | None = None
        self._frames = 0
        self._finished = False

    def __enter__(self) -> TraceWriter:
        if self._path is None:
            return self
        # an error on the way leaves by the inner stack, which takes the temporary files with it
        with contextlib.ExitStack() as stack:
            self._target = stack.enter_context(whole_file(self._path))
            try:
                if self._path.suffix.lower() == ".csv":
                    text = stack.enter_context(open(self._target, "wb"))
                    text.write((",".join(TRACE_COLUMNS) + "\n").encode())
                    self._columns = [text]
                else:
                    self._columns = [
                        stack.enter_context(tempfile.TemporaryFile(dir=self._path.parent))
                        for _ in TRACE_COLUMNS
                    ]
            except OSError as error:
                raise output_error(self._path, error) from None
            stack.push(self._close)
            self._stack = stack.pop_all()
        return self

    def write(self, table: NDArray[np.float64]) -> None:
        """Append float64 (frames, 9)."""
        if self._path is None or not len(table):
            return
        self._frames += len(table)
        try:
            if self._path.suffix.lower() == ".csv":
                lines = (",".join(map(repr, row)) for row in table.tolist())
                self._columns[0].write(("\n".join(lines) + "\n").encode())
            else:
                for column, file in enumerate(self._columns):
                    file.write(np.ascontiguousarray(table[:, column]).tobytes())
        except OSError as error:
            raise output_error(self._path, error) from None

    def finish(self) -> None:
        """Write what still waits: after this, the disk had space for all of it."""
        if self._path is None or self._finished:
            return
        self._finished = True
        try:
            if self._path.suffix.lower() == ".npz":
                self._pack()
            else:
                self._columns[0].flush()
        except OSError as error:
            raise output_error(self._path, error) from None

    def _close(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.finish()

    def _pack(self) -> None:
        assert self._target is not None
        header = {"descr": "<f8", "fortran_order": False, "shape": (self._frames,)}
        with zipfile.ZipFile(self._target, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
            for name, file in zip(TRACE_COLUMNS, self._columns, strict=True):
                file.seek(0)
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    np.lib.format.write_array_header_1_0(member, header)
                    while piece := file.read(1 << 20):
                        member.write(piece)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._stack.__exit__(kind, error, traceback)
