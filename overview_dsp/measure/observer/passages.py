"""Which event each onset belongs to: an observer's teacher and examiner knows it, by the trace.

The disk is *on* an event from where it enters its span until it leaves it. An onset belongs to an
event if it comes from `BEFORE_MS` before that to `AFTER_MS` after it; of several, to the one whose
own profile lets go the most friction (not the friction that surrounds it: a foul beside a goal
would take the goal's).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.measure.felt import passages
from overview_dsp.signal.surface.model import Surface

BEFORE_MS, AFTER_MS = 15.0, 40.0

TURN = 0.01
"""A disk turns back where it goes so far the other way, as a part of the timeline."""

LOOK_S = 0.004
"""How often it is looked at for that."""


@dataclass(frozen=True, eq=False)
class Met:
    """Events of a stroke, once for each time that the disk passes them; row by row.

    Events that the input disk passes and the disk never meets are rows too, with infinite times.

    Attributes
    ----------
    kind : int64 (events,)
        Index into the surface's `kind_names`.
    enters_ms, leaves_ms : float64 (events,)
        From the stroke's start.
    strength : float64 (events,)
        Friction that lets go, N m s/rad.
    """

    kind: NDArray[np.int64]
    enters_ms: NDArray[np.float64]
    leaves_ms: NDArray[np.float64]
    strength: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.kind)


def met(
    surface: Surface, cursor: NDArray[np.float64], sample_rate: float, furthest: float = -math.inf
) -> Met:
    """Find the events that a stroke meets, and those that it misses.

    Parameters
    ----------
    surface : Surface
    cursor : float64 (frames,)
        Of the stroke.
    sample_rate : float
        Hz.
    furthest : float
        Furthest position of the input disk: it passes all events that start before.
    """
    bounds = _turns(cursor, max(1, int(LOOK_S * sample_rate)))
    events, enters, leaves = [], [], []
    for start, stop in itertools.pairwise(bounds):
        event, first, last = passages(surface, cursor[start:stop])
        events.append(event)
        enters.append(first + start)
        leaves.append(last + start)
    event = np.concatenate(events)
    frames = np.stack([np.concatenate(enters), np.concatenate(leaves)]).astype(np.float64)
    begins = surface.span[:, 0]
    missed = np.setdiff1d(np.flatnonzero((begins > -math.inf) & (begins <= furthest)), event)
    event = np.append(event, missed)
    frames = np.hstack([frames, np.full((2, len(missed)), math.inf)])
    enters_ms, leaves_ms = frames * (1000.0 / sample_rate)
    return Met(
        surface.kind[event],
        enters_ms,
        leaves_ms,
        surface.release[event],
    )


def owners(at_ms: NDArray[np.int64], there: Met) -> NDArray[np.int64]:
    """The row of `there` that each onset belongs to; -1 for none."""
    if not len(there):
        return np.full(len(at_ms), -1)
    at = at_ms[:, None]
    near = (there.enters_ms - BEFORE_MS <= at) & (at <= there.leaves_ms + AFTER_MS)
    strength = np.where(near, there.strength, -1.0)
    # of equal ones the last, as of an event passed twice
    row = len(there) - 1 - strength[:, ::-1].argmax(axis=1)
    return np.where(near.any(axis=1), row, -1)


def _turns(cursor: NDArray[np.float64], step: int) -> list[int]:
    """Frames at which the disk turns back, with the first and the one behind the last."""
    coarse = cursor[::step]
    bounds, extreme, way = [0], 0, 0
    for i, place in enumerate(coarse.tolist()):
        ahead = place - coarse[extreme]
        if way == 0:
            if abs(ahead) > TURN:
                way, extreme = (1 if ahead > 0.0 else -1), i
        elif ahead * way >= 0.0:
            extreme = i
        elif -ahead * way > TURN:
            bounds.append(extreme * step)
            way, extreme = -way, i
    return [*dict.fromkeys(bounds), len(cursor)]
