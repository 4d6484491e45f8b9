"""Opener of a session's output."""

from __future__ import annotations

from dataclasses import dataclass

from overview_dsp.errors import InputError
from overview_dsp.live.output.null_stream import NullStream
from overview_dsp.live.output.portaudio_library import SILENT, device_named, rescan
from overview_dsp.live.output.portaudio_stream import CallbackKind, OutputStream
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import Stream
from overview_dsp.signal.engine.engine import Engine

MAX_BLOCK = 8192


@dataclass
class StreamOpener:
    """Callable that opens a stream on one device.

    Attributes
    ----------
    device : str or None
        Name or number of the output; None is the default, `SILENT` no sound.
    block_size : int
        Block size in frames; 0 lets the device choose.
    callback : str
        Kind of callback, as in `OutputStream`.
    rescans : bool
        Whether PortAudio looks for new devices first. The second call and later ones always do.
    """

    device: str | None
    block_size: int
    callback: CallbackKind
    rescans: bool = False

    def __post_init__(self) -> None:
        if not 0 <= self.block_size <= MAX_BLOCK:
            raise InputError(f"block size {self.block_size} must be 0 to {MAX_BLOCK} frames")

    def __call__(self, engine: Engine, settings: OutputSettings) -> Stream:
        """Open a stream for an engine; errors as in `OutputStream`."""
        if self.device == SILENT:
            return NullStream(engine, self.block_size or 256, settings)
        if self.rescans:
            rescan()
        self.rescans = True
        device = device_named(self.device)
        return OutputStream(engine, device, self.block_size, settings, self.callback)
