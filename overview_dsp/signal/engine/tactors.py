"""Router of several tactors: the share of each at every position of a surface."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray, SampleArray
from overview_dsp.kernels import layout
from overview_dsp.kernels.device import router
from overview_dsp.signal.surface.model import Surface

SMOOTHING_S, HOLD_S = 0.002, 0.05


class TactorRouter:
    """Splits the tactor's signal among 2 to 8 tactors by the position of the disk.

    The preset's `tactor.routing` chooses them. `memory` is float64 (router.SIZE,); `trace` is a
    table in it for the trace of up to `router.FRAMES` frames.
    Thread: one that calls `process`; the others while nothing runs.
    """

    def __init__(self, count: int, sample_rate: float) -> None:
        self.count = validation.whole(count, "tactors", 2, router.MAX_TACTORS)
        self.memory = np.zeros(router.SIZE)
        table = self.memory[router.TRACE :][: router.FRAMES * layout.TRACE]
        self.trace = table.reshape(router.FRAMES, layout.TRACE)
        self._integers = self.memory.view(np.int64)
        self._integers[router.TACTORS] = count
        self._integers[router.HOLD] = round(HOLD_S * sample_rate)
        self.memory[router.SMOOTHING] = 1.0 - math.exp(-1.0 / (SMOOTHING_S * sample_rate))
        self.set_channels([(1 + tactor,) for tactor in range(count)])

    def set_channels(self, channels: Sequence[Sequence[int]]) -> None:
        """Choose the output channels of each tactor, from 0; the first is that of the signal."""
        for tactor, several in enumerate(channels):
            mask = sum(1 << channel for channel in several)
            self.memory.view(np.uint64)[router.CHANNELS + tactor] = mask

    def write(self, slot: int, surface: Surface) -> None:
        """Write the places of a surface, which is written to a slot of the engine."""
        cells = layout.CELLS + 1
        places = np.linspace(0.0, self.count - 1.0, cells)
        if surface.tactor is not None:
            places[:] = router.ALL
            spans = np.clip(surface.span, 0.0, 1.0) * layout.CELLS
            for event in np.argsort(surface.release, kind="stable"):  # the strongest comes last
                number = min(int(surface.tactor[event]), self.count)
                first, last = spans[event]
                places[int(first) : int(last) + 1] = number - 1.0 if number else router.ALL
        self.memory[router.PLACES + slot * cells :][:cells] = places

    def reset(self, slot: int = 0, cursor: float = 0.0) -> None:
        """Start at a position (0 to 1) of the surface in a slot."""
        cell = int(min(max(cursor, 0.0), 1.0) * layout.CELLS)
        place = self.memory[router.PLACES + slot * (layout.CELLS + 1) + cell]
        away = np.abs(place - np.arange(router.MAX_TACTORS))
        weights = np.sqrt(np.maximum(0.0, 1.0 - away)) if place != router.ALL else 1.0
        self.memory[router.WEIGHTS :][: router.MAX_TACTORS] = weights
        self.memory[router.LINE :] = self.memory[router.PLACE] = place
        self._integers[[router.SINCE, router.WRITTEN]] = 0

    def process(self, engine: FloatArray, samples: SampleArray, trace: FloatArray) -> None:
        """Split the tactor's channel of up to `router.FRAMES` frames, in place.

        `engine` is its memory, `samples` are float32 (frames, channels), `trace` is that of
        the frames.
        """
        frames, channels = samples.shape
        table = trace.reshape(-1)
        out = samples.reshape(-1)
        integers = engine.view(np.int64)
        router.split_block(integers, self.memory, self._integers, out, frames, channels, table)
