"""What is new ahead of a hand, joined to what it touches: no place moves, none behind changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from overview_dsp.signal.surface.model import Surface, TextureStrikes

BLEND = 0.01
"""Part of the surface over which the old friction becomes the new."""


def joined(old: Surface, new: Surface, place: float) -> Surface | None:
    """Return the new surface beyond a place, and the old one up to it.

    Parameters
    ----------
    old, new : Surface
        Of the same preset, and of timelines of one length.
    place : float
        Cursor, 0 to 1: up to there every value is the old one's.

    Returns
    -------
    Surface or None
        None where the events up to there aren't the same, or where bristles or detents lie beside
        friction: what bends them has a history.
    """
    layered = (old.bristles, old.detents, new.bristles, new.detents) != (None,) * 4
    if layered or (old.kind_names, old.kind_modes, old.own_modes) != (
        new.kind_names, new.kind_modes, new.own_modes
    ):  # fmt: skip
        return None
    count = _begun(old, place)
    if count is None or count != _begun(new, place):
        return None
    same = (
        np.array_equal(getattr(old, name)[:count], getattr(new, name)[:count])
        for name in ("position", "kind", "event")
    )
    crests = _crests(old.texture_strikes, new.texture_strikes, place)
    if not all(same) or crests is None:
        return None
    cells = len(old.friction) - 1
    part = np.clip((np.arange(cells + 1) / cells - place) / BLEND, 0.0, 1.0)
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


def _begun(surface: Surface, place: float) -> int | None:
    """How many events the disk meets up to a place; None unless they are the first of the list."""
    begins: NDArray[np.float64] = np.minimum(surface.position, surface.edges.min(axis=1, initial=1))
    met = begins <= place
    count = int(np.count_nonzero(met))
    return count if met[:count].all() else None


def _crests(old: TextureStrikes, new: TextureStrikes, place: float) -> TextureStrikes | None:
    count = int(np.searchsorted(old.position, place, side="right"))
    if not np.array_equal(old.position[:count], new.position[:count]):
        return None
    return TextureStrikes(new.position, np.concatenate((old.release[:count], new.release[count:])))
