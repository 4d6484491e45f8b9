"""Features of the onsets in a stroke: the only input of an observer.

Levels are RMS in dB of full scale, one per millisecond: over 10 ms of the tactor for a finger, over
4 ms of the click for an ear. A pulse is detected where the level has a prominence of
`PULSE_PROMINENCE_DB` (`SOUND_PROMINENCE_DB` for the ear) above the floor, at least
`MIN_PULSE_GAP_MS` from a higher pulse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from overview_dsp.arrays import FloatArray, IntArray, SampleArray
from overview_dsp.files.toml import load_toml
from overview_dsp.kernels.layout import CLICK, TACTOR
from overview_dsp.measure import perception
from overview_dsp.units import FELT_WINDOW_S

Modality = Literal["touch", "sound", "both"]
MODALITIES: tuple[Modality, ...] = ("touch", "sound", "both")

SOUND_WINDOW_S = 0.004
SOUND_FLOOR_DB = -62.0  # lowest audible level
SOUND_PROMINENCE_DB = 6.0
RHYTHM_MS = 120  # time in which several pulses are perceived as one pattern
TOGETHER_MS = 40  # distance from a felt pulse within which a click belongs to it

FEATURES: dict[str, dict[str, dict[str, float]]] = load_toml(__file__, "features.toml")
"""Features of touch, of sound and of the movement, and a human's noise in each."""

TOUCH_FEATURES, SOUND_FEATURES = tuple(FEATURES["touch"]), tuple(FEATURES["sound"])
PACE = "pace"
"""Logarithm of the input's pace (timelines per second), for movements that change their pace."""


@dataclass(frozen=True, eq=False)
class StrokeFeatures:
    """Onsets of one stroke, ms from its start, and their features (onsets, features) by name."""

    at_ms: IntArray
    features: FloatArray
    names: tuple[str, ...]


def stroke_features(
    samples: SampleArray,
    sample_rate: float,
    modalities: Sequence[Modality] = MODALITIES,
    pace: FloatArray | None = None,
) -> dict[Modality, StrokeFeatures]:
    """Find the onsets of a stroke and their features, by each modality.

    `samples` (frames, 2) are click and tactor. `pace` (milliseconds,), the logarithm of the pace,
    adds a feature.
    """
    level = perception.levels(
        samples[:, TACTOR], sample_rate, FELT_WINDOW_S, perception.TOUCH_FLOOR_DB
    )
    touched = perception.touch_pulses(level)
    found: dict[Modality, StrokeFeatures] = {}
    click, audible = np.zeros(0), np.zeros(0, np.int64)
    if any(modality != "touch" for modality in modalities):
        click = perception.levels(samples[:, CLICK], sample_rate, SOUND_WINDOW_S, SOUND_FLOOR_DB)
        audible = perception.find_pulses(click, SOUND_PROMINENCE_DB, SOUND_FLOOR_DB + 6.0)
    for modality in modalities:
        at = touched if modality == "touch" else audible
        if modality == "both":
            alone = audible[_nearest(touched, audible) > TOGETHER_MS]
            at = np.sort(np.concatenate([touched, alone]))
        columns: dict[tuple[str, ...], FloatArray] = {}
        if modality != "sound":
            columns[TOUCH_FEATURES] = _touch_columns(level, at, touched)
        if modality != "touch":
            columns[SOUND_FEATURES] = _sound_columns(samples[:, CLICK], sample_rate, click, at)
        if pace is not None:
            columns[(PACE,)] = pace[np.minimum(at, len(pace) - 1)][:, None]
        names = tuple(name for group in columns for name in group)
        found[modality] = StrokeFeatures(at, np.hstack(list(columns.values())), names)
    return found


def _nearest(times: IntArray, at: IntArray) -> IntArray:
    """Return the distance of each of `at` from the nearest of ascending times."""
    far = np.iinfo(np.int64).max // 4
    edges = np.concatenate([[-far], times, [far]])
    after = np.searchsorted(edges, at)
    return np.asarray(np.minimum(at - edges[after - 1], edges[after] - at), dtype=np.int64)


def _around(level: FloatArray, at: IntArray, before: int, after: int) -> FloatArray:
    """Return the level from `before` to `after` ms around each time; its ends are extended."""
    index = at[:, None] + np.arange(-before, after + 1)
    return np.asarray(level[np.clip(index, 0, len(level) - 1)])


def _touch_columns(level: FloatArray, at: IntArray, pulses: IntArray) -> FloatArray:
    """Return the columns of `TOUCH_FEATURES` at each onset."""
    if not len(at):
        return np.zeros((0, len(TOUCH_FEATURES)))
    top = np.clip(at - 10 + _around(level, at, 10, 25).argmax(axis=1), 0, len(level) - 1)
    high = level[top]
    before, after = _around(level, top, 60, 0), _around(level, top, 0, 60)
    surroundings = np.median(_around(level, top, 400, 400), axis=1)
    slope = (before[:, 10:] - before[:, :-10]).max(axis=1)
    longest = 600
    later = _around(level, top, 0, longest) < high[:, None] - 6.0
    later[:, -1] = True
    earlier = _around(level, top, longest, 0)[:, ::-1] < high[:, None] - 6.0
    earlier[:, -1] = True
    duration = later.argmax(axis=1) + earlier.argmax(axis=1)

    first = np.searchsorted(pulses, top + perception.MIN_PULSE_GAP_MS)
    last = np.searchsorted(pulses, top - perception.MIN_PULSE_GAP_MS, side="right") - 1
    count = np.searchsorted(pulses, top + RHYTHM_MS, side="right") - first
    far = 10 * RHYTHM_MS + len(level)
    marks = np.concatenate([[-far], pulses, [far]])
    heights = level[np.clip(marks, 0, len(level) - 1)]
    follows, leads = count > 0, marks[last + 1] >= top - RHYTHM_MS
    columns = (
        high,
        high - surroundings,
        high - before.min(axis=1),
        slope,
        high - after.min(axis=1),
        duration,
        count,
        np.where(follows, marks[first + 1] - top, 0.0),
        np.where(follows, heights[first + 1] - high, -30.0),
        np.where(leads, top - marks[last + 1], 0.0),
        np.where(leads, heights[last + 1] - high, -30.0),
    )
    return np.stack(columns, axis=1).astype(np.float64)


def _sound_columns(
    click: SampleArray, sample_rate: float, level: FloatArray, at: IntArray
) -> FloatArray:
    """Return the columns of `SOUND_FEATURES`: of the loudest sound near each onset."""
    found = np.zeros((len(at), len(SOUND_FEATURES)))
    found[:, 0] = SOUND_FLOOR_DB
    if not len(at):
        return found
    top = np.clip(at - 20 + _around(level, at, 20, 100).argmax(axis=1), 0, len(level) - 1)
    audible = level[top] > SOUND_FLOOR_DB + 3.0
    top = top[audible]
    before, length = int(sample_rate / 500), int(sample_rate / 500 + sample_rate / 33)
    # the falling half of a Hann window
    window = np.hanning(2 * length)[length:]
    start = (top * sample_rate / 1000.0).astype(np.int64) - before
    index = start[:, None] + np.arange(length)
    part = np.where((index >= 0) & (index < len(click)), click[index.clip(0, len(click) - 1)], 0.0)
    power = np.abs(np.fft.rfft(part * window, 2048)) ** 2
    frequency = np.fft.rfftfreq(2048, 1.0 / sample_rate)
    centroid = power @ frequency / (power.sum(axis=1) + 1e-30)
    quiet = _around(level, top, 0, 300) < level[top][:, None] - 15.0
    quiet[:, -1] = True
    columns = (level[top], centroid, quiet.argmax(axis=1), top - at[audible])
    found[audible] = np.stack(columns, axis=1)
    return found
