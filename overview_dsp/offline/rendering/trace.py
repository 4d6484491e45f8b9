"""Trace of the disk: columns in memory and in files (.npz, .csv)."""

from __future__ import annotations

import contextlib
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO, TYPE_CHECKING, TypeVar

import numpy as np

from overview_dsp.arrays import FloatArray
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import atomic_file, output_errors
from overview_dsp.kernels.layout import TRACE_COLUMNS
from overview_dsp.public import dataframe

if TYPE_CHECKING:
    from pandas import DataFrame


class Trace(Mapping[str, FloatArray]):
    """Motion of the disk: columns with one value per frame, `trace.torque` or `trace["torque"]`.

    Parameters
    ----------
    table : float64 (frames, columns)
        All columns.
    names : tuple of str
        Names of the columns, from the attributes below; default: all.

    Attributes
    ----------
    time : float64 (frames,)
        Time of the frame's end, s.
    theta2 : float64 (frames,)
        Smoothed input angle, rad.
    touching : float64 (frames,)
        1 while an input touches the disk, else 0.
    theta1, omega1 : float64 (frames,)
        Angle (rad) and angular velocity (rad/s) of the disk at the frame's end.
    cursor : float64 (frames,)
        Position of the disk on the timeline, 0 to 1.
    friction : float64 (frames,)
        Friction B, N m s/rad.
    torque : float64 (frames,)
        Friction times the step's mean omega1, plus torque of bristles and detents, N m.
    envelope : float64 (frames,)
        Amplitude of the tactor's carrier, linear.
    engaged : float64 (frames,)
        1 while shaft 2 is engaged: from a touch until the disk has arrived after its release.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> result.trace.cursor.max().round(2)
    np.float64(1.0)
    >>> list(result.trace)[:3]
    ['time', 'theta2', 'touching']
    """

    time: FloatArray
    theta2: FloatArray
    touching: FloatArray
    theta1: FloatArray
    omega1: FloatArray
    cursor: FloatArray
    friction: FloatArray
    torque: FloatArray
    envelope: FloatArray
    engaged: FloatArray

    def __init__(self, table: FloatArray, names: tuple[str, ...] = TRACE_COLUMNS) -> None:
        self._table = table
        self._names = names

    if not TYPE_CHECKING:  # a type checker knows the columns above, and no others

        def __getattr__(self, name: str) -> FloatArray:
            # a column is copied on first access
            if name.startswith("_") or name not in self._names:
                raise AttributeError(f"the trace has no column {name!r}")
            column = np.ascontiguousarray(self._table[:, self._names.index(name)])
            setattr(self, name, column)
            return column

    def __getitem__(self, name: str) -> FloatArray:
        """Return a column by its name."""
        if name not in self._names:
            raise KeyError(name)
        column: FloatArray = getattr(self, name)
        return column

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def to_dataframe(self) -> DataFrame:
        """Return a pandas DataFrame with one row per frame.

        Returns
        -------
        pandas.DataFrame
            Columns as the attributes above.

        Raises
        ------
        InputError
            pandas isn't installed.

        Examples
        --------
        >>> result = ov.render("world-cup-final-2018", "football", "sweep:0.5", sample_rate=8000)
        >>> result.trace.to_dataframe()["cursor"].max().round(2)
        np.float64(1.0)
        """
        return dataframe({name: self[name] for name in self})

    def __repr__(self) -> str:
        return f"<Trace: {len(self._table)} frames of {', '.join(self._names)}>"


if TYPE_CHECKING:
    from typing_extensions import TypeVar as DefaultTypeVar

    Traced = DefaultTypeVar("Traced", bound=Trace | None, covariant=True, default=Trace)
else:
    Traced = TypeVar("Traced")
"""Type of a render's trace: `Trace` or `None`."""

FILE_SUFFIXES = (".npz", ".csv")


class TraceWriter(contextlib.ExitStack):
    """Writes a trace file block by block in constant memory, whole or absent.

    Without a path it does nothing. A .npz needs contiguous columns, which are collected in
    temporary files next to the target.
    """

    def __init__(self, path: Path | None) -> None:
        """Raise InputError if the suffix is neither .npz nor .csv."""
        super().__init__()
        if path is not None and path.suffix.lower() not in FILE_SUFFIXES:
            raise InputError(f"{path}: a trace must be {' or '.join(FILE_SUFFIXES)}")
        self._path = path
        self._as_text = path is not None and path.suffix.lower() == ".csv"
        self._columns: list[IO[bytes]] = []
        self._frames = 0
        self._finished = False

    def __enter__(self) -> TraceWriter:
        if self._path is None:
            return self
        # after an error the inner stack removes the temporary files
        with contextlib.ExitStack() as stack:
            self._target = stack.enter_context(atomic_file(self._path))
            with output_errors(self._path):
                if self._as_text:
                    self._columns = [stack.enter_context(open(self._target, "wb"))]
                    self._columns[0].write((",".join(TRACE_COLUMNS) + "\n").encode())
                else:
                    self._columns = [
                        stack.enter_context(tempfile.TemporaryFile(dir=self._path.parent))
                        for _ in TRACE_COLUMNS
                    ]
            stack.push(lambda kind, *_: self.finish() if kind is None else None)
            self.push(stack.pop_all())
        return self

    def write(self, table: FloatArray) -> None:
        """Append float64 (frames, columns)."""
        if self._path is None or not len(table):
            return
        self._frames += len(table)
        with output_errors(self._path):
            if self._as_text:
                lines = (",".join(map(repr, row)) for row in table.tolist())
                self._columns[0].write(("\n".join(lines) + "\n").encode())
            else:
                for column, file in enumerate(self._columns):
                    file.write(np.ascontiguousarray(table[:, column]).tobytes())

    def finish(self) -> None:
        """Write all remaining data, so that a full disk is detected before any file appears."""
        if self._path is None or self._finished:
            return
        self._finished = True
        with output_errors(self._path):
            if self._as_text:
                self._columns[0].flush()
            else:
                self._pack()

    def _pack(self) -> None:
        header = {"descr": "<f8", "fortran_order": False, "shape": (self._frames,)}
        with zipfile.ZipFile(self._target, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
            for name, file in zip(TRACE_COLUMNS, self._columns, strict=True):
                file.seek(0)
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    np.lib.format.write_array_header_1_0(member, header)
                    while piece := file.read(1 << 20):
                        member.write(piece)
