"""A timeline that grows, in a folder that any web host or CDN serves: versioned files, replaced.

The folder is that of `static_site`, and in `live/` of it::

    now.json              the notice of the present version (`live_data`); pages ask for it
    VERSION-RATE.update   the update to that version for a page that has none
    VERSION-points.json   the values of a series

A version's files never change, so they may be cached for ever; `now.json` is replaced once they
are there. The versions before stay for pages that are just fetching them.

Thread: its own.
"""

from __future__ import annotations

import json
import os
import threading
from collections import deque
from collections.abc import Callable
from pathlib import Path

from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import OverviewError
from overview_dsp.files.atomic import atomic_file
from overview_dsp.web.live_data import LiveData
from overview_dsp.web.site_content import RATES
from overview_dsp.web.static_site import write_site
from overview_dsp.web.values import has_values, points_json

EVERY_S = 2.0
"""A version is published at most so often, and pages ask as often."""

OLD = 3
"""So many versions before the present one stay."""


class Published:
    """Keeps a folder up with a timeline until it is closed."""

    def __init__(
        self,
        live: LiveTimeline,
        preset: Preset,
        path: str | os.PathLike[str],
        note: Callable[[str], None],
        every_s: float = EVERY_S,
    ) -> None:
        """Write the folder and begin; `note` receives what can't be written later.

        Raises
        ------
        InputError
            The folder can't be written, or holds other files.
        """
        self._data = LiveData(live, lambda: preset)
        self._live = live
        self._note = note
        self._every_s = every_s
        self._kept: deque[list[Path]] = deque()
        described = {"levels": 0, "version": self._data.version, "poll_s": every_s}
        write_site(self._data.timeline, preset, path, levels=0, live=described)
        self._folder = Path(path) / "live"
        self._folder.mkdir(exist_ok=True)
        self._publish()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="publishing", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Publish what is there, and end."""
        self._over.set()
        self._thread.join()

    def _run(self) -> None:
        failed = ""
        over = False
        while not over:
            over = self._over.wait(self._every_s)
            if self._live.revision == self._data.version:
                continue
            self._data.take()
            try:
                self._publish()
            except OverviewError as error:
                if str(error) != failed:
                    self._note(str(error))
                failed = str(error)

    def _publish(self) -> None:
        version = self._data.version
        files = []
        for rate in RATES:
            files.append(self._folder / f"{version}-{rate}.update")
            with atomic_file(files[-1]) as temporary:
                temporary.write_bytes(self._data.update(-1, rate))
        timeline = self._data.timeline
        if has_values(timeline):
            files.append(self._folder / f"{version}-points.json")
            with atomic_file(files[-1]) as temporary:
                points = points_json(timeline, 0.0, timeline.duration_s)
                temporary.write_text(json.dumps(points), encoding="utf-8")
        with atomic_file(self._folder / "now.json") as temporary:
            temporary.write_text(json.dumps(self._data.notice(0)), encoding="utf-8")
        self._kept.append(files)
        while len(self._kept) > OLD + 1:
            for old in self._kept.popleft():
                old.unlink(missing_ok=True)
