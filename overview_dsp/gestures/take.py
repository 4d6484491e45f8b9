"""Takes: gestures as CSV files with the columns time_s, theta2_rad, touching."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np

from overview_dsp.errors import InputError
from overview_dsp.files import whole_file
from overview_dsp.gestures.model import Gesture

COLUMNS = ("time_s", "theta2_rad", "touching")
_TOUCH = {"1": True, "true": True, "0": False, "false": False}


def load_gesture(path: str | Path) -> Gesture:
    """A take: CSV with a header and the columns time_s (s), theta2_rad (0 to pi), touching (0, 1).

    Raises
    ------
    InputError
        Missing file, missing column, a word for a number, times that go back: names file and line.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: can't be read ({error.strerror})") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not UTF-8 text (byte {error.start}); a take is CSV") from None
    rows = csv.reader(text.splitlines())
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
    events: list[tuple[float, float, bool]] = []
    try:
        for row in rows:
            if not row or not any(cell.strip() for cell in row):
                continue
            events.append(_event(row, at, events, f"{path}:{rows.line_num}"))
    except csv.Error as error:
        raise InputError(f"{path}:{rows.line_num}: not CSV: {error}") from None
    if not events:
        raise InputError(f"{path}: no events; a take has one control event a line")
    if events[-1][2]:
        # a gesture ends with a release
        events.append((events[-1][0], events[-1][1], False))
    time_s, theta2, touching = zip(*events, strict=True)
    return Gesture(np.array(time_s), np.array(theta2), np.array(touching), events[-1][0])


def _event(
    row: list[str], at: list[int], before: list[tuple[float, float, bool]], place: str
) -> tuple[float, float, bool]:
    if len(row) <= max(at):
        raise InputError(f"{place}: {len(row)} cells; the header needs {max(at) + 1}")
    time_s = _number(row[at[0]], f"{place}: time_s")
    theta2 = _number(row[at[1]], f"{place}: theta2_rad")
    touching = _TOUCH.get(row[at[2]].strip().lower())
    if touching is None:
        raise InputError(f"{place}: touching = {row[at[2]].strip()!r}; it is 0 or 1")
    if time_s < 0.0:
        raise InputError(f"{place}: time_s = {time_s:g} is negative; a take starts at 0")
    if before and time_s < before[-1][0]:
        raise InputError(
            f"{place}: time_s goes back, {time_s:g} after {before[-1][0]:g}; sort the take by time"
        )
    if not -1e-9 <= theta2 <= math.pi + 1e-9:
        raise InputError(f"{place}: theta2_rad = {theta2:g} is out of range; it is 0 to pi")
    return time_s, min(max(theta2, 0.0), math.pi), touching


def _number(text: str, what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise InputError(f"{what} = {text.strip()!r} is not a number") from None
    if not math.isfinite(value):
        raise InputError(f"{what} = {text.strip()} is not finite")
    return value


def save_gesture(gesture: Gesture, path: str | Path) -> None:
    """Write a gesture as a take; numbers keep every bit."""
    with whole_file(path) as temporary, open(temporary, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for time_s, theta2, touching in zip(
            gesture.time_s, gesture.theta2, gesture.touching, strict=True
        ):
            writer.writerow([repr(float(time_s)), repr(float(theta2)), int(touching)])
