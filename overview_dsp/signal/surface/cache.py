"""Surfaces kept while many voices share them: what doesn't change the surface builds none.

Thread: any.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Hashable

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.design.presets.parameters import PARAMETERS
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.signal.surface.model import Surface

MOST = 32
"""Surfaces kept: a megabyte or two each."""

_OF_SURFACE = tuple(id for id, known in PARAMETERS.items() if known.surface)


def _key(timeline: Timeline, preset: Preset) -> Hashable:
    values = tuple(preset.values[id] for id in _OF_SURFACE)
    return id(timeline), values, preset.points, tuple(preset.kinds.items())


class SurfaceCache:
    """The surfaces used last, by what they are made of."""

    def __init__(self, most: int = MOST) -> None:
        """Keep up to `most` surfaces."""
        self._most = most
        # the timeline is held: while an entry lives, its id names no other
        self._kept: OrderedDict[Hashable, tuple[Timeline, Surface]] = OrderedDict()
        self._latest: tuple[Timeline, Preset, Surface] | None = None
        self._lock = threading.Lock()

    def surface(self, timeline: Timeline, preset: Preset) -> Surface:
        """`build_surface(timeline, preset)`, or what it gave for the same before."""
        latest = self._latest
        # voices that differ in nothing but their seed come one after another
        if latest is not None and latest[0] is timeline and latest[1] is preset:
            return latest[2]
        key = _key(timeline, preset)
        with self._lock:
            found = self._kept.get(key)
            if found is not None:
                self._kept.move_to_end(key)
                self._latest = timeline, preset, found[1]
                return found[1]
            # within the lock: threads that start together build each surface once
            surface = build_surface(timeline, preset)
            self._kept[key] = (timeline, surface)
            while len(self._kept) > self._most:
                self._kept.popitem(last=False)
            self._latest = timeline, preset, surface
            return surface
