"""Angle map: map between time and angle that separates neighbouring events, and its inverse.

Every conversion between a time of a timeline and a position of its surface (0 to 1, half a turn)
goes through one `AngleMap`, which the surface holds. A window of a timeline has a map of its own.

1. The sorted times of the events to separate divide the timeline of T seconds into n intervals.
2. The least width is `least = share * T / n`. Narrower intervals get this width, and all
   others shrink by a common factor, so that their sum remains T. Touches and shots count in
   n and widen their interval by the same amount each, so that they can be distinguished near a
   goal. Other intervals keep at least `MIN_ROOM` of their width without them.
3. Positions are linear in time between these events. Simultaneous events keep their order, `least`
   apart, and their time has the position of the last one. Events at the ends stay there.

Events that fill a timeline (touches, shots, ticks of the calendar) and marks of the user move with
their surroundings but are not separated.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.event import MARK
from overview_dsp.data.timeline.ticks import KINDS as TICKS
from overview_dsp.design.presets.model import Preset

BETWEEN = frozenset(("touch", "shot"))
"""Event kinds that are not separated but widen their interval."""

MIN_ROOM = 0.3  # least width of an interval relative to that without touches and shots
FILL = BETWEEN | {*TICKS, MARK}  # event kinds that are not separated

SHARE = "surface.angle_map"
"""Parameter of the preset: least interval between two events relative to the mean interval."""

BISECTIONS = 60  # bisection steps for the factor of the wide intervals, to float64 precision


@dataclass(frozen=True, eq=False)
class AngleMap:
    """Monotonic map from time to position, piecewise linear.

    `time_s`, float64 (points,): ascending from 0 to the timeline's duration; equal where events lie
        at one time.
    `position`, float64 (points,): position of each point, strictly ascending from 0 to 1.
    `events`, float64 (events,): position of each of the timeline's events.
    """

    time_s: FloatArray
    position: FloatArray
    events: FloatArray

    @classmethod
    def of(cls, timeline: Timeline, preset: Preset) -> AngleMap:
        """Return the map of a timeline and a preset.

        It is linear if all events are separate, and for live timelines, where events must not move.
        """
        ends = np.array([0.0, timeline.duration_s])
        made = cls(ends, np.array([0.0, 1.0]), np.zeros(0))
        share = preset.number(SHARE)
        if share > 0.0 and timeline.known_until_s is None:
            times = [time_s for _, time_s in _separated_events(timeline)]
            points = np.concatenate((ends[:1], times, ends[1:]))
            gaps = np.diff(points)
            least = _least_gaps(timeline, points, share)
            if (gaps < least).any():
                made = cls(points, _spread(gaps, least), made.events)
        return made.on(timeline)

    def on(self, timeline: Timeline) -> AngleMap:
        """Return this map with the events of another timeline of the same duration."""
        events = self.position_of([event.time_s for event in timeline.events])
        before, turn = -1.0, 0
        for i, time_s in () if self.is_linear else _separated_events(timeline):
            turn = turn + 1 if time_s == before else 0
            before = time_s
            point = int(np.searchsorted(self.time_s, time_s)) + turn
            if self.time_s[min(point, len(self.time_s) - 1)] == time_s:
                events[i] = self.position[point]
        return replace(self, events=events)

    @property
    def duration_s(self) -> float:
        """Duration of the timeline, s."""
        return float(self.time_s[-1])

    @property
    def is_linear(self) -> bool:
        """True if positions are proportional to time."""
        return len(self.time_s) == 2

    def position_of(self, time_s: ArrayLike) -> FloatArray:
        """Return positions (0 to 1) of times (s), which are limited to the timeline."""
        times = np.clip(validation.numbers(time_s, "time_s"), 0.0, self.duration_s)
        return times / self.duration_s if self.is_linear else self._between(times, forward=True)

    def time_at(self, position: ArrayLike) -> FloatArray:
        """Return times (s) at positions, which are limited to 0 to 1."""
        positions = np.clip(validation.numbers(position, "position"), 0.0, 1.0)
        return positions * self.duration_s if self.is_linear else self._between(positions)

    def stretched(self) -> list[tuple[float, float]]:
        """Return the intervals of positions that are stretched by 1.5 or more."""
        wide = np.diff(self.position) >= 1.5 * np.diff(self.time_s) / self.duration_s
        ends = zip(self.position[:-1], self.position[1:], strict=True)
        return [(float(a), float(b)) for (a, b), one in zip(ends, wide, strict=True) if one]

    def evened(self, time_s: ArrayLike) -> FloatArray:
        """Return times (s) to which a linear map gives the positions of `time_s`."""
        times = validation.numbers(time_s, "time_s")
        return times if self.is_linear else self.position_of(times) * self.duration_s

    def at_even_positions(self, even: FloatArray) -> FloatArray:
        """Resample values at evenly spaced times to evenly spaced positions."""
        if self.is_linear:
            return even
        points = np.linspace(0.0, 1.0, len(even))
        return np.interp(self.time_at(points) / self.duration_s, points, even)

    def _between(self, at: FloatArray, forward: bool = False) -> FloatArray:
        x, y = (self.time_s, self.position) if forward else (self.position, self.time_s)
        # the last of equal times counts
        lower = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
        width = x[lower + 1] - x[lower]
        part = (at - x[lower]) / np.where(width > 0.0, width, 1.0)
        # the upper point itself, since y0 + (y1 - y0) may round past it
        found = np.where(part < 1.0, y[lower] + part * (y[lower + 1] - y[lower]), y[lower + 1])
        return np.asarray(np.where(np.isnan(at), at, found))


def without_map(preset: Preset) -> Preset:
    """Return the preset with positions proportional to time (`--linear`)."""
    return preset.with_value(SHARE, 0.0)


def _separated_events(timeline: Timeline) -> Iterator[tuple[int, float]]:
    """Yield index and time of the events to separate, by time."""
    for i, event in enumerate(timeline.events):
        if event.kind not in FILL and 0.0 < event.time_s < timeline.duration_s:
            yield i, event.time_s


def _least_gaps(timeline: Timeline, points: FloatArray, share: float) -> FloatArray:
    """Return the least width of each interval between points, s."""
    gaps = len(points) - 1
    times = [event.time_s for event in timeline.events if event.kind in BETWEEN]
    between = np.diff(np.searchsorted(times, points)).astype(np.float64)
    all_places = gaps + float(between.sum())
    room = max(1.0 / all_places, MIN_ROOM / gaps) + between / all_places
    return np.asarray(timeline.duration_s * min(share, 1.0 / float(room.sum())) * room)


def _spread(gaps: FloatArray, least: FloatArray) -> FloatArray:
    """Return the positions of the intervals' ends after widening them to at least `least`."""
    total = float(gaps.sum())
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        factor = (low + high) / 2.0
        if float(np.maximum(factor * gaps, least).sum()) > total:
            high = factor
        else:
            low = factor
    position = np.concatenate(([0.0], np.cumsum(np.maximum(low * gaps, least))))
    return np.asarray(position / position[-1])
