"""Engines side by side: one memory, a lane of the compiled loops for each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from overview_dsp.compile_notice import announce_compile
from overview_dsp.engine import Engine
from overview_dsp.kernels import lane_memory, layout
from overview_dsp.kernels.compiling import runs_as_python
from overview_dsp.kernels.lanes import LANES

CHANNELS = 2


class VoiceLanes:
    """Up to `LANES` engines that are processed at once, with the bits they have alone.

    An engine gets its lane with `prepare(..., memory=lanes.memory(lane))`. Their output has two
    channels. Thread: one at a time.
    """

    def __init__(self, block: int) -> None:
        """For blocks of up to `block` frames; nothing is compiled until several voices play."""
        self._m = np.zeros(lane_memory.MEMORY)
        self._w = self._m.view(np.int64)
        self._u = self._m.view(np.uint64)
        self._out = np.zeros(LANES * block * CHANNELS, np.float32)
        self._trace = np.zeros(0)
        self._block = block
        self._announced = False

    def memory(self, lane: int) -> NDArray[np.float64]:
        """The memory of a lane's engine."""
        start = lane_memory.SIZE + lane * layout.TOTAL
        return self._m[start : start + layout.TOTAL]

    def process(
        self, engines: Sequence[Engine | None], frames: int, trace: bool
    ) -> tuple[NDArray[np.float32], NDArray[np.float64] | None]:
        """The next frames of every engine (None: a lane without one).

        Returns float32 (LANES, frames, 2) and, if asked for, the traces, float64 (LANES, frames,
        9); both are overwritten by the next call.
        """
        out = self._out[: LANES * frames * CHANNELS]
        if trace and not len(self._trace):
            self._trace = np.zeros(LANES * self._block * layout.TRACE)
        table = self._trace[: LANES * frames * layout.TRACE]
        samples = out.reshape(LANES, frames, CHANNELS)
        traces = table.reshape(LANES, frames, layout.TRACE) if trace else None
        together = self._together(engines, out, frames, table, trace)
        for lane, engine in enumerate(engines):
            if engine is not None and not together[lane]:
                engine.process(samples[lane], traces[lane] if traces is not None else None)
        return samples, traces

    def _together(
        self,
        engines: Sequence[Engine | None],
        out: NDArray[np.float32],
        frames: int,
        table: NDArray[np.float64],
        trace: bool,
    ) -> Sequence[bool]:
        """Process what goes through the lanes' loops; which engines that were."""
        from overview_dsp.kernels import lane_block

        if sum(engine is not None for engine in engines) < lane_block.FEWEST or runs_as_python():
            return [False] * LANES
        if not self._announced:
            announce_compile("process_lanes")
            self._announced = True
        for lane, engine in enumerate(engines):
            self._w[lane_memory.WANTED + lane] = engine is not None
        lane_block.process_lanes(self._m, self._w, self._u, LANES, out, frames, table, trace)
        members: list[bool] = (self._w[lane_memory.MEMBER :][:LANES] == 1).tolist()
        return members
