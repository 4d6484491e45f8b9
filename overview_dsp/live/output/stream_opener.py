"""Which output a session opens, and opens again."""

from __future__ import annotations

from typing import Literal

from overview_dsp.errors import InputError
from overview_dsp.live.output.device_names import SILENT, device_named
from overview_dsp.live.output.portaudio_library import rescan
from overview_dsp.live.output.portaudio_stream import OutputStream
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.silent_stream import SilentStream
from overview_dsp.signal.engine.engine import Engine

MAX_BLOCK = 8192


class Outputs:
    """Opens an output: `device` by its name or number, None the default, `SILENT` no sound."""

    def __init__(
        self,
        device: str | None,
        block_size: int,
        callback: Literal["native", "python"],
        again: bool = False,
    ) -> None:
        """`again`: devices are looked for anew. InputError for a block size out of range."""
        if not 0 <= block_size <= MAX_BLOCK:
            raise InputError(f"block size {block_size}; it is 1 to {MAX_BLOCK} frames, or 0")
        self.device = device
        self.block_size = block_size
        self._callback: Literal["native", "python"] = callback
        self._again = again

    def with_device(self, device: str | None) -> Outputs:
        """Another device."""
        return Outputs(device, self.block_size, self._callback, again=True)

    def with_block_size(self, block_size: int) -> Outputs:
        """Other blocks."""
        return Outputs(self.device, block_size, self._callback, again=True)

    def __call__(self, engine: Engine, settings: OutputSettings) -> SilentStream | OutputStream:
        """Open it for an engine; errors as `OutputStream`."""
        if self.device == SILENT:
            return SilentStream(engine, self.block_size or 256, settings)
        if self._again:
            rescan()
        self._again = True
        return OutputStream(
            engine, device_named(self.device), self.block_size, settings, self._callback
        )
