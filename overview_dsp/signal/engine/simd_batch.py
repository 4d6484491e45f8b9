"""Batch of engines in one memory block, each in one lane of the compiled loops."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from overview_dsp.arrays import FloatArray, SampleArray
from overview_dsp.kernels import layout
from overview_dsp.kernels.simd import memory as lane_memory
from overview_dsp.kernels.simd.vector import SIMD_WIDTH
from overview_dsp.kernels.sources import runs_as_python
from overview_dsp.signal.engine.coefficients import announce_compile
from overview_dsp.signal.engine.engine import Engine


class EngineBatch:
    """Processes up to `SIMD_WIDTH` engines at once, bit-identical to single engines.

    `prepare(..., memory=batch.memory(lane))` assigns a lane to an engine. The output has two
    channels. Thread: one at a time.
    """

    def __init__(self, block: int) -> None:
        """Allocate for blocks of up to `block` frames."""
        # a vector of eight numbers then lies in one cache line
        memory = np.zeros(lane_memory.MEMORY + SIMD_WIDTH)
        first = -memory.ctypes.data // memory.itemsize % SIMD_WIDTH
        self._f64 = memory[first : first + lane_memory.MEMORY]
        self._i64 = self._f64.view(np.int64)
        self._u64 = self._f64.view(np.uint64)
        self._out = np.zeros(SIMD_WIDTH * block * layout.SIGNALS, np.float32)
        self._trace = np.zeros(0)
        self._block = block
        self._announced = False

    def memory(self, lane: int) -> FloatArray:
        """Return the memory of a lane's engine."""
        start = lane_memory.SIZE + lane * layout.TOTAL
        return self._f64[start : start + layout.TOTAL]

    def process(
        self, engines: Sequence[Engine | None], frames: int, trace: bool
    ) -> tuple[SampleArray, FloatArray | None]:
        """Return the next frames of all engines (None: an empty lane).

        Returns float32 (SIMD_WIDTH, frames, 2) and, with `trace`, the traces, float64 (SIMD_WIDTH,
        frames, 9). The next call overwrites both.
        """
        out = self._out[: SIMD_WIDTH * frames * layout.SIGNALS]
        if trace and not len(self._trace):
            self._trace = np.zeros(SIMD_WIDTH * self._block * layout.TRACE)
        table = self._trace[: SIMD_WIDTH * frames * layout.TRACE]
        samples = out.reshape(SIMD_WIDTH, frames, layout.SIGNALS)
        traces = table.reshape(SIMD_WIDTH, frames, layout.TRACE) if trace else None
        together = self._together(engines, out, frames, table, trace)
        for lane, engine in enumerate(engines):
            if engine is not None and not together[lane]:
                engine.process(samples[lane], traces[lane] if traces is not None else None)
        return samples, traces

    def _together(
        self,
        engines: Sequence[Engine | None],
        out: SampleArray,
        frames: int,
        table: FloatArray,
        trace: bool,
    ) -> Sequence[bool]:
        """Process the engines that the lanes' loops support; return which ones these are."""
        from overview_dsp.kernels.simd import block as lane_block

        if sum(engine is not None for engine in engines) < lane_block.FEWEST or runs_as_python():
            return [False] * SIMD_WIDTH
        if not self._announced:
            announce_compile("process_lanes")
            self._announced = True
        for lane, engine in enumerate(engines):
            self._i64[lane_memory.WANTED + lane] = engine is not None
        lane_block.process_lanes(
            self._f64, self._i64, self._u64, SIMD_WIDTH, out, frames, table, trace
        )
        return list((self._i64[lane_memory.MEMBER :][:SIMD_WIDTH] == 1).tolist())
