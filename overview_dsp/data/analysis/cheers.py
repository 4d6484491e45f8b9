"""Excitement of a crowd, the loudness above the background, and its peaks.

**Background**: the 10th percentile of the loudness over 1 s, within a minute before and after. So a
murmur is little above it, and a cheer of half a minute does not raise it. Silence (below -70 LUFS)
is left out. The background is at least the integrated loudness less 20 LU.

**Excitement**: loudness over 1 s above that background, LU, at least 0.

**Peaks**: excitement of `MIN_PEAK_LU` or more that falls by `MIN_FALL_LU` on both sides before a
higher value. A `cheer` stays above half its height for `CHEER_S` or longer; a `burst` (a
whistle, a bang, a shout) is shorter.
"""

from __future__ import annotations

import numpy as np

from overview_dsp.arrays import FloatArray
from overview_dsp.data.analysis.loudness import SILENCE_LUFS, STEPS_PER_S
from overview_dsp.data.timeline.event import Event
from overview_dsp.units import clock_text

WINDOW_STEPS = STEPS_PER_S
"""Loudness is averaged over 1 s: momentary loudness varies too much, short-term loudness lags."""

REACH_S = 60
PERCENTILE = 10.0
MAX_DEPTH_LU = 20.0

MIN_PEAK_LU = 6.0
"""An even murmur's loudest second is up to 3 LU above its background; twice that is not random."""

MIN_FALL_LU = 4.0
CHEER_S = 2.0

ORDINARY_LU = 10.0  # height of an event of weight 1, perceived as twice as loud as the background
_GRID_STEPS = STEPS_PER_S  # the background is slow: once a second is enough
_CHUNK = 4096


def background(loudness: FloatArray, integrated: float) -> FloatArray:
    """Return the background at each step, LUFS.

    `loudness` (n,): LUFS over 1 s at each step, NaN where missing.
    `integrated`: integrated loudness of the recording, LUFS.
    """
    heard = np.where(loudness > SILENCE_LUFS, loudness, np.nan)
    lowest = max(SILENCE_LUFS, integrated - MAX_DEPTH_LU)
    seconds = np.arange(0, len(heard), _GRID_STEPS)
    reach = REACH_S * _GRID_STEPS
    padded = np.pad(heard, reach, constant_values=np.nan)
    # every fifth step is enough, since neighbouring windows overlap
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1)[seconds, ::5]
    found = np.concatenate(
        [_percentile(windows[i : i + _CHUNK]) for i in range(0, len(windows), _CHUNK)]
    )
    slow = np.interp(np.arange(len(heard)), seconds, np.fmax(found, lowest))
    return np.asarray(slow, dtype=np.float64)


def _percentile(windows: FloatArray) -> FloatArray:
    """Return the percentile of each row, ignoring NaN; NaN for a row of NaN only."""
    ordered = np.sort(windows, axis=1)  # NaN last
    known = np.count_nonzero(~np.isnan(ordered), axis=1)
    place = PERCENTILE / 100.0 * np.maximum(known - 1, 0)
    low = np.floor(place).astype(np.int64)
    high = np.minimum(low + 1, np.maximum(known - 1, 0))
    rows = np.arange(len(ordered))
    part = place - low
    return np.asarray(ordered[rows, low] * (1.0 - part) + ordered[rows, high] * part)


def excitement(loudness: FloatArray, ambient: FloatArray) -> FloatArray:
    """Return the loudness above the background, LU, at least 0; NaN if missing."""
    return np.maximum(loudness - ambient, 0.0)


def peaks(above: FloatArray, time_s: FloatArray) -> tuple[Event, ...]:
    """Return the peaks of the excitement (LU, NaN where missing) as events.

    Weight 1 is `ORDINARY_LU`.
    """
    from scipy.signal import find_peaks, peak_widths

    # 0 before the start and after the end, so that a truncated cheer counts, too
    height = np.concatenate([[0.0], np.nan_to_num(above), [0.0]])
    found, measured = find_peaks(height, height=MIN_PEAK_LU, prominence=MIN_FALL_LU)
    widths = peak_widths(
        height,
        found,
        rel_height=0.5,
        prominence_data=(height[found], measured["left_bases"], measured["right_bases"]),
    )[0]
    events = []
    for peak, width in zip(found.tolist(), widths.tolist(), strict=True):
        lu = float(height[peak])
        at = float(time_s[peak - 1])
        kind = "cheer" if width >= CHEER_S * STEPS_PER_S else "burst"
        events.append(Event(at, kind, f"{clock_text(at)} +{lu:.1f} LU", lu / ORDINARY_LU))
    return tuple(events)
