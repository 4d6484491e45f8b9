"""What is noticed in a stroke, and how it feels and sounds: the only thing an observer gets.

Levels are RMS in dB of full scale, every millisecond: over 10 ms of the tactor for a finger, over 4
ms of the click for an ear. A pulse is noticed where the level rises `STEP_DB` out of what surrounds
it (`SOUND_STEP_DB` for the ear), `APART_MS` or more from a higher pulse, above the floor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from overview_dsp.kernels.layout import CLICK, TACTOR

Modality = Literal["touch", "sound", "both"]
MODALITIES: tuple[Modality, ...] = ("touch", "sound", "both")

TOUCH_WINDOW_S, SOUND_WINDOW_S = 0.010, 0.004
TOUCH_FLOOR_DB, SOUND_FLOOR_DB = -50.0, -62.0
"""Nothing is felt, or heard, below."""

STEP_DB = 2.5
"""A step of amplitude on the skin (Israr and Tan 2006: 2.2 to 2.5 dB)."""

SOUND_STEP_DB = 6.0
APART_MS = 30
"""Pulses nearer than this are one."""

RHYTHM_MS = 120
"""Within which pulses make a figure."""

TOGETHER_MS = 40
"""What is heard so near to what is felt belongs to it."""

TOUCH_FEATURES = (
    "level_db",
    "over_surroundings_db",
    "rise_db",
    "slope_db",
    "fall_db",
    "duration_ms",
    "pulses_after",
    "next_ms",
    "next_db",
    "last_ms",
    "last_db",
)
SOUND_FEATURES = ("click_db", "centroid_hz", "click_decay_ms", "click_delay_ms")
PACE = "pace"
"""How fast the hand moves there, log of timelines a second; of movements that change their pace."""


@dataclass(frozen=True, eq=False)
class Noticed:
    """What is noticed in one stroke.

    Attributes
    ----------
    at_ms : int64 (onsets,)
        From the stroke's start.
    features : float64 (onsets, features)
        Columns as `names`.
    names : tuple of str
    """

    at_ms: NDArray[np.int64]
    features: NDArray[np.float64]
    names: tuple[str, ...]


def levels(
    signal: NDArray[np.float32], sample_rate: float, window_s: float, floor_db: float
) -> NDArray[np.float64]:
    """RMS over a window around each millisecond, dB of full scale, not below a floor."""
    energy = np.zeros(len(signal) + 1)
    np.cumsum(np.square(signal, dtype=np.float64), out=energy[1:])
    middle = np.arange(0.0, len(signal), sample_rate / 1000.0).astype(np.int64)
    half = int(window_s * sample_rate / 2.0)
    first, end = np.maximum(middle - half, 0), np.minimum(middle + half, len(signal))
    mean = (energy[end] - energy[first]) / (end - first)
    return np.asarray(np.maximum(10.0 * np.log10(mean + 1e-12), floor_db), dtype=np.float64)


def notice(
    samples: NDArray[np.float32],
    sample_rate: float,
    modalities: Sequence[Modality] = MODALITIES,
    pace: NDArray[np.float64] | None = None,
) -> dict[Modality, Noticed]:
    """Find what is noticed in a stroke, by each modality.

    Parameters
    ----------
    samples : float32 (frames, 2)
        Click and tactor of the stroke.
    sample_rate : float
        Hz.
    modalities
        Which.
    pace : float64 (milliseconds,), or None
        Log of the hand's pace, for a feature more.
    """
    level = levels(samples[:, TACTOR], sample_rate, TOUCH_WINDOW_S, TOUCH_FLOOR_DB)
    touched = touch_pulses(level)
    found: dict[Modality, Noticed] = {}
    click, heard = np.zeros(0), np.zeros(0, np.int64)
    if any(modality != "touch" for modality in modalities):
        click = levels(samples[:, CLICK], sample_rate, SOUND_WINDOW_S, SOUND_FLOOR_DB)
        heard = _pulses(click, SOUND_STEP_DB, SOUND_FLOOR_DB + 6.0)
    for modality in modalities:
        at = touched if modality == "touch" else heard
        if modality == "both":
            alone = heard[_nearest(touched, heard) > TOGETHER_MS]
            at = np.sort(np.concatenate([touched, alone]))
        columns: list[NDArray[np.float64]] = []
        names: list[str] = []
        if modality != "sound":
            columns.append(_felt(level, at, touched))
            names += TOUCH_FEATURES
        if modality != "touch":
            columns.append(_heard(samples[:, CLICK], sample_rate, click, at))
            names += SOUND_FEATURES
        if pace is not None:
            columns.append(pace[np.minimum(at, len(pace) - 1)][:, None])
            names.append(PACE)
        found[modality] = Noticed(at, np.hstack(columns), tuple(names))
    return found


def touch_pulses(level: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the milliseconds of the pulses that a finger notices in a level."""
    return _pulses(np.maximum(level, TOUCH_FLOOR_DB), STEP_DB, TOUCH_FLOOR_DB + 3.0)


def _pulses(level: NDArray[np.float64], step_db: float, least_db: float) -> NDArray[np.int64]:
    from scipy.signal import find_peaks

    rises, _ = find_peaks(level, prominence=step_db, height=least_db)
    # only what is a pulse itself hides one beside it
    alone = np.full(len(level), -np.inf)
    alone[rises] = level[rises]
    found, _ = find_peaks(alone, distance=APART_MS)
    return np.asarray(found, dtype=np.int64)


def _nearest(places: NDArray[np.int64], at: NDArray[np.int64]) -> NDArray[np.int64]:
    """How far each of `at` is from the nearest of ascending places."""
    far = np.iinfo(np.int64).max // 4
    edges = np.concatenate([[-far], places, [far]])
    after = np.searchsorted(edges, at)
    return np.asarray(np.minimum(at - edges[after - 1], edges[after] - at), dtype=np.int64)


def _around(
    level: NDArray[np.float64], at: NDArray[np.int64], before: int, after: int
) -> NDArray[np.float64]:
    """The level from `before` ms before to `after` ms after each place; its ends go on."""
    index = at[:, None] + np.arange(-before, after + 1)
    return np.asarray(level[np.clip(index, 0, len(level) - 1)])


def _felt(
    level: NDArray[np.float64], at: NDArray[np.int64], pulses: NDArray[np.int64]
) -> NDArray[np.float64]:
    """The columns of `TOUCH_FEATURES` at each onset."""
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

    first = np.searchsorted(pulses, top + APART_MS)
    last = np.searchsorted(pulses, top - APART_MS, side="right") - 1
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


def _heard(
    click: NDArray[np.float32],
    sample_rate: float,
    level: NDArray[np.float64],
    at: NDArray[np.int64],
) -> NDArray[np.float64]:
    """The columns of `SOUND_FEATURES` at each onset: of the loudest from 20 ms before it to 100."""
    found = np.zeros((len(at), len(SOUND_FEATURES)))
    found[:, 0] = SOUND_FLOOR_DB
    if not len(at):
        return found
    top = np.clip(at - 20 + _around(level, at, 20, 100).argmax(axis=1), 0, len(level) - 1)
    audible = level[top] > SOUND_FLOOR_DB + 3.0
    top = top[audible]
    before, length = int(sample_rate / 500), int(sample_rate / 500 + sample_rate / 33)
    # rises at once, falls as a Hann window does
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
