"""A surface into its slot of the memory block: where the kernel reads it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from overview_dsp.bristle_field import BristleField
from overview_dsp.coefficients import mode_coefficients, ring_samples
from overview_dsp.kernels import layout
from overview_dsp.presets.model import Mode
from overview_dsp.surface import Surface


def write_surface(m: NDArray[np.float64], slot: int, surface: Surface, sample_rate: float) -> None:
    """Write a surface's friction, events and clicks into slot 0, 1 or 2 of the block `m`."""
    w = m.view(np.int64)
    base = layout.SURFACES + slot * layout.SLOT_SIZE
    table = m[base + layout.SLOT_TABLE :][: 2 * (layout.CELLS + 1)]
    _write_table(table, surface.friction)
    count = len(surface.place)
    w[base + layout.SLOT_EVENTS] = count
    m[base + layout.SLOT_PLACE :][:count] = surface.place * layout.CELLS
    m[base + layout.SLOT_RELEASE :][:count] = surface.release
    w[base + layout.SLOT_KIND :][:count] = surface.kind
    w[base + layout.SLOT_MODELS] = 0
    if surface.bristles is not None:
        _write_bristles(m, base, surface.bristles)
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


def _write_table(table: NDArray[np.float64], values: NDArray[np.float64]) -> None:
    """Values at the table's points and the slopes between them, interleaved."""
    table[0::2] = values
    table[1:-1:2] = np.diff(values)
    table[-1] = 0.0


def _write_bristles(m: NDArray[np.float64], base: int, field: BristleField) -> None:
    w = m.view(np.int64)
    w[base + layout.SLOT_MODELS] |= layout.HAS_BRISTLES
    _write_table(m[base + layout.SLOT_GRIP :][: 2 * (layout.CELLS + 1)], field.grip)
    w[base + layout.SLOT_OWNER :][: layout.CELLS + 1] = field.owner
    of_bank = [*enumerate(field.of_kind), (layout.MAX_KINDS, field.bare)]
    for bank, bristles in of_bank:
        row = base + layout.BRISTLES + bank * layout.BRISTLE_PARAMETERS
        sticks = bank < len(field.sticks) and field.sticks[bank]
        w[row + layout.P_MODEL] = layout.BRISTLE_EVENT if sticks else layout.VISCOUS_EVENT
        m[row + layout.P_STIFFNESS] = bristles.stiffness
        m[row + layout.P_DAMPING] = bristles.damping
        m[row + layout.P_STATIC] = bristles.static_ratio
        m[row + layout.P_STRIBECK] = bristles.stribeck_speed
        m[row + layout.P_BREAK_AWAY] = bristles.break_away
