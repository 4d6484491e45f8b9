"""The formats that can be read, in the order in which a file is tried.

A new format is one module with `sniff(source) -> bool` and `read(source, options) -> Timeline`, and
one entry in `FORMATS`; other packages bring theirs by an entry point (`plugins`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from overview_dsp.data.readers import native
from overview_dsp.data.readers.audio import reader as audio
from overview_dsp.data.readers.cardiac import samples_table as heart_table
from overview_dsp.data.readers.cardiac import wfdb_reader
from overview_dsp.data.readers.events import cue_lists, event_table, icalendar
from overview_dsp.data.readers.football import (
    metrica,
    minute_list,
    openfootball,
    openfootball_text,
    providers,
    statsbomb,
    wyscout,
)
from overview_dsp.data.readers.plugins import package_readers
from overview_dsp.data.readers.series import series as series
from overview_dsp.data.readers.source import LoadOptions, Source
from overview_dsp.data.readers.tables import arrays, delimited, json, logs, tracks
from overview_dsp.data.timeline.model import Timeline


@dataclass(frozen=True)
class Format:
    """A file format and its reader.

    Parameters
    ----------
    name
        What an error line calls it.
    sniff
        Whether the source is in this format; cheap, never by the file's name.
    read
        Makes the Timeline; errors begin with the file's path.
    options
        The names of the `LoadOptions` it takes.
    matches
        For files of several matches: gives a line on each, in the order of their numbers.
    """

    name: str
    sniff: Callable[[Source], bool]
    read: Callable[[Source, LoadOptions], Timeline]
    options: frozenset[str] = frozenset()
    matches: Callable[[Source], list[str]] | None = None


_LISTED = frozenset({"duration_s", "time", "kind", "label"})

FORMATS: tuple[Format, ...] = (
    # before the formats of whole JSON documents, which lines of them are not
    Format(
        "table of events (one JSON object a line)",
        event_table.sniff_lines,
        event_table.read_lines,
        _LISTED,
    ),
    Format(
        "series (one JSON object a line)",
        json.sniff_lines,
        series.reading(json.open_lines),
        series.OPTIONS,
    ),
    Format(
        'native timeline (JSON with the key "overview_timeline")',
        native.sniff,
        native.read,
    ),
    Format(
        "StatsBomb events (JSON list with period, timestamp and type)",
        statsbomb.sniff,
        statsbomb.read,
    ),
    Format(
        "Metrica raw events (CSV with Team, Type, Subtype and Start Time [s])",
        metrica.sniff,
        metrica.read,
    ),
    Format(
        "Wyscout v2 events (JSON with matchPeriod, eventSec and tags)",
        wyscout.sniff,
        wyscout.read,
        frozenset({"match"}),
        wyscout.matches,
    ),
    Format(
        "Opta F24, Stats Perform MA3, Sportec, DataFactory, Metrica JSON or Wyscout v3 (with the "
        "extra `football`)",
        providers.sniff,
        providers.read,
    ),
    Format(
        "openfootball matches (JSON with team1, team2 and goals)",
        openfootball.sniff,
        openfootball.read,
        frozenset({"match"}),
        openfootball.matches,
    ),
    Format(
        "openfootball matches (Football.TXT: teams, score, goals in minutes)",
        openfootball_text.sniff,
        openfootball_text.read,
        frozenset({"match"}),
        openfootball_text.matches,
    ),
    Format(
        "list of minutes (CSV with minute and type or scorer)",
        minute_list.sniff,
        minute_list.read,
        frozenset({"match"}),
        minute_list.matches,
    ),
    Format(
        "event list (CSV with the columns time_s and kind)",
        event_table.sniff_list,
        event_table.read_list,
        frozenset({"duration_s"}),
    ),
    Format(
        "calendar (iCalendar, .ics)",
        icalendar.sniff,
        icalendar.read,
        frozenset({"duration_s"}),
    ),
    Format(
        "subtitles (SubRip .srt, WebVTT .vtt)",
        cue_lists.sniff,
        cue_lists.read,
        frozenset({"duration_s"}),
    ),
    Format(
        "labels (Audacity: start, end and label with tabs between)",
        cue_lists.sniff_labels,
        cue_lists.read_labels,
        frozenset({"duration_s"}),
    ),
    Format(
        "table of events (CSV, TSV, JSON: time, date, minute or start with event, what, type, name "
        "or label; lines of clock and words)",
        event_table.sniff,
        event_table.read,
        _LISTED,
    ),
    Format(
        "WFDB record (.hea, with .dat and .atr beside it)",
        wfdb_reader.sniff,
        wfdb_reader.read,
        frozenset({"value", "map"}),
    ),
    Format(
        "ECG or pulse wave (table of samples, with rate or a column of times)",
        heart_table.sniff,
        heart_table.read,
        frozenset({"rate", "value", "time", "map", "max_mb"}),
    ),
    Format(
        "recording (WAV, FLAC, Ogg, MP3, AIFF and what else libsndfile opens)",
        audio.sniff,
        audio.read,
        frozenset({"map", "max_mb"}),
    ),
    Format("track (GPX, TCX)", tracks.sniff, series.reading(tracks.open_table), series.OPTIONS),
    Format(
        "log (lines with a date each, for map count)",
        logs.sniff,
        series.reading(logs.LogTable),
        series.OPTIONS,
    ),
    Format(
        "series (CSV, TSV: a table with a column of times and one of values)",
        delimited.sniff,
        series.reading(delimited.open_table),
        series.OPTIONS,
    ),
    Format(
        "series (JSON: records, columns or pairs of times and values)",
        json.sniff,
        series.reading(json.open_table),
        series.OPTIONS,
    ),
    Format(
        "series (NumPy .npy)", arrays.sniff_npy, series.reading(arrays.open_npy), series.OPTIONS
    ),
    Format(
        "series (NumPy .npz)", arrays.sniff_npz, series.reading(arrays.open_npz), series.OPTIONS
    ),
    Format(
        "series (Parquet, with the extra `parquet`)",
        arrays.sniff_parquet,
        series.reading(arrays.open_parquet),
        series.OPTIONS,
    ),
)
"""The formats of this package, asked in this order."""


def formats() -> tuple[Format, ...]:
    """Return all formats that can be read, in the order they are asked: other packages' first."""
    others = (Format(p.name, p.sniff, p.read, p.options, p.matches) for p in package_readers())
    return (*others, *FORMATS)


def is_series(known: Format) -> bool:
    """Return whether a format is a table of a series, whose rows may be counted too."""
    return known.options == SERIES_OPTIONS


SERIES_OPTIONS = series.OPTIONS
"""The options of tables of series."""

LIMITS = frozenset({"max_mb", "max_depth"})
"""The options every format takes."""
