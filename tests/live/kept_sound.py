"""An output that keeps what it was given, in time, and where the engine began anew."""

from __future__ import annotations

import threading
import time

import numpy as np

from overview_dsp.kernels import layout
from overview_dsp.live.python_path import connect, run_block
from overview_dsp.live.stream_meters import play_again, read_meters


class KeptSound:
    """As `SilentStream`; `passes` are float32 (frames, 2), one for each beginning of the engine.

    It plays `speed` times as fast as it should.
    """

    name = "kept"

    def __init__(self, engine, block_size, settings, speed=1.0):
        self._engine, self.block_size, self._speed = engine, block_size, speed
        self._out = np.zeros((block_size, connect(engine, settings)), dtype=np.float32)
        self._blocks = [[]]
        self._thread = None

    def start(self):
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        due, over = time.perf_counter(), False
        while not over:
            over = run_block(self._engine, self._out)
            self._blocks[-1].append(self._out.copy())
            due += self.block_size / self._engine.sample_rate / self._speed
            time.sleep(max(0.0, due - time.perf_counter()))

    def restart(self, begin):
        self.close()
        begin()
        play_again(self._engine.memory)
        self._blocks.append([])
        self.start()

    def close(self):
        self._engine.memory.view(np.int64)[layout.L_STOP] = 1
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    @property
    def passes(self):
        return [np.concatenate(blocks) for blocks in self._blocks if blocks]

    @property
    def active(self):
        return self._thread is not None and self._thread.is_alive()

    @property
    def meters(self):
        return read_meters(self._engine.memory, self.block_size / self._engine.sample_rate)
