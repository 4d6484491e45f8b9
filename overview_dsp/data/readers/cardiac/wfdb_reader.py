"""WFDB records (PhysioNet): a header (.hea), signal files (.dat) and annotations (.atr).

The user may pass any of the three. Beats and their kinds are read from the annotations, if the
record has an `.atr` file or the user passes another one. Otherwise beats are detected in the
signal. `value` selects the signal, `map` the curve: heart rate or its variability. Time ranges
without a signal, and those too noisy to find beats, are gaps.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from overview_dsp import validation
from overview_dsp.data.analysis.heartbeats import find_beats, silent_parts
from overview_dsp.data.analysis.rhythm import BEATS, OTHERS, Beats
from overview_dsp.data.analysis.runs import Spans
from overview_dsp.data.readers.cardiac import build
from overview_dsp.data.readers.cardiac.wfdb_header import Header, looks_like_header, read_header
from overview_dsp.data.readers.cardiac.wfdb_signal import JoinedSignal, RecordSignal, signal_of
from overview_dsp.data.readers.data_file import DataFile, LoadOptions, printable_path
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.gaps import Gaps
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, printable
from overview_dsp.installation import library_errors, require_package

_ANNOTATION_SUFFIX = ".atr"

_FOREIGN = re.compile(rb"[A-Za-z]{4}|PAR1|ID3|PK\x03|.(NUMPY|HDF|PNG)", re.DOTALL)
"""First bytes of files in other formats (RIFF, Parquet, ZIP) that may share a record's name."""


def sniff(source: DataFile) -> bool:
    """Return whether the file is a WFDB header, or a binary file beside a header of that name."""
    if source.head_text is not None and not source.looks_like_json:
        return looks_like_header(source.head_text)
    header = _header_of(source.path) if source.head_text is None else None
    return header is not None and (
        _FOREIGN.match(source.head) is None or _is_signal_file(source.path, read_header(header))
    )


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a record (takes `value`, `map`, `progress`).

    InputError: the header or a signal file is invalid, the signal or map is unknown, there are no
    heartbeats, or wfdb is not installed.
    """
    with validation.prefix_errors(f"{source.where}: "):
        build.check_map(options)
    is_header = source.head_text is not None
    path = source.path if is_header else _header_of(source.path)
    assert path is not None  # sniffed
    header = read_header(path)
    signal = signal_of(header, options.value)
    is_annotation = not is_header and not _is_signal_file(source.path, header)
    annotation_path = source.path if is_annotation else path.with_suffix(_ANNOTATION_SUFFIX)
    if signal is not None:
        duration_s: float | None = signal.length / signal.rate
    else:
        duration_s = None if header.frames is None else header.frames / header.rate
    annotations = None
    if annotation_path.exists():
        annotations = read_annotations(annotation_path, header.rate, duration_s)
    with validation.prefix_errors(f"{header.where}: "):
        return _timeline(header, signal, annotations, annotation_path.name, duration_s, options)


def _timeline(
    header: Header,
    signal: RecordSignal | JoinedSignal | None,
    annotations: Annotations | None,
    annotation_file: str,
    duration_s: float | None,
    options: LoadOptions,
) -> Timeline:
    notes = annotations.notes if annotations is not None else ()
    beats = annotations.beats if annotations is not None and len(annotations.beats.time_s) else None
    if annotations is not None and beats is None:
        notes = (*notes, f"{annotation_file} has no beats; beats were detected in the signal")
    gaps: tuple[Gaps, tuple[str, ...]] = ((), ())
    record, origin = f"WFDB record {header.name}", f"beats and their kinds from {annotation_file}"
    if signal is None:
        if beats is None:
            raise InputError("the record has neither signals nor annotated beats; use another one")
        duration_s = duration_s or float(beats.time_s[-1])
    else:
        assert duration_s is not None  # known with a signal
        record += f" ({signal.name} at {signal.rate:g} Hz)"
        if beats is not None:
            noisy: Spans = []  # annotated beats are valid in noise, too
            silent, lost = silent_parts(signal, options.report_progress)
        else:
            detection = find_beats(signal, None, options.report_progress)
            silent, noisy, lost = detection.silent, detection.noisy, detection.lost
            beats = build.beats_of(detection, signal.rate)
            origin = f"beats found in {signal.name} ({detection.what})"
        gaps = build.find_gaps(silent, noisy, signal.rate, duration_s)
        if lost:
            notes = (*notes, f"{lost} single samples of {signal.name} are missing")
    description = build.Description(
        header.name, duration_s, f"{record}; {origin}", notes, header.start
    )
    others = annotations.others if annotations else ()
    return build.heart_timeline(description, beats, gaps, others, options, signal)


def _header_of(path: Path) -> Path | None:
    """Return the header of a signal or annotation file; None without one."""
    header = path.with_suffix(".hea")
    if header == path or not header.is_file():
        return None
    with open(header, "rb") as stream:
        head = stream.read(65_536).decode("ascii", "replace")
    return header if looks_like_header(head) else None


def _is_signal_file(path: Path, header: Header) -> bool:
    return path.suffix == ".dat" or any(signal.file == path.name for signal in header.signals)


MAX_BYTES = 16 << 20
"""Maximum size of an annotation file: eight million annotations, or months of beats."""

MAX_OTHERS = 4000
"""Maximum number of annotations of rhythm and signal quality."""


@dataclass(frozen=True, eq=False)
class Annotations:
    """Beats and other events of an annotation file, and notes about omitted ones."""

    beats: Beats
    others: tuple[Event, ...]
    notes: tuple[str, ...]


def read_annotations(path: Path, rate: float, duration_s: float | None) -> Annotations:
    """Read an annotation file.

    `path`: path of the file; its name without the suffix is the name of the record.
    `rate`: frame rate, Hz. The file stores the frame number of each annotation.
    `duration_s`: duration of the record, s; None if unknown. Later annotations are omitted with a
    note.

    InputError: the file is too large or not an annotation file, or wfdb is not installed.
    """
    where = printable_path(path)
    try:
        size = path.stat().st_size
    except OSError as error:
        raise InputError(f"{where}: cannot be read ({error.strerror})") from error
    if size > MAX_BYTES:
        raise InputError(
            f"{where}: size is {size / 2**20:.0f} MB; an annotation file must have at most "
            f"{MAX_BYTES >> 20} MB"
        )
    wfdb: Any = require_package("wfdb", "reading annotations", "ecg")
    with library_errors(
        lambda error: (
            f"{where}: not a WFDB annotation file ({str(error) or type(error).__name__}); "
            "download it again, or remove it to find the beats in the signal"
        )
    ):
        annotation = wfdb.rdann(str(path.with_suffix("")), path.suffix[1:])
        samples = np.asarray(annotation.sample, dtype=np.int64)
        symbols = [str(symbol) for symbol in annotation.symbol]
        texts = [str(note or "").strip("\0 ") for note in annotation.aux_note]
    time_s = samples / rate
    outside = (time_s < 0.0) | (time_s > (np.inf if duration_s is None else duration_s))
    beats: dict[float, tuple[str, str]] = {}
    others: dict[tuple[float, str, str], Event] = {}
    repeated = skipped = 0
    for time, symbol, text, is_outside in zip(
        time_s.tolist(), symbols, texts, outside.tolist(), strict=True
    ):
        if is_outside:
            continue
        if symbol in BEATS:
            repeated += time in beats
            beats.setdefault(time, BEATS[symbol])
        elif symbol in OTHERS:
            kind, meaning = OTHERS[symbol]
            label = " ".join(part for part in (meaning, printable(text)[:200].strip()) if part)
            others.setdefault((time, kind, label), Event(time, kind, label))
        else:
            skipped += 1
    notes = []
    if outside.any():
        notes.append(f"{int(outside.sum())} annotations after the end of the record were omitted")
    if skipped:
        notes.append(f"{skipped} annotations of waves and measurements were omitted")
    if repeated:
        notes.append(f"{repeated} beats have the time of another beat; the first one is used")
    if len(others) > MAX_OTHERS:
        notes.append(
            f"{MAX_OTHERS} of {len(others)} annotations of rhythm and signal quality were read"
        )
    times = sorted(beats)
    kinds, labels = (tuple(beats[time][i] for time in times) for i in (0, 1))
    return Annotations(
        Beats(np.array(times, np.float64), kinds, labels, annotated=True),
        tuple(list(others.values())[:MAX_OTHERS]),
        tuple(notes),
    )
