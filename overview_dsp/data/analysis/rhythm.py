"""Heart rate, premature and missed beats, computed from the times of beats.

Codes of beats: PhysioBank's, https://archive.physionet.org/physiobank/annotations.shtml.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from overview_dsp.arrays import BoolArray, FloatArray
from overview_dsp.data.timeline.event import HEART_CODES, Event
from overview_dsp.data.timeline.gaps import Gaps
from overview_dsp.data.timeline.model import Intensity

NORMAL = "beat"
PREMATURE = "premature"
MISSED = "missed_beat"
OTHER_SHAPE = "other_shape"

BEATS: dict[str, tuple[str, str]] = {k: (v[0], v[1]) for k, v in HEART_CODES["beats"].items()}
"""Event kind and label for the code of a beat."""

OTHERS: dict[str, tuple[str, str]] = {k: (v[0], v[1]) for k, v in HEART_CODES["others"].items()}
"""Event kind and label for other codes. Codes in neither table (waves, measurements) are left out
and counted."""

ORDINARY = frozenset({NORMAL, "bundle_branch_block", "paced"})  # kinds of a steady rhythm
AVERAGED_BEATS = 8
"""The heart rate is the mean over 8 intervals around a beat, which is short enough to follow a
sprint. A premature beat and its pause cancel, since they last as long as two ordinary beats."""

VARIABILITY_BEATS = 30

USUAL_BEATS = 8  # the usual interval is the median over this number of beats on either side
PREMATURE_BELOW = 0.87
TURNS_BELOW = 0.95
"""An interval below this fraction of the usual one ends with a premature beat, if the next is not
below the usual one; the second fraction applies where short and long intervals alternate."""

MOST_DRIFT = 0.1
"""Maximum change of the usual interval for a premature beat, as a fraction: above, the rate itself
changes."""

MISSED_ABOVE = 1.6  # an interval above this multiple of the usual one lacks a beat
COMPENSATED = 2.5
"""A premature interval and the following pause last up to two usual intervals. Above this sum, a
beat is missing."""

ORDINARY_EARLY = 0.3
"""Earliness of a premature beat of weight 1, as a fraction of the usual interval."""

MIN_WEIGHT = 0.5

MAX_EVENTS = 16_000  # maximum number of events of one timeline, below that of a surface (16384)


@dataclass(frozen=True, eq=False)
class Beats:
    """Beats in order of time, each with its event kind and label.

    `annotated`: whether the kinds come from annotations; if not, premature beats are detected from
        the intervals.
    `hidden`: whether the interval before a beat has a peak that may be a beat: no beat is missed
        there.
    """

    time_s: FloatArray
    kind: tuple[str, ...]
    label: tuple[str, ...]
    annotated: bool
    hidden: BoolArray | None = None


def heart_rate(time_s: FloatArray, gaps: Gaps) -> Intensity | None:
    """Return the beats per minute at each beat, averaged over `AVERAGED_BEATS` intervals, or None.

    Intervals with a gap do not count.
    """
    times, values = [], []
    for part in _unbroken(time_s, gaps):
        beats = np.arange(len(part))
        low = np.maximum(beats - AVERAGED_BEATS // 2, 0)
        high = np.minimum(beats + AVERAGED_BEATS // 2, len(part) - 1)
        times.append(part)
        values.append(60.0 * (high - low) / (part[high] - part[low]))
    if not times:
        return None
    return Intensity(np.concatenate(times), np.concatenate(values), "bpm")


def variability(time_s: FloatArray, gaps: Gaps) -> Intensity | None:
    """Return the RMSSD at each beat, ms: the root mean square of successive differences.

    It covers `VARIABILITY_BEATS` differences around the beat. None without three beats in a row.
    """
    times, values = [], []
    for part in _unbroken(time_s, gaps):
        if len(part) < 3:
            continue
        squares = np.diff(part, n=2) ** 2
        total = np.concatenate([[0.0], np.cumsum(squares)])
        beats = np.arange(len(part))
        low = np.clip(beats - 1 - VARIABILITY_BEATS // 2, 0, len(squares) - 1)
        high = np.clip(beats - 1 + VARIABILITY_BEATS // 2, low + 1, len(squares))
        mean = np.maximum(total[high] - total[low], 0.0) / (high - low)
        times.append(part)
        values.append(1000.0 * np.sqrt(mean))
    if not times:
        return None
    return Intensity(np.concatenate(times), np.concatenate(values), "ms")


def mean_rate(time_s: FloatArray, gaps: Gaps) -> float | None:
    """Return the beats per minute over all intervals without gaps."""
    parts = _unbroken(time_s, gaps)
    spans = math.fsum(float(part[-1] - part[0]) for part in parts)
    return 60.0 * sum(len(part) - 1 for part in parts) / spans if parts else None


def beat_events(beats: Beats, gaps: Gaps) -> tuple[list[Event], tuple[str, ...]]:
    """Return an event for each beat and for each missed beat, by time, and notes."""
    usual = np.full(len(beats.time_s), np.nan)
    interval = np.full(len(beats.time_s), np.nan)  # the one that ends with the beat
    early_beats = np.zeros(len(beats.time_s), np.bool_)
    for part in _unbroken(beats.time_s, gaps):
        index = int(np.searchsorted(beats.time_s, part[0]))
        interval[index + 1 : index + len(part)] = np.diff(part)
        steps = np.diff(part)
        # in bigeminy every second interval is short: the mean of two in a row is the usual one
        pairs = np.append(steps[:-1] + steps[1:], np.nan) / 2.0
        pairs[-1] = pairs[-2] if len(pairs) > 1 else steps[-1]
        both = np.maximum(_local_median(steps), 0.0), _local_median(pairs)
        early_beats[index + 1 : index + len(part)] = _premature(steps, *both)
        alternates = _alternates(steps)
        usual[index + 1 : index + len(part)] = np.where(alternates, both[1], both[0])
    part_of_usual = interval / usual

    ordinary: list[Event] = []
    others: list[Event] = []
    for i, at in enumerate(beats.time_s.tolist()):
        ratio = float(part_of_usual[i])
        kind, label = beats.kind[i], beats.label[i]
        early = 1.0 - ratio if math.isfinite(ratio) else 0.0
        if not beats.annotated and early_beats[i] and kind == NORMAL:
            kind, label = PREMATURE, "premature"
        if kind in ORDINARY:
            ordinary.append(Event(at, kind, label))
        else:
            if early > 0.0:
                label = f"{label}, {100.0 * early:.0f} % early"
            weight = max(MIN_WEIGHT, early / ORDINARY_EARLY)
            others.append(Event(at, kind, label, weight))
        hidden = beats.hidden is not None and bool(beats.hidden[i])
        if not hidden and _lacks_a_beat(part_of_usual, i):
            expected = float(beats.time_s[i] - interval[i] + usual[i])
            words = f"{interval[i]:.2f} s without a beat, {ratio:.1f} times the usual"
            others.append(Event(expected, MISSED, words, math.log2(ratio)))
    return _limited(ordinary, others)


def _limited(ordinary: list[Event], others: list[Event]) -> tuple[list[Event], tuple[str, ...]]:
    """Return at most `MAX_EVENTS` events, steady beats left out first, and notes on that."""
    notes: tuple[str, ...] = ()
    if len(ordinary) + len(others) > MAX_EVENTS and ordinary:
        notes = (
            f"the {len(ordinary)} steady beats are left out, as a timeline has at most "
            f"{MAX_EVENTS} events: they are in the curve; a shorter recording keeps them",
        )
        ordinary = []
    if len(others) > MAX_EVENTS:
        notes = (*notes, f"of {len(others)} unsteady beats the {MAX_EVENTS} heaviest are events")
        others = sorted(others, key=lambda event: -event.weight)[:MAX_EVENTS]
    return sorted([*ordinary, *others], key=lambda event: event.time_s), notes


def _premature(steps: FloatArray, median: FloatArray, of_pairs: FloatArray) -> BoolArray:
    """Return which intervals end with a premature beat: shorter than usual, and no run of them."""
    below = np.where(_alternates(steps), TURNS_BELOW, PREMATURE_BELOW)
    following = np.append(steps[1:] / median[1:], 1.0)
    padded = np.pad(of_pairs, USUAL_BEATS, mode="edge")
    drift = np.abs(padded[2 * USUAL_BEATS :] / padded[: -2 * USUAL_BEATS] - 1.0)
    short = (steps < below * of_pairs) & ((steps < below * median) | _alternates(steps))
    late = following >= np.where(_alternates(steps), 0.95, 1.0)
    return np.asarray(short & late & (drift <= MOST_DRIFT))


def _alternates(steps: FloatArray) -> BoolArray:
    """Return where short and long intervals alternate, over seven differences."""
    if len(steps) < 7:
        return np.zeros(len(steps), np.bool_)
    change = np.diff(steps)
    turning = (change[1:] * change[:-1] < 0.0) & (
        np.minimum(np.abs(change[1:]), np.abs(change[:-1])) > 0.1 * (steps[1:-1] + steps[2:]) / 2.0
    )
    share = np.convolve(np.pad(turning.astype(float), 1, mode="edge"), np.ones(7) / 7.0, "same")
    ends = np.convolve(np.ones(len(steps)), np.ones(7) / 7.0, "same")
    return np.asarray(share / ends > 0.8)


def _lacks_a_beat(part_of_usual: FloatArray, i: int) -> bool:
    ratio = part_of_usual[i]
    if not ratio > MISSED_ABOVE:  # also NaN
        return False
    before = part_of_usual[i - 1]
    return not before < PREMATURE_BELOW or ratio + before > COMPENSATED


def _local_median(intervals: FloatArray) -> FloatArray:
    padded = np.pad(intervals, USUAL_BEATS, constant_values=np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * USUAL_BEATS + 1)
    return np.asarray(np.nanmedian(windows, axis=1))  # its middle is never NaN


def _unbroken(time_s: FloatArray, gaps: Gaps) -> list[FloatArray]:
    """Return the runs of two or more beats without gaps."""
    if len(time_s) < 2:
        return []
    starts = np.array([start for start, _ in gaps])
    group = np.searchsorted(starts, time_s, side="right")
    parts = np.split(time_s, np.flatnonzero(np.diff(group)) + 1)
    return [part for part in parts if len(part) > 1]
