"""Live update of a surface that is being touched: only the part ahead of the cursor changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from overview_dsp.arrays import FloatArray
from overview_dsp.signal.surface.model import Surface, TextureStrikes

BLEND = 0.01
"""Part of the surface over which friction changes from old to new."""


def join_surfaces(old: Surface, new: Surface, cursor: float) -> Surface | None:
    """Return a surface that is the old one up to the cursor (0 to 1) and the new one beyond it.

    Both are of the same preset and of timelines of the same duration. None if the events up to the
    cursor differ, or if a surface has bristles or detents, whose state depends on the past.
    """
    layered = (old.bristles, old.detents, new.bristles, new.detents) != (None,) * 4
    if layered or (old.kind_names, old.kind_modes, old.own_modes) != (
        new.kind_names, new.kind_modes, new.own_modes
    ):  # fmt: skip
        return None
    count = _count_before(old, cursor)
    if count is None or count != _count_before(new, cursor):
        return None
    same = (
        np.array_equal(getattr(old, name)[:count], getattr(new, name)[:count])
        for name in ("position", "kind", "event")
    )
    crests = _crests(old.texture_strikes, new.texture_strikes, cursor)
    if not all(same) or crests is None:
        return None
    cells = len(old.friction) - 1
    part = np.clip((np.arange(cells + 1) / cells - cursor) / BLEND, 0.0, 1.0)
    friction = np.where(
        part > 0.0, old.friction + part * (new.friction - old.friction), old.friction
    )
    friction[part == 1.0] = new.friction[part == 1.0]
    return replace(
        new,
        friction=friction,
        texture_strikes=crests,
        edges=np.concatenate((old.edges[:count], new.edges[count:])),
        release=np.concatenate((old.release[:count], new.release[count:])),
        span=np.concatenate((old.span[:count], new.span[count:])),
    )


def _count_before(surface: Surface, cursor: float) -> int | None:
    """Return the number of events up to the cursor; None unless they are the first in the list."""
    begins: FloatArray = np.minimum(surface.position, surface.edges.min(axis=1, initial=1))
    reached = begins <= cursor
    count = int(np.count_nonzero(reached))
    return count if reached[:count].all() else None


def _crests(old: TextureStrikes, new: TextureStrikes, cursor: float) -> TextureStrikes | None:
    count = int(np.searchsorted(old.position, cursor, side="right"))
    if not np.array_equal(old.position[:count], new.position[:count]):
        return None
    return TextureStrikes(new.position, np.concatenate((old.release[:count], new.release[count:])))
