"""Options of a live timeline: source, layout, announcements."""

from __future__ import annotations

import math
import re
import sys
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import overview_dsp as ov
from overview_dsp.cli.options.declaring import option, refuse_options
from overview_dsp.cli.options.reading import Reading, Window, open_timeline, preset_for
from overview_dsp.cli.options.server import Server, ServerAddress, open_server
from overview_dsp.errors import InputError
from overview_dsp.validation import float_or_nan

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Timeline
    from overview_dsp.live.session.live_updates import FollowSettings
    from overview_dsp.live.session.marks import MarksFile
    from overview_dsp.web.media import Media
    from overview_dsp.web.session import HostSession

FIRST_WITHIN_S = 3.0  # longest wait for the first data, which determine the preset, s

MINIMUM_S = {"held": 0.0, "every": 1.0}
"""Settings at the end of `--follow SOURCE,held=S,every=S`, with their smallest value, s."""

_SETTING = re.compile(rf"(.*),({'|'.join(MINIMUM_S)})=([^,]*)", re.DOTALL)


def _settings_of(text: str) -> tuple[str, dict[str, float]]:
    """Return the source of `--follow` and its settings, s; InputError for an invalid one."""
    found: dict[str, float] = {}
    while match := _SETTING.fullmatch(text):
        text, name, value = match.groups()
        found[name] = float_or_nan(value)
        if not MINIMUM_S[name] <= found[name] < math.inf:
            raise InputError(f"--follow: {name}={value}; must be {MINIMUM_S[name]:g} s or more")
    return text, found


@dataclass(frozen=True)
class Feed:
    """Options of a live source."""

    heading: ClassVar[str] = "Live data"

    follow: str | None = option(metavar="SOURCE")
    expected_duration: str | None = option(metavar="LENGTH")
    layout: str | None = option(metavar="LAYOUT")
    announce: str | None = option(metavar="KIND")

    @contextmanager
    def opened(self, timeline: str | None, reading: Reading) -> Iterator[FollowSettings | None]:
        """Follow the live source; yields None if TIMELINE is a file; InputError."""
        if self.follow is None:
            refuse_options("needs --follow; add it", Feed)
            if timeline is None:
                raise InputError("no timeline; name a TIMELINE, or a live source with --follow")
            yield None
            return
        if timeline is not None:
            raise InputError(f"--follow {self.follow} replaces TIMELINE; remove {timeline}")
        refuse_options("doesn't apply to --follow; remove it", Reading)
        from overview_dsp.data.feeds.follower import Follower
        from overview_dsp.data.feeds.sources import Sound
        from overview_dsp.live.inputs.feeds import open_source, parse_duration, parse_layout
        from overview_dsp.live.session.live_updates import FollowSettings

        name, settings = _settings_of(self.follow)
        length, layout = self.expected_duration, self.layout
        live = ov.LiveTimeline(
            expected_duration_s=None if length is None else parse_duration(length),
            layout=None if layout is None else parse_layout(layout),
        )
        source = open_source(name, sys.stdin.buffer, settings.get("every"))
        follower = Follower(live, source).start()
        try:
            until = time.monotonic() + FIRST_WITHIN_S
            while live.revision == 0 and not follower.over and time.monotonic() < until:
                time.sleep(0.02)
            if live.revision == 0 and follower.over:
                raise InputError("; ".join(follower.take_messages()) or f"{self.follow}: no data")
            preset = "crowd" if isinstance(source, Sound) else None  # it has no events yet
            held_s = settings.get("held")
            yield FollowSettings(live, follower, held_s, self.announce, layout is not None, preset)
        finally:
            follower.close()


@dataclass(frozen=True)
class OpenedData:
    """Opened timeline, its first window (start_s, end_s), preset (name or path) and marks."""

    timeline: Timeline
    window: tuple[float, float] | None
    preset: str
    follow: FollowSettings | None
    marks: MarksFile

    def served(
        self, server: Server, host: HostSession | None, linear: bool, media: Media | None = None
    ) -> AbstractContextManager[ServerAddress]:
        """Serve the data to pages, which play them, or which control the session `host`."""
        from overview_dsp.web.data import data_routes

        live = None if self.follow is None else self.follow.live
        routes = data_routes(
            self.timeline, self.preset, audio="here" if host is None else "host",
            first=self.window, media=media, live=live, linear=linear,
        )  # fmt: skip
        return open_server(server, host, routes, live is not None)


@contextmanager
def open_data(
    timeline: str | None, feed: Feed, reading: Reading, window: Window, preset: str | None
) -> Iterator[OpenedData]:
    """Open the timeline of a file, or follow a live source; InputError."""
    from overview_dsp.live.session.marks import MarksFile  # late: the session takes time to load

    with feed.opened(timeline, reading) as follow:
        if follow is None:
            assert timeline is not None
            data = open_timeline(timeline, reading)
        else:
            data, preset = follow.live.padded_snapshot(), preset or follow.preset
        first = window.of(data)
        marks = MarksFile(_marks_path(timeline or _settings_of(feed.follow or "")[0]))
        if first is not None and window.window and follow is None:
            data, marks = data.window(*first), replace(marks, start_s=first[0])
            first = None
        name = preset_for(data, preset)
        if follow is not None:
            follow.use_preset_layout(ov.load_preset(name))
            data = follow.live.padded_snapshot()
        yield OpenedData(data, first, name, follow, marks)


def _marks_path(source: str) -> Path:
    """Return the path of a source's marks: beside a file, otherwise in the current folder."""
    path = Path(source)
    if path.is_file():
        return path.with_name(f"{path.name}.marks.json")
    last = source.partition("?")[0].rpartition("/")[2]  # a query may contain a key
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", last).strip("-.")
    return Path(f"{name or 'live'}.marks.json")
