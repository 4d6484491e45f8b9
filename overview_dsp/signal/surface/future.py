"""What hasn't happened yet feels like: smooth and heavy, behind a soft end where now is.

Nothing in the future strikes, and it has neither pattern nor ribs. Friction rises from what is
there at the last moment that has happened to more than a curve can reach, within a few hundredths
of the surface: the disk sinks into it instead of hitting a stop, and it is no event.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SOFT_END = 0.03
"""Part of the surface in which friction rises: wider than any event of the bundled presets."""

OVER_THE_CURVE = 2.0
"""How much heavier it is than the bare surface at the top of the curve: of 1.2, Weber's fraction of
damping, a finger may doubt; of 2 it doesn't."""


def heaviness(ambience: float) -> float:
    """Friction of the future, in bare surfaces, above a curve of this ambience."""
    return OVER_THE_CURVE * (1.0 + ambience)


def rise(now: float, cells: int) -> NDArray[np.float64]:
    """How far each point of a table of cells + 1 is in the future: 0, then a smooth rise to 1.

    Parameters
    ----------
    now
        Up to where it has happened, 0 to 1 of the surface.
    cells
        Of the table.
    """
    part = np.clip((np.arange(cells + 1) / cells - now) / SOFT_END, 0.0, 1.0)
    return part * part * (3.0 - 2.0 * part)
