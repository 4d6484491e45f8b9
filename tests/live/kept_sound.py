"""An output that plays when it is told to and keeps it, and where the engine began anew."""

from __future__ import annotations

import numpy as np

from overview_dsp.kernels import layout
from overview_dsp.live.output.stream import connect, read_meters, run_block, undo_fade


class KeptSound:
    """As `NullStream`, in a time of its own: no machine is too slow for it.

    `passes` are float32 (frames, 2), one for each beginning of the engine.
    """

    name = "kept"
    waits_for_server = False
    missing_connections = ()

    def __init__(self, engine, block_size, settings):
        self._engine, self.block_size = engine, block_size
        self._out = np.zeros((block_size, connect(engine, settings)), dtype=np.float32)
        self._blocks = [[]]
        self.active = False
        self._over = False

    def start(self):
        self.active, self._over = True, False

    def play(self, seconds):
        """Let so much time go by, in whole blocks."""
        for _ in range(max(1, round(seconds * self._engine.sample_rate / self.block_size))):
            self._play_block()

    def _play_block(self):
        if not self._over:
            self._over = run_block(self._engine, self._out)
            self._blocks[-1].append(self._out.copy())

    def restart(self, begin):
        self.close()
        begin()
        undo_fade(self._engine.memory)
        self._blocks.append([])
        self.start()

    def close(self):
        self._engine.memory.view(np.int64)[layout.L_STOP] = 1
        while self.active and not self._over:
            self._play_block()
        self.active = False

    @property
    def passes(self):
        return [np.concatenate(blocks) for blocks in self._blocks if blocks]

    @property
    def meters(self):
        return read_meters(self._engine.memory, self.block_size / self._engine.sample_rate)
