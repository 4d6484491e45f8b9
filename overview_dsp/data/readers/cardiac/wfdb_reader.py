"""WFDB records (PhysioNet): a header (.hea), signal files (.dat) and annotations (.atr).

Any of the three may be given. Where the record has annotations (`.atr`, or the file given), their
beats and kinds are taken; where not, beats are found in the signal. `value` names the signal,
`map` chooses heart rate or its variability as the curve. Stretches without signal (missing samples,
a lead that is off) or with so much noise that no beat is told from it are gaps.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from overview_dsp import validation
from overview_dsp.data.analysis.heart_signal import Spans
from overview_dsp.data.analysis.heartbeats import find_beats, silent_parts
from overview_dsp.data.analysis.rhythm import BEATS, OTHERS, Beats
from overview_dsp.data.readers.cardiac.build import (
    About,
    check_map,
    detected,
    find_gaps,
    heart_timeline,
)
from overview_dsp.data.readers.cardiac.wfdb_header import Header, looks_like_header, read_header
from overview_dsp.data.readers.cardiac.wfdb_signal import JoinedSignal, RecordSignal, signal_of
from overview_dsp.data.readers.data_file import DataFile, LoadOptions, printable_path
from overview_dsp.data.readers.plugins import require_package
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.gaps import Gaps
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError

_ANNOTATIONS = ".atr"

_OTHERS = re.compile(rb"[A-Za-z]{4}|PAR1|ID3|PK\x03|.(NUMPY|HDF|PNG)", re.DOTALL)
"""How files of other kinds begin that may lie beside a record under its name: RIFF, PAR1 ..."""


def sniff(source: DataFile) -> bool:
    """Return whether the file is a WFDB header, or binary data with its header beside it."""
    if source.head_text is not None and not source.looks_like_json:
        # a header lists its own record; a note that happens to begin likewise has another name
        return looks_like_header(source.head_text)
    header = _header_beside(source.path) if source.head_text is None else None
    return header is not None and (
        _OTHERS.match(source.head) is None or _is_signal_file(source.path, read_header(header))
    )


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a record (takes `value`, `map`, `progress`).

    Raises
    ------
    InputError
        A broken header (which line), a signal file that is missing, too short or elsewhere, an
        unknown signal or map, no heartbeat; wfdb isn't installed.
    """
    with validation.located(f"{source.where}: "):
        check_map(options)
    is_header = source.head_text is not None
    path = source.path if is_header else _header_beside(source.path)
    assert path is not None  # sniffed
    header = read_header(path)
    signal = signal_of(header, options.value)
    given = not is_header and not _is_signal_file(source.path, header)
    noted = source.path if given else path.with_suffix(_ANNOTATIONS)
    if signal is not None:
        duration_s: float | None = signal.length / signal.rate
    else:
        duration_s = None if header.frames is None else header.frames / header.rate
    said = read_annotations(noted, header.rate, duration_s) if noted.exists() else None
    with validation.located(f"{header.where}: "):
        return _timeline(header, signal, said, noted.name, duration_s, options)


def _timeline(
    header: Header,
    signal: RecordSignal | JoinedSignal | None,
    said: Annotations | None,
    noted: str,
    duration_s: float | None,
    options: LoadOptions,
) -> Timeline:
    notes = said.notes if said is not None else ()
    beats = said.beats if said is not None and len(said.beats.time_s) else None
    if said is not None and beats is None:
        notes = (*notes, f"{noted} names no beat: they were found in the signal")
    gaps: tuple[Gaps, tuple[str, ...]] = ((), ())
    record, found = f"WFDB record {header.name}", f"{noted}: its beats and kinds"
    if signal is None:
        if beats is None:
            raise InputError("the record has neither signals nor annotated beats")
        duration_s = duration_s or float(beats.time_s[-1])
    else:
        assert duration_s is not None  # of the signal
        record += f" ({signal.name} at {signal.rate:g} Hz)"
        if beats is not None:
            noisy: Spans = []  # whoever annotated it saw the beats
            silent, lost = silent_parts(signal, options.report_progress)
        else:
            detection = find_beats(signal, None, options.report_progress)
            silent, noisy, lost = detection.silent, detection.noisy, detection.lost
            beats = detected(detection, signal.rate)
            found = f"beats found in {signal.name} ({detection.what})"
        gaps = find_gaps(silent, noisy, signal.rate, duration_s)
        if lost:
            notes = (*notes, f"{lost} single samples of {signal.name} are missing")
    about = About(header.name, duration_s, f"{record}; {found}", notes, header.start)
    return heart_timeline(about, beats, gaps, said.others if said else (), options, signal)


def _header_beside(path: Path) -> Path | None:
    """Return the header of a signal or annotation file's record, None if there is none."""
    header = path.with_suffix(".hea")
    if header == path or not header.is_file():
        return None
    with open(header, "rb") as stream:
        head = stream.read(65_536).decode("ascii", "replace")
    return header if looks_like_header(head) else None


def _is_signal_file(path: Path, header: Header) -> bool:
    return path.suffix == ".dat" or any(signal.file == path.name for signal in header.signals)


MAX_BYTES = 16 << 20
"""Largest annotation file: eight million annotations, months of beats."""

MAX_OTHERS = 4000


@dataclass(frozen=True, eq=False)
class Annotations:
    """What an annotation file says: beats, other events, and what was left out."""

    beats: Beats
    others: tuple[Event, ...]
    notes: tuple[str, ...]


def read_annotations(path: Path, rate: float, duration_s: float | None) -> Annotations:
    """Read an annotation file.

    Parameters
    ----------
    path
        Of the file; its name without the suffix is the record's.
    rate
        Frames a second: annotations count frames.
    duration_s
        The record's; annotations after it are left out with a note. None = unknown.

    Raises
    ------
    InputError
        Too large, or not an annotation file; wfdb isn't installed.
    """
    where = printable_path(path)
    try:
        size = path.stat().st_size
    except OSError as error:
        raise InputError(f"{where}: can't be read ({error.strerror})") from error
    if size > MAX_BYTES:
        raise InputError(
            f"{where}: {size / 2**20:.0f} MB, more than the {MAX_BYTES >> 20} MB an annotation "
            "file may have; is it one?"
        )
    wfdb: Any = require_package("wfdb", "reading annotations", "ecg")
    try:
        found = wfdb.rdann(str(path.with_suffix("")), path.suffix[1:])
        samples = np.asarray(found.sample, dtype=np.int64)
        symbols = [str(symbol) for symbol in found.symbol]
        words = [str(note or "").strip("\0 ") for note in found.aux_note]
    # what a decoder raises on broken data is not documented
    except Exception as error:
        reason = str(error) or type(error).__name__
        raise InputError(
            f"{where}: isn't a WFDB annotation file ({reason}); get it again, or remove it to have "
            "the beats found in the signal"
        ) from error
    time_s = samples / rate
    outside = (time_s < 0.0) | (time_s > (np.inf if duration_s is None else duration_s))
    beats: dict[float, tuple[str, str]] = {}
    others: dict[tuple[float, str, str], Event] = {}
    twice = left_out = 0
    for at, symbol, note, out in zip(
        time_s.tolist(), symbols, words, outside.tolist(), strict=True
    ):
        if out:
            continue
        if symbol in BEATS:
            twice += at in beats
            beats.setdefault(at, BEATS[symbol])
        elif symbol in OTHERS:
            kind, meaning = OTHERS[symbol]
            label = " ".join(part for part in (meaning, _printable(note)) if part)
            others.setdefault((at, kind, label), Event(at, kind, label))
        else:
            left_out += 1
    notes = []
    if outside.any():
        notes.append(f"{int(outside.sum())} annotations after the end of the record are left out")
    if left_out:
        notes.append(f"{left_out} annotations of waves and measurements are left out")
    if twice:
        notes.append(f"{twice} beats are annotated twice at one moment; the first counts")
    if len(others) > MAX_OTHERS:
        notes.append(f"of {len(others)} annotations of rhythm and quality {MAX_OTHERS} are kept")
    ordered = sorted(beats)
    return Annotations(
        Beats(
            np.array(ordered, np.float64),
            tuple(beats[at][0] for at in ordered),
            tuple(beats[at][1] for at in ordered),
            annotated=True,
        ),
        tuple(list(others.values())[:MAX_OTHERS]),
        tuple(notes),
    )


def _printable(note: str) -> str:
    """Return a note without control characters and half characters, cut to a line."""
    return "".join(mark if mark.isprintable() else " " for mark in note)[:200].strip()
