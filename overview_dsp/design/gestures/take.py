"""Takes: gestures as CSV files with the columns time_s, theta2_rad, touching.

A recorded one (`recorded_take.py`) has sample, sample_rate and source too.
"""

from __future__ import annotations

import csv
import math
import os
import stat
from array import array
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from overview_dsp import validation
from overview_dsp.design.gestures.model import LONGEST_S, SOURCES, Gesture
from overview_dsp.design.gestures.recorded_take import TakeDocument, load_document
from overview_dsp.errors import InputError
from overview_dsp.files.atomic import atomic_file

COLUMNS = ("time_s", "theta2_rad", "touching")
ROUNDED_RAD = 1e-5  # largest rounding error of an angle: 3.141593 is pi to six decimals
_TOUCH = {"1": True, "true": True, "0": False, "false": False}


def load_gesture(path: str | Path) -> Gesture:
    """Read a take: a CSV file with the columns time_s (s), theta2_rad (0 to pi), touching (0, 1).

    A recorded take is replayed with the parameter and surface changes of the JSON beside it.

    Parameters
    ----------
    path : str or path
        The CSV file.

    Returns
    -------
    Gesture
        Gesture that ends with a release of every input.

    Raises
    ------
    InputError
        A missing file or column, text for a number, or decreasing times; names file and line.

    Examples
    --------
    >>> ov.save_gesture(ov.tap(0.8), "take.csv")
    >>> ov.load_gesture("take.csv").duration_s
    0.05
    """
    path = validation.path(path, "a take")
    try:
        # a pipe or a device would block
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise InputError(f"{path}: is not a file; a take is a CSV file")
        with open(path, encoding="utf-8-sig", newline="") as file:
            return _read(file, path)
    except OSError as error:
        raise InputError(f"{path}: can't be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: not UTF-8 text; a take is CSV") from None
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"{str(path)!r}: can't be read ({error})") from None


def _read(file: TextIO, path: Path) -> Gesture:
    rows = csv.reader(file)
    try:
        header = [name.strip() for name in next(rows)]
    except StopIteration:
        raise InputError(f"{path}: empty; a take has the columns {', '.join(COLUMNS)}") from None
    except csv.Error as error:
        raise InputError(f"{path}:1: not CSV: {error}") from None
    missing = [name for name in COLUMNS if name not in header]
    if missing:
        raise InputError(
            f"{path}:1: no column {', '.join(missing)}; a take has {', '.join(COLUMNS)}"
        )
    at = [header.index(name) for name in COLUMNS]
    by = header.index("source") if "source" in header else None
    recorded = "sample" in header and "sample_rate" in header
    # arrays, since tuples of an hour's take would need half a gigabyte
    times, angles, touches, sources = array("d"), array("d"), array("b"), array("b")
    columns: list[array[Any]] = [times, angles, touches, sources]

    def add(*event: float) -> None:
        for column, value in zip(columns, event, strict=True):
            column.append(value)

    event = (0.0, 0.0, False)
    try:
        for row in rows:
            if not row or not any(cell.strip() for cell in row):
                continue
            location = f"{path}:{rows.line_num}"
            try:
                event = _event(row, at, event[0], location)
                source = 0 if by is None else _source(row, by, location)
            except InputError:
                if recorded and _is_cut_short(path) and next(rows, None) is None:
                    break  # the last line is incomplete, since writing was interrupted
                raise
            add(*event, source)
    except csv.Error as error:
        raise InputError(f"{path}:{rows.line_num}: not CSV: {error}") from None
    document = load_document(path) if recorded else TakeDocument((), None)
    if document.played_s is not None and document.played_s > (times[-1] if times else 0.0):
        _, *held = [column[-1] if column else 0 for column in columns]
        add(document.played_s, *held)
    if not times:
        raise InputError(f"{path}: no events; a take has one control event per line")
    # a gesture ends with a release of every input
    for source in sorted(set(sources)):
        last = len(sources) - 1 - sources[::-1].index(source)
        if touches[last]:
            add(times[-1], angles[last], False, source)
    return Gesture(
        np.array(times),
        np.array(angles),
        np.array(touches, dtype=bool),
        times[-1],
        np.array(sources, dtype=np.int8),
        document.changes,
    )


def _is_cut_short(path: Path) -> bool:
    """Return whether the file's last line has no line end."""
    with open(path, "rb") as file:
        file.seek(-1, os.SEEK_END)
        return file.read(1) != b"\n"


def _source(row: list[str], at: int, location: str) -> int:
    name = row[at].strip() if at < len(row) else ""
    if name not in SOURCES:
        raise InputError(f"{location}: source = {name[:60]!r}; must be one of {', '.join(SOURCES)}")
    return SOURCES.index(name)


def _event(
    row: list[str], at: list[int], before: float, location: str
) -> tuple[float, float, bool]:
    if len(row) <= max(at):
        raise InputError(f"{location}: {len(row)} cells; the header needs {max(at) + 1}")
    time_s = _number(row[at[0]], f"{location}: time_s")
    theta2 = _number(row[at[1]], f"{location}: theta2_rad")
    touching = _TOUCH.get(row[at[2]].strip().lower())
    if touching is None:
        raise InputError(f"{location}: touching = {row[at[2]].strip()[:60]!r}; must be 0 or 1")
    if time_s < 0.0:
        raise InputError(f"{location}: time_s = {time_s:g} is negative; a take starts at 0")
    if time_s > LONGEST_S:
        raise InputError(
            f"{location}: time_s = {time_s:g} is out of range; allowed: 0 to {LONGEST_S:g} s"
        )
    if time_s < before:
        raise InputError(
            f"{location}: time_s goes back, {time_s:g} after {before:g}; sort the take by time"
        )
    if not -ROUNDED_RAD <= theta2 <= math.pi + ROUNDED_RAD:
        raise InputError(f"{location}: theta2_rad = {theta2:g} is out of range; allowed: 0 to pi")
    return time_s, min(max(theta2, 0.0), math.pi), touching


def _number(text: str, what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise InputError(f"{what} = {text.strip()[:60]!r} is not a number") from None
    if not math.isfinite(value):
        raise InputError(f"{what} = {text.strip()} is not finite")
    return value


def save_gesture(gesture: Gesture, path: str | Path) -> None:
    """Write a gesture as a take, without rounding.

    A last line repeats the last state if the gesture ends later.

    Parameters
    ----------
    gesture : Gesture
        Gesture; the changes of a recorded take are not written.
    path : str or path
        The CSV file; it is written completely or not at all.

    Raises
    ------
    InputError
        The file cannot be written.
    OutputError
        The disk is full.

    Examples
    --------
    >>> ov.save_gesture(ov.sweep(1.0) + ov.pause(0.5), "sweep.csv")
    """
    path = validation.path(path, "a take")
    validation.instance(gesture, Gesture, "gesture", "ov.sweep makes one")
    events = list(zip(gesture.time_s, gesture.theta2, gesture.touching, strict=True))
    _, theta2, touching = events[-1] if events else (0.0, 0.0, False)
    if not events or events[-1][0] < gesture.duration_s:
        events.append((np.float64(gesture.duration_s), theta2, touching))
    with atomic_file(path) as temporary, open(temporary, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for time_s, theta2, touching in events:
            writer.writerow([repr(float(time_s)), repr(float(theta2)), int(touching)])
