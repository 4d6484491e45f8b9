"""Cache of surfaces shared by many voices.

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

MOST = 32  # default number of surfaces in the cache, of one to two megabytes each
_OF_SURFACE = tuple(id for id, known in PARAMETERS.items() if known.surface)


class SurfaceCache:
    """Most recently used surfaces by timeline and surface parameters."""

    def __init__(self, most: int = MOST) -> None:
        """Keep up to `most` surfaces."""
        self._most = most
        # the reference to the timeline keeps its id unique while the entry exists
        self._kept: OrderedDict[Hashable, tuple[Timeline, Surface]] = OrderedDict()
        self._latest: tuple[Timeline, Preset, Surface] | None = None
        self._lock = threading.Lock()

    def surface(self, timeline: Timeline, preset: Preset) -> Surface:
        """Return `build_surface(timeline, preset)` or an equal surface from the cache."""
        latest = self._latest
        # voices that differ only in their seed follow each other
        if latest is not None and latest[0] is timeline and latest[1] is preset:
            return latest[2]
        values = tuple(preset.values[id] for id in _OF_SURFACE)
        key = id(timeline), values, preset.points, tuple(preset.kinds.items())
        with self._lock:
            found = self._kept.get(key)
            if found is not None:
                self._kept.move_to_end(key)
                self._latest = timeline, preset, found[1]
                return found[1]
            # within the lock, so that concurrent threads build each surface once
            surface = build_surface(timeline, preset)
            self._kept[key] = (timeline, surface)
            while len(self._kept) > self._most:
                self._kept.popitem(last=False)
            self._latest = timeline, preset, surface
            return surface
