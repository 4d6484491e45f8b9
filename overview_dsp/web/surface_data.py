"""The friction under a window's cursor, as a page draws it: binary, little-endian.

``GET /data/surface?start=S&end=S&preset=NAME&points=N``::

    offset 0    4 bytes "ovs1"
           4    uint32 points N, uint32 events E, uint32 0
          16    float64 start_s, end_s
          32    float32 x N: what a disk at 1 rad/s is held with, N m s/rad, by all friction models,
                at N even cursors from 0 to 1; the largest of the table's points nearest to each
          ...   E records of 20 bytes: float32 place, span_from, span_to (cursor; -inf, inf beyond
                an end), uint32 event (index into `/data/timeline`'s events), uint32 kind (index
                into `/data/preset`'s kinds)

At most 65537 points and 16384 events: 0.6 MB.
"""

from __future__ import annotations

import numpy as np

from overview_dsp.errors import InputError
from overview_dsp.surface import CELLS, Surface

MAGIC = b"ovs1"
POINTS = 2049
EVENT = np.dtype(
    [("place", "<f4"), ("span", "<f4", 2), ("event", "<u4"), ("kind", "<u4")], align=False
)


def encode_surface(surface: Surface, window: tuple[float, float], points: int = POINTS) -> bytes:
    """The answer's bytes; InputError for fewer than 2 points or more than the table has."""
    if not 2 <= points <= CELLS + 1:
        raise InputError(f"points {points} is out of range; it is 2 to {CELLS + 1}")
    nearest = np.rint(np.arange(CELLS + 1) * ((points - 1) / CELLS)).astype(np.int64)
    first = np.searchsorted(nearest, np.arange(points))
    table = np.maximum.reduceat(surface.resistance, first).astype("<f4")
    events = np.zeros(len(surface.place), EVENT)
    events["place"], events["span"] = surface.place, surface.span
    events["event"], events["kind"] = surface.event, surface.kind
    head = np.array([points, len(events), 0], "<u4").tobytes()
    return MAGIC + head + np.array(window, "<f8").tobytes() + table.tobytes() + events.tobytes()
