"""The data files of a timeline's page (`site_data`, `sound_data`), each created on request.

A static folder contains all of them; a server creates those that a page requests.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

from overview_dsp.data.analysis.series_events import has_values
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.kernels.layout import CELLS
from overview_dsp.signal.actuators.model import Actuator
from overview_dsp.signal.surface.base_surface import rank_step
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.signal.surface.model import Surface
from overview_dsp.web import site_data
from overview_dsp.web.sound_data import make_patch, pack, whole_bytes, window_bytes

RATES = (48_000, 44_100)
"""Common sample rates of browsers, Hz; at others the browser resamples."""

FIRST = ("data/timeline.json", "data/window-0.json", "data/points-0.json")


class SiteContent:
    """The files of a timeline and its windows for one preset.

    `levels`: number of zoom levels.
    `actuator`: actuator of the tactor's signal.
    `server`: features of the server (`data`); None in a static folder.
    `live`: settings of a live timeline (`live_data`, `static_publisher`).
    `files`: functions that make the bytes of each file, by its path, window by window.
    """

    def __init__(
        self,
        timeline: Timeline,
        preset: Preset,
        *,
        levels: int,
        seed: int = 0,
        actuator: Actuator | None = None,
        server: dict[str, Any] | None = None,
        live: dict[str, Any] | None = None,
    ) -> None:
        self.preset = preset
        self.parts = site_data.site_windows(timeline, levels)
        self.timeline = timeline
        self._seed = seed
        self._actuator = actuator
        self._server, self._live = server, live
        self.files: dict[str, Callable[[], bytes]] = {"data/timeline.json": self._timeline_file}
        # files of one window are requested together
        self._surface = lru_cache(maxsize=1)(self._build)
        self._sound = lru_cache(maxsize=1)(lambda i: self._at_rate(i, RATES[0]))
        for i in range(len(self.parts)):
            self.files[f"data/window-{i}.json"] = partial(self._window, i)
            if has_values(timeline) and (i == 0 or not site_data.fits_one_file(timeline)):
                self.files[f"data/points-{i}.json"] = partial(self._points, i)
            if i == 0:
                self._add_sound("0", -1)
            if len(self.parts) > 1:
                self._add_sound("back" if i == 0 else str(i), i)

    def is_needed_first(self, name: str) -> bool:
        """Return whether a page needs a file to show and play the whole timeline."""
        return name in FIRST or name.startswith(("sound/0.", "sound/0-"))

    def _add_sound(self, name: str, i: int) -> None:
        self.files[f"sound/{name}.packed"] = partial(self._packed, i)
        for rate in RATES[1:]:
            self.files[f"sound/{name}-{rate}.patch"] = partial(self._patch, i, rate)

    def _timeline_file(self) -> bytes:
        content = site_data.timeline_json(self.timeline, self.preset, self.parts, RATES)
        return compact_json({**content, "server": self._server, "live": self._live})

    def _window(self, i: int) -> bytes:
        timeline, surface = self._surface(i)
        return compact_json(site_data.window_json(timeline, surface, self.parts[i].start_s))

    def _points(self, i: int) -> bytes:
        part = self.parts[i]
        return compact_json(site_data.points_json(self.timeline, part.start_s, part.end_s))

    def _build(self, i: int) -> tuple[Timeline, Surface]:
        part = self.parts[i]
        timeline = self.timeline if i == 0 else self.timeline.window(part.start_s, part.end_s)
        return timeline, build_surface(timeline, self.preset)

    def _at_rate(self, i: int, rate: int) -> bytes:
        if i < 0:
            return whole_bytes(self.timeline, self.preset, rate, self._seed, self._actuator)
        return window_bytes(self._surface(i)[1], self.preset, rate)

    def _packed(self, i: int) -> bytes:
        step = rank_step(self._surface(max(i, 0))[0], self.preset, CELLS)
        return pack(self._sound(i), step)

    def _patch(self, i: int, rate: int) -> bytes:
        return make_patch(self._sound(i), self._at_rate(i, rate))


def compact_json(document: dict[str, Any]) -> bytes:
    """Return a JSON object without spaces."""
    text = json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.encode()
