"""EDF and EDF+ recordings (EEG, ECG, sleep), through edfio (extra `edf`).

An ECG or a pulse wave becomes a heart recording; any other signal is the curve. `value` names the
signal. Annotations of EDF+ are events.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from datetime import date, datetime
from typing import Any

import numpy as np

from overview_dsp.data.analysis.heart_signal import Samples
from overview_dsp.data.analysis.heartbeats import find_beats
from overview_dsp.data.readers.cardiac.build import MAPS, Description, detected_timeline
from overview_dsp.data.readers.cardiac.wfdb_signal import best_signal, index_of, is_heart
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.events.timeline_builder import DEFAULT_KIND, kind_of
from overview_dsp.data.readers.series.series_reader import series_timeline
from overview_dsp.data.readers.tables.arrays import array_table
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, quoted
from overview_dsp.installation import library_errors, require_package

_NO_DATE = date(1985, 1, 1)  # of recordings whose date was removed


def sniff(source: DataFile) -> bool:
    """Return whether the file begins like EDF: version 0, and the size of its header."""
    size = source.head[184:192].strip()
    return source.head[:8] == b"0       " and size.isdigit() and int(size) % 256 == 0


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a signal (takes `value`, `map`); InputError for a damaged file or an unknown signal."""
    edfio = require_package("edfio", "reading an EDF file", "edf")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # damage is an error below
        if source.head[192:197] == b"EDF+D":
            raise InputError("an EDF+D recording with gaps; convert it to EDF+C")
        with library_errors(lambda error: f"a damaged EDF file ({error}); get it again"):
            # headers should be ASCII, but units such as µV exist
            recording = edfio.read_edf(source.path, header_encoding="latin-1")
            names = list(recording.labels)
            start = _start(recording)
            annotations = [(note.onset, note.text) for note in recording.annotations]
            if not names and annotations:
                # a file without signals, such as a hypnogram
                duration_s = max([recording.duration, *(onset for onset, _ in annotations)])
                found = tuple(_events(annotations, duration_s))
                origin = "annotations of an EDF+ file"
                return Timeline(source.stem, duration_s, found, provenance=origin, start=start)
            chosen = _index(names, options.value)
            signal, name = recording.signals[chosen], names[chosen]
            for what in ("digital", "physical"):
                low, high = getattr(signal, f"{what}_min"), getattr(signal, f"{what}_max")
                if low == high:
                    raise InputError(
                        f"signal {quoted(name)} has no scale: its {what} minimum and maximum are "
                        f"{low:g}; export it again, or name another signal"
                    )
            values = np.asarray(signal.data, dtype=np.float32)
            declared = int(source.head[236:244])
            rate, unit = float(signal.sampling_frequency), str(signal.physical_dimension)
            if recording.num_data_records < declared:
                raise InputError(
                    f"the file is cut off: {recording.num_data_records} of {declared} records; "
                    "get it again"
                )
        events = _events(annotations, len(values) / rate)
        if options.map in MAPS or (options.map is None and is_heart(name)):
            heart = Samples(name, rate, values)
            beats = find_beats(heart, None, options.report_progress)
            duration_s = heart.length / rate
            origin = f"EDF signal {name} at {rate:g} Hz; {beats.what}; beats found in it"
            description = Description(source.stem, duration_s, origin, (), start)
            return detected_timeline(description, beats, heart, events, options)
        header = f"{name} ({unit})" if unit else name
        table = replace(array_table([header], [values]), kind="sampled EDF")
        timeline = series_timeline(table, replace(options, value=None, rate=rate), source.stem)
        merged = sorted((*timeline.events, *events), key=lambda event: event.time_s)
        return replace(timeline, events=tuple(merged), start=start)


def _start(recording: Any) -> datetime | None:
    """Return the beginning of a recording, None if its date was removed."""
    try:
        start: datetime = recording.startdatetime
    except ValueError:  # "Startdate X", or no date
        return None
    return None if start.date() == _NO_DATE else start


def _events(annotations: list[tuple[float, str]], duration_s: float) -> list[Event]:
    return [
        Event(onset, kind_of(text) or DEFAULT_KIND, text)
        for onset, text in annotations
        if text and 0.0 <= onset <= duration_s
    ]


def _index(names: list[str], value: str | None) -> int:
    """Return the signal that the option names, the only one, or the one that shows a heart best."""
    chosen = best_signal(names) if value is None else index_of(names, value)
    if chosen is None or (value is None and len(names) != 1 and not is_heart(names[chosen])):
        listed = ", ".join(map(quoted, names[:12]))
        raise InputError(
            f"{len(names)} signals; name one with value (--value-column), or its number: {listed}"
        )
    return chosen
