"""GPX and TCX tracks as a table: a row a point with its time, and what is known there.

Columns, where any point has them: `speed` (km/h, from the positions of this point and the one
before it, or from the distance a TCX gives), `elevation` (m), `heart_rate` (bpm), `cadence`
(1/min), `distance` (m). Points without a time are left out; all tracks and laps are one table.
Tags are read as they come, without a tree; XML with a document type is refused.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.tables.arrays import array_table
from overview_dsp.data.readers.tables.table import ColumnTable
from overview_dsp.data.timeline.time_parsing import NS, moment
from overview_dsp.errors import InputError

MAX_DEPTH = 64
"""Levels of XML: a track has ten."""

EARTH_M = 6_371_008.8
"""Mean radius of the earth (IUGG)."""

_PIECE = 1 << 20
_LONGEST = 100
"""Characters of a point's value that are kept."""

_POINTS = frozenset({"trkpt", "Trackpoint"})
_VALUES = {
    "ele": "elevation (m)",
    "AltitudeMeters": "elevation (m)",
    "hr": "heart_rate (bpm)",
    "cad": "cadence (1/min)",
    "Cadence": "cadence (1/min)",
    "RunCadence": "cadence (1/min)",
    "DistanceMeters": "distance (m)",
    "LatitudeDegrees": "lat",
    "LongitudeDegrees": "lon",
}
_COLUMNS = ("elevation (m)", "heart_rate (bpm)", "cadence (1/min)", "distance (m)")
SPEED = "speed (km/h)"

Floats = NDArray[np.float64]


def sniff(source: DataFile) -> bool:
    """Return whether the file is XML whose outermost element is a GPX's or a TCX's."""
    return source.xml_root in ("gpx", "TrainingCenterDatabase")


def open_table(source: DataFile) -> ColumnTable:
    """Return the points of all tracks; InputError for broken XML, no point with a time."""
    times = array("d")
    columns = {name: array("d") for name in ("lat", "lon", *_COLUMNS)}
    timeless = 0
    for point in _points(source.xml_text, source.options.report_progress):
        moment = point.pop("time", None)
        if moment is None or not math.isfinite(moment):
            timeless += 1
            continue
        times.append(moment)
        for name, values in columns.items():
            values.append(point.get(name, math.nan))
    if len(times) < 2:
        raise InputError(
            f"{len(times)} points of its tracks have a time; a timeline needs two: record the "
            "track with times, not a planned route"
        )
    order = np.argsort(times, kind="stable")
    time_s = np.asarray(times)[order]
    known = {name: np.asarray(values)[order] for name, values in columns.items()}
    notes = [f"{timeless} points without a time are left out"] if timeless else []
    table: dict[str, NDArray[Any]] = {
        "time": (time_s * 1e6).astype(np.int64).astype("datetime64[us]")
    }
    table[SPEED] = _speed(time_s, known["lat"], known["lon"], known["distance (m)"])
    table |= {name: known[name] for name in _COLUMNS}
    given = [name for name, values in table.items() if not _is_empty(values)]
    if len(given) < 2:
        raise InputError("its points have neither positions nor anything else but times")
    points = array_table(given, [table[name] for name in given], notes)
    zoned = (replace(points.columns[0], zoned=True), *points.columns[1:])
    kind = "GPX" if source.xml_root == "gpx" else "TCX"
    return replace(points, kind=kind, columns=zoned, row_word="point")


def _is_empty(values: NDArray[Any]) -> bool:
    return values.dtype.kind == "f" and bool(np.isnan(values).all())


def _points(text: str, progress: Callable[[float], None]) -> Iterator[dict[str, float]]:
    """Yield what each point says; InputError for XML that is broken or too deep."""
    reader = _Reader()
    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler = reader.start
    parser.EndElementHandler = reader.end
    parser.CharacterDataHandler = reader.text
    try:
        for begin in range(0, len(text), _PIECE):
            parser.Parse(text[begin : begin + _PIECE], False)
            progress(min(1.0, (begin + _PIECE) / len(text)) / 2.0)
            yield from reader.taken()
        parser.Parse("", True)
    except expat.ExpatError as error:
        raise InputError(f"broken XML ({error}); get the file again") from error
    yield from reader.taken()


class _Reader:
    """Takes tags and keeps what is said of points, and nothing else."""

    def __init__(self) -> None:
        self._path: list[str] = []
        self._point: dict[str, float] | None = None
        self._words = ""
        self._done: list[dict[str, float]] = []

    def taken(self) -> list[dict[str, float]]:
        """Return the points since the last call."""
        done, self._done = self._done, []
        return done

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        name = tag.rpartition(":")[2]
        self._path.append(name)
        self._words = ""
        if len(self._path) > MAX_DEPTH:
            raise InputError(f"XML nested more than {MAX_DEPTH} deep; a track isn't")
        if name in _POINTS:
            self._point = {key: _number(attributes.get(key)) for key in ("lat", "lon")}

    def text(self, words: str) -> None:
        if self._point is not None and len(self._words) < _LONGEST:
            self._words += words

    def end(self, tag: str) -> None:
        name = self._path.pop()
        point, words = self._point, self._words.strip()
        self._words = ""
        if point is None:
            return
        if name in _POINTS:
            self._done.append(point)
            self._point = None
        elif name in ("time", "Time"):
            point["time"] = _seconds(words)
        elif words and name in _VALUES:
            point[_VALUES[name]] = _number(words)
        elif words and name == "Value" and self._path[-1] == "HeartRateBpm":
            point["heart_rate (bpm)"] = _number(words)


def _number(text: str | None) -> float:
    """Return a number, NaN for what is none (as a device writes what it doesn't know)."""
    try:
        value = float(text or "nan")
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan


def _seconds(text: str | None) -> float:
    """Return an ISO moment as seconds since 1970 (UTC where no zone is said), NaN for none."""
    found = moment((text or "").strip(), "iso")
    return math.nan if found is None else found.ns / NS


def _speed(time_s: Floats, lat: Floats, lon: Floats, distance: Floats) -> Floats:
    """Return km/h at each point since the one before it, NaN where that isn't known."""
    step_s = np.diff(time_s)
    phi, theta = np.radians(lat), np.radians(lon)
    half = (
        np.sin(np.diff(phi) / 2.0) ** 2
        + np.cos(phi[1:]) * np.cos(phi[:-1]) * np.sin(np.diff(theta) / 2.0) ** 2
    )
    way = 2.0 * EARTH_M * np.arcsin(np.sqrt(np.clip(half, 0.0, 1.0)))
    gone = np.diff(distance)
    way = np.where(np.isnan(gone) | (gone < 0.0), way, gone)
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.where(step_s > 0.0, 3.6 * way / step_s, np.nan)
    # finer than a receiver knows it, rounding alone would make turning points of a steady pace
    speed = np.round(speed, 3)
    # the first point stands still with the second
    return np.concatenate((speed[:1], speed))
