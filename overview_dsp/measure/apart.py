"""Events that are felt apart: how many knocks of its events a stroke gives a finger.

A knock is a peak of the felt level that stands at least `KNOCK_DB` above its surroundings (its
prominence), at least `APART_S` from any higher one. It counts where the disk is on an event then.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from overview_dsp.measure.felt import Stroke, window_db
from overview_dsp.signal.surface.model import Surface
from overview_dsp.units import FELT_WINDOW_S

KNOCK_DB = 2.3
"""A step of amplitude that the skin notices (Israr and Tan 2006: 2.2 to 2.5 dB)."""

APART_S = 0.030
"""Two knocks closer than this are felt as one."""

HOP_S = 0.002


def knocks(level: NDArray[np.float64]) -> NDArray[np.int64]:
    """The indices of the knocks in a level (dB, `HOP_S` apart)."""
    from scipy.signal import find_peaks

    found, _ = find_peaks(level, prominence=KNOCK_DB, distance=round(APART_S / HOP_S))
    return np.asarray(found, dtype=np.int64)


def events_felt_apart(
    stroke: Stroke,
    surface: Surface,
    columns: Mapping[str, NDArray[np.float64]],
    tactor: NDArray[np.float32],
    sample_rate: float,
) -> int:
    """Count the events of a surface that are felt one by one in a stroke.

    Parameters
    ----------
    stroke : Stroke
        Which part of the render.
    surface : Surface
        What the disk moved on.
    columns : Trace or mapping
        Its column `cursor` is used.
    tactor : float32 (frames,)
        The tactor's channel of the same render.
    sample_rate : float
        Hz.

    Returns
    -------
    int
        Knocks 30 ms apart or more, while the disk is on an event.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> trace, surface = result.trace, result.engine.surface
    >>> stroke = ov.measure.strokes(trace.engaged, trace.cursor)[0]
    >>> ov.measure.events_felt_apart(stroke, surface, trace, result.samples[:, 1], 8000) > 0
    True
    """
    cursor = columns["cursor"][stroke.start : stroke.stop]
    starts, level = window_db(tactor[stroke.start : stroke.stop], sample_rate, HOP_S)
    peaks = knocks(level)
    middles = (starts[peaks] + FELT_WINDOW_S * sample_rate / 2.0).astype(np.int64)
    return int(np.count_nonzero(surface.in_span(cursor[np.minimum(middles, len(cursor) - 1)])))
