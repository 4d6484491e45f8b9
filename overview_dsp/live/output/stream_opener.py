"""Opener of a session's output, which also opens it again."""

from __future__ import annotations

from dataclasses import dataclass

from overview_dsp.errors import InputError
from overview_dsp.live.output.portaudio_library import SILENT, device_named, rescan
from overview_dsp.live.output.portaudio_stream import CallbackKind, OutputStream
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.silent_stream import SilentStream
from overview_dsp.live.output.stream import Stream
from overview_dsp.signal.engine.engine import Engine

MAX_BLOCK = 8192


@dataclass
class StreamOpener:
    """Opens a stream on one device.

    Attributes
    ----------
    device : str or None
        Name or number; None is the default, `SILENT` no sound.
    block_size : int
        Frames; 0 is the device's own.
    callback : str
        As `OutputStream` takes it.
    rescans : bool
        Whether PortAudio looks for devices again first; from the second opening on it does.
    """

    device: str | None
    block_size: int
    callback: CallbackKind
    rescans: bool = False

    def __post_init__(self) -> None:
        if not 0 <= self.block_size <= MAX_BLOCK:
            raise InputError(f"block size {self.block_size}; it is 1 to {MAX_BLOCK} frames, or 0")

    def __call__(self, engine: Engine, settings: OutputSettings) -> Stream:
        """Open it for an engine; errors as `OutputStream`."""
        if self.device == SILENT:
            return SilentStream(engine, self.block_size or 256, settings)
        if self.rescans:
            rescan()
        self.rescans = True
        device = device_named(self.device)
        return OutputStream(engine, device, self.block_size, settings, self.callback)
