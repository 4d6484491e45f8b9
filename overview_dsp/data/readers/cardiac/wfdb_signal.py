"""One signal of a WFDB record, read in parts by the wfdb package."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.analysis.heartbeats import MIN_RATE
from overview_dsp.data.readers.cardiac.wfdb_header import (
    NO_FILE,
    Header,
    HeaderSignal,
    frames_in_files,
    read_header,
)
from overview_dsp.data.readers.plugins import require_package
from overview_dsp.errors import InputError, shown

MAX_SAMPLES = 1 << 31
"""Longest signal, samples: eight months at 100 a second."""

_PREFERRED = ("MLII", "II", "ML2", "MLI", "I", "V5", "V2", "V1")
_ECG = re.compile(r"ecg|ekg|^(i{1,3}|av[rlf]|v\d|ml?(i{1,3}|\d)|mv\d|mcl\d?)$|lead", re.I)
_PULSE = re.compile(r"ppg|pleth|pulse|bvp|abp|art\b|bp\b|press", re.I)
MAX_OPEN = 1 << 24
"""Most samples, of all signals together, of a record whose header gives no length."""

_PART = 1 << 20
"""Most samples, of all signals together, that are decoded at a time."""


@dataclass(frozen=True)
class RecordSignal:
    """A signal of a record with signal files (`heart.signal.Signal`)."""

    header: Header
    index: int
    frames: int

    @property
    def name(self) -> str:
        """What the header calls it."""
        return self._described.name

    @property
    def rate(self) -> float:
        """Samples a second: several a frame count."""
        return self.header.rate * self._described.frame

    @property
    def length(self) -> int:
        """How many samples."""
        return self.frames * self._described.frame

    @property
    def _described(self) -> HeaderSignal:
        return self.header.signals[self.index]

    def read(self, first: int, end: int) -> NDArray[np.float64]:
        """Return samples in the header's unit, NaN where the file marks none; InputError."""
        each = self._described.frame
        low, high = first // each, -(-end // each)
        step = max(1, _PART // sum(signal.frame for signal in self.header.signals))
        parts = [self._decoded(at, min(at + step, high)) for at in range(low, high, step)]
        whole = np.concatenate(parts) if parts else np.zeros(0)
        return whole[first - low * each : end - low * each]

    def _decoded(self, low: int, high: int) -> NDArray[np.float64]:
        described = self._described
        if described.file == NO_FILE:
            return np.full((high - low) * described.frame, np.nan)
        if self.header.frames is None:
            samples = self._whole[low * described.frame : high * described.frame]
        else:
            samples = self._asked(sampfrom=low, sampto=high)
        if len(samples) != (high - low) * described.frame:
            raise InputError(
                f"{described.file} gives {len(samples)} samples from frame {low} to {high}; get "
                "the record again"
            )
        return samples

    @cached_property
    def _whole(self) -> NDArray[np.float64]:
        """All samples: without a length in the header wfdb reads all or nothing."""
        return self._asked()

    def _asked(self, **span: int) -> NDArray[np.float64]:
        wfdb: Any = require_package("wfdb", "reading a WFDB record", "ecg")
        try:
            record = wfdb.rdrecord(
                str(self.header.path.with_suffix("")),
                channels=[self.index],
                smooth_frames=False,
                **span,
            )
            return np.asarray(record.e_p_signal[0], dtype=np.float64)
        # what a decoder raises on broken data is not documented
        except Exception as error:
            reason = str(error) or type(error).__name__
            raise InputError(
                f"{self._described.file} can't be decoded ({reason}); get the record again"
            ) from error


@dataclass(frozen=True)
class JoinedSignal:
    """A signal that lies in several records, one after the other (`heart.signal.Signal`).

    `parts`: (its samples before, its samples, the signal or None where it wasn't recorded).
    """

    name: str
    rate: float
    parts: tuple[tuple[int, int, RecordSignal | None], ...]

    @property
    def length(self) -> int:
        """How many samples."""
        before, count, _ = self.parts[-1]
        return before + count

    def read(self, first: int, end: int) -> NDArray[np.float64]:
        """Return samples, NaN where the signal wasn't recorded."""
        found = np.full(end - first, np.nan)
        for before, count, signal in self.parts:
            low, high = max(first, before), min(end, before + count)
            if signal is not None and low < high:
                found[low - first : high - first] = signal.read(low - before, high - before)
        return found


def signal_of(header: Header, wanted: str | None) -> RecordSignal | JoinedSignal | None:
    """Return the signal to read, None for a record without any.

    Parameters
    ----------
    header
        A record's; its segments' headers are read from beside it.
    wanted
        The name of a signal, or its number from 1; None = the one that shows beats best.

    Raises
    ------
    InputError
        No such signal, a signal too long or too slow, segments that don't fit together.
    """
    if header.segments:
        return _joined(header, wanted)
    if not header.signals:
        return None
    index = _chosen([signal.name for signal in header.signals], wanted, header.where)
    frames = header.frames if header.frames is not None else frames_in_files(header)
    if not frames:
        raise InputError(f"{header.where}: a record without samples; give its length in line 1")
    if header.frames is None and frames * len(header.signals) > MAX_OPEN:
        raise InputError(
            f"{header.where}: no length in line 1, and too long to be read without; write {frames} "
            "after the rate"
        )
    found = RecordSignal(header, index, frames)
    _check(found, header)
    return found


def _joined(header: Header, wanted: str | None) -> JoinedSignal:
    headers: dict[str, Header] = {}
    for name in dict.fromkeys(name for name, _ in header.segments if name != NO_FILE):
        headers[name] = segment = read_header(header.beside(f"{name}.hea"))
        if segment.segments:
            raise InputError(f"{header.where}: the segment {name} has segments itself")
        if segment.rate != header.rate:
            raise InputError(
                f"{header.where}: the segment {name} has {segment.rate:g} frames a second and the "
                f"record {header.rate:g}"
            )
    names = list(
        dict.fromkeys(signal.name for segment in headers.values() for signal in segment.signals)
    )
    if not names:
        raise InputError(f"{header.where}: no segment has a signal")
    name = names[_chosen(names, wanted, header.where)]
    each = 1
    found: list[tuple[int, RecordSignal | None]] = []
    for segment_name, frames in header.segments:
        here = headers.get(segment_name)
        signals = here.signals if here else ()
        index = next(
            (i for i, one in enumerate(signals) if one.name == name and one.file != NO_FILE), None
        )
        if here is None or index is None or frames == 0:  # a layout segment has no frames
            found.append((frames, None))
            continue
        if here.frames is not None and here.frames != frames:
            raise InputError(
                f"{header.where}: the segment {segment_name} has {here.frames} frames and the "
                f"record says {frames}"
            )
        found.append((frames, RecordSignal(here, index, frames)))
        if each not in (1, signals[index].frame):
            raise InputError(f"{header.where}: {name} changes its rate in {segment_name}")
        each = signals[index].frame
    parts: list[tuple[int, int, RecordSignal | None]] = []
    before = 0
    for frames, signal in found:
        parts.append((before, frames * each, signal))
        before += frames * each
    joined = JoinedSignal(name, header.rate * each, tuple(parts))
    _check(joined, header)
    return joined


def _check(signal: RecordSignal | JoinedSignal, header: Header) -> None:
    if signal.length > MAX_SAMPLES:
        raise InputError(
            f"{header.where}: {signal.length} samples, more than the {MAX_SAMPLES} that are read; "
            "cut the record into parts"
        )
    if signal.rate < MIN_RATE:
        raise InputError(
            f"{header.where}: {signal.name} has {signal.rate:g} samples a second; beats are found "
            f"from {MIN_RATE:g} up: choose another signal with value"
        )


def _chosen(names: list[str], wanted: str | None, where: str) -> int:
    if wanted is None:
        return best_signal(names)
    index = name_or_number(names, wanted)
    if index is None:
        known = ", ".join(names[:12]) + (" ..." if len(names) > 12 else "")
        raise InputError(f"{where}: no signal is called {shown(wanted)}; there is {known}")
    return index


def name_or_number(names: Sequence[str], wanted: str) -> int | None:
    """Return the signal or column of a name in any case, or of a number from 1; None if none is."""
    small, asked = [name.lower() for name in names], wanted.strip().lower()
    if asked in small:
        return small.index(asked)
    number = int(asked[:9]) if asked.isascii() and asked.isdigit() else 0
    return number - 1 if 1 <= number <= len(names) else None


def best_signal(names: list[str]) -> int:
    """Return which of the signals shows beats best, by their names; the first if none does."""
    for name in _PREFERRED:
        if name in names:
            return names.index(name)
    for pattern in (_ECG, _PULSE):
        for i, name in enumerate(names):
            if pattern.search(name.strip()):
                return i
    return 0
