"""Opener of a session's output."""

from __future__ import annotations

from dataclasses import dataclass, field

from overview_dsp.errors import InputError
from overview_dsp.live.output.devices import OutputDevice, find_device, same_device
from overview_dsp.live.output.null_stream import NullStream
from overview_dsp.live.output.portaudio_library import PAD, SILENT, device_named, rescan
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
        Output; None is the default, `SILENT` no sound. A name or number is looked up at the first
        opening; later ones use that output only.
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
    _known: OutputDevice | None = field(default=None, init=False)

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
        known = self._known
        device = device_named(self.device) if known is None else same_device(known).index
        stream = OutputStream(engine, device, self.block_size, settings, self.callback)
        if self.device not in (None, PAD):
            self._known = find_device(stream.index)
        return stream
