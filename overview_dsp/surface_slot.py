"""A surface into its slot of the memory block: where the kernel reads it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from overview_dsp.coefficients import mode_coefficients, ring_samples
from overview_dsp.kernels import layout
from overview_dsp.presets.model import Mode
from overview_dsp.surface import Surface


def write_surface(m: NDArray[np.float64], slot: int, surface: Surface, sample_rate: float) -> None:
    """Write a surface's friction, events and clicks into slot 0, 1 or 2 of the block `m`."""
    w = m.view(np.int64)
    base = layout.SURFACES + slot * layout.SLOT_SIZE
    table = m[base + layout.SLOT_TABLE :][: 2 * (layout.CELLS + 1)]
    table[0::2] = surface.friction
    table[1:-1:2] = np.diff(surface.friction)
    table[-1] = 0.0
    count = len(surface.place)
    w[base + layout.SLOT_EVENTS] = count
    m[base + layout.SLOT_PLACE :][:count] = surface.place * layout.CELLS
    m[base + layout.SLOT_RELEASE :][:count] = surface.release
    w[base + layout.SLOT_KIND :][:count] = surface.kind
    for kind, modes in enumerate(surface.kind_modes):
        heard: list[tuple[Mode, Mapping[int, float]]] = []
        for mode in modes:
            columns = mode_coefficients(mode, sample_rate)
            if columns is not None:
                heard.append((mode, columns))
        w[base + layout.KIND_MODES + kind] = len(heard)
        longest = max((ring_samples(mode, sample_rate) for mode, _ in heard), default=0)
        w[base + layout.KIND_RING + kind] = longest
        for index, (_, columns) in enumerate(heard):
            for column, value in columns.items():
                m[base + column + kind * layout.MAX_MODES + index] = value
