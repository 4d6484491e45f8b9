"""What a session's output is to it, whichever it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from overview_dsp.live.output_settings import OutputSettings
from overview_dsp.live.stream_meters import StreamMeters
from overview_dsp.signal.engine.engine import Engine


class Stream(Protocol):
    """What runs the engine: a PortAudio output, or a silent one."""

    name: str
    block_size: int

    def start(self) -> None:
        """Begin to play."""

    def restart(self, begin: Callable[[], None]) -> None:
        """Fade out, call `begin` while nothing runs the engine, and play on; OverviewError."""

    def close(self) -> None:
        """Fade out and end."""

    @property
    def active(self) -> bool:
        """Whether it plays."""

    @property
    def meters(self) -> StreamMeters:
        """Counters so far."""


OpenStream = Callable[[Engine, OutputSettings], Stream]
"""Opens an output for an engine; OverviewError if it can't be."""
