"""Felt level: what the tactor channel gives a finger, stroke by stroke and event by event.

Level is the RMS over windows of 10 ms, in dB of full scale. A *stroke* is one movement of the disk:
from the touch until shaft 2 disengages, which is when the disk has arrived after the release (out),
or from there until it is back at the start (recoil). An event is felt while the disk is within its
span (where its profile exceeds a tenth of its height): its level is the highest of the windows that
overlap that time. Windows that overlap no event's span are the event-free rest of the stroke; its
level is their median.

What is just noticeable, and the gestures that it is measured by.

Events that are felt apart: how many knocks of its events a stroke gives a finger.

A knock is a peak of the felt level that stands at least `STEP_DB` above its surroundings (its
prominence), at least `MERGED_S` from any higher one. It counts where the disk is on an event then.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.design.gestures import Gesture, sweep, tap
from overview_dsp.errors import InputError, shown
from overview_dsp.signal.surface.model import Surface
from overview_dsp.units import FELT_WINDOW_S

HOP_S = 0.001
"""From one window to the next: a knock of a few milliseconds lies whole in one of them."""

_RUN = 64
"""Frames whose lowest and highest position are looked at together."""

COASTS = 0.001
"""A disk that goes on by less after the release, as a share of the timeline, turned back there."""

BACK_AT = 0.01
"""A recoil ends where the cursor is back to this."""


@dataclass(frozen=True)
class Stroke:
    """One movement of the disk: frames of a trace.

    Attributes
    ----------
    name : str
        `out` or `recoil`.
    start, stop : int
        First frame, and the one behind the last.

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
    """What one stroke feels like.

    Attributes
    ----------
    stroke : Stroke
    event_free_db : float
        Median level of the windows outside every event's span, dB.
    event_db : float64 (events,)
        Highest level at each event of the surface's table, dB; NaN if it wasn't passed.
    rise : float64 (events,)
        Steepest rise of the torque's size at each event, N m/s; NaN if it wasn't passed.
    """

    stroke: Stroke
    event_free_db: float
    event_db: NDArray[np.float64]
    rise: NDArray[np.float64]


def strokes(engaged: NDArray[np.float64], cursor: NDArray[np.float64]) -> list[Stroke]:
    """Find the strokes of a trace: from a touch until the disk turns back, and the recoil.

    It turns back when shaft 2 disengages, or later if it still moves away from the start then.

    Parameters
    ----------
    engaged, cursor : float64 (frames,)
        The trace's columns.

    Returns
    -------
    list of Stroke
        In order.

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
            # the disk may be on its way still, but not behind the furthest place of the touch
            turn = start + int(np.argmax(cursor[start:stop]))
            if cursor[turn] > cursor[start - 1] + COASTS:
                start = min(turn + 1, stop - 1)
            found.append(Stroke("out", before.start, start))
            back = np.flatnonzero(cursor[start:stop] <= BACK_AT)
            end = start + int(back[0]) + 1 if len(back) else stop
            if end - start > 1:
                found.append(Stroke("recoil", start, end))
    return found


def window_db(
    signal: NDArray[np.float32], sample_rate: float, hop_s: float = FELT_WINDOW_S
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Measure the level of windows of 10 ms.

    Windows begin and end between samples where they must, so that rates can be compared.

    Parameters
    ----------
    signal : float32 (frames,)
        One channel.
    sample_rate : float
        Hz.
    hop_s : float
        From one window to the next, s.

    Returns
    -------
    starts : float64 (windows,)
        Where each window starts, frames.
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
    runs: NDArray[np.float64],
    lows: NDArray[np.float64],
    highs: NDArray[np.float64],
    spans: NDArray[np.float64],
) -> NDArray[np.int64]:
    """The first frame within each span (from, to) of a course cut into runs; its length if none."""
    first, last = spans[:, 0], spans[:, 1]
    # in the runs before, it was below the span all the time, or above
    reached = np.searchsorted(np.maximum.accumulate(highs), first)
    run = np.maximum(reached, np.searchsorted(-np.minimum.accumulate(lows), -last))
    run = np.minimum(run, len(runs) - 1)
    there = runs[run]
    within = (there >= first[:, None]) & (there <= last[:, None])
    position = within.argmax(axis=1)
    frame: NDArray[np.int64] = run * _RUN + position
    for i in np.flatnonzero(~within[np.arange(len(run)), position]):
        # it leapt over the span
        later = runs[run[i] :].ravel()
        inside = np.flatnonzero((later >= first[i]) & (later <= last[i]))
        frame[i] = run[i] * _RUN + inside[0] if len(inside) else runs.size
    return frame


def passages(
    surface: Surface, cursor: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """The events that a stroke meets, and the first and the last frame in which it is on each.

    It meets those that it enters (`Surface.edges`), and of those it starts on the ones it passes.
    """
    frames = len(cursor)
    if not frames:
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0, np.int64)
    # the last run is filled up with where it stays
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
    met = first <= last
    return events[met], first[met], last[met]


def _highest(
    starts: NDArray[np.float64],
    level: NDArray[np.float64],
    length: float,
    first: NDArray[np.int64],
    last: NDArray[np.int64],
) -> NDArray[np.float64]:
    """The highest level of the windows that overlap frames `first` to `last`; NaN without any."""
    begin = np.searchsorted(starts + length, first, side="right")
    end = np.searchsorted(starts, last, side="right")
    bounds = np.stack([begin, end], axis=1).ravel()
    highest = np.maximum.reduceat(np.append(level, -np.inf), bounds)[::2]
    return np.where(begin < end, highest, np.nan)


def event_levels(
    surface: Surface,
    columns: Mapping[str, NDArray[np.float64]],
    tactor: NDArray[np.float32],
    sample_rate: float,
) -> NDArray[np.float64]:
    """Measure the highest level at each event of a surface in any stroke.

    Parameters
    ----------
    surface : Surface
        What the disk moved on.
    columns : Trace or mapping
        Its columns `engaged` and `cursor` are used.
    tactor : float32 (frames,)
        The tactor's channel of the same render.
    sample_rate : float
        Hz.

    Returns
    -------
    float64 (events,)
        RMS over 10 ms, dB of full scale; NaN for events that weren't passed.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> surface, tactor = result.engine.surface, result.samples[:, 1]
    >>> ov.measure.event_levels(surface, result.trace, tactor, 8000).shape == surface.event.shape
    True
    """
    validation.instance(surface, Surface, "surface", "ov.build_surface makes one")
    if not isinstance(columns, Mapping) or not {"engaged", "cursor"} <= set(columns):
        raise InputError(f"columns is {shown(columns)}; give a render's trace")
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
    columns: Mapping[str, NDArray[np.float64]],
    tactor: NDArray[np.float32],
    sample_rate: float,
    hop_s: float = HOP_S,
) -> StrokeFeel:
    """Measure one stroke.

    Parameters
    ----------
    columns : the trace (`cursor` and `torque` are used)
    tactor : float32 (frames,), the tactor channel of the same render
    """
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
    count = len(surface.position)
    event_db, rise = np.full(count, np.nan), np.full(count, np.nan)
    events, first, last = passages(surface, cursor)
    event_db[events] = _highest(starts, level, length, first, last)
    for i, start, stop in zip(events, first, last + 1, strict=True):
        inside = (cursor[start:stop] >= surface.span[i, 0]) & (
            cursor[start:stop] <= surface.span[i, 1]
        )
        rise[i] = slope[start:stop][inside].max()
    return StrokeFeel(stroke, float(np.median(free)) if len(free) else np.nan, event_db, rise)


STEP_DB = 2.3
"""A step of amplitude that the skin notices (Israr and Tan 2006: 2.2 to 2.5 dB)."""

STEP_DURATION = 1.25
STEP_SHARPNESS = 2.0
MERGED_S = 0.030
"""Two knocks closer than this are felt as one."""

FALL_DB = 6.0

GESTURES: Mapping[str, Gesture] = {
    "slow": sweep(6.0),
    "medium": sweep(3.0),
    "fast": sweep(1.0),
    "tap": tap(1.0, 3.0),
}
"""Slow, medium and fast sweeps over all of the timeline, and a tap at its end."""


def ratio_steps(first: float, second: float, step: float) -> float:
    """How many times two figures are a ratio of `step` apart; NaN if one isn't above 0."""
    if not (first > 0.0 and second > 0.0):
        return math.nan
    return abs(math.log(first / second)) / math.log(step)


KNOCK_HOP_S = 0.002


def knocks(level: NDArray[np.float64]) -> NDArray[np.int64]:
    """The indices of the knocks in a level (dB, `KNOCK_HOP_S` apart)."""
    from scipy.signal import find_peaks

    found, _ = find_peaks(level, prominence=STEP_DB, distance=round(MERGED_S / KNOCK_HOP_S))
    return np.asarray(found, dtype=np.int64)


def near_peak(level: NDArray[np.float64], peak: int, fall_db: float) -> int:
    """Return how many levels around a peak stay within `fall_db` of it, the peak included."""
    below = np.flatnonzero(level < level[peak] - fall_db)
    after = int(np.searchsorted(below, peak))
    first = below[after - 1] + 1 if after else 0
    return int((below[after] if after < len(below) else len(level)) - first)


def events_felt_apart(
    stroke: Stroke,
    surface: Surface,
    columns: Mapping[str, NDArray[np.float64]],
    tactor: NDArray[np.float32],
    sample_rate: float,
) -> int:
    """Count the events of a surface that are felt one by one in a stroke.

    Parameters
    ----------
    stroke : Stroke
        Which part of the render.
    surface : Surface
        What the disk moved on.
    columns : Trace or mapping
        Its column `cursor` is used.
    tactor : float32 (frames,)
        The tactor's channel of the same render.
    sample_rate : float
        Hz.

    Returns
    -------
    int
        Knocks 30 ms apart or more, while the disk is on an event.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> trace, surface = result.trace, result.engine.surface
    >>> stroke = ov.measure.strokes(trace.engaged, trace.cursor)[0]
    >>> ov.measure.events_felt_apart(stroke, surface, trace, result.samples[:, 1], 8000) > 0
    True
    """
    cursor = columns["cursor"][stroke.start : stroke.stop]
    starts, level = window_db(tactor[stroke.start : stroke.stop], sample_rate, KNOCK_HOP_S)
    peaks = knocks(level)
    middles = (starts[peaks] + FELT_WINDOW_S * sample_rate / 2.0).astype(np.int64)
    return int(np.count_nonzero(surface.in_span(cursor[np.minimum(middles, len(cursor) - 1)])))
