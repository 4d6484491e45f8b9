"""WFDB annotation files (.atr and others): what people or programs said of each beat."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from overview_dsp.analysis.rhythm import BEATS, OTHERS, Beats
from overview_dsp.errors import InputError
from overview_dsp.readers.extra import needed
from overview_dsp.readers.source import shown_path
from overview_dsp.timeline.event import Event

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
    where = shown_path(path)
    try:
        size = path.stat().st_size
    except OSError as error:
        raise InputError(f"{where}: can't be read ({error.strerror})") from error
    if size > MAX_BYTES:
        raise InputError(
            f"{where}: {size / 2**20:.0f} MB, more than the {MAX_BYTES >> 20} MB an annotation "
            "file may have; is it one?"
        )
    wfdb: Any = needed("wfdb", "reading annotations", "ecg")
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
