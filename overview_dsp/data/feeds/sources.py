"""What a timeline is followed from: a file that grows or is replaced, a stream of bytes, a sound.

A source is an iterator of what came: bytes of a feed (none of them are a sign of life), a timeline
that was read anew, or None where nothing came for a moment. It ends where the feed does, and raises
`LostError` where it is lost but may come back; then it is asked again.
"""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from typing import Any, BinaryIO, Protocol

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.analysis.loudness import MIN_RATE, StepMeter
from overview_dsp.data.feeds.feed_lines import KEYS
from overview_dsp.data.readers.audio.channels import layout_of, weights_of
from overview_dsp.data.readers.audio.reader import timeline_of
from overview_dsp.data.readers.registry import load_timeline
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError

LOOK_EVERY_S = 0.05
"""How often a file is looked at: a goal is felt within a tenth of a second."""

READ_AGAIN_S = 0.25
"""A file that isn't a feed is read anew at most so often ..."""

ENDS_WITHIN_S = 0.5
DEVICE_ENDS_WITHIN_S = 10.0
"""A device that isn't given back before the program ends takes the program with it."""

BUSY_PART = 0.2
"""... and less often if that takes longer than this part of the time."""

CHUNK_BYTES = 1 << 16

Came = bytes | Timeline | None


class LostError(Exception):
    """A source that is gone for now: why, and how long it asks to be left alone, s."""

    def __init__(self, why: str, wait_s: float = 0.0) -> None:
        super().__init__(why)
        self.wait_s = wait_s


class Source(Protocol):
    """Where a feed comes from; `ends_within_s`: what it opened is given back in so long."""

    name: str
    ends_within_s: float

    def come(self) -> Iterator[Came]:
        """Connect, and give what comes from now on; LostError, or InputError for good."""


def is_feed(head: bytes) -> bool:
    """Whether a file's first bytes are lines of the feed format."""
    first = head.lstrip().split(b"\n", 1)[0]
    try:
        document = json.loads(first)
    except (ValueError, RecursionError):
        return False
    return isinstance(document, dict) and not document.keys().isdisjoint(KEYS)


@dataclass
class GrowingFile:
    """A file that grows, by its path: a feed is read on, anything else is read again.

    One that isn't there yet is waited for; one that is replaced or cut begins again, which
    changes nothing where it says the same.
    """

    name: str
    ends_within_s: float = ENDS_WITHIN_S

    def come(self) -> Iterator[Came]:
        """What is there, and then what comes."""
        while True:
            try:
                file = open(self.name, "rb")  # noqa: SIM115
            except FileNotFoundError:
                yield None
                time.sleep(LOOK_EVERY_S)
                continue
            except OSError as error:
                raise InputError(f"{self.name}: can't be read ({error.strerror})") from None
            with file:
                head = file.read(CHUNK_BYTES)
                if b"\n" not in head and len(head) < CHUNK_BYTES:  # nothing is known of it yet
                    yield None
                    time.sleep(LOOK_EVERY_S)
                    continue
                if not is_feed(head):
                    break
                yield head
                yield from self._more(file)
        yield from self._again()

    def _more(self, file: BinaryIO) -> Iterator[Came]:
        while True:
            while data := file.read(CHUNK_BYTES):
                yield data
            yield None
            with contextlib.suppress(OSError):  # gone for a moment: it is replaced
                status = os.stat(self.name)
                if status.st_size < file.tell() or not os.path.samestat(
                    status, os.fstat(file.fileno())
                ):
                    yield b"\n"  # whatever was half a line
                    return
            time.sleep(LOOK_EVERY_S)

    def _again(self) -> Iterator[Came]:
        seen: tuple[int, int, int] | None = None
        wait_s = 0.0
        while True:
            with contextlib.suppress(OSError):
                status = os.stat(self.name)
                state = (status.st_mtime_ns, status.st_size, status.st_ino)
                if state != seen:
                    begun = time.monotonic()
                    timeline = self._read(first=seen is None)
                    seen = state
                    wait_s = max(READ_AGAIN_S, (time.monotonic() - begun) / BUSY_PART)
                    if timeline is not None:
                        yield timeline
                        time.sleep(wait_s)
                        continue
            yield None
            time.sleep(LOOK_EVERY_S)

    def _read(self, first: bool) -> Timeline | None:
        """The file without a last line that isn't whole yet; None if it can't be read just now."""
        try:
            with open(self.name, "rb") as file:
                data = file.read()
            cut = data.rfind(b"\n") + 1
            text = data if self.name.endswith(".json") or not cut else data[:cut]
            return load_timeline(text)
        except InputError as error:
            if first:
                raise InputError(f"{self.name}: {error}") from None
            return None


@dataclass
class Stream:
    """A stream of bytes: standard input, a pipe."""

    stream: BinaryIO
    name: str = "standard input"
    ends_within_s: float = ENDS_WITHIN_S

    def come(self) -> Iterator[bytes]:
        """What comes, until its end."""
        read = getattr(self.stream, "read1", self.stream.read)
        while data := read(CHUNK_BYTES):
            yield data


LISTEN_EVERY_S = 0.5
"""Cheers are looked for so often ..."""

LISTEN_PART = 0.1
"""... or less, so that it takes no more than this part of the time."""

LONGEST_S = 27 * 3600.0
"""What comes later isn't listened to: as much as is read of a file."""


class Crowd:
    """Listens; tells a timeline whenever there is enough that is new.

    Loudness and cheers are those that the reader of recordings finds in a file of as much. All that
    is kept of the sound is ten numbers a second. The background reaches a minute ahead, so a cheer
    of the last minute may still change a little.

    Parameters
    ----------
    sample_rate
        Hz, 4000 or more.
    channels
        How many.
    tell
        Receives a timeline of all that was heard.
    now
        A clock, s.

    Raises
    ------
    InputError
        A rate or number of channels that can't be measured.
    """

    def __init__(
        self,
        sample_rate: int,
        channels: int,
        tell: Callable[[Timeline], None],
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        if sample_rate < MIN_RATE or sample_rate > 768_000 or not 1 <= channels <= 64:
            raise InputError(
                f"{channels} channels at {sample_rate} Hz; loudness is measured of 1 to 64, from "
                f"{MIN_RATE} Hz up"
            )
        self._rate, self._channels = sample_rate, channels
        layout = layout_of(channels)
        self._meter = StepMeter(sample_rate, weights_of(layout) if layout else (1.0,) * channels)
        self._waiting: list[NDArray[np.floating[Any]]] = []
        self._frames = self._heard = 0
        self._tell, self._now = tell, now
        self._look_at = 0.0

    def feed(self, block: NDArray[np.floating[Any]]) -> None:
        """Listen to the next (frames, channels), of any length; NaN is missing."""
        if self._heard >= LONGEST_S * self._rate:
            return
        self._waiting.append(block)
        self._frames += len(block)
        whole = self._frames // self._rate * self._rate
        if not whole:
            return
        sound = np.concatenate(self._waiting)
        self._waiting = [sound[whole:].copy()]
        self._frames -= whole
        self._heard += whole
        for start in range(0, whole, self._rate):  # the meter takes whole seconds
            self._meter.feed(sound[start : start + self._rate])
        begun = self._now()
        if begun >= self._look_at:
            self._tell(self._timeline(self._meter))
            took = self._now() - begun
            self._look_at = begun + max(LISTEN_EVERY_S, took / LISTEN_PART)

    def end(self) -> None:
        """Tell the whole: it is over."""
        if self._frames:
            self._meter.feed(np.concatenate(self._waiting))
            self._heard += self._frames
        if self._heard:
            self._tell(self._timeline(self._meter))

    def _timeline(self, meter: StepMeter) -> Timeline:
        kind = f"sound as it is heard, {self._channels} channels at {self._rate} Hz"
        return timeline_of(meter.so_far(), "loudness", "", kind, ())


@dataclass
class Sound:
    """A sound as blocks of samples: its loudness and cheers.

    `open_blocks` gives a rate (Hz), the number of channels and float blocks of them.
    """

    name: str
    open_blocks: Callable[[], tuple[int, int, Iterator[np.ndarray | None]]]
    ends_within_s: float = ENDS_WITHIN_S

    def come(self) -> Iterator[Came]:
        """A timeline of all that was heard, now and then."""
        rate, channels, blocks = self.open_blocks()
        told: list[Timeline] = []
        crowd = Crowd(rate, channels, told.append)
        try:
            for block in blocks:
                if block is not None:
                    crowd.feed(block)
                yield from told or (None,)
                told.clear()
        finally:
            if isinstance(blocks, Generator):
                blocks.close()
        crowd.end()
        yield from told


def pcm_blocks(
    stream: BinaryIO, rate: int, channels: int
) -> tuple[int, int, Iterator[np.ndarray | None]]:
    """Raw samples, 16 bits each, little-endian, channels interleaved, for `Sound`."""

    def blocks() -> Iterator[np.ndarray | None]:
        rest, frame = b"", 2 * channels
        for data in Stream(stream).come():
            rest += data
            whole = len(rest) // frame * frame
            data, rest = rest[:whole], rest[whole:]
            samples = np.frombuffer(data, "<i2").reshape(-1, channels)
            yield samples.astype(np.float32) / 32_768.0

    return rate, channels, blocks()
