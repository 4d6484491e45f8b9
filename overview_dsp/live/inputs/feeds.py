"""What `--follow` names: a file, an address, standard input, a sound that is heard."""

from __future__ import annotations

import queue
import re
from collections.abc import Iterator
from typing import BinaryIO

import numpy as np

from overview_dsp.data.feeds.live_timeline import MAPS, Map
from overview_dsp.data.feeds.net import Http, WebSocket
from overview_dsp.data.feeds.sources import (
    DEVICE_ENDS_WITHIN_S,
    GrowingFile,
    Sound,
    Source,
    Stream,
    pcm_blocks,
)
from overview_dsp.data.timeline.time_parsing import length_s
from overview_dsp.errors import InputError, OverviewError

FORMS = (
    "a file, - (a feed on standard input), http(s)://..., ws(s)://..., audio:DEVICE, "
    "pcm:RATE[:CHANNELS] (16-bit samples on standard input)"
)
QUEUE_BLOCKS = 200
"""So many blocks of sound wait at most, some seconds; what is too much is missing."""

_PCM = re.compile(r"pcm:(\d{1,6})(?::(\d{1,2}))?")


def source_named(text: str, stdin: BinaryIO) -> Source:
    """What a SOURCE of `--follow` names; InputError lists the forms."""
    if not text:
        raise InputError(f"--follow names {FORMS}")
    if text == "-":
        return Stream(stdin)
    if text.startswith(("http://", "https://")):
        return Http(text)
    if text.startswith(("ws://", "wss://")):
        return WebSocket(text)
    if text.startswith("audio:"):
        device = text.removeprefix("audio:")
        return Sound(text, lambda: _heard(device), DEVICE_ENDS_WITHIN_S)
    if text.startswith("pcm:"):
        found = _PCM.fullmatch(text)
        if found is None:
            raise InputError(f"--follow {text}: it is pcm:RATE or pcm:RATE:CHANNELS, pcm:48000:2")
        rate, channels = int(found[1]), int(found[2] or 1)
        return Sound(text, lambda: pcm_blocks(stdin, rate, channels))
    return GrowingFile(text)


def _heard(device: str) -> tuple[int, int, Iterator[np.ndarray | None]]:
    """Rate, channels and blocks of an audio input, by name or number; "" is the usual one."""
    try:
        import sounddevice
    except (ImportError, OSError) as error:
        raise InputError(f"audio:{device}: no sound can be heard here ({error})") from None
    wanted = int(device) if device.isdecimal() else device or None
    try:
        about = sounddevice.query_devices(wanted, "input")
    except (ValueError, sounddevice.PortAudioError) as error:
        raise InputError(f"audio:{device}: {error}; overview devices lists what there is") from None
    rate, channels = round(about["default_samplerate"]), min(2, about["max_input_channels"])
    waiting: queue.Queue[np.ndarray] = queue.Queue(QUEUE_BLOCKS)
    missed = 0

    def take(block: np.ndarray, frames: int, time: object, status: object) -> None:
        nonlocal missed
        try:
            waiting.put_nowait(block.copy())
        except queue.Full:
            missed += frames

    def blocks() -> Iterator[np.ndarray | None]:
        nonlocal missed
        try:
            stream = sounddevice.InputStream(
                rate, device=wanted, channels=channels, dtype="float32", callback=take
            )
        except sounddevice.PortAudioError as error:
            raise OverviewError(f"audio:{device}: {error}") from None
        with stream:
            while stream.active:
                try:
                    yield waiting.get(timeout=0.2)
                except queue.Empty:
                    yield None
                if missed and waiting.empty():
                    lost, missed = missed, 0
                    yield np.full((lost, channels), np.nan, np.float32)

    return rate, channels, blocks()


def expected_s(text: str) -> float:
    """An expected length as a person writes it (`95m`, `1:35:00`, `2h`, `5700`), s; InputError."""
    given = re.sub(r"(?<=\d)\s*m$", "min", text.strip(), flags=re.IGNORECASE)
    length = length_s(given)
    if length is None or not length > 0.0:
        raise InputError(f"{text!r} is no length; give 95m, 1:35:00, 2h or seconds")
    return length


def map_named(text: str) -> Map:
    """A map as a person writes it: `whole` or `so-far`; InputError."""
    for map in MAPS:
        if text.strip().lower().replace("-", " ").replace("_", " ") == map:
            return map
    raise InputError(f"the map is {text!r}; it is whole or so-far")
