"""Text of a position for people who do not see the screen: moment, value or score, event."""

from __future__ import annotations

import itertools
import math
import re
from collections import Counter
from collections.abc import Sequence
from datetime import timedelta

import numpy as np

from overview_dsp.data.analysis.series_events import has_values, value_text
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.data.timeline.event import GOALS, score_of
from overview_dsp.data.timeline.ticks import Half
from overview_dsp.live.session.player import Player
from overview_dsp.public import counted
from overview_dsp.units import HALF_TURN, clock_text

MAX_NAMED, MAX_KINDS = 2, 3
"""Maximum number of passed events that are named, and of kinds if more events are counted."""

NEAR_EXTREME = 0.005
"""Distance from an extreme of the curve at which the finger is on it, as a part of the window."""

MAX_POINTS = 1_000_000
"""Maximum number of points of a curve that are searched for extremes."""

DAYS_FROM_S = 3 * 86_400.0
"""Length of a window from which moments are days, s."""

_TENTHS_BELOW_S = 600.0
_SCORE = re.compile(r"(?<![\d-])(\d+)-(\d+)\b(?!-)\s*")  # not a part of a date


def event_text(event: Event, sides: Sequence[str] = ()) -> str:
    """Return kind, label and team of an event, without the score; an own goal is for its team."""
    kind = event.kind.replace("_", " ")
    text = _SCORE.sub("", event.display_label, count=1) or kind
    if not text.casefold().startswith(kind):
        text = f"{kind}, {text}"
    team = sides[event.side - 1] if event.side and sides else ""
    if team in text:
        return text
    return f"{text}, {'for ' if event.kind == 'own_goal' else ''}{team}"


def running_scores(timeline: Timeline) -> list[tuple[Event, str]]:
    """Return the goals with the score after each, by their sides, or else by their labels."""
    goals = [event for event in timeline.events if event.kind in GOALS]
    if score_of(timeline.events) is None:
        found = ((goal, _SCORE.match(goal.display_label)) for goal in goals)
        return [(goal, f"{score[1]}-{score[2]}") for goal, score in found if score is not None]
    first = itertools.accumulate(goal.side % 2 for goal in goals)
    return [(goal, f"{n}-{i - n}") for i, (goal, n) in enumerate(zip(goals, first, strict=True), 1)]


def match_minute(halves: Sequence[Half], time_s: float) -> tuple[str, str]:
    """Return the minute of a match, counted from 1, and the name of its half; both may be empty."""
    for half in reversed(halves):
        if half.begin_s <= time_s < half.end_s:
            return half.minute_text(int(time_s - half.begin_s) // 60 + 1), half.name
    return "", ""


def finger_position(player: Player) -> float | None:
    """Return the position (0 to 1) of the input or replay that touches the disk; None without.

    A blind comparison's replay has none: events told at other positions would show the preset.
    """
    if player.pointer.touching:
        return player.pointer.position
    held = player.engine.active_input
    # a release by the pointer may not be applied yet
    is_own = player.pointer.used or player.blind is not None
    return None if held is None or (held[0] == "touch" and is_own) else held[1] / HALF_TURN


class PositionReport:
    """Reports on positions, each with the events passed since the last one (control thread)."""

    def __init__(self, player: Player) -> None:
        self._player = player
        self._timeline: Timeline | None = None
        self._last: tuple[float, Event | None] | None = None

    def forget(self) -> None:
        """Forget the last position; nothing is passed before the next one."""
        self._last = None

    def moment(self, time_s: float) -> str:
        """Return a time as a clock or a date, as exact as the window needs."""
        start, window = self._player.timeline.start, self._player.window
        width_s = window[1] - window[0]
        if start is None:
            whole = width_s >= _TENTHS_BELOW_S
            return clock_text(round(time_s))[:-2] if whole else clock_text(time_s)
        day = start + timedelta(seconds=time_s)
        date = f"{day.day} {day:%B %Y}"
        return date if width_s > DAYS_FROM_S else f"{date}, {day:%H:%M}"

    def here(self, position: float) -> tuple[tuple[str, str, str], float, Event | None]:
        """Return moment, start or end, and value of a position (0 to 1), its time, its event."""
        self._prepare()
        time_s = self._player.time_at(position)
        event = self._event_at(position)
        end = "start" if position <= 0.0 else "end" if position >= 1.0 else ""
        # the score counts a goal from the beginning of its surface on
        known_s = time_s if event is None else max(time_s, event.time_s)
        return (self.moment(time_s), end, self._value(time_s, known_s)), time_s, event

    def text(self, position: float, names_event: bool = False) -> str:
        """Return the report on a position: moment and value, event entered, events passed.

        With `names_event`, an event that was entered before is named again.
        """
        place, time_s, event = self.here(position)
        last, self._last = self._last, (time_s, event)
        parts = [", ".join(filter(None, place))]
        if event is not None and (names_event or last is None or not is_same(last[1], event)):
            parts.append(event_text(event, self._player.timeline.sides))
        if last is not None and (passed := self._passed(last, time_s, event)):
            parts.append(f"passed {passed}")
        return " ".join(f"{part[:1].upper()}{part[1:]}." for part in parts)

    def _prepare(self) -> None:
        """Find the scores and extremes of a new timeline."""
        timeline = self._player.timeline
        if timeline is self._timeline:
            return
        self._timeline = timeline
        found = running_scores(timeline)
        self._scores = [(goal.time_s, score.replace("-", " to ")) for goal, score in found]
        if found or score_of(timeline.events):
            self._scores.insert(0, (-math.inf, "0 to 0"))
        curve, self._extremes = timeline.intensity, list[Event]()
        self._has_values = has_values(timeline)
        if curve is None or not self._has_values or not 1 < curve.count <= MAX_POINTS:
            return
        index = np.arange(curve.count)
        times = curve.points.times_of(index)
        values = np.where(timeline.has_data(times), curve.value[index], np.nan)
        for kind, find in (("lowest", np.nanargmin), ("highest", np.nanargmax)):
            if kind not in timeline.kinds() and not np.isnan(values).all():
                self._extremes.append(Event(float(times[find(values)]), kind))

    def _value(self, time_s: float, known_s: float) -> str:
        """Return the score up to `known_s`, the value with its unit, or the gap at a time."""
        timeline, curve = self._player.timeline, self._player.timeline.intensity
        for start_s, end_s in timeline.gaps:
            if start_s < time_s < end_s:
                return f"no data from {self.moment(start_s)} to {self.moment(end_s)}"
        if timeline.known_until_s is not None and time_s > timeline.known_until_s:
            return "no data yet"
        if self._scores:
            return next(one for at, one in reversed(self._scores) if at <= known_s)
        if curve is None or not self._has_values:
            return ""
        at = np.array([time_s])
        if not timeline.has_data(at)[0]:
            return "no data"
        return value_text(float(f"{float(curve.at(at)[0]):.4g}"), curve.unit)

    def _event_at(self, position: float) -> Event | None:
        """Return the event whose surface a position is on, in the timeline's own time."""
        player = self._player
        surface, events = player.engine.surface, player.active_window.window_timeline.events
        for span, index in zip(surface.span, surface.event, strict=True):
            if span[0] <= position <= span[1] and index < len(events):
                event: Event = events[index]
                return event.moved(event.time_s + player.window[0])
        low = player.time_at(max(position - NEAR_EXTREME, 0.0))
        high = player.time_at(min(position + NEAR_EXTREME, 1.0))
        return next((one for one in self._extremes if low <= one.time_s <= high), None)

    def _passed(self, last: tuple[float, Event | None], time_s: float, event: Event | None) -> str:
        """Name or count the events between two positions; empty without any."""
        last_s, last_event = last
        passed = [
            one
            for one in (*self._player.timeline.events, *self._extremes)
            # events at the last position were in its report
            if (last_s < one.time_s <= time_s or time_s <= one.time_s < last_s)
            and not (is_same(one, last_event) or is_same(one, event))
        ]
        if len(passed) <= MAX_NAMED:
            return ", ".join(event_text(one, self._player.timeline.sides) for one in passed)
        kinds = Counter(one.kind.replace("_", " ") for one in passed)
        if len(kinds) > MAX_KINDS:
            return f"{len(passed)} events"
        return ", ".join(counted(count, kind) for kind, count in kinds.items())


def is_same(one: Event | None, other: Event | None) -> bool:
    """Return whether two events are one, whose time was computed from different windows."""
    if one is None or other is None:
        return one is other
    near = math.isclose(one.time_s, other.time_s, rel_tol=1e-9, abs_tol=1e-6)
    return near and (one.kind, one.label) == (other.kind, other.label)
