"""Time expressions: written moments of a timeline, and windows between two of them.

| written | means |
|---|---|
| `90`, `90.5`, `90s`, `15min`, `6h`, `3d`, `2w` | time after the start |
| `1:30`, `1:02:03.5` | m:ss and h:mm:ss after the start |
| `2012-09-19`, `2012-09-19T09:30`, `Sep 19, 2012`, `2012Q3` | that moment, or its beginning |
| `goal:1`, `event:3` | the first goal, the third event of any kind |
| `start`, `end` | start and end of the timeline |

The last two take an offset, written like the first two: `goal:1-60`, `goal:1+1:30`, `end-6w`.

Dates require a timeline with a calendar (`Timeline.start`), whose time zone is the default. Seconds
outside the timeline are an error. A date or an offset beyond an end is moved to the end, with a
warning.

`Zoom` is a window that can be scaled around a moment.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta

from overview_dsp.data.timeline import time_parsing
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.data.timeline.time_parsing import length_s
from overview_dsp.errors import InputError, quoted, warn

HINT = (
    "give seconds (90.5), m:ss, h:mm:ss, 15min, 6h, 3d or 2w after the start, a date "
    "(2012-09-19, 2012-09-19T09:30), kind:number (goal:1, event:3), start or end; the last three "
    "take an offset (goal:1-60, end-6w)"
)
"""Allowed expressions, for error messages."""

ZOOM_PART = 10.0  # zoom factor for an event: a tenth of the timeline, nine minutes of a match
ZOOM_LEAD = 0.75  # position of the event in its window: the time before it is more important
NARROWEST_S = 0.5  # minimum width of a window, s (or the whole timeline, if it is shorter)
_EVENT = re.compile(r"(?P<kind>[a-z0-9_]*[a-z_][a-z0-9_]*):(?P<number>\d{1,9})", re.A)
_FROM = re.compile(rf"(?P<from>{_EVENT.pattern}|start|end)(?:(?P<sign>[+-])(?P<offset>.+))?", re.A)
_EPOCH = datetime(1970, 1, 1)


@dataclass(frozen=True)
class _Moment:
    """Seconds from the start, and whether they are limited to the timeline."""

    time_s: float
    is_limited: bool


def parse_time_expression(text: str, timeline: Timeline) -> float:
    """Return the seconds from the start to a written moment, within [0, duration_s].

    InputError if the text is not a moment, is outside the timeline, names a missing event, or is a
    date in a timeline without calendar. OverviewWarning for a date or offset beyond an end.
    """
    moment = _parsed(text, timeline)
    limited = _limited(text, moment, timeline)
    if not 0.0 <= limited <= timeline.duration_s:
        raise InputError(f"{quoted(text)} lies outside the timeline; {_reach(timeline)}")
    return limited


def window_of(timeline: Timeline, start: str, end: str) -> tuple[float, float]:
    """Return the window (start_s, end_s) between two written moments.

    Errors as in `parse_time_expression`, and InputError if the window is empty.
    """
    moments = [_parsed(text, timeline) for text in (start, end)]
    first, last = (
        _limited(text, moment, timeline) for text, moment in zip((start, end), moments, strict=True)
    )
    if first >= last and any(moment.is_limited for moment in moments):
        raise InputError(
            f"the window from {quoted(start)} to {quoted(end)} is empty or outside "
            f"the timeline; {_reach(timeline)}"
        )
    timeline.require_window(first, last)
    return first, last


def zoom_window(timeline: Timeline, text: str) -> tuple[float, float]:
    """Return the window (start_s, end_s) around an event: `goal:1`, or `goal:1:90` for 90 s.

    The event is at three quarters of the window, except near the ends of the timeline. InputError
    for a missing event, and for a text that is not its number with an optional width.
    """
    name, _, width_text = text.strip().partition(":")
    number, _, width_text = width_text.partition(":")
    found = _EVENT.fullmatch(f"{name}:{number}")
    width = length_s(width_text) if width_text else timeline.duration_s / ZOOM_PART
    if found is None or width is None or not width > 0.0:
        raise InputError(
            f"{quoted(text)} is not an event; give kind:number (goal:1, event:3) and, "
            "if you like, how long a window (goal:1:90, goal:1:5min)"
        )
    return Zoom.whole(timeline).around(_event_s(found, timeline), width).window


def _parsed(text: str, timeline: Timeline) -> _Moment:
    written = text.strip()
    length = length_s(written)
    if length is not None:
        return _Moment(length, False)
    try:  # nan, inf and negative numbers are rejected later
        return _Moment(float(written), False)
    except ValueError:
        pass
    found = _FROM.fullmatch(written)
    if found is not None:
        return _after(found, timeline, text)
    date = time_parsing.moment(written, "iso", "month names", "quarters, months or weeks")
    if date is not None:
        return _Moment(_calendar_s(date, timeline, text), True)
    raise InputError(f"{quoted(text)} is not a moment; {HINT}")


def _after(found: re.Match[str], timeline: Timeline, text: str) -> _Moment:
    event = _EVENT.fullmatch(found["from"])
    if event is not None:
        base = _event_s(event, timeline)
    else:
        base = 0.0 if found["from"] == "start" else timeline.duration_s
    if found["offset"] is None:
        return _Moment(base, False)
    offset = length_s(found["offset"])
    if offset is None:
        raise InputError(
            f"{quoted(text)}: {quoted(found['offset'])} is not a length; give seconds, "
            "m:ss, h:mm:ss, 15min, 6h, 3d or 2w"
        )
    return _Moment(base + offset if found["sign"] == "+" else base - offset, True)


def _event_s(found: re.Match[str], timeline: Timeline) -> float:
    number = int(found["number"])
    if found["kind"] != "event":
        return timeline.event(found["kind"], number).time_s
    if not 1 <= number <= len(timeline.events):
        raise InputError(
            f"there is no event number {number}; the timeline has {len(timeline.events)}"
            + (f": give 1 to {len(timeline.events)}" if timeline.events else "")
        )
    return timeline.events[number - 1].time_s


def _calendar_s(date: time_parsing.Moment, timeline: Timeline, text: str) -> float:
    start = timeline.start
    if start is None:
        raise InputError(
            f"{quoted(text)} is a date, and the timeline has no calendar; give seconds, "
            "m:ss or an event"
        )
    if start.tzinfo is None and date.offset_min is not None:
        raise InputError(
            f"{quoted(text)} names a time zone, and the timeline's calendar has none; leave it out"
        )
    try:
        moment = _EPOCH + timedelta(microseconds=date.ns // 1000)
        if start.tzinfo is not None:
            zone = UTC if date.offset_min is not None else start.tzinfo
            # subtracted in UTC: within one zone Python ignores its clock changes
            moment, start = moment.replace(tzinfo=zone).astimezone(UTC), start.astimezone(UTC)
    except OverflowError as error:
        raise InputError(f"{quoted(text)} lies outside the calendar") from error
    return (moment - start) / timedelta(seconds=1)


def _limited(text: str, moment: _Moment, timeline: Timeline) -> float:
    within = min(max(moment.time_s, 0.0), timeline.duration_s)
    if not moment.is_limited or within == moment.time_s:
        return moment.time_s
    end = "start" if within == 0.0 else "end"
    warn(
        f"{text} lies beyond the timeline's {end} and stops there ({timeline.moment_text(within)})",
        2,
    )
    return within


def _reach(timeline: Timeline) -> str:
    first, last = timeline.moment_text(0.0), timeline.moment_text(timeline.duration_s)
    return f"it reaches from {first} to {last}"


@dataclass(frozen=True)
class Zoom:
    """Window of a timeline that can be scaled and moved, within the ends.

    InputError unless 0 <= start_s < end_s <= duration_s of the whole timeline.
    """

    timeline: Timeline
    start_s: float
    end_s: float

    def __post_init__(self) -> None:
        self.timeline.require_window(self.start_s, self.end_s)

    @classmethod
    def whole(cls, timeline: Timeline) -> Zoom:
        """Return the window of a whole timeline."""
        return cls(timeline, 0.0, timeline.duration_s)

    @property
    def window(self) -> tuple[float, float]:
        """Window as (start_s, end_s)."""
        return self.start_s, self.end_s

    @property
    def width_s(self) -> float:
        """Length of the window, s."""
        return self.end_s - self.start_s

    def scaled(self, factor: float, moment_s: float, at: float) -> Zoom:
        """Return a window narrower by `factor`, with a moment at position `at`, as `around`."""
        narrowest = min(NARROWEST_S, self.timeline.duration_s)
        return self.around(moment_s, max(self.width_s / factor, narrowest), at)

    def around(self, moment_s: float, width_s: float, at: float = ZOOM_LEAD) -> Zoom:
        """Return a window of `width_s` with a moment at position `at` (0 to 1), if possible."""
        whole = self.timeline.duration_s
        width = min(width_s, whole)
        start = min(max(moment_s - width * at, 0.0), whole - width)
        return replace(self, start_s=start, end_s=min(start + width, whole))

    def next_event_s(self, moment_s: float) -> float | None:
        """Return the time of the first event after a moment, s; None after the last."""
        times = (event.time_s for event in self.timeline.events)
        return min((time_s for time_s in times if time_s > moment_s), default=None)

    def previous_event_s(self, moment_s: float) -> float | None:
        """Return the time of the last event before a moment, s; None before the first."""
        times = (event.time_s for event in self.timeline.events)
        return max((time_s for time_s in times if time_s < moment_s), default=None)

    def showing(self, moment_s: float) -> Zoom:
        """Return this window if it contains a moment, else one of equal width around it."""
        if self.start_s <= moment_s <= self.end_s:
            return self
        return self.around(moment_s, self.width_s)
