"""Tables of GPX, TCX and Garmin FIT tracks, with one row for each point.

A column is present if any point has a value: `speed` (km/h, from the positions of this point and
the one before it, or from the distance a TCX gives), `elevation` (m), `heart_rate` (bpm), `cadence`
(1/min), `distance` (m), `power` (W). Points without a time are left out. All tracks and laps form
one table. The XML is read as a stream; a document type is an error. FIT files are read through
fitdecode (extra `fit`).
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator
from dataclasses import replace
from typing import Any
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import FloatArray
from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.tables.arrays import array_table
from overview_dsp.data.readers.tables.column_names import FIT_FIELDS, TRACK_ELEMENTS
from overview_dsp.data.readers.tables.table import ColumnTable
from overview_dsp.data.timeline.time_parsing import NS, moment
from overview_dsp.errors import InputError
from overview_dsp.installation import library_errors, require_package

MAX_DEPTH = 64
"""Maximum nesting level of the XML; tracks have about ten levels."""

EARTH_M = 6_371_008.8
"""Mean radius of the earth (IUGG)."""

_PIECE = 1 << 20
_LONGEST = 100
"""Maximum number of characters of a value."""

_POINTS = frozenset({"trkpt", "Trackpoint"})
_COLUMNS = tuple(name for name in dict.fromkeys(FIT_FIELDS.values()) if name != "speed")
_SEMICIRCLES = {"position_lat": "lat", "position_long": "lon"}
SPEED = "speed (km/h)"


def sniff(source: DataFile) -> bool:
    """Return whether the file is XML with the root element of GPX or TCX, or a FIT file."""
    return source.xml_root in ("gpx", "TrainingCenterDatabase") or _is_fit(source)


def _is_fit(source: DataFile) -> bool:
    return source.head[8:12] == b".FIT"


def open_table(source: DataFile) -> ColumnTable:
    """Return the points of all tracks; InputError for a broken file, or fewer than two times."""
    times = array("d")
    columns = {name: array("d") for name in ("lat", "lon", "speed", *_COLUMNS)}
    timeless = 0
    for point in _fit_points(source) if _is_fit(source) else _xml_points(source):
        moment = point.pop("time", None)
        if moment is None or not math.isfinite(moment):
            timeless += 1
            continue
        known = {name: value for name, value in point.items() if not math.isnan(value)}
        same = times and moment == times[-1]
        if not same or any(not math.isnan(columns[name][-1]) for name in known):
            times.append(moment)
            for values in columns.values():
                values.append(math.nan)
        for name, value in known.items():  # of one time, different values are of one point
            columns[name][-1] = value
    if len(times) < 2:
        raise InputError(
            f"{len(times)} points of its tracks have a time; a timeline needs two: record the "
            "track with times, not a planned route"
        )
    order = np.argsort(times, kind="stable")
    time_s = np.asarray(times)[order]
    ordered = {name: np.asarray(values)[order] for name, values in columns.items()}
    notes = [f"{timeless} points without a time are left out"] if timeless else []
    table: dict[str, NDArray[Any]] = {
        "time": (time_s * 1e6).astype(np.int64).astype("datetime64[us]")
    }
    table[SPEED] = _speed(time_s, *(ordered[name] for name in ("lat", "lon", "distance (m)")))
    if _is_empty(table[SPEED]):
        table[SPEED] = 3.6 * ordered["speed"]
    table |= {name: ordered[name] for name in _COLUMNS}
    present = [name for name, values in table.items() if not _is_empty(values)]
    if len(present) < 2:
        raise InputError("its points have times, but no positions or other values")
    found = array_table(present, [table[name] for name in present], notes)
    zoned = (replace(found.columns[0], zoned=True), *found.columns[1:])
    kind = "FIT" if _is_fit(source) else "GPX" if source.xml_root == "gpx" else "TCX"
    return replace(found, kind=kind, columns=zoned, row_word="point")


def _fit_points(source: DataFile) -> Iterator[dict[str, float]]:
    """Yield the values of each record of a FIT file; InputError for a damaged one."""
    fitdecode = require_package("fitdecode", "reading a FIT file", "fit")
    with (
        library_errors(lambda e: f"a damaged FIT file ({e}); copy it from the device again"),
        fitdecode.FitReader(
            str(source.path),
            check_crc=fitdecode.CrcCheck.RAISE,
            error_handling=fitdecode.ErrorHandling.IGNORE,
        ) as reader,
    ):
        for frame in reader:
            if frame.frame_type != fitdecode.FIT_FRAME_DATA or frame.name != "record":
                continue
            point: dict[str, float] = {}
            for one in frame.fields:
                if one.name == "timestamp" and hasattr(one.value, "timestamp"):
                    point["time"] = one.value.timestamp()
                elif isinstance(one.value, int | float):
                    if one.name in _SEMICIRCLES:
                        point[_SEMICIRCLES[one.name]] = one.value * 180.0 / 2**31
                    # a developer's field of the same name may have another unit
                    elif one.name in FIT_FIELDS and not getattr(one.field_def, "is_dev", False):
                        point.setdefault(FIT_FIELDS[one.name], float(one.value))
            yield point


def _is_empty(values: NDArray[Any]) -> bool:
    return values.dtype.kind == "f" and bool(np.isnan(values).all())


def _xml_points(source: DataFile) -> Iterator[dict[str, float]]:
    """Yield the values of each point; InputError for XML that is broken or nested too deep."""
    text = source.xml_text
    reader = _Reader()
    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler = reader.start
    parser.EndElementHandler = reader.end
    parser.CharacterDataHandler = reader.text
    try:
        for begin in range(0, len(text), _PIECE):
            parser.Parse(text[begin : begin + _PIECE], False)
            source.options.report_progress(min(1.0, (begin + _PIECE) / len(text)) / 2.0)
            yield from reader.pop_points()
        parser.Parse("", True)
    except expat.ExpatError as error:
        raise InputError(f"broken XML ({error}); get the file again") from error
    yield from reader.pop_points()


class _Reader:
    """Handler of XML tags that collects the values of points."""

    def __init__(self) -> None:
        self._path: list[str] = []
        self._point: dict[str, float] | None = None
        self._text = ""
        self._done: list[dict[str, float]] = []

    def pop_points(self) -> list[dict[str, float]]:
        """Return the points read since the last call."""
        done, self._done = self._done, []
        return done

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        name = tag.rpartition(":")[2]
        self._path.append(name)
        self._text = ""
        if len(self._path) > MAX_DEPTH:
            raise InputError(f"XML nested more than {MAX_DEPTH} levels deep, unlike any track")
        if name in _POINTS:
            self._point = {key: _number(attributes.get(key)) for key in ("lat", "lon")}

    def text(self, text: str) -> None:
        if self._point is not None and len(self._text) < _LONGEST:
            self._text += text

    def end(self, tag: str) -> None:
        name = self._path.pop()
        point, text = self._point, self._text.strip()
        self._text = ""
        if point is None:
            return
        if name in _POINTS:
            self._done.append(point)
            self._point = None
        elif name in ("time", "Time"):
            found = moment((text or "").strip(), "iso")  # UTC without a zone
            point["time"] = math.nan if found is None else found.ns / NS
        elif text and name in TRACK_ELEMENTS:
            point[TRACK_ELEMENTS[name]] = _number(text)
        elif text and name == "Value" and self._path[-1] == "HeartRateBpm":
            point["heart_rate (bpm)"] = _number(text)


def _number(text: str | None) -> float:
    """Return a number, NaN for other texts, which devices write for unknown values."""
    try:
        value = float(text or "nan")
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan


def _speed(
    time_s: FloatArray, lat: FloatArray, lon: FloatArray, distance: FloatArray
) -> FloatArray:
    """Return the speed from the previous point to each point, km/h, NaN if unknown."""
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
    # rounding errors below the precision of a receiver would make turning points
    speed = np.round(speed, 3)
    # the first point gets the speed of the second
    return np.concatenate((speed[:1], speed))
