"""Guard of a feed's times: a line whose time jumps too far waits for a second line.

The allowed jump depends on the feed. A feed that sends clock lines or samples may jump ahead by 10
minutes, by 4 times its `silence_s`, or by 8 times the median interval of its latest lines,
whichever is longest. A feed of events only, and the first line of any feed, may jump ahead by
3 hours, or to 1.5 times the expected duration. A line with a regular run of samples is judged by
its first time.

A line beyond that is held. It is applied when the feed's time reaches it, when `end` is not before
it, or when the next lines confirm it: a line with another time, no further from it than the allowed
jump, before any line that continues the old time. Before two intervals are known, the second line
may be as far from the first as that one was from the feed's time. A retraction or correction by id
removes a held event. Lines that are held at the end are dropped and reported.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from statistics import median
from typing import Any

from overview_dsp.data.feeds.feed_lines import HEADER, apply_parsed, parse_line
from overview_dsp.data.feeds.live_timeline import SILENCE_S, LiveTimeline
from overview_dsp.units import clock_text

SHORTEST_JUMP_S = 600.0  # minimum allowed jump of a feed with clock lines or samples, s
EVENT_JUMP_S = 3 * 3600.0
"""Allowed jump of a feed of events only, and of the first line of a feed, s."""

MAX_HELD = 1_000  # maximum number of held lines; above it the oldest is dropped
INTERVALS = 15  # number of latest intervals whose median is the feed's interval


@dataclass(eq=False)
class HeldLine:
    """A line that waits for a second one.

    `is_contradicted` is True after a line that continued the feed's old time.
    """

    time_s: float
    key: str
    document: Mapping[str, Any]
    is_contradicted: bool = False


class ClockGuard:
    """Applies lines of a feed to a timeline, and holds those whose time jumps too far.

    `held`: lines that wait for a second one, up to 1000.
    `dropped`: latest lines that were never confirmed, up to 1000.
    """

    def __init__(self, live: LiveTimeline) -> None:
        self._live = live
        self.held: list[HeldLine] = []
        self.dropped: deque[HeldLine] = deque(maxlen=MAX_HELD)
        self._reports: list[str] = []
        self._intervals: deque[float] = deque(maxlen=INTERVALS)
        self._has_clock = False
        self._silence_s = SILENCE_S

    def apply(self, line: bytes | str) -> str:
        """Apply or hold a line; return its key as `parse_line` does.

        InputError for an invalid line, which changes nothing.
        """
        key, document = parse_line(line)
        if key in ("", "later"):
            return key
        if key == "end":
            self._end(document)
            return key
        time_s = _checked_s(key, document)
        if time_s is not None and time_s > self._limit_s():
            apply_parsed(LiveTimeline(), key, document)  # raises if the line is invalid
            self._forget(key, document)
            self._hold(HeldLine(float(time_s), key, document))
            return key
        self._apply(key, document)
        self._forget(key, document)
        if key == HEADER and document.get("silence_s") is not None:
            self._silence_s = float(document["silence_s"])
        self._release_reached()
        return key

    def take_reports(self) -> list[str]:
        """Return the reports of held and dropped lines since the last call."""
        reports, self._reports = self._reports, []
        return reports

    def _apply(self, key: str, document: Mapping[str, Any]) -> None:
        before = self._live.now_s
        apply_parsed(self._live, key, document)
        if key not in ("clock", "sample"):
            return
        advance = self._live.now_s - before
        if advance > 0.0:
            if self._has_clock:
                self._intervals.append(advance)
            for one in self.held:
                one.is_contradicted = True
        self._has_clock = True

    def _jump_s(self) -> float:
        """Return the time by which the feed may jump ahead, s."""
        if not self._has_clock:
            return EVENT_JUMP_S
        interval = median(self._intervals) if self._intervals else 0.0
        return max(SHORTEST_JUMP_S, 4.0 * self._silence_s, 8.0 * interval)

    def _limit_s(self) -> float:
        """Return the latest time that a line may have, s."""
        live = self._live
        if live.ended:
            return live.duration_s
        now = live.now_s
        limit = now + self._jump_s()
        if not self._has_clock or now == 0.0:
            limit = max(limit, now + EVENT_JUMP_S, 1.5 * (live.expected_duration_s or 0.0))
        return limit

    def _hold(self, line: HeldLine) -> None:
        is_loose = self._has_clock and len(self._intervals) < 2 and not self._live.ended
        for one in self.held:
            reach = max(self._jump_s(), one.time_s - self._live.now_s if is_loose else 0.0)
            if 0.0 < abs(one.time_s - line.time_s) <= reach and not (
                one.is_contradicted or self._live.ended
            ):
                self.held.remove(one)
                for confirmed in sorted((one, line), key=lambda each: each.time_s):
                    self._apply(confirmed.key, confirmed.document)
                self._release_reached()
                return
        if any(one.key == line.key and one.document == line.document for one in self.held):
            return
        self._reports.append(
            f"line held back: its time {clock_text(line.time_s)} is too far after "
            f"{clock_text(self._live.now_s)}; a second line must confirm it"
        )
        self.held.append(line)
        if len(self.held) > MAX_HELD:
            self._drop(self.held[:1])

    def _release_reached(self) -> None:
        """Apply the held lines that the feed's time has reached."""
        while reached := [one for one in self.held if one.time_s <= self._limit_s()]:
            first = min(reached, key=lambda one: one.time_s)
            self.held.remove(first)
            apply_parsed(self._live, first.key, first.document)

    def _forget(self, key: str, document: Mapping[str, Any]) -> None:
        """Remove the held event that a line corrects or retracts."""
        meant = document.get("id" if key == "event" else "retract")

        def is_meant(one: HeldLine) -> bool:
            if isinstance(meant, dict):
                return _fields(one.document.get("event")) == _fields(meant)
            return meant is not None and str(one.document.get("id")) == str(meant)

        self.held = [one for one in self.held if not is_meant(one)]

    def _end(self, document: Mapping[str, Any]) -> None:
        apply_parsed(self._live, "end", document)
        self._release_reached()
        self._drop(list(self.held))

    def _drop(self, lines: list[HeldLine]) -> None:
        self.held = [one for one in self.held if one not in lines]
        self.dropped.extend(lines)
        for one in lines:
            self._reports.append(
                f"line dropped: no second line confirmed its time {clock_text(one.time_s)}"
            )


def _fields(event: object) -> object:
    """Return time, kind and label of an event's object."""
    if not isinstance(event, dict):
        return None
    return event.get("time_s"), event.get("kind"), event.get("label", "")


def _times(key: str, document: Mapping[str, Any]) -> list[Any]:
    """Return the times in a line, which may be of any type; empty if it has none."""
    value = document[key]
    if key in ("event", "detail"):
        return [value.get("time_s")] if isinstance(value, dict) else []
    if key == "clock":
        return [value]
    if key == "gap":
        return value if isinstance(value, list) else []
    if key == "sample" and isinstance(value, list):
        pairs = value if value and isinstance(value[0], list) else [value]
        return [pair[0] for pair in pairs if isinstance(pair, list) and pair]
    return []


def _checked_s(key: str, document: Mapping[str, Any]) -> float | None:
    """Return the latest time of a line, s; of a regular run of samples, its first time."""
    times = sorted(one for one in _times(key, document) if type(one) in (int, float))
    if key == "sample" and len(times) > 2:
        steps = [later - earlier for earlier, later in pairwise(times)]
        if max(steps) <= 8 * median(steps):
            return float(times[0])
    return max(times, default=None)
