"""Feeds for tests: a recorded match told line by line, and what a reader makes of a part of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import overview_dsp as ov
from overview_dsp.data.feeds.feed_lines import encode_line, feed_of, take_line
from overview_dsp.data.readers.events import event_table

MATCHES = (
    "football/metrica/Sample_Game_1_RawEventsData.csv",
    "football/statsbomb/15986.json",
    "football/statsbomb/22936.json",
    "football/statsbomb/69321.json",
    "football/wyscout/wyscout_v2_match_2499773.json",
)
"""The shared matches."""


def matches(folder: Path) -> list[ov.Timeline]:
    return [ov.load_timeline(folder / name) for name in MATCHES]


def tell(live: ov.LiveTimeline, timeline: ov.Timeline) -> None:
    """All of a timeline, through the feed's lines."""
    for _, line in feed_of(timeline):
        take_line(live, encode_line(line))


def lines_of(timeline: ov.Timeline) -> list[dict[str, Any]]:
    return [line for _, line in feed_of(timeline)]


def read_prefix(events: list[ov.Event], now_s: float) -> ov.Timeline:
    """What the reader of event lists makes of the events up to now."""
    rows = ["time_s,kind,label"]
    # products of the curve are rounded in the order of the file: that of the readers of matches
    for event in sorted(events, key=lambda one: one.kind != "period"):
        label = event.label.replace('"', '""')
        rows.append(f'{event.time_s!r},{event.kind},"{label}"')
    return event_table.decode("\n".join(rows), duration_s=now_s)
