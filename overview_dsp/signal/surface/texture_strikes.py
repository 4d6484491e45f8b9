"""Where the disk strikes the bare surface itself, whose material is heard there.

At the crests of its pattern: a crest takes torque from the arriving disk and lets it go, as an
event does; its release is the friction, or the grip, that the pattern adds at its top. Where the
pattern is detents, the disk falls into their troughs. A surface without material has none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class TextureStrikes:
    """Crests or troughs: `position` (cursor, ascending), `release` (N m s/rad); float64 (n,)."""

    position: NDArray[np.float64]
    release: NDArray[np.float64]


NONE = TextureStrikes(np.zeros(0), np.zeros(0))


def crests(course: NDArray[np.float64]) -> NDArray[np.int64]:
    """The points of a table that are higher than the one before and not lower than the next."""
    inner = course[1:-1]
    return np.flatnonzero((inner > course[:-2]) & (inner >= course[2:])) + 1


def crests_of(course: NDArray[np.float64], top: float) -> TextureStrikes:
    """The crests of a pattern (0 to 1 at the table's points), whose 1 is `top` N m s/rad."""
    at = crests(course)
    return TextureStrikes(at / (len(course) - 1), top * course[at])


def troughs_of(course: NDArray[np.float64], impedance: float) -> TextureStrikes:
    """The troughs of a pattern of detents, which take `impedance` N m s/rad from the disk."""
    at = crests(-course)
    return TextureStrikes(at / (len(course) - 1), np.full(len(at), impedance))
