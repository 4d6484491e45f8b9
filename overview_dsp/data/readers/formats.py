"""Supported file formats, in the order in which they are tried.

A new format is one module with `sniff(source) -> bool` and `read(source, options) -> Timeline`, and
one entry in `FORMATS`. Other packages add formats by an entry point (`plugins`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from types import ModuleType

from overview_dsp.data.readers import native
from overview_dsp.data.readers.audio import reader as audio
from overview_dsp.data.readers.cardiac import edf, wfdb_reader
from overview_dsp.data.readers.cardiac import samples_table as heart_table
from overview_dsp.data.readers.data_file import DataFile, Format
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
from overview_dsp.data.readers.plugins import package_readers
from overview_dsp.data.readers.series import charts, series_reader
from overview_dsp.data.readers.tables import arrays, delimited, json, logs, tracks
from overview_dsp.data.readers.tables.table import Table

SERIES_OPTIONS = series_reader.OPTIONS
"""Options of formats of series."""

LIMITS = frozenset({"max_mb", "max_depth"})
"""Options of every format."""

_EVENT_TABLE = frozenset({"duration_s", "time", "kind", "label", "match"})

_LENGTH, _MATCH = frozenset({"duration_s"}), frozenset({"match"})


def _module(name: str, module: ModuleType, options: Iterable[str] = ()) -> Format:
    matches = getattr(module, "matches", None)
    return Format(name, module.sniff, module.read, frozenset(options), matches)


def _series(
    name: str, sniff: Callable[[DataFile], bool], open_table: Callable[[DataFile], Table]
) -> Format:
    read = series_reader.reading(open_table)
    return Format(name, sniff, read, SERIES_OPTIONS, open_table=open_table)


def _begins_with(magic: bytes) -> Callable[[DataFile], bool]:
    return lambda source: source.head.startswith(magic)


FORMATS: tuple[Format, ...] = (
    # before the formats of whole JSON documents
    Format(
        "table of events (one JSON object per line)",
        event_table.sniff_lines,
        event_table.read_lines,
        _EVENT_TABLE,
        open_table=json.JsonLinesTable,
    ),
    _series("series (one JSON object per line)", json.sniff_lines, json.JsonLinesTable),
    _module('native timeline (JSON with the key "overview_timeline")', native),
    _module("chart (MAIDR JSON: lines, bars, histograms, points)", charts, ("match", "map")),
    _module("StatsBomb events (JSON list with period, timestamp and type)", statsbomb),
    Format(
        "StatsBomb events as a table (of statsbombpy or mplsoccer)",
        statsbomb.sniff_table,
        statsbomb.read_table,
    ),
    _module("Metrica raw events (CSV with Team, Type, Subtype and Start Time [s])", metrica),
    _module("Wyscout v2 events (JSON with matchPeriod, eventSec and tags)", wyscout, _MATCH),
    _module(
        "Opta F24, Stats Perform MA3, Sportec, DataFactory, Metrica JSON or Wyscout v3 (with the "
        "extra `football`)",
        kloppy_formats,
    ),
    _module(
        "live services (JSON of API-Football, football-data.org, OpenLigaDB)", services, _MATCH
    ),
    _module("openfootball matches (JSON with team1, team2 and goals)", openfootball, _MATCH),
    Format(
        "openfootball matches (Football.TXT: teams, score, goals in minutes)",
        openfootball.sniff_text,
        openfootball.read,
        _MATCH,
        openfootball.matches,
    ),
    _module("list of minutes (CSV with minute and type or scorer)", minute_list, _MATCH),
    Format(
        "event list (CSV with the columns time_s and kind)",
        event_table.sniff_list,
        event_table.read_list,
        _LENGTH,
    ),
    _module("calendar (iCalendar, .ics)", icalendar, _LENGTH),
    _module("subtitles (SubRip .srt, WebVTT .vtt)", cue_lists, _LENGTH),
    Format(
        "labels (Audacity: start, end and label with tabs between)",
        cue_lists.sniff_labels,
        cue_lists.read_labels,
        _LENGTH,
    ),
    Format(
        "table of events (CSV, TSV, JSON: time, date, minute or start with event, what, type, name "
        "or label; lines of a time and words)",
        event_table.sniff,
        event_table.read,
        _EVENT_TABLE,
        open_table=event_table.open_table,
    ),
    _module("WFDB record (.hea, with .dat and .atr beside it)", wfdb_reader, ("value", "map")),
    _module("recording (EDF, EDF+, with the extra `edf`)", edf, ("value", "map")),
    _module(
        "ECG or pulse wave (table of samples, with rate or a column of times)",
        heart_table,
        ("rate", "value", "time", "map", "max_mb"),
    ),
    _module(
        "recording (WAV, FLAC, Ogg, MP3, AIFF and all others of libsndfile)",
        audio,
        ("map", "max_mb"),
    ),
    _series("track (GPX, TCX, Garmin FIT with the extra `fit`)", tracks.sniff, tracks.open_table),
    _series("log (each line with a date, for map count)", logs.sniff, logs.LogTable),
    _series(
        "series (CSV, TSV: a table with a column of times and one of values)",
        delimited.sniff,
        delimited.open_table,
    ),
    _series(
        "series (JSON: records, columns or pairs of times and values)", json.sniff, json.open_table
    ),
    _series("series (NumPy .npy)", _begins_with(arrays.MAGIC), arrays.open_npy),
    _series("series (NumPy .npz)", _begins_with(arrays.ZIP_MAGIC), arrays.open_npz),
    _series(
        "series (Parquet, with the extra `parquet`)",
        _begins_with(arrays.PARQUET_MAGIC),
        arrays.ParquetTable,
    ),
)
"""Formats of this package, in the order in which they are tried."""


def formats() -> tuple[Format, ...]:
    """Return all formats in the order in which they are tried, those of other packages first."""
    return (*package_readers(), *FORMATS)


def is_series(known: Format) -> bool:
    """Return whether a format is a table of a series, whose rows can also be counted."""
    return known.options == SERIES_OPTIONS
