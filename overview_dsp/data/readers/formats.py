"""Supported file formats, in the order in which they are tried.

A new format is one module with `sniff(source) -> bool` and `read(source, options) -> Timeline`, and
one entry in `FORMATS`. Other packages add formats by the entry-point group `overview_dsp.readers`.
The object of an entry point (usually a module) has

- `name`: name of the format in error messages;
- `sniff(head: bytes) -> bool`: whether a file with these first bytes (64 kB) has the format;
- `read(path: str, **options) -> Timeline`: raises InputError for errors in the file;
- `options` (optional): options of `load_timeline` that it takes, such as `("rate", "value")`;
- `matches(path: str) -> list of str` (optional): one line per match in a file of several.

These formats are tried before those of this package. A reader that can't be loaded is left out
with one warning. An error that is not an InputError is reported with the name of the package.
"""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterable, Iterator
from importlib.metadata import EntryPoint, entry_points
from types import ModuleType
from typing import Any

from overview_dsp.data.readers import native
from overview_dsp.data.readers.audio import reader as audio
from overview_dsp.data.readers.cardiac import edf, wfdb_reader
from overview_dsp.data.readers.cardiac import samples_table as heart_table
from overview_dsp.data.readers.data_file import DataFile, Format, LoadOptions
from overview_dsp.data.readers.events import cue_lists, event_table, icalendar
from overview_dsp.data.readers.football import (
    kloppy_formats,
    metrica,
    minute_list,
    openfootball,
    services,
    statsbomb,
    wyscout,
)
from overview_dsp.data.readers.series import charts, series_reader
from overview_dsp.data.readers.tables import arrays, delimited, json, json_lines, logs, tracks
from overview_dsp.data.readers.tables.json_lines import JsonLinesTable
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, warn
from overview_dsp.files.toml import load_toml

Sniff = Callable[[DataFile], bool]
Read = Callable[[DataFile, LoadOptions], Timeline]
OpenTable = Callable[[DataFile], Any]

SERIES_OPTIONS = series_reader.OPTIONS
"""Options of formats of series."""

LIMITS = frozenset({"max_mb", "max_depth"})
"""Options of every format."""

_EVENT_TABLE = frozenset({"duration_s", "time", "kind", "label", "match"})
_NAMES: dict[str, str] = load_toml(__file__, "formats.toml")

_LENGTH, _MATCH = frozenset({"duration_s"}), frozenset({"match"})


def _module(
    name: str, module: ModuleType, options: Iterable[str] = (), sniff: Sniff | None = None
) -> Format:
    matches = getattr(module, "matches", None)
    return Format(_NAMES[name], sniff or module.sniff, module.read, frozenset(options), matches)


def _events(name: str, sniff: Sniff, read: Read, open_table: OpenTable) -> Format:
    return Format(_NAMES[name], sniff, read, _EVENT_TABLE, open_table=open_table)


def _series(name: str, sniff: Sniff, open_table: OpenTable) -> Format:
    read = series_reader.reading(open_table)
    return Format(_NAMES[name], sniff, read, SERIES_OPTIONS, open_table=open_table)


def _begins_with(magic: bytes) -> Callable[[DataFile], bool]:
    return lambda source: source.head.startswith(magic)


FORMATS: tuple[Format, ...] = (
    # before the formats of whole JSON documents
    _events("event_lines", event_table.sniff_lines, event_table.read_lines, JsonLinesTable),
    _series("series_lines", json_lines.sniff, JsonLinesTable),
    _module("native", native),
    _module("charts", charts, ("match", "map")),
    _module("statsbomb", statsbomb),
    Format(_NAMES["statsbomb_table"], statsbomb.sniff_table, statsbomb.read_table),
    _module("metrica", metrica),
    _module("wyscout", wyscout, _MATCH),
    _module("kloppy", kloppy_formats),
    _module("services", services, _MATCH),
    _module("openfootball", openfootball, _MATCH),
    _module("football_txt", openfootball, _MATCH, openfootball.sniff_text),
    _module("minutes", minute_list, _MATCH),
    Format(_NAMES["event_list"], event_table.sniff_list, event_table.read_list, _LENGTH),
    _module("calendar", icalendar, _LENGTH),
    _module("subtitles", cue_lists, _LENGTH),
    Format(_NAMES["labels"], cue_lists.sniff_labels, cue_lists.read_labels, _LENGTH),
    _events("events", event_table.sniff, event_table.read, event_table.open_table),
    _module("wfdb", wfdb_reader, ("value", "map")),
    _module("edf", edf, ("value", "map")),
    _module("heart_table", heart_table, ("rate", "value", "time", "map", "max_mb")),
    _module("audio", audio, ("map", "max_mb")),
    _series("tracks", tracks.sniff, tracks.open_table),
    _series("logs", logs.sniff, logs.LogTable),
    _series("series_text", delimited.sniff, delimited.open_table),
    _series("series_json", json.sniff, json.open_table),
    _series("npy", _begins_with(arrays.MAGIC), arrays.open_npy),
    _series("npz", _begins_with(arrays.ZIP_MAGIC), arrays.open_npz),
    _series("parquet", _begins_with(arrays.PARQUET_MAGIC), arrays.ParquetTable),
)
"""Formats of this package, in the order in which they are tried."""


def formats() -> tuple[Format, ...]:
    """Return all formats in the order in which they are tried, those of other packages first."""
    return (*package_readers(), *FORMATS)


def is_series(known: Format) -> bool:
    """Return whether a format is a table of a series, whose rows can also be counted."""
    return known.options == SERIES_OPTIONS


GROUP = "overview_dsp.readers"

_OPTIONS = frozenset({"duration_s", "value", "time", "map", "rate", "match"})
"""Options that a reader may take."""


@functools.cache
def package_readers() -> tuple[Format, ...]:
    """Return the formats of installed packages, sorted by name."""
    found = []
    for point in sorted(entry_points(group=GROUP), key=lambda point: (_package(point), point.name)):
        package = _package(point)
        try:
            reader = point.load()
            missing = [n for n in ("name", "sniff", "read") if not hasattr(reader, n)]
            options = _option_names(getattr(reader, "options", ()))
        except Exception as error:  # its import may raise any error
            _warn(package, f"can't be loaded ({_error_text(error)})")
            continue
        if missing:
            _warn(package, f"has no {' and no '.join(missing)}")
            continue
        found.append(_format_of(reader, package, options))
    return tuple(found)


def _format_of(reader: Any, package: str, options: frozenset[str]) -> Format:
    """Return the format of an entry point; errors of its reader become one line."""

    def sniff(source: DataFile) -> bool:
        try:
            return bool(reader.sniff(source.head))
        except Exception as error:  # then the file is not of this format
            _warn(package, f"failed to look at a file ({_error_text(error)})")
            return False

    def read(source: DataFile, chosen: LoadOptions) -> Timeline:
        arguments = {name: getattr(chosen, name) for name in options & chosen.names_set()}
        with _reader_errors(source, package):
            timeline = reader.read(str(source.path), **arguments)
        if not isinstance(timeline, Timeline):
            raise InputError(
                f"{source.where}: the reader of {package} gave a {type(timeline).__name__}, not a "
                "Timeline; report this to its authors"
            )
        return timeline

    def matches(source: DataFile) -> list[str]:
        with _reader_errors(source, package):
            return [str(line) for line in reader.matches(str(source.path))]

    has_matches = getattr(reader, "matches", None) is not None
    return Format(str(reader.name), sniff, read, options, matches if has_matches else None)


@contextlib.contextmanager
def _reader_errors(source: DataFile, package: str) -> Iterator[None]:
    """Let each error of a package's reader become an InputError that begins with the file."""
    try:
        yield
    except InputError as error:
        message = str(error)
        where = "" if message.startswith(source.where) else f"{source.where}: "
        raise InputError(where + message) from error
    except Exception as error:
        raise InputError(
            f"{source.where}: the reader of {package} failed ({_error_text(error)}); "
            "report this to its authors"
        ) from error


def _option_names(names: Iterable[object]) -> frozenset[str]:
    options = frozenset(str(name) for name in names)
    if unknown := sorted(options - _OPTIONS):
        raise InputError(f"unknown: {', '.join(unknown)}; known: {', '.join(sorted(_OPTIONS))}")
    return options


def _package(point: EntryPoint) -> str:
    return f"{point.dist.name if point.dist is not None else point.value} ({point.name})"


def _warn(package: str, what: str) -> None:
    warn(f"the reader of {package} {what}; it is left out", 3)


def _error_text(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:200]
