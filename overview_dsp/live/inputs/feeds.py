"""Sources of live data for `--follow`: a file, a URL, standard input, or sound."""

from __future__ import annotations

import math
import queue
import re
import time
from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np

from overview_dsp.data.feeds import sources
from overview_dsp.data.feeds.live_timeline import LAYOUTS, Layout
from overview_dsp.data.feeds.network_sources import Http, WebSocket
from overview_dsp.data.timeline.time_parsing import length_s
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.live.output import portaudio_library as library
from overview_dsp.live.output.devices import OutputDevice, listed, same_device
from overview_dsp.live.output.reconnecting_stream import LOST_AFTER_S
from overview_dsp.live.output.stream import FADE_WITHIN_S

FORMS = (
    "a file, - (a feed on standard input), http(s)://...[,every=S], ws(s)://..., audio:DEVICE, "
    "pcm:RATE[:CHANNELS] (16-bit samples on standard input)"
)
QUEUE_BLOCKS = 200
"""Maximum number of queued sound blocks, some seconds; blocks beyond it become a gap."""
WAIT_S, RETRY_S = 0.2, 1.0

_PCM = re.compile(r"pcm:(\d{1,6})(?::(\d{1,2}))?")


def open_source(text: str, stdin: BinaryIO, every_s: float | None = None) -> sources.Source:
    """Return the source of a `--follow` argument; InputError lists the allowed forms.

    `every_s`: interval of the requests of an http(s) URL, s.
    """
    if every_s is not None and not text.startswith(("http://", "https://")):
        raise InputError(f"--follow {text} is not requested repeatedly; remove every=")
    if not text:
        raise InputError(f"--follow is empty; must be {FORMS}")
    if text == "-":
        return sources.Stream(stdin)
    if text.startswith(("http://", "https://")):
        return Http(text, every_s)
    if text.startswith(("ws://", "wss://")):
        return WebSocket(text)
    if text.startswith("audio:"):
        return sources.Sound(text, SoundInput(text).open_blocks, sources.DEVICE_CLOSE_TIMEOUT_S)
    if text.startswith("pcm:"):
        found = _PCM.fullmatch(text)
        if found is None:
            raise InputError(
                f"--follow {text} must be pcm:RATE or pcm:RATE:CHANNELS, such as pcm:48000:2"
            )
        rate, channels = int(found[1]), int(found[2] or 1)
        return sources.Sound(text, lambda: sources.pcm_blocks(stdin, rate, channels))
    return sources.GrowingFile(text)


class SoundInput:
    """Audio input `audio:DEVICE`, by default the system's, which is opened again after a loss.

    A chosen input is never replaced by another one. Missed frames are NaN. Thread: the feed's.
    """

    def __init__(self, name: str) -> None:
        self._selected = library.device_named(name.removeprefix("audio:") or None)
        self._known: OutputDevice | None = None
        self._stream: Any = None
        self._name, self._lost, self._heard_at = name, False, 0.0

    def open_blocks(self) -> tuple[int, int, Iterator[np.ndarray | None]]:
        """Return rate, channels, and blocks that end with a `LostError`; InputError."""
        if self._known is None:
            try:
                sounddevice = library.import_sounddevice()
                index = sounddevice.query_devices(self._selected, "input")["index"]
            except OverviewError as error:
                raise InputError(f"{self._name}: {error}") from None
            except (ValueError, sounddevice.PortAudioError) as error:
                raise InputError(
                    f"{self._name}: {error}; `overview devices` lists devices"
                ) from None
            self._known = next(one for one in listed("input") if one.index == index)
            self._waits_for_server = "JACK" in self._known.host
            self._rate = round(self._known.sample_rate)
            self._channels = min(2, self._known.channels)
        return self._rate, self._channels, self._blocks(self._known)

    @property
    def active(self) -> bool:
        """State of the stream: True while it records."""
        with library.LIBRARY_LOCK:  # a search may replace the library
            return self._stream is not None and bool(self._stream.active)

    def _open(self, known: OutputDevice) -> None:
        sounddevice, selected = library.import_sounddevice(), self._selected
        recorded = self._recorded = queue.Queue[tuple[np.ndarray, int]](QUEUE_BLOCKS)
        missed = 0  # frames before the next block that is queued

        def put(block: np.ndarray, frames: int, time: object, status: object) -> None:
            nonlocal missed
            try:
                recorded.put_nowait((block.copy(), missed))
                missed = 0
            except queue.Full:
                missed += frames

        with library.LIBRARY_LOCK:
            if self._lost:
                library.rescan()
                if selected is not None:
                    selected = same_device(known, "input").index
            try:
                stream = sounddevice.InputStream(
                    self._rate, device=selected, channels=self._channels, dtype="float32",
                    callback=put,
                )  # fmt: skip
                stream.start()
            except (ValueError, sounddevice.PortAudioError) as error:
                raise OverviewError(f"{self._name}: {error}") from None
            self._stream = stream
            library.OPEN_STREAMS.add(self)  # a search for devices would end it

    def _blocks(self, known: OutputDevice) -> Iterator[np.ndarray | None]:
        while self._stream is None:
            try:
                self._open(known)
            except OverviewError:
                if not self._lost:
                    raise
                for _ in range(round(RETRY_S / WAIT_S)):
                    time.sleep(WAIT_S)
                    yield None
        silent_s = -math.inf  # before the first block
        try:
            while self.active and silent_s < LOST_AFTER_S:
                try:
                    block, missed = self._recorded.get(timeout=WAIT_S)
                except queue.Empty:
                    silent_s += WAIT_S
                    yield None
                    continue
                silent_s, now = 0.0, time.monotonic()
                if self._lost:
                    missed = round((now - self._heard_at) * self._rate) - len(block)
                self._lost, self._heard_at = False, now
                for first in range(0, missed, self._rate):
                    shape = min(missed - first, self._rate), self._channels
                    yield np.full(shape, np.nan, np.float32)
                yield block
        except GeneratorExit:
            self.close()
            raise
        self._lost = True
        if self._waits_for_server and self.active:  # it continues with its server
            raise sources.LostError("its server doesn't respond")
        self.close()
        raise sources.LostError("disconnected")

    def close(self) -> None:
        """End the stream, except that of a server that doesn't respond: that would wait for it."""
        with library.LIBRARY_LOCK:
            library.OPEN_STREAMS.discard(self)
            stream, self._stream = self._stream, None
            self._recorded.queue.clear()
            try:
                if self._waits_for_server:
                    self._recorded.get(timeout=FADE_WITHIN_S)
                stream.close()
            except queue.Empty:
                library.ABANDONED.append(stream)


def parse_duration(text: str) -> float:
    """Parse a duration (`95m`, `1:35:00`, `2h`, `5700`) and return it in s; InputError."""
    duration = length_s(re.sub(r"(?<=\d)\s*m$", "min", text.strip(), flags=re.IGNORECASE))
    if duration is None or not duration > 0.0:
        raise InputError(f"duration {text!r} must be like 95m, 1:35:00, 2h or a number of seconds")
    return duration


def parse_layout(text: str) -> Layout:
    """Parse a layout, `whole` or `so-far`; InputError."""
    for layout in LAYOUTS:
        if text.strip().lower().replace("-", " ").replace("_", " ") == layout:
            return layout
    raise InputError(f"layout {text!r} must be whole or so-far")
