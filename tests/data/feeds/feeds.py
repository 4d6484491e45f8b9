"""Feeds for tests: lines of a recorded match, and timelines of its first part."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import overview_dsp as ov
from overview_dsp.data.feeds.feed_lines import (
    KEYS,
    apply_parsed,
    encode_line,
    lines_of_timeline,
    parse_line,
)
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


def apply_line(live: ov.LiveTimeline, line: bytes | str) -> str:
    """Apply a line of a feed to a timeline; return its key."""
    key, document = parse_line(line)
    if key in KEYS:
        apply_parsed(live, key, document)
    return key


def apply_all(live: ov.LiveTimeline, timeline: ov.Timeline) -> None:
    """Apply all lines of a timeline's feed."""
    for _, line in lines_of_timeline(timeline):
        apply_line(live, encode_line(line))


def lines_of(timeline: ov.Timeline) -> list[dict[str, Any]]:
    return [line for _, line in lines_of_timeline(timeline)]


def read_prefix(events: list[ov.Event], now_s: float) -> ov.Timeline:
    """Return the events until now as read from an event list."""
    rows = ["time_s,kind,label,side"]
    # in the order of the match readers, so that the curve is bit-identical
    for event in sorted(events, key=lambda one: one.kind != "period"):
        label = event.label.replace('"', '""')
        rows.append(f'{event.time_s!r},{event.kind},"{label}",{event.side}')
    return event_table.decode("\n".join(rows), duration_s=now_s)
