"""An output that nobody hears: a thread that runs the engine in time, where there is no device."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np

from overview_dsp import validation
from overview_dsp.kernels import layout
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import (
    StreamMeters,
    compile_python_path,
    connect,
    play_again,
    read_meters,
    run_block,
)
from overview_dsp.signal.engine.engine import Engine

MAX_BLOCK = 1 << 20
"""Frames of the longest block: no output asks for more than some thousands."""


class SilentStream:
    """Runs an engine at its sample rate and throws the sound away, where there is no device.

    As a context it starts and closes. Thread: main; the engine's `process` runs in a thread of its
    own.

    Parameters
    ----------
    engine : Engine
        Prepared.
    block_size : int
        Frames.
    settings : OutputSettings or None
        As `OutputStream` takes them.

    Raises
    ------
    NotPreparedError
        The engine isn't prepared.

    Examples
    --------
    >>> engine = ov.Engine(football, match)
    >>> engine.prepare(sample_rate=8000, max_block_size=256)
    >>> with ov.live.SilentStream(engine) as stream:
    ...     engine.control(theta2=1.2, touching=True)
    >>> stream.active
    False
    """

    callback = "python"
    name = "none (no sound)"

    def __init__(
        self, engine: Engine, block_size: int = 256, settings: OutputSettings | None = None
    ) -> None:
        self._engine = engine
        self.block_size = validation.whole(block_size, "block_size", 1, MAX_BLOCK)
        channels = connect(engine, settings)
        self._out = np.zeros((self.block_size, channels), dtype=np.float32)
        self._thread: threading.Thread | None = None
        compile_python_path(engine)

    def start(self) -> None:
        """Begin to play.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> stream = ov.live.SilentStream(engine)
        >>> stream.start()
        >>> stream.active
        True
        >>> stream.close()
        """
        self._thread = threading.Thread(target=self._run, name="silent output", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        period = self.block_size / self._engine.sample_rate
        due = time.perf_counter()
        over = False
        while not over:
            began = time.perf_counter()
            over = run_block(self._engine, self._out)
            due = max(due + period, began - 1.0)
            time.sleep(max(0.0, due - time.perf_counter()))

    def restart(self, begin: Callable[[], None]) -> None:
        """Fade out, call `begin` while nothing runs the engine, and play on.

        Parameters
        ----------
        begin : callable
            May call what needs the engine to itself: `reset`, `restart`.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> with ov.live.SilentStream(engine) as stream:
        ...     stream.restart(engine.reset)
        """
        self.close()
        begin()
        play_again(self._engine.memory)
        self.start()

    def close(self) -> None:
        """Fade out and end; may be called twice.

        Examples
        --------
        >>> engine = ov.Engine(football, match)
        >>> engine.prepare(sample_rate=8000, max_block_size=256)
        >>> stream = ov.live.SilentStream(engine)
        >>> stream.start()
        >>> stream.close()
        >>> stream.active
        False
        """
        self._engine.memory.view(np.int64)[layout.L_STOP] = 1
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    @property
    def active(self) -> bool:
        """Whether the engine is running."""
        return self._thread is not None and self._thread.is_alive()

    @property
    def meters(self) -> StreamMeters:
        """Counters and block times (s) so far."""
        return read_meters(self._engine.memory, self.block_size / self._engine.sample_rate)

    def __enter__(self) -> SilentStream:
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<SilentStream: {'playing' if self.active else 'not playing'}>"
