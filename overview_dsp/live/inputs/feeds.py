"""Sources of live data for `--follow`: a file, a URL, standard input, or sound."""

from __future__ import annotations

import queue
import re
from collections.abc import Iterator
from contextlib import ExitStack
from typing import BinaryIO

import numpy as np

from overview_dsp.data.feeds.live_timeline import LAYOUTS, Layout
from overview_dsp.data.feeds.network_sources import Http, WebSocket
from overview_dsp.data.feeds.sources import (
    DEVICE_CLOSE_TIMEOUT_S,
    GrowingFile,
    Sound,
    Source,
    Stream,
    pcm_blocks,
)
from overview_dsp.data.timeline.time_parsing import length_s
from overview_dsp.errors import InputError, OverviewError
from overview_dsp.live.output.portaudio_library import (
    OPEN_STREAMS,
    device_named,
    import_sounddevice,
)

FORMS = (
    "a file, - (a feed on standard input), http(s)://...[,every=S], ws(s)://..., audio:DEVICE, "
    "pcm:RATE[:CHANNELS] (16-bit samples on standard input)"
)
QUEUE_BLOCKS = 200
"""Maximum number of queued sound blocks, some seconds; blocks beyond it become a gap."""

_PCM = re.compile(r"pcm:(\d{1,6})(?::(\d{1,2}))?")


def open_source(text: str, stdin: BinaryIO, every_s: float | None = None) -> Source:
    """Return the source of a `--follow` argument; InputError lists the allowed forms.

    `every_s`: interval of the requests of an http(s) URL, s.
    """
    if every_s is not None and not text.startswith(("http://", "https://")):
        raise InputError(f"--follow {text} is not requested repeatedly; remove every=")
    if not text:
        raise InputError(f"--follow is empty; must be {FORMS}")
    if text == "-":
        return Stream(stdin)
    if text.startswith(("http://", "https://")):
        return Http(text, every_s)
    if text.startswith(("ws://", "wss://")):
        return WebSocket(text)
    if text.startswith("audio:"):
        device = text.removeprefix("audio:")
        return Sound(text, lambda: _record_device(device), DEVICE_CLOSE_TIMEOUT_S)
    if text.startswith("pcm:"):
        found = _PCM.fullmatch(text)
        if found is None:
            raise InputError(
                f"--follow {text} must be pcm:RATE or pcm:RATE:CHANNELS, such as pcm:48000:2"
            )
        rate, channels = int(found[1]), int(found[2] or 1)
        return Sound(text, lambda: pcm_blocks(stdin, rate, channels))
    return GrowingFile(text)


def _record_device(device: str) -> tuple[int, int, Iterator[np.ndarray | None]]:
    """Return rate, channels and blocks of an audio input, by name or number; "" is the default."""
    try:
        sounddevice = import_sounddevice()
    except OverviewError as error:
        raise InputError(f"audio:{device}: {error}") from None
    selected = device_named(device or None)
    try:
        info = sounddevice.query_devices(selected, "input")
    except (ValueError, sounddevice.PortAudioError) as error:
        raise InputError(f"audio:{device}: {error}; `overview devices` lists devices") from None
    rate, channels = round(info["default_samplerate"]), min(2, info["max_input_channels"])
    recorded: queue.Queue[tuple[np.ndarray, int]] = queue.Queue(QUEUE_BLOCKS)
    missed = 0  # frames before the next block that is queued

    def put(block: np.ndarray, frames: int, time: object, status: object) -> None:
        nonlocal missed
        try:
            recorded.put_nowait((block.copy(), missed))
            missed = 0
        except queue.Full:
            missed += frames

    def blocks() -> Iterator[np.ndarray | None]:
        try:
            stream = sounddevice.InputStream(
                rate, device=selected, channels=channels, dtype="float32", callback=put
            )
        except sounddevice.PortAudioError as error:
            raise OverviewError(f"audio:{device}: {error}") from None
        with stream, ExitStack() as stack:
            OPEN_STREAMS.add(stream)  # a search for devices would end it
            stack.callback(OPEN_STREAMS.discard, stream)
            while stream.active:
                try:
                    block, lost = recorded.get(timeout=0.2)
                except queue.Empty:
                    yield None
                    continue
                if lost:
                    yield np.full((lost, channels), np.nan, np.float32)
                yield block

    return rate, channels, blocks()


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
