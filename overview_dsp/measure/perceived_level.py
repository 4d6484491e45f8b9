"""Level of the tactor channel as it is felt, by stroke and by event.

Level is the RMS over windows of 10 ms, in dB of full scale. A *stroke* is one movement of the disk.
The outward stroke lasts from the touch until shaft 2 disengages, which is when the disk has arrived
after the release. The recoil lasts from there until the disk is back at the start.

An event is felt while the disk is within its span (where its profile exceeds a tenth of its
height). Its level is the highest of the windows that overlap that time. The event-free level of a
stroke is the median of the windows that overlap no event's span.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray, IntArray, SampleArray
from overview_dsp.design.gestures import Gesture, sweep, tap
from overview_dsp.errors import InputError, quoted
from overview_dsp.measure.perception import PULSE_HOP_S, pulse_indices
from overview_dsp.signal.surface.model import Surface
from overview_dsp.units import FELT_WINDOW_S

HOP_S = 0.001
"""Time from one window to the next, s: short enough that one window holds a whole short pulse."""

_RUN = 64  # frames per run; the lowest and highest position of a run are found at once

MIN_COAST = 0.001
"""Smallest movement after a release that extends the outward stroke, as a share of the timeline."""

RECOIL_END = 0.01  # cursor at which a recoil ends


@dataclass(frozen=True)
class Stroke:
    """Frames of one movement of the disk in a trace.

    Attributes
    ----------
    name : str
        `out` or `recoil`.
    start, stop : int
        First frame, and the frame after the last.

    Examples
    --------
    >>> ov.measure.Stroke("out", 0, 8000)
    Stroke(name='out', start=0, stop=8000)
    """

    name: str
    start: int
    stop: int


@dataclass(frozen=True, eq=False)
class StrokeFeel:
    """Levels felt in one stroke.

    `event_free_db`: median level of the windows outside every event's span, dB.
    `event_db`: highest level at each event of the surface, dB; NaN if it was not passed.
    `rise`: steepest rise of the torque at each event, N m/s; NaN if it was not passed.
    """

    stroke: Stroke
    event_free_db: float
    event_db: FloatArray
    rise: FloatArray


def strokes(engaged: FloatArray, cursor: FloatArray) -> list[Stroke]:
    """Find the strokes of a trace: outward movements and recoils.

    An outward stroke lasts from the touch until the disk turns back. The disk turns back when shaft
    2 disengages, or later if it still moves away from the start.

    Parameters
    ----------
    engaged, cursor : float64 (frames,)
        Columns of the trace.

    Returns
    -------
    list of Stroke
        Strokes in order of time.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> [stroke.name for stroke in ov.measure.strokes(result.trace.engaged, result.trace.cursor)]
    ['out', 'recoil']
    """
    engaged = validation.floats(engaged, "engaged")
    cursor = validation.floats(cursor, "cursor")
    validation.equally_long("engaged and cursor", engaged, cursor)
    if not len(engaged):
        return []
    held = engaged > 0.5
    edges = np.flatnonzero(np.diff(held)) + 1
    bounds = [0, *edges.tolist(), len(held)]
    found: list[Stroke] = []
    for start, stop in itertools.pairwise(bounds):
        if held[start]:
            found.append(Stroke("out", start, stop))
        elif start > 0:
            before = found.pop()
            # the disk may still move on, to a position beyond the furthest one of the touch
            turn = start + int(np.argmax(cursor[start:stop]))
            if cursor[turn] > cursor[start - 1] + MIN_COAST:
                start = min(turn + 1, stop - 1)
            found.append(Stroke("out", before.start, start))
            back = np.flatnonzero(cursor[start:stop] <= RECOIL_END)
            end = start + int(back[0]) + 1 if len(back) else stop
            if end - start > 1:
                found.append(Stroke("recoil", start, end))
    return found


def window_db(
    signal: SampleArray, sample_rate: float, hop_s: float = FELT_WINDOW_S
) -> tuple[FloatArray, FloatArray]:
    """Measure the level of windows of 10 ms.

    Windows may begin and end between samples, so that sample rates can be compared.

    Parameters
    ----------
    signal : float32 (frames,)
        One channel.
    sample_rate : float
        Hz.
    hop_s : float
        Time from one window to the next, s.

    Returns
    -------
    starts : float64 (windows,)
        Start of each window, in frames.
    level : float64 (windows,)
        RMS, dB of full scale; -200 for silence.

    Examples
    --------
    >>> starts, level = ov.measure.window_db(np.ones(800, dtype=np.float32), 8000)
    >>> starts[:2], float(level[0])
    (array([ 0., 80.]), 0.0)
    """
    samples = validation.floats(signal, "signal")
    sample_rate = validation.positive(sample_rate, "sample_rate")
    length, hop = FELT_WINDOW_S * sample_rate, validation.positive(hop_s, "hop_s") * sample_rate
    starts = np.arange(0.0, max(0.0, len(samples) - length) + 0.5, hop)
    energy = np.zeros(len(samples) + 1)
    np.cumsum(np.square(samples), out=energy[1:])
    frames = np.arange(len(energy), dtype=np.float64)
    mean = (np.interp(starts + length, frames, energy) - np.interp(starts, frames, energy)) / length
    return starts, 10.0 * np.log10(np.maximum(mean, 1e-20))


def _first_within(
    runs: FloatArray, lows: FloatArray, highs: FloatArray, spans: FloatArray
) -> IntArray:
    """Return the first frame within each span; the number of frames if no frame is."""
    first, last = spans[:, 0], spans[:, 1]
    # all earlier runs are below the span, or above it
    reached = np.searchsorted(np.maximum.accumulate(highs), first)
    run = np.maximum(reached, np.searchsorted(-np.minimum.accumulate(lows), -last))
    run = np.minimum(run, len(runs) - 1)
    there = runs[run]
    within = (there >= first[:, None]) & (there <= last[:, None])
    position = within.argmax(axis=1)
    frame: IntArray = run * _RUN + position
    for i in np.flatnonzero(~within[np.arange(len(run)), position]):
        # the run skips the span
        later = runs[run[i] :].ravel()
        inside = np.flatnonzero((later >= first[i]) & (later <= last[i]))
        frame[i] = run[i] * _RUN + inside[0] if len(inside) else runs.size
    return frame


def passages(surface: Surface, cursor: FloatArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return the events that a stroke passes, and the first and last frame on each.

    A stroke passes the events that it enters (`Surface.edges`). It also passes events in whose span
    it starts, if it crosses their position.
    """
    frames = len(cursor)
    if not frames:
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.int64)
    # the last run is padded with the last position
    course = np.append(cursor, np.full(-frames % _RUN, cursor[-1]))
    starts = np.arange(0, len(course), _RUN)
    lows, highs = np.minimum.reduceat(course, starts), np.maximum.reduceat(course, starts)
    lower, upper = surface.edges.T
    upwards = (cursor[0] < lower) & (lower <= highs.max())
    downwards = (lows.min() < upper) & (upper <= cursor[0])
    passed = (lows.min() < surface.position) & (surface.position <= highs.max())
    events = np.flatnonzero(upwards | downwards | passed)
    spans, runs = surface.span[events], course.reshape(-1, _RUN)
    first = _first_within(runs, lows, highs, spans)
    backwards = _first_within(runs[::-1, ::-1], lows[::-1], highs[::-1], spans)
    last = np.minimum(len(course) - 1 - backwards, frames - 1)
    is_on = first <= last
    return events[is_on], first[is_on], last[is_on]


def _highest(
    starts: FloatArray, level: FloatArray, length: float, first: IntArray, last: IntArray
) -> FloatArray:
    """Return the highest level of the windows that overlap frames `first` to `last`, or NaN."""
    begin = np.searchsorted(starts + length, first, side="right")
    end = np.searchsorted(starts, last, side="right")
    bounds = np.stack([begin, end], axis=1).ravel()
    highest = np.maximum.reduceat(np.append(level, -np.inf), bounds)[::2]
    return np.where(begin < end, highest, np.nan)


def event_levels(
    surface: Surface, columns: Mapping[str, FloatArray], tactor: SampleArray, sample_rate: float
) -> FloatArray:
    """Measure the highest level at each event of a surface, over all strokes.

    Parameters
    ----------
    surface : Surface
        Surface of the render.
    columns : Trace or mapping
        Its columns `engaged` and `cursor` are used.
    tactor : float32 (frames,)
        Tactor channel of the same render.
    sample_rate : float
        Hz.

    Returns
    -------
    float64 (events,)
        RMS over 10 ms, dB of full scale; NaN for events that were not passed.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> surface, tactor = result.engine.surface, result.samples[:, 1]
    >>> ov.measure.event_levels(surface, result.trace, tactor, 8000).shape == surface.event.shape
    True
    """
    validation.instance(surface, Surface, "surface", "ov.build_surface makes one")
    if not isinstance(columns, Mapping) or not {"engaged", "cursor"} <= set(columns):
        raise InputError(f"columns is {quoted(columns)}; give a render's trace")
    validation.equally_long(
        "the trace's engaged and tactor", columns["engaged"], validation.floats(tactor, "tactor")
    )
    found = np.full(len(surface.position), np.nan)
    for stroke in strokes(columns["engaged"], columns["cursor"]):
        frames = slice(stroke.start, stroke.stop)
        starts, level = window_db(tactor[frames], sample_rate, HOP_S)
        events, first, last = passages(surface, columns["cursor"][frames])
        highest = _highest(starts, level, FELT_WINDOW_S * sample_rate, first, last)
        found[events] = np.fmax(found[events], highest)
    return found


def stroke_feel(
    stroke: Stroke,
    surface: Surface,
    columns: Mapping[str, FloatArray],
    tactor: SampleArray,
    sample_rate: float,
    hop_s: float = HOP_S,
) -> StrokeFeel:
    """Measure one stroke by the trace (`cursor`, `torque`) and the tactor channel of a render."""
    cursor = columns["cursor"][stroke.start : stroke.stop]
    torque = np.abs(columns["torque"][stroke.start : stroke.stop])
    starts, level = window_db(tactor[stroke.start : stroke.stop], sample_rate, hop_s)
    length = FELT_WINDOW_S * sample_rate
    within = np.concatenate([[0], np.cumsum(surface.in_span(cursor))])
    first_frame = np.floor(starts).astype(np.int64)
    last_frame = np.minimum(np.ceil(starts + length).astype(np.int64), len(cursor))
    occupied = within[last_frame] - within[first_frame] > 0
    free = level[~occupied]
    slope = np.diff(torque, prepend=torque[:1]) * sample_rate
    event_db, rise = np.full((2, len(surface.position)), np.nan)
    events, first, last = passages(surface, cursor)
    event_db[events] = _highest(starts, level, length, first, last)
    for i, start, stop in zip(events, first, last + 1, strict=True):
        low, high = surface.span[i]
        inside = (cursor[start:stop] >= low) & (cursor[start:stop] <= high)
        rise[i] = slope[start:stop][inside].max()
    return StrokeFeel(stroke, float(np.median(free)) if len(free) else np.nan, event_db, rise)


GESTURES: Mapping[str, Gesture] = {
    "slow": sweep(6.0),
    "medium": sweep(3.0),
    "fast": sweep(1.0),
    "tap": tap(1.0, 3.0),
}
"""Slow, medium and fast sweeps over the whole timeline, and a tap at its end."""


def count_resolved_events(
    stroke: Stroke,
    surface: Surface,
    columns: Mapping[str, FloatArray],
    tactor: SampleArray,
    sample_rate: float,
) -> int:
    """Count the events of a surface that are felt separately in a stroke.

    Parameters
    ----------
    stroke : Stroke
        Frames of the render.
    surface : Surface
        Surface of the render.
    columns : Trace or mapping
        Its column `cursor` is used.
    tactor : float32 (frames,)
        Tactor channel of the same render.
    sample_rate : float
        Hz.

    Returns
    -------
    int
        Number of pulses at least 30 ms from each other, while the disk is on an event.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> trace, surface = result.trace, result.engine.surface
    >>> stroke = ov.measure.strokes(trace.engaged, trace.cursor)[0]
    >>> ov.measure.count_resolved_events(stroke, surface, trace, result.samples[:, 1], 8000) > 0
    True
    """
    cursor = columns["cursor"][stroke.start : stroke.stop]
    starts, level = window_db(tactor[stroke.start : stroke.stop], sample_rate, PULSE_HOP_S)
    peaks = pulse_indices(level)
    middles = (starts[peaks] + FELT_WINDOW_S * sample_rate / 2.0).astype(np.int64)
    return int(np.count_nonzero(surface.in_span(cursor[np.minimum(middles, len(cursor) - 1)])))
