"""Moments of a timeline as a person writes them, and windows between two of them.

| written | means |
|---|---|
| `90`, `90.5`, `90s`, `15min`, `6h`, `3d`, `2w` | so long after the start |
| `1:30`, `1:02:03.5` | m:ss and h:mm:ss after the start |
| `2012-09-19`, `2012-09-19T09:30`, `Sep 19, 2012`, `2012Q3` | that moment, or the beginning of it |
| `goal:1`, `event:3` | the first goal, the third event of any kind |
| `start`, `end` | the timeline's |

The last two take an offset, written like the first two: `goal:1-60`, `goal:1+1:30`, `end-6w`.

Dates need a timeline with a calendar (`Timeline.start`); one without a zone is in the timeline's.
Seconds outside the timeline are an error; a date or an offset that reaches over an end stops there,
with a warning.

`Zoom` is a window and the ones that come next as one zooms about a moment.
"""

from __future__ import annotations

import re
import warnings
from bisect import bisect_left, bisect_right
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta

from overview_dsp.data.timeline import time_parsing
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.data.timeline.time_parsing import length_s
from overview_dsp.errors import InputError, OverviewWarning, shown

HINT = (
    "give seconds (90.5), m:ss, h:mm:ss, 15min, 6h, 3d or 2w after the start, a date "
    "(2012-09-19, 2012-09-19T09:30), kind:number (goal:1, event:3), start or end; the last three "
    "take an offset (goal:1-60, end-6w)"
)
"""What a moment may be, for error lines."""

ZOOM_PART = 10.0
"""A zoom on an event shows a tenth of the whole timeline: nine minutes of a match, in which three
times as many things are felt one by one as in all of it."""

ZOOM_LEAD = 0.75
"""Where in its window an event lies that was zoomed on: what led to it counts more."""

NARROWEST_S = 0.5
"""No window is narrower, s (or the whole, where that is shorter)."""

_EVENT = re.compile(r"(?P<kind>[a-z0-9_]*[a-z_][a-z0-9_]*):(?P<number>\d{1,9})", re.A)
_FROM = re.compile(rf"(?P<from>{_EVENT.pattern}|start|end)(?:(?P<sign>[+-])(?P<offset>.+))?", re.A)
_EPOCH = datetime(1970, 1, 1)


@dataclass(frozen=True)
class _Moment:
    """Seconds from the start, and whether an end of the timeline may stop it."""

    time_s: float
    stops: bool


def parse_time_expression(text: str, timeline: Timeline) -> float:
    """Seconds from the start of the timeline to a written moment, within [0, duration_s].

    Raises
    ------
    InputError
        Not a moment, outside the timeline, an event that isn't there, or a date where the timeline
        has no calendar. Warns (OverviewWarning) of a date or offset stopped at an end.
    """
    moment = _parsed(text, timeline)
    stopped = _stopped(text, moment, timeline)
    if not 0.0 <= stopped <= timeline.duration_s:
        raise InputError(f"{shown(text)} lies outside the timeline; {_reach(timeline)}")
    return stopped


def window_of(timeline: Timeline, start: str, end: str) -> tuple[float, float]:
    """The window (start_s, end_s) between two written moments.

    Raises
    ------
    InputError
        As `parse_time_expression`; or it is empty.
    """
    moments = [_parsed(text, timeline) for text in (start, end)]
    first, last = (
        _stopped(text, moment, timeline) for text, moment in zip((start, end), moments, strict=True)
    )
    if first >= last and any(moment.stops for moment in moments):
        raise InputError(
            f"the window from {shown(start)} to {shown(end)} is empty or outside "
            f"the timeline; {_reach(timeline)}"
        )
    timeline.require_window(first, last)
    return first, last


def zoom_window(timeline: Timeline, text: str) -> tuple[float, float]:
    """The window (start_s, end_s) about an event: `goal:1`, or `goal:1:90` for one of 90 s.

    The event lies three quarters into it, or later where the timeline begins or ends.

    Raises
    ------
    InputError
        Not an event's number with an optional width, or an event that isn't there.
    """
    name, _, width_text = text.strip().partition(":")
    number, _, width_text = width_text.partition(":")
    found = _EVENT.fullmatch(f"{name}:{number}")
    width = length_s(width_text) if width_text else timeline.duration_s / ZOOM_PART
    if found is None or width is None or not width > 0.0:
        raise InputError(
            f"{shown(text)} is nothing to zoom to; give kind:number (goal:1, event:3) and, "
            "if you like, how long a window (goal:1:90, goal:1:5min)"
        )
    return Zoom.whole(timeline).around(_event_s(found, timeline), width).window


def _parsed(text: str, timeline: Timeline) -> _Moment:
    written = text.strip()
    length = length_s(written)
    if length is not None:
        return _Moment(length, False)
    try:  # nan, inf and negative numbers: refused with the window they make
        return _Moment(float(written), False)
    except ValueError:
        pass
    found = _FROM.fullmatch(written)
    if found is not None:
        return _after(found, timeline, text)
    date = time_parsing.moment(written, "iso", "month names", "quarters, months or weeks")
    if date is not None:
        return _Moment(_calendar_s(date, timeline, text), True)
    raise InputError(f"{shown(text)} is no moment; {HINT}")


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
            f"{shown(text)}: {shown(found['offset'])} is no length; give seconds, "
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
            f"{shown(text)} is a date, and the timeline has no calendar; give seconds, "
            "m:ss or an event"
        )
    if start.tzinfo is None and date.offset_min is not None:
        raise InputError(
            f"{shown(text)} names a time zone, and the timeline's calendar has none; leave it out"
        )
    try:
        moment = _EPOCH + timedelta(microseconds=date.ns // 1000)
        if start.tzinfo is not None:
            zone = UTC if date.offset_min is not None else start.tzinfo
            # subtracted in UTC: within one zone Python ignores its clock changes
            moment, start = moment.replace(tzinfo=zone).astimezone(UTC), start.astimezone(UTC)
    except OverflowError as error:
        raise InputError(f"{shown(text)} lies outside the calendar") from error
    return (moment - start) / timedelta(seconds=1)


def _stopped(text: str, moment: _Moment, timeline: Timeline) -> float:
    within = min(max(moment.time_s, 0.0), timeline.duration_s)
    if not moment.stops or within == moment.time_s:
        return moment.time_s
    end = "start" if within == 0.0 else "end"
    warnings.warn(
        f"{text} lies beyond the timeline's {end} and stops there ({timeline.moment_text(within)})",
        OverviewWarning,
        stacklevel=3,
    )
    return within


def _reach(timeline: Timeline) -> str:
    first, last = timeline.moment_text(0.0), timeline.moment_text(timeline.duration_s)
    return f"it reaches from {first} to {last}"


@dataclass(frozen=True)
class Zoom:
    """A window of a timeline, and the ones that can be reached from it; never beyond the ends.

    Parameters
    ----------
    timeline
        The whole.
    start_s, end_s
        The window on it, 0 <= start_s < end_s <= duration_s; InputError otherwise.
    """

    timeline: Timeline
    start_s: float
    end_s: float

    def __post_init__(self) -> None:
        self.timeline.require_window(self.start_s, self.end_s)

    @classmethod
    def whole(cls, timeline: Timeline) -> Zoom:
        """All of a timeline."""
        return cls(timeline, 0.0, timeline.duration_s)

    @property
    def window(self) -> tuple[float, float]:
        """(start_s, end_s)."""
        return self.start_s, self.end_s

    @property
    def width_s(self) -> float:
        """Length of the window, s."""
        return self.end_s - self.start_s

    def scaled(self, factor: float, moment_s: float, at: float) -> Zoom:
        """`factor` times as much detail, with a moment at `at` (0 to 1), as `around`."""
        narrowest = min(NARROWEST_S, self.timeline.duration_s)
        return self.around(moment_s, max(self.width_s / factor, narrowest), at)

    def around(self, moment_s: float, width_s: float, at: float = ZOOM_LEAD) -> Zoom:
        """A window of `width_s` with a moment at `at` (0 to 1) of it, or as near as it can."""
        whole = self.timeline.duration_s
        width = min(width_s, whole)
        start = min(max(moment_s - width * at, 0.0), whole - width)
        return replace(self, start_s=start, end_s=min(start + width, whole))

    def next_event_s(self, moment_s: float) -> float | None:
        """When the first event after a moment is, s; None after the last."""
        times = [event.time_s for event in self.timeline.events]
        index = bisect_right(times, moment_s)
        return times[index] if index < len(times) else None

    def previous_event_s(self, moment_s: float) -> float | None:
        """When the last event before a moment is, s; None before the first."""
        times = [event.time_s for event in self.timeline.events]
        index = bisect_left(times, moment_s)
        return times[index - 1] if index else None

    def showing(self, moment_s: float) -> Zoom:
        """This window if a moment lies in it, else one as wide about the moment."""
        if self.start_s <= moment_s <= self.end_s:
            return self
        return self.around(moment_s, self.width_s)
