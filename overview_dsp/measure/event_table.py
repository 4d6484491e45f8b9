"""Table of felt events with one row per event and stroke.

An outward stroke ends where the disk turns back, which may be after the release
(`perceived_level.strokes`). Each row has

- *reached*: whether the disk comes to the event's position;
- *lag*: where the disk enters the event's span, the time since the input disk entered it, and the
  distance between both;
- *level*: highest RMS over 10 ms while the disk is on the event, dB of full scale;
- *contrast*: level above the median of all windows of 10 ms that overlap no event;
- *sharpness*: steepest rise of the torque, N m/s;
- *duration*: time for which the level stays within 6 dB of its highest, ms (of an event with a
  contrast below 12 dB: in the upper half of the contrast);
- *click*: highest RMS over 10 ms of the click, dB of full scale, and when it is struck;
- *detected*: a pulse (`perception.touch_pulses`) belongs to the event;
- *masked*: its level is less than one JND above the level between the events;
- *merged*: it strikes within 30 ms of another event, so that both are felt as one;
- *lost*: that other event has more friction and hides it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.arrays import BoolArray, FloatArray, IntArray, SampleArray
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError, quoted
from overview_dsp.kernels.layout import CLICK, TACTOR
from overview_dsp.measure import perception
from overview_dsp.measure.perceived_level import GESTURES, Stroke, passages, strokes
from overview_dsp.offline.rendering.many import RenderedJob, RenderJob, render_many
from overview_dsp.offline.rendering.schedule import Tail
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.public import counted, short
from overview_dsp.units import FELT_WINDOW_S, HALF_TURN

FLOOR_DB = -90.0  # lowest level of a row

ARRIVED = 0.005
"""Distance from the end of the stroke, as a share of the timeline, at which a disk has arrived. A
disk held there produces no output, which does not count for the level between the events."""

HALF_WINDOW_MS = 5
"""Half a window: the largest distance of a window's centre from a frame that it overlaps."""

_PEAK_MS = 30
"""Longest time from entering an event to its peak of vibration, unless the disk stays longer."""

_CLICK_MS = 55  # time from a strike in which the level of its click is measured


@dataclass(frozen=True, eq=False)
class FeltEvents:
    """Events of one stroke over one timeline; one row per event of the surface, by position.

    Attributes
    ----------
    name : str
        The gesture's name, followed by `recoil` for the recoil: `fast`, `fast recoil`.
    timeline : Timeline
        Timeline of the surface.
    stroke : Stroke
        `out` or `recoil`, with its frames.
    sample_rate : float
        Sample rate of the frames, Hz.
    target : float
        Furthest position of the input disk in the stroke.
    turn : float
        Position where the disk turns back.
    event : int64 (events,)
        Index into the timeline's events.
    kind : str (events,)
        Event kind.
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
    level_db, sharpness, duration_ms : float64 (events,)
        Highest level on the event, dB; steepest rise of the torque, N m/s; how long the level stays
        near its highest, ms. NaN if the disk is never on it.
    detected : bool (events,)
        Whether a pulse belongs to the event.
    release : float64 (events,)
        Friction released by the event, N m s/rad.
    click_s, click_db : float64 (events,)
        When the event is struck, s, and the highest level of the click, dB; NaN if it is not.
    click_lag_ms : float64 (events,)
        Distance between click and peak of the vibration; NaN without either.
    merged : bool (events,)
        Whether another event is struck within 30 ms.
    lost_to : str (events,)
        The kind of the merged event with more friction, or "".
    pulse_s : float64 (pulses,)
        Time of each felt pulse, s.
    free_db : float
        Median level of the windows that overlap no event, dB; NaN if all overlap one.
    course, level : float64 (milliseconds,)
        Position of the disk and level (dB) at each millisecond from the start of the stroke.
    arrived_s : float
        When the disk has arrived, from the start of the stroke, s.
    slope : float
        Steepest rise of the torque in the median tenth of a second, N m/s.

    See Also
    --------
    felt_events : Measures the events.

    Examples
    --------
    >>> out, recoil = ov.measure.felt_events(football, [match], {"fast": ov.sweep(1.0)})
    >>> out.name, recoil.name, int(out.of("goal").sum())
    ('fast', 'fast recoil', 5)
    """

    name: str
    timeline: Timeline
    stroke: Stroke
    sample_rate: float
    target: float
    turn: float
    event: IntArray
    kind: NDArray[np.str_]
    time_s: FloatArray
    position: FloatArray
    start: FloatArray
    end: FloatArray
    passed: BoolArray
    reached: BoolArray
    first_s: FloatArray
    last_s: FloatArray
    lag_ms: FloatArray
    lag_percent: FloatArray
    level_db: FloatArray
    sharpness: FloatArray
    duration_ms: FloatArray
    detected: BoolArray
    release: FloatArray
    click_s: FloatArray
    click_db: FloatArray
    click_lag_ms: FloatArray
    merged: BoolArray
    lost_to: NDArray[np.str_]
    pulse_s: FloatArray
    free_db: float
    course: FloatArray
    level: FloatArray
    arrived_s: float
    slope: float

    @property
    def contrast_db(self) -> FloatArray:
        """Level above the windows that overlap no event, dB."""
        return self.level_db - self.free_db

    @property
    def masked(self) -> BoolArray:
        """Events whose level is less than one JND above the level between the events."""
        return np.asarray(self.contrast_db < perception.JND_DB)

    def of(self, *kinds: str) -> BoolArray:
        """Return which events are passed, of the given kinds or of all.

        Parameters
        ----------
        *kinds : str
            Names of the kinds; none: all kinds.

        Returns
        -------
        bool (events,)
            True for the rows that match.

        Examples
        --------
        >>> out, _ = ov.measure.felt_events(football, [match], {"fast": ov.sweep(1.0)})
        >>> int(out.of("goal").sum())
        5
        """
        return self.passed & (np.isin(self.kind, kinds) if kinds else True)

    def __repr__(self) -> str:
        return (
            f"<FeltEvents {short(self.name)}: {counted(len(self.event), 'event')} of "
            f"{short(self.timeline.title)}, {int(np.isfinite(self.level_db).sum())} felt>"
        )


def felt_events(
    preset: Preset,
    timelines: Sequence[Timeline],
    gestures: Mapping[str, Gesture] = GESTURES,
    sample_rate: float = 16_000,
    tail: Tail = "rest",
    progress: Callable[[float], None] = lambda part: None,
) -> list[FeltEvents]:
    """Measure every event of timelines in every stroke of gestures.

    Parameters
    ----------
    preset : Preset
        Preset that is measured.
    timelines : sequence of Timeline
        Timelines with events.
    gestures : mapping of str to Gesture
        Gestures by name; default: slow, medium and fast sweeps and a tap.
    sample_rate : float
        Hz. The vibration is the same at any sample rate; clicks need 48 kHz.
    tail : {"rest", "none"} or float
        As in `render`.
    progress : callable
        Called with the completed share, 0 to 1.

    Returns
    -------
    list of FeltEvents
        One table per stroke, by gesture, then by timeline.

    Raises
    ------
    InputError
        No timelines, or an error of `render`.

    Examples
    --------
    >>> tables = ov.measure.felt_events(football, [match], {"fast": ov.sweep(1.0)})
    >>> [table.name for table in tables]
    ['fast', 'fast recoil']
    """
    if not isinstance(gestures, Mapping):
        raise InputError(
            f"gestures is {quoted(gestures)}; give them by name: {{'fast': ov.sweep(1.0)}}"
        )
    validation.instances(gestures.values(), Gesture, "gestures", "ov.sweep makes one")
    timelines = validation.instances(timelines, Timeline, "timelines", "ov.load_timeline gives one")
    if not timelines:
        raise InputError("no timelines; give one or more")
    validation.instance(preset, Preset, "preset", "ov.load_preset gives one")
    names = [name for name in gestures for _ in timelines]
    jobs = [RenderJob(each, preset, gesture) for gesture in gestures.values() for each in timelines]
    sample_rate = validation.positive(sample_rate, "sample_rate")
    results = render_many(jobs, sample_rate, tail=tail, trace=True)
    tables: list[FeltEvents] = []
    for done, (name, result) in enumerate(zip(names, results, strict=True), 1):
        tables += stroke_events(result, name)
        progress(done / len(jobs))
    return tables


def stroke_events(done: RenderedJob[Trace], name: str = "") -> Iterator[FeltEvents]:
    """Measure each stroke of a render, in order."""
    for stroke in strokes(done.trace.engaged, done.trace.cursor):
        yield _measured(done, stroke, name if stroke.name == "out" else f"{name} {stroke.name}")


def _measured(done: RenderedJob[Trace], stroke: Stroke, name: str) -> FeltEvents:
    surface, rate, timeline = done.surface, done.sample_rate, done.job.timeline
    outward, per_ms = stroke.name == "out", rate / 1e3
    cursor = done.trace.cursor[stroke.start : stroke.stop]
    torque = np.abs(done.trace.torque[stroke.start : stroke.stop])
    slope = np.diff(torque, prepend=torque[:1]) * rate
    trailing = round(perception.TRAILING_S * rate) if outward else 0
    samples = done.samples[stroke.start : stroke.stop + trailing]
    level = perception.levels(samples[:, TACTOR], rate, FELT_WINDOW_S, FLOOR_DB)
    course = cursor[np.arange(0.0, len(cursor), per_ms).astype(np.int64)]
    away = np.flatnonzero(np.abs(cursor - cursor[-1]) > ARRIVED)
    arrived = min(int(away[-1]) + 2 if len(away) else len(cursor), len(cursor))
    # a window overlaps an event if the disk is on one in any of its frames
    on_event = np.cumsum(np.append(0, surface.in_span(cursor)))
    windows = slice(HALF_WINDOW_MS, max(HALF_WINDOW_MS, int(arrived / per_ms) - HALF_WINDOW_MS))
    middle = np.arange(len(course))[windows]
    first_frame, last_frame = (
        ((middle + side) * per_ms).astype(int) for side in (-HALF_WINDOW_MS, HALF_WINDOW_MS)
    )
    free = level[windows][on_event[last_frame] == on_event[first_frame]]
    free_db = float(np.median(free)) if len(free) else np.nan

    pulses = perception.touch_pulses(level)
    rows, first, last = passages(surface, cursor)
    count = len(surface.position)
    frames, (high, sharpness, duration) = np.full((2, count), np.nan), np.full((3, count), np.nan)
    frames[:, rows] = first, last
    detected, reached = np.zeros((2, count), dtype=bool)
    low, furthest = cursor.min(), cursor.max()
    reached[rows] = (low <= surface.position[rows]) & (surface.position[rows] <= furthest)
    for row, begin, end in zip(rows.tolist(), first.tolist(), last.tolist(), strict=True):
        inside = surface.span[row, 0] <= cursor[begin : end + 1]
        inside &= cursor[begin : end + 1] <= surface.span[row, 1]
        sharpness[row] = slope[begin : end + 1][inside].max()
        begin_ms, end_ms = begin / per_ms, end / per_ms
        near = max(int(begin_ms) - HALF_WINDOW_MS, 0)
        if near < len(level):
            high[row] = level[near : int(end_ms) + HALF_WINDOW_MS + 1].max()
            first_ms, last_ms = begin_ms - perception.BEFORE_MS, end_ms + perception.AFTER_MS
            detected[row] = ((pulses >= first_ms) & (pulses <= last_ms)).any()
        duration[row] = _duration_ms(level[windows], course[windows], surface.span[row], free_db)

    start, end_of_span = surface.span.T
    target, lag_ms, lag = 0.0, *np.full((2, count), np.nan)
    if outward:
        target, lag_ms, lag = _lags(done.job.gesture, stroke, rate, start, frames[0] / per_ms)
        lag_ms[~reached], lag[~reached] = np.nan, np.nan
    moving = np.abs(slope[1:arrived]) if arrived > 1 else np.zeros(1)
    tenths = np.arange(0, max(1, len(moving) - 1), max(1, round(0.1 * rate)))
    events = [timeline.events[i] for i in surface.event.tolist()]
    kinds = np.array([event.kind for event in events], dtype=str)
    first_s, last_s = (frames + stroke.start) / rate
    return FeltEvents(
        name=name,
        timeline=timeline,
        stroke=stroke,
        sample_rate=rate,
        target=target,
        turn=float(furthest if outward else low),
        event=surface.event,
        kind=kinds,
        time_s=np.array([event.time_s for event in events]),
        position=surface.position,
        start=start,
        end=end_of_span,
        passed=(start > -np.inf) & (end_of_span <= (target if outward else cursor[0])),
        reached=reached,
        first_s=first_s,
        last_s=last_s,
        lag_ms=lag_ms,
        lag_percent=lag,
        level_db=high,
        sharpness=sharpness,
        duration_ms=duration,
        detected=detected,
        release=surface.release,
        **_clicks(done, stroke, frames, samples[:, CLICK], kinds),
        pulse_s=pulses / 1e3 + stroke.start / rate,
        free_db=free_db,
        course=course,
        level=level,
        arrived_s=arrived / rate,
        slope=float(np.median(np.maximum.reduceat(moving, tenths))),
    )


def _duration_ms(level: FloatArray, course: FloatArray, span: FloatArray, free_db: float) -> float:
    """Return how long the level stays near its highest in a span, ms; NaN if the disk skips it."""
    inside = np.flatnonzero((course >= span[0]) & (course <= span[1]))
    if not len(inside):
        return np.nan
    peak = int(inside[np.argmax(level[inside])])
    contrast = level[peak] - free_db
    fall_db = min(perception.FALL_DB, 0.5 * contrast) if contrast > 0.0 else perception.FALL_DB
    return perception.near_peak(level, peak, fall_db)


def _lags(
    gesture: Gesture, stroke: Stroke, rate: float, start: FloatArray, first_ms: FloatArray
) -> tuple[float, FloatArray, FloatArray]:
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


def _clicks(
    done: RenderedJob[Trace],
    stroke: Stroke,
    frames: FloatArray,
    click: SampleArray,
    kinds: NDArray[np.str_],
) -> dict[str, Any]:
    """Return the fields of `FeltEvents` about the click of each event."""
    rate, envelope, release = done.sample_rate, done.trace.envelope, done.surface.release
    level = perception.levels(click, rate, FELT_WINDOW_S, FLOOR_DB)
    row_of = {event: row for row, event in enumerate(done.surface.event.tolist())}
    struck, loud, lag = np.full((3, len(kinds)), np.nan)
    merged, lost_to = np.zeros(len(kinds), dtype=bool), np.full_like(kinds, "")
    near, peak = round(HALF_WINDOW_MS * rate / 1e3), round(_PEAK_MS * rate / 1e3)
    times = done.strikes.time_s
    in_stroke = (times * rate >= stroke.start) & (times * rate < stroke.stop)
    rows = np.array([row_of.get(event, -1) for event in done.strikes.event.tolist()], dtype=int)
    in_stroke &= rows >= 0
    times, rows = times[in_stroke], rows[in_stroke]
    for time_s, row in zip(times.tolist(), rows.tolist(), strict=True):
        struck[row] = time_s
        at_ms = int(1e3 * (time_s - stroke.start / rate))
        loud[row] = level[at_ms : at_ms + _CLICK_MS + 1].max(initial=FLOOR_DB)
        if np.isfinite(frames[0, row]):
            first, last = (frames[:, row] + stroke.start).astype(int).tolist()
            begin = max(0, first - near)
            felt = begin + int(np.argmax(envelope[begin : max(last, first + peak) + near]))
            lag[row] = 1e3 * abs(felt / rate - time_s)
        beside = rows[np.abs(times - time_s) < perception.MERGED_S]
        merged[row] |= (beside != row).any()
        strongest = beside[np.argmax(release[beside])]
        if release[strongest] > release[row]:
            lost_to[row] = kinds[strongest]
    clicks = {"click_s": struck, "click_db": loud, "click_lag_ms": lag}
    return {**clicks, "merged": merged, "lost_to": lost_to}
