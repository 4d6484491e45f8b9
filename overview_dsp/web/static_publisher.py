"""A live timeline in a static folder, which any web host or CDN can serve.

The folder is that of `static_site` with a subfolder `live/`::

    now.json              the notice of the current version (`live_data`); pages poll it
    VERSION-RATE.update   the complete update to that version
    VERSION-points.json   the values of a series

A version's files never change, so they can be cached. `now.json` is replaced after they are
written. Earlier versions stay for pages that are loading them.

Thread: its own.
"""

from __future__ import annotations

import json
import os
import threading
from collections import deque
from collections.abc import Callable
from pathlib import Path

from overview_dsp.data.analysis.series_events import has_values
from overview_dsp.data.feeds.live_timeline import LiveTimeline
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import OverviewError
from overview_dsp.files.atomic import write_file
from overview_dsp.web.live_data import LiveData
from overview_dsp.web.site_content import RATES
from overview_dsp.web.site_data import points_json
from overview_dsp.web.static_site import write_site

INTERVAL_S = 2.0
"""Time between two versions, and between two requests of a page."""

KEPT_VERSIONS = 3
"""Number of earlier versions that stay in the folder."""


class StaticPublisher:
    """Updates a static folder with a live timeline until it is closed."""

    def __init__(
        self,
        live: LiveTimeline,
        preset: Preset,
        path: str | os.PathLike[str],
        report: Callable[[str], None],
        interval_s: float = INTERVAL_S,
    ) -> None:
        """Write the folder and start the thread; `report` receives later errors.

        InputError if the folder can't be written, or contains other files.
        """
        self._data = LiveData(live, lambda: preset)
        self._live = live
        self._report = report
        self._interval_s = interval_s
        self._versions: deque[list[Path]] = deque()
        description = {"levels": 0, "version": self._data.version, "poll_s": interval_s}
        write_site(self._data.timeline, preset, path, levels=0, live=description)
        self._folder = Path(path) / "live"
        self._folder.mkdir(exist_ok=True)
        self._publish()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="publishing", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Publish the newest version and stop."""
        self._closing.set()
        self._thread.join()

    def _run(self) -> None:
        last_error = ""
        closing = False
        while not closing:
            closing = self._closing.wait(self._interval_s)
            if self._live.revision == self._data.version:
                continue
            self._data.refresh()
            try:
                self._publish()
            except OverviewError as error:
                if str(error) != last_error:
                    self._report(str(error))
                last_error = str(error)

    def _publish(self) -> None:
        version = self._data.version
        files = []
        for rate in RATES:
            files.append(self._folder / f"{version}-{rate}.update")
            write_file(files[-1], self._data.update(-1, rate))
        timeline = self._data.timeline
        if has_values(timeline):
            files.append(self._folder / f"{version}-points.json")
            points = points_json(timeline, 0.0, timeline.duration_s)
            write_file(files[-1], json.dumps(points))
        write_file(self._folder / "now.json", json.dumps(self._data.notice(0)))
        self._versions.append(files)
        while len(self._versions) > KEPT_VERSIONS + 1:
            for old in self._versions.popleft():
                old.unlink(missing_ok=True)
