"""Output without a device: a thread that runs the engine in real time and discards the sound."""

from __future__ import annotations

import threading
import time

import numpy as np

from overview_dsp import validation
from overview_dsp.kernels import layout
from overview_dsp.live.output.settings import OutputSettings
from overview_dsp.live.output.stream import Stream, compile_python_path, connect, run_block
from overview_dsp.signal.engine.engine import Engine

MAX_BLOCK = 1 << 20
"""Maximum block size in frames, far above that of any output."""


class NullStream(Stream):
    """Stream that runs an engine in real time and discards the sound, without a device.

    As a context manager it starts and closes. Thread: main; the engine's `process` runs in a thread
    of its own.

    Parameters
    ----------
    engine : Engine
        Prepared engine.
    block_size : int
        Block size in frames.
    settings : OutputSettings or None
        Settings as in `OutputStream`.

    Raises
    ------
    NotPreparedError
        The engine isn't prepared.

    Examples
    --------
    >>> engine = ov.Engine(football, match)
    >>> engine.prepare(sample_rate=8000, max_block_size=256)
    >>> with ov.live.NullStream(engine) as stream:
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

    def _start(self) -> None:
        self._thread = threading.Thread(target=self._run, name="null output", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        due = time.perf_counter()
        over = False
        while not over:
            began = time.perf_counter()
            over = run_block(self._engine, self._out)
            due = max(due + self._latency_s, began - 1.0)
            time.sleep(max(0.0, due - time.perf_counter()))

    def _close(self) -> None:
        self._engine.memory.view(np.int64)[layout.L_STOP] = 1
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    _stop = _close

    @property
    def active(self) -> bool:
        """State of the stream: True while it runs the engine."""
        return self._thread is not None and self._thread.is_alive()

    @property
    def _latency_s(self) -> float:
        """Duration of a block, s."""
        return self.block_size / self._engine.sample_rate

    def __repr__(self) -> str:
        return f"<NullStream: {'playing' if self.active else 'not playing'}>"
