"""More events than a surface holds: the strongest of those that fall together strikes for all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def thin_events(
    position: NDArray[np.float64], release: NDArray[np.float64], most: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The events to keep, at most `most` (1 or more) of them, in the order of their positions.

    Events fall together that lie in one cell; if that leaves too many, in one of twice the width,
    and so on. Of equally strong ones the first stays.

    Parameters
    ----------
    position : float64 (events,)
        Where each strikes, cells.
    release : float64 (events,)
        How strong it is.

    Returns
    -------
    kept : int64 (kept,)
        Indices of events.
    stands_for : int64 (events,)
        For each event the number, in `kept`, of the one that strikes for it.
    """
    order = np.argsort(position, kind="stable")
    cell = np.floor(position[order]).astype(np.int64)
    while len(np.unique(cell)) > most:
        cell >>= 1
    group = np.unique(cell, return_inverse=True)[1]
    strongest = np.lexsort((np.arange(len(order)), -release[order], group))
    first = np.flatnonzero(np.diff(group[strongest], prepend=-1))
    stands_for = np.empty(len(order), dtype=np.int64)
    stands_for[order] = group
    return order[strongest[first]], stands_for
