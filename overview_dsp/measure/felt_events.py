"""One row per event and stroke: when the disk reaches an event, how far it lags, what is felt.

An outward stroke ends where the disk turns back, which may be after the release (`felt.strokes`).
An event is *reached* if the disk comes to its position. The *lag* is measured where the disk enters
the event's span: the time since the input disk entered it, and the distance between both. The
*level* is the highest RMS over 10 ms while the disk is on the event; the event is *detected* if a
pulse (`observer.noticed`) belongs to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture
from overview_dsp.kernels.layout import TACTOR
from overview_dsp.measure.felt import Stroke, passages, strokes
from overview_dsp.measure.observer.noticed import TOUCH_WINDOW_S, levels, touch_pulses
from overview_dsp.measure.observer.strokes import AFTER_MS, BEFORE_MS
from overview_dsp.offline.rendering.many import RenderedJob
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.units import HALF_TURN

Floats = NDArray[np.float64]

TRAILING_S = 0.15
"""Output that is analysed after the disk turns back: pulses end and are felt by then."""

FLOOR_DB = -90.0
"""Lowest level of a row."""

_NEAR_MS = 5
_PEAK_MS = 30
"""The tactor's peak of an event comes this long after the disk enters it, or while it is on it."""


@dataclass(frozen=True, eq=False)
class FeltEvents:
    """Events of one stroke; one row per event of the surface, in order of position.

    Attributes
    ----------
    stroke : Stroke
        `out` or `recoil`, with its frames.
    target : float
        Furthest position of the input disk in the stroke.
    turn : float
        Position where the disk turns back.
    event : int64 (events,)
        Index into the timeline's events.
    kind : str (events,)
    time_s : float64 (events,)
        Time on the timeline, s.
    position, start, end : float64 (events,)
        Position and span; infinite at an end of the timeline.
    passed : bool (events,)
        Whether the input disk passes the whole span; in a recoil, whether the disk was beyond it.
    reached : bool (events,)
        Whether the disk reaches the position.
    first_s, last_s : float64 (events,)
        When the disk is on the event for the first and last time, s; NaN if never.
    lag_ms, lag_percent : float64 (events,)
        Lag where the disk enters the span; NaN in a recoil and where it is not reached.
    level_db : float64 (events,)
        Highest level on the event; NaN if the disk is never on it.
    detected : bool (events,)
        Whether a pulse belongs to the event.
    release : float64 (events,)
        Friction that lets go, N m s/rad.
    click_s : float64 (events,)
        When the event is struck, s; NaN if it is not.
    click_lag_ms : float64 (events,)
        Distance between click and peak of the vibration; NaN without either.
    pulse_s : float64 (pulses,)
        When a pulse is felt, s.
    free_db : float
        Median level while the disk is on no event, dB; NaN if it always is on one.
    course, level : float64 (milliseconds,)
        Position of the disk and level (dB) at each millisecond from the start of the stroke.
    """

    stroke: Stroke
    target: float
    turn: float
    event: NDArray[np.int64]
    kind: NDArray[np.str_]
    time_s: Floats
    position: Floats
    start: Floats
    end: Floats
    passed: NDArray[np.bool_]
    reached: NDArray[np.bool_]
    first_s: Floats
    last_s: Floats
    lag_ms: Floats
    lag_percent: Floats
    level_db: Floats
    detected: NDArray[np.bool_]
    release: Floats
    click_s: Floats
    click_lag_ms: Floats
    pulse_s: Floats
    free_db: float
    course: Floats
    level: Floats

    def of(self, *kinds: str) -> NDArray[np.bool_]:
        """Return which rows are passed and of these kinds (none: all)."""
        return self.passed & (np.isin(self.kind, kinds) if kinds else True)


def felt_events(done: RenderedJob[Trace]) -> list[FeltEvents]:
    """Return the table of each stroke of a render, in order."""
    trace, surface, rate = done.trace, done.surface, done.sample_rate
    made = []
    for stroke in strokes(trace.engaged, trace.cursor):
        tail = stroke.stop + (round(TRAILING_S * rate) if stroke.name == "out" else 0)
        cursor = trace.cursor[stroke.start : stroke.stop]
        level = levels(done.samples[stroke.start : tail, TACTOR], rate, TOUCH_WINDOW_S, FLOOR_DB)
        count = len(surface.position)
        frames = np.full((2, count), np.nan)
        rows, *ends = passages(surface, cursor)
        frames[:, rows] = ends
        first_ms, last_ms = frames * (1e3 / rate)
        pulses = touch_pulses(level)
        high, detected = np.full(count, np.nan), np.zeros(count, dtype=bool)
        reached = np.zeros(count, dtype=bool)
        low_turn, high_turn = float(cursor.min()), float(cursor.max())
        for row in rows.tolist():
            at = surface.position[row]
            reached[row] = low_turn <= at <= high_turn
            on = slice(max(int(first_ms[row]) - _NEAR_MS, 0), int(last_ms[row]) + _NEAR_MS + 1)
            if len(level[on]):
                high[row] = level[on].max()
                detected[row] = _belongs(pulses, first_ms[row], last_ms[row])
        start, end = surface.span.T
        if stroke.name == "out":
            target, lag_ms, lag = _lags(done.job.gesture, stroke, rate, start, first_ms)
            passed = (start > -np.inf) & (end <= target)
        else:
            target, lag_ms, lag = 0.0, np.full(count, np.nan), np.full(count, np.nan)
            passed = (start > -np.inf) & (end <= cursor[0])
        lag_ms[~reached], lag[~reached] = np.nan, np.nan
        times, kinds = _events(done.job.timeline, surface.event)
        course = cursor[np.arange(0.0, len(cursor), rate / 1e3).astype(np.int64)]
        free = level[: len(course)][~surface.in_span(course)]
        made.append(
            FeltEvents(
                stroke,
                target,
                high_turn if stroke.name == "out" else low_turn,
                surface.event,
                kinds,
                times,
                surface.position,
                start,
                end,
                passed,
                reached,
                (frames[0] + stroke.start) / rate,
                (frames[1] + stroke.start) / rate,
                lag_ms,
                lag,
                high,
                detected,
                surface.release,
                *_clicks(done, stroke, frames),
                pulses / 1e3 + stroke.start / rate,
                float(np.median(free)) if len(free) else np.nan,
                course,
                level,
            )
        )
    return made


def _belongs(pulses: NDArray[np.int64], first_ms: float, last_ms: float) -> bool:
    return bool(((pulses >= first_ms - BEFORE_MS) & (pulses <= last_ms + AFTER_MS)).any())


def _events(timeline: Timeline, event: NDArray[np.int64]) -> tuple[Floats, NDArray[np.str_]]:
    chosen = [timeline.events[i] for i in event.tolist()]
    return np.array([one.time_s for one in chosen]), np.array([one.kind for one in chosen], str)


def _lags(
    gesture: Gesture, stroke: Stroke, rate: float, start: Floats, first_ms: Floats
) -> tuple[float, Floats, Floats]:
    """Return the furthest position of the input disk, and each event's lag in ms and per cent."""
    within = gesture.touching & (gesture.time_s * rate < stroke.stop)
    within &= gesture.time_s * rate >= stroke.start - 1
    time_ms = 1e3 * (gesture.time_s[within] - stroke.start / rate)
    place = gesture.theta2[within] / HALF_TURN
    furthest = np.maximum.accumulate(place)
    rising = furthest + 1e-12 * np.arange(len(furthest))
    lag_ms = first_ms - np.interp(start, rising, time_ms)
    lag = 100.0 * (np.interp(first_ms, time_ms, place) - start)
    return float(furthest[-1]), np.asarray(lag_ms), np.asarray(lag)


def _clicks(done: RenderedJob[Trace], stroke: Stroke, frames: Floats) -> tuple[Floats, Floats]:
    """Return when each event is struck, s, and how far from the peak of its vibration, ms."""
    rate, envelope = done.sample_rate, done.trace.envelope
    row_of = {event: row for row, event in enumerate(done.surface.event.tolist())}
    struck, lag = np.full((2, frames.shape[1]), np.nan)
    near, peak = round(_NEAR_MS * rate / 1e3), round(_PEAK_MS * rate / 1e3)
    for time_s, event in zip(done.strikes.time_s, done.strikes.event.tolist(), strict=True):
        row = row_of.get(event, -1)
        if row < 0 or not stroke.start <= time_s * rate < stroke.stop:
            continue
        struck[row] = time_s
        if np.isfinite(frames[0, row]):
            first, last = (frames[:, row] + stroke.start).astype(int).tolist()
            begin = max(0, first - near)
            felt = begin + int(np.argmax(envelope[begin : max(last, first + peak) + near]))
            lag[row] = 1e3 * abs(felt / rate - time_s)
    return struck, lag
