"""Sources of a live timeline: a file that grows or is replaced, a byte stream, a sound.

`read` of a source yields bytes of a feed, a timeline that was read again, or None if nothing was
received for a moment. Empty bytes show that the source is still connected. The iterator ends with
the feed. It raises `LostError` if the connection is lost; then `read` is called again later.
"""

from __future__ import annotations

import codecs
import contextlib
import json
import os
import time
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, field
from typing import Any, BinaryIO, Protocol

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.analysis.loudness import MIN_RATE, StepMeter
from overview_dsp.data.feeds.feed_lines import HEADER, KEYS, parse_line
from overview_dsp.data.readers.audio.channels import layout_of, weights_of
from overview_dsp.data.readers.audio.reader import timeline_of
from overview_dsp.data.readers.registry import load_timeline
from overview_dsp.data.readers.series.sample_scan import FEW_ROWS
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError

POLL_EVERY_S = 0.05
"""Interval at which a file is checked, s: an announcement then starts within 0.1 s."""

READ_AGAIN_S = 0.25  # minimum interval between two readings of a file that is not a feed, s
MAX_READING_SHARE = 0.2  # maximum share of the time that is spent on reading such a file
CLOSE_TIMEOUT_S = 0.5
DEVICE_CLOSE_TIMEOUT_S = 10.0
"""Timeout for an audio device, s. Exiting before the device is closed can crash the program."""

CHUNK_BYTES = 1 << 16

Received = bytes | Timeline | None


class LostError(Exception):
    """A source is lost for now; `wait_s` is the wait that the source requests before a retry."""

    def __init__(self, reason: str, wait_s: float = 0.0) -> None:
        super().__init__(reason)
        self.wait_s = wait_s


class Source(Protocol):
    """Source of a live timeline; `close_timeout_s` is the time in which it closes, s."""

    name: str
    close_timeout_s: float = CLOSE_TIMEOUT_S

    def read(self) -> Iterator[Received]:
        """Connect and yield the data; LostError, or InputError if a retry is useless."""


def is_feed(head: bytes) -> bool:
    """Return whether a file's first bytes are lines of the feed format.

    Rows of a table may have a key such as `event` too; its value is then no object.
    """
    first = head.lstrip().split(b"\n", 1)[0]
    try:
        key, document = parse_line(first)
    except InputError:
        return first.startswith(b"{") and f'"{HEADER}"'.encode() in first[:64]
    return key in KEYS and (key not in ("event", "detail") or isinstance(document[key], dict))


def _is_complete(head: bytes) -> bool:
    """Return whether a file's first bytes without a newline suffice to detect its format."""
    if not head.strip() or b"\n" in head:
        return bool(head.strip())
    return _is_binary(head) or is_json(head)


def _is_binary(head: bytes) -> bool:
    return b"\0" in head[:CHUNK_BYTES]


def is_json(data: bytes) -> bool:
    """Return whether bytes are one JSON object or array."""
    try:
        json.loads(data)
    except (ValueError, RecursionError):
        return False
    return data.removeprefix(codecs.BOM_UTF8).lstrip()[:1] in (b"{", b"[")


def _is_first_line(data: bytes) -> bool:
    """Return whether a file may be the header or first row of a table that is being written."""
    is_line = data.count(b"\n") == 1 and any(mark in data for mark in (b",", b";", b"\t"))
    return is_line and not _is_binary(data) and b"[" not in data and data.count(b"{") <= 1


@dataclass
class GrowingFile(Source):
    """Path of a file that grows. A feed is read on; any other file is read again when it changes.

    A missing file is waited for. A file that is replaced or truncated is read from its start;
    events that were read before have no effect.
    """

    name: str

    def read(self) -> Iterator[Received]:
        """Yield the content of the file, then its changes."""
        while True:
            try:
                file = open(self.name, "rb")  # noqa: SIM115
            except FileNotFoundError:
                yield None
                time.sleep(POLL_EVERY_S)
                continue
            except OSError as error:
                raise InputError(f"{self.name}: cannot be read ({error.strerror})") from None
            with file:
                head = file.read(CHUNK_BYTES)
                if not _is_complete(head) and len(head) < CHUNK_BYTES:
                    yield None
                    time.sleep(POLL_EVERY_S)
                    continue
                if not is_feed(head):
                    break
                yield head
                yield from self._read_on(file)
        yield from self._read_again()

    def _read_on(self, file: BinaryIO) -> Iterator[Received]:
        while True:
            while data := file.read(CHUNK_BYTES):
                yield data
            yield None
            with contextlib.suppress(OSError):  # the file is missing while it is being replaced
                status = os.stat(self.name)
                if status.st_size < file.tell() or not os.path.samestat(
                    status, os.fstat(file.fileno())
                ):
                    yield b"\n"  # ends an incomplete line
                    return
            time.sleep(POLL_EVERY_S)

    def _read_again(self) -> Iterator[Received]:
        last: tuple[int, int, int] | None = None
        was_read = False
        while True:
            wait_s = POLL_EVERY_S
            timeline = None
            with contextlib.suppress(OSError):
                status = os.stat(self.name)
                state = (status.st_mtime_ns, status.st_size, status.st_ino)
                if state != last:
                    start = time.monotonic()
                    timeline = self._load(first=not was_read)
                    last = state
                    was_read |= timeline is not None
                    if timeline is not None:
                        took_s = time.monotonic() - start
                        wait_s = max(READ_AGAIN_S, took_s / MAX_READING_SHARE)
            yield timeline
            time.sleep(wait_s)

    def _load(self, first: bool) -> Timeline | None:
        """Return the file without an incomplete last line; None if it is invalid at the moment."""
        try:
            with open(self.name, "rb") as file:
                data = file.read()
            end = data.rfind(b"\n") + 1
            if not end or _is_binary(data) or is_json(data):
                return load_timeline(data)
            return load_timeline(data if self.name.endswith(".json") else data[:end])
        except InputError as error:
            few = error.note == FEW_ROWS or _is_first_line(data)
            if first and not (few and not self.name.endswith(".json")):
                raise InputError(f"{self.name}: {error}") from None
            return None


@dataclass
class Stream(Source):
    """Byte stream, such as standard input or a pipe."""

    stream: BinaryIO
    name: str = "standard input"

    def read(self) -> Iterator[bytes]:
        """Yield the bytes until the end of the stream."""
        read = getattr(self.stream, "read1", self.stream.read)
        while data := read(CHUNK_BYTES):
            yield data


ANALYSE_EVERY_S = 0.5  # minimum interval between two searches for cheers, s
MAX_ANALYSIS_SHARE = 0.1  # maximum share of the time that is spent on searching for cheers
LONGEST_S = 27 * 3600.0
"""Duration that is analysed, s, the maximum of an audio file too. Later samples are ignored."""


class LoudnessMonitor:
    """Meter for the loudness of a live sound, which also detects its cheers.

    Loudness and cheers equal those of a file with the same sound. Only ten values per second are
    stored. The background is averaged over a minute ahead too, so a cheer of the last minute may
    still change a little. `on_timeline` receives a timeline of the whole sound so far.

    InputError unless the sound has 1 to 64 channels at `MIN_RATE` (4000) to 768000 Hz.
    """

    def __init__(
        self, sample_rate: int, channels: int, on_timeline: Callable[[Timeline], None]
    ) -> None:
        if sample_rate < MIN_RATE or sample_rate > 768_000 or not 1 <= channels <= 64:
            raise InputError(
                f"the sound has {channels} channels at {sample_rate} Hz; must be 1 to 64 channels "
                f"at {MIN_RATE} to 768000 Hz"
            )
        self._rate, self._channels = sample_rate, channels
        layout = layout_of(channels)
        self._meter = StepMeter(sample_rate, weights_of(layout) if layout else (1.0,) * channels)
        self._waiting: list[NDArray[np.floating[Any]]] = []
        self._frames = self._measured = 0
        self._on_timeline = on_timeline
        self._next_at = 0.0

    def feed(self, block: NDArray[np.floating[Any]]) -> None:
        """Measure the next samples (frames, channels), any number of frames; NaN is missing."""
        if self._measured >= LONGEST_S * self._rate:
            return
        self._waiting.append(block)
        self._frames += len(block)
        whole = self._frames // self._rate * self._rate
        if not whole:
            return
        sound = np.concatenate(self._waiting)
        self._waiting = [sound[whole:].copy()]
        self._frames -= whole
        self._measured += whole
        for start in range(0, whole, self._rate):  # the meter requires whole seconds
            self._meter.feed(sound[start : start + self._rate])
        start_s = time.monotonic()
        if start_s >= self._next_at:
            self._report()
            took_s = time.monotonic() - start_s
            self._next_at = start_s + max(ANALYSE_EVERY_S, took_s / MAX_ANALYSIS_SHARE)

    def end(self) -> None:
        """Measure the remaining samples and report the whole sound."""
        if self._frames:
            self._meter.feed(np.concatenate(self._waiting))
            self._measured += self._frames
        if self._measured:
            self._report()

    def _report(self) -> None:
        kind = f"live sound, {self._channels} channels at {self._rate} Hz"
        self._on_timeline(timeline_of(self._meter.so_far(), "loudness", "", kind, ()))


@dataclass
class Sound(Source):
    """Sound as blocks of samples: its loudness and cheers.

    `open_blocks` returns the rate (Hz), the number of channels, and float blocks of samples.
    """

    name: str
    open_blocks: Callable[[], tuple[int, int, Iterator[np.ndarray | None]]]
    close_timeout_s: float = CLOSE_TIMEOUT_S
    _timelines: list[Timeline] = field(default_factory=list, init=False)
    _monitor: LoudnessMonitor | None = field(default=None, init=False)

    def read(self) -> Iterator[Received]:
        """Yield timelines of the whole sound so far, which continues after a loss."""
        rate, channels, blocks = self.open_blocks()
        timelines = self._timelines
        monitor = self._monitor or LoudnessMonitor(rate, channels, timelines.append)
        self._monitor = monitor
        try:
            for block in blocks:
                if block is not None:
                    monitor.feed(block)
                yield from timelines or (None,)
                timelines.clear()
        finally:
            if isinstance(blocks, Generator):
                blocks.close()
        monitor.end()
        yield from timelines


def pcm_blocks(
    stream: BinaryIO, rate: int, channels: int
) -> tuple[int, int, Iterator[np.ndarray | None]]:
    """Return raw 16-bit samples, little-endian, channels interleaved, as blocks for `Sound`."""

    def blocks() -> Iterator[np.ndarray | None]:
        rest, frame = b"", 2 * channels
        for data in Stream(stream).read():
            rest += data
            whole = len(rest) // frame * frame
            samples = np.frombuffer(rest[:whole], "<i2").reshape(-1, channels)
            rest = rest[whole:]
            yield samples.astype(np.float32) / 32_768.0

    return rate, channels, blocks()
