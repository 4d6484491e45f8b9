"""Signal of a WFDB record, which the wfdb package decodes in parts."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from overview_dsp.arrays import FloatArray
from overview_dsp.data.analysis.heartbeats import MIN_RATE
from overview_dsp.data.readers.cardiac.wfdb_header import (
    NO_FILE,
    Header,
    HeaderSignal,
    frames_in_files,
    read_header,
)
from overview_dsp.errors import InputError, quoted
from overview_dsp.installation import library_errors, require_package

MAX_SAMPLES = 1 << 31
"""Maximum number of samples of a signal: eight months at 100 Hz."""

_PREFERRED = ("MLII", "II", "ML2", "MLI", "I", "V5", "V2", "V1")
_ECG = re.compile(r"ecg|ekg|^(i{1,3}|av[rlf]|v\d|ml?(i{1,3}|\d)|mv\d|mcl\d?)$|lead", re.I)
_PULSE = re.compile(r"ppg|pleth|pulse|bvp|abp|art\b|bp\b|press", re.I)
MAX_UNSIZED_SAMPLES = 1 << 24
"""Maximum number of samples, all signals together, of a record without a length."""

MAX_PART = 1 << 20
"""Maximum number of samples, all signals together, that are decoded at a time."""


@dataclass(frozen=True)
class RecordSignal:
    """Signal of a record with signal files (implements `heart_signal.Signal`)."""

    header: Header
    index: int
    frames: int

    @property
    def name(self) -> str:
        """Name in the header."""
        return self._signal.name

    @property
    def rate(self) -> float:
        """Sample rate, Hz."""
        return self.header.rate * self._signal.per_frame

    @property
    def length(self) -> int:
        """Number of samples."""
        return self.frames * self._signal.per_frame

    @property
    def _signal(self) -> HeaderSignal:
        return self.header.signals[self.index]

    def read(self, first: int, end: int) -> FloatArray:
        """Return samples in the header's unit, NaN for missing ones; InputError if unreadable."""
        per_frame = self._signal.per_frame
        low, high = first // per_frame, -(-end // per_frame)
        step = max(1, MAX_PART // sum(signal.per_frame for signal in self.header.signals))
        parts = [self._decoded(start, min(start + step, high)) for start in range(low, high, step)]
        whole = np.concatenate(parts) if parts else np.zeros(0)
        return whole[first - low * per_frame : end - low * per_frame]

    def _decoded(self, low: int, high: int) -> FloatArray:
        file, per_frame = self._signal.file, self._signal.per_frame
        if file == NO_FILE:
            return np.full((high - low) * per_frame, np.nan)
        if self.header.frames is None:
            samples = self._whole[low * per_frame : high * per_frame]
        else:
            samples = self._decode(sampfrom=low, sampto=high)
        if len(samples) != (high - low) * per_frame:
            raise InputError(
                f"{file} has {len(samples)} samples in frames {low} to {high}; must have "
                f"{(high - low) * per_frame}: download the record again"
            )
        return samples

    @cached_property
    def _whole(self) -> FloatArray:
        """All samples, because wfdb cannot read a part of a record without a length."""
        return self._decode()

    def _decode(self, **span: int) -> FloatArray:
        wfdb: Any = require_package("wfdb", "reading a WFDB record", "ecg")
        path, file = str(self.header.path.with_suffix("")), self._signal.file
        with library_errors(
            lambda error: (
                f"{file} cannot be decoded ({str(error) or type(error).__name__}); "
                "download the record again"
            )
        ):
            record = wfdb.rdrecord(path, channels=[self.index], smooth_frames=False, **span)
            return np.asarray(record.e_p_signal[0], dtype=np.float64)


@dataclass(frozen=True)
class JoinedSignal:
    """Signal of a record of consecutive segments (implements `heart_signal.Signal`).

    Each of `parts` has the index of its first sample, its number of samples, and the signal, None
    if the segment lacks it.
    """

    name: str
    rate: float
    parts: tuple[tuple[int, int, RecordSignal | None], ...]

    @property
    def length(self) -> int:
        """Number of samples."""
        first, count, _ = self.parts[-1]
        return first + count

    def read(self, first: int, end: int) -> FloatArray:
        """Return samples, with NaN in segments that lack the signal."""
        samples = np.full(end - first, np.nan)
        for start, count, signal in self.parts:
            low, high = max(first, start), min(end, start + count)
            if signal is not None and low < high:
                samples[low - first : high - first] = signal.read(low - start, high - start)
        return samples


def signal_of(header: Header, selector: str | None) -> RecordSignal | JoinedSignal | None:
    """Return the signal to read; None for a record without signals.

    `header`: header of the record. The headers of its segments are in the same folder.
    `selector`: name of a signal, or its number from 1; None selects the best one for finding beats.

    InputError: the signal is unknown, too long or has too low a rate, or the segments do not match.
    """
    if header.segments:
        return _joined_signal(header, selector)
    if not header.signals:
        return None
    index = _select([signal.name for signal in header.signals], selector, header.where)
    frames = header.frames if header.frames is not None else frames_in_files(header)
    if not frames:
        raise InputError(
            f"{header.where}: the record has no samples; write its number of samples in line 1"
        )
    samples = frames * sum(one.per_frame for one in header.signals)
    if header.frames is None and samples > MAX_UNSIZED_SAMPLES:
        raise InputError(
            f"{header.where}: line 1 has no length, which a record of this size requires; write "
            f"{frames} after the rate"
        )
    signal = RecordSignal(header, index, frames)
    _check(signal, header)
    return signal


def _joined_signal(header: Header, selector: str | None) -> JoinedSignal:
    headers: dict[str, Header] = {}
    for name in dict.fromkeys(name for name, _ in header.segments if name != NO_FILE):
        headers[name] = segment = read_header(header.path_of(f"{name}.hea"))
        if segment.segments:
            raise InputError(
                f"{header.where}: the segment {name} has segments; must be a record with signals"
            )
        if segment.rate != header.rate:
            raise InputError(
                f"{header.where}: the segment {name} has {segment.rate:g} frames per second; must "
                f"be {header.rate:g}, as in the record"
            )
    names = list(
        dict.fromkeys(signal.name for segment in headers.values() for signal in segment.signals)
    )
    if not names:
        raise InputError(f"{header.where}: no segment has a signal; download the record again")
    name = names[_select(names, selector, header.where)]
    per_frame = 0
    found: list[tuple[int, RecordSignal | None]] = []
    for segment_name, frames in header.segments:
        segment_header = headers.get(segment_name)
        signals = segment_header.signals if segment_header else ()
        index = next(
            (i for i, one in enumerate(signals) if one.name == name and one.file != NO_FILE), None
        )
        if segment_header is None or index is None or frames == 0:  # a layout has no frames
            found.append((frames, None))
            continue
        if segment_header.frames is not None and segment_header.frames != frames:
            raise InputError(
                f"{header.where}: the segment {segment_name} has {segment_header.frames} frames; "
                f"must be {frames}, as in the record"
            )
        found.append((frames, RecordSignal(segment_header, index, frames)))
        if per_frame not in (0, signals[index].per_frame):
            raise InputError(
                f"{header.where}: the rate of {name} changes in the segment {segment_name}; must "
                "be constant"
            )
        per_frame = signals[index].per_frame
    parts: list[tuple[int, int, RecordSignal | None]] = []
    first, per_frame = 0, per_frame or 1  # without a signal
    for frames, signal in found:
        parts.append((first, frames * per_frame, signal))
        first += frames * per_frame
    joined = JoinedSignal(name, header.rate * per_frame, tuple(parts))
    _check(joined, header)
    return joined


def _check(signal: RecordSignal | JoinedSignal, header: Header) -> None:
    if signal.length > MAX_SAMPLES:
        raise InputError(
            f"{header.where}: the signal has {signal.length} samples; must be at most "
            f"{MAX_SAMPLES}: cut the record into parts"
        )
    if signal.rate < MIN_RATE:
        raise InputError(
            f"{header.where}: the rate of {signal.name} is {signal.rate:g} Hz; must be at least "
            f"{MIN_RATE:g} to find beats: choose another signal with value (--value-column)"
        )


def _select(names: list[str], selector: str | None, where: str) -> int:
    if selector is None:
        return best_signal(names)
    index = index_of(names, selector)
    if index is None:
        known = ", ".join(names[:12]) + (" ..." if len(names) > 12 else "")
        raise InputError(f"{where}: no signal is called {quoted(selector)}; available: {known}")
    return index


def index_of(names: Sequence[str], selector: str) -> int | None:
    """Return the index of a name in any case, or of a number from 1; None if there is none.

    InputError: several have the name.
    """
    lower_names, selector = [name.lower() for name in names], selector.strip().lower()
    if lower_names.count(selector) > 1:
        same = ", ".join(str(i) for i, name in enumerate(lower_names, 1) if name == selector)
        name = names[lower_names.index(selector)]
        raise InputError(
            f"signals {same} are called {quoted(name)}; give the number of one as value "
            "(--value-column)"
        )
    if selector in lower_names:
        return lower_names.index(selector)
    number = int(selector[:9]) if selector.isascii() and selector.isdigit() else 0
    return number - 1 if 1 <= number <= len(names) else None


def best_signal(names: list[str]) -> int:
    """Return the index of the best signal for finding beats, by its name; 0 if none is known."""
    for name in _PREFERRED:
        if name in names:
            return names.index(name)
    for pattern in (_ECG, _PULSE):
        for i, name in enumerate(names):
            if pattern.search(name.strip()):
                return i
    return 0


def is_heart(name: str) -> bool:
    """Return whether a signal is called like an ECG or a pulse wave."""
    return _ECG.search(name.strip()) is not None or _PULSE.search(name.strip()) is not None
