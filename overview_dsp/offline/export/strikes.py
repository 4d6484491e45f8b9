"""Which events of a rendered gesture are strikes of its clip, and how strong.

A strike is a knock: a peak of the felt level that stands out of its surroundings where the disk
breaks loose from an event. It is as strong as that peak. An event that is felt as a swell, or not
at all beside a higher one, is none; it is in the continuous part, like all that isn't an event.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.offline.export.clip import FLOOR, LEVELS_PER_S, Transient
from overview_dsp.offline.rendering.offline import Result
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.signal.surface.bristles import BARE
from overview_dsp.units import JUST_NOTICEABLE_DB

STANDS_OUT_DB = 12.0
"""So far a knock's peak is above what lies between it and a higher one (its prominence): five just
noticeable steps."""

HIGH, HIGH_STANDS_OUT_DB = 0.25, JUST_NOTICEABLE_DB
"""An event of this part of the surface's highest friction is what the hand looks for: it strikes
wherever its knock is felt at all."""

QUIETEST = FLOOR / 32.0
"""A knock may rise from less than counts as a level."""

KNOCK_MS = (-4, 20)
"""From an event's strike to its knock's peak: a tactor that rises in some milliseconds is at its
peak 5 to 10 ms after the disk broke loose."""

ONSET_MS = 4
"""A knock's onset, before its felt peak: half the window of the felt level."""

NEAR_MS = 5
"""A strike is no farther from when the disk broke loose."""

SEPARATE_MS = 12
"""Strikes nearer than this would overlap: the sharpest emphasis of Meta's renderer."""

MUCH_LOWER = 0.05
"""An event whose friction is so much lower never strikes harder: a foul that is felt as strong as
the faintest goal, by where both lie in the hand's way, is no strike."""

DULL_HZ, SHARP_HZ = 100.0, 6400.0


@dataclass(frozen=True)
class _Candidate:
    """An event that broke loose: when, with which friction."""

    time_ms: int
    release: float
    kind: str
    sharpness: float


def strikes_of(result: Result[Trace | None], felt: NDArray[np.float64]) -> tuple[Transient, ...]:
    """The strikes of a rendered gesture, in order of time.

    Parameters
    ----------
    result
        Its strikes and surface are used.
    felt : float64 (n,)
        The felt level at each millisecond.
    """
    peaks, prominences = _knocks(felt)
    above_floor = 20.0 * np.log10(felt[peaks] / FLOOR)
    outstanding = peaks[np.minimum(prominences, above_floor) >= STANDS_OUT_DB]
    high = HIGH * result.engine.surface.release.max(initial=0.0)
    found: list[tuple[_Candidate, int, float]] = []
    # the higher event first: of two at a knock, it is the higher one's
    for one in sorted(_candidates(result, len(felt)), key=lambda one: (-one.release, one.time_ms)):
        after = peaks - one.time_ms
        own = peaks[(after >= KNOCK_MS[0]) & (after <= KNOCK_MS[1])]
        if one.release < high:
            own = np.intersect1d(own, outstanding)
        if not len(own):
            continue
        peak = int(own[np.argmin(np.abs(own - one.time_ms))])
        onset = peak - ONSET_MS
        onset = min(max(onset, one.time_ms - NEAR_MS, 0), one.time_ms + NEAR_MS)
        if all(abs(onset - other) >= SEPARATE_MS for _, other, _ in found):
            found.append((one, onset, float(felt[peak])))
    return tuple(
        Transient(onset / LEVELS_PER_S, amplitude, one.sharpness, one.kind)
        for one, onset, amplitude in sorted(found, key=lambda strike: strike[1])
        if not any(
            one.release < MUCH_LOWER * other.release and amplitude >= strength
            for other, _, strength in found
        )
    )


def _knocks(felt: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Where the felt level stands out, ms, ascending, and by how much, dB."""
    from scipy.signal import find_peaks

    level = 20.0 * np.log10(np.maximum(felt, QUIETEST))
    # the clip begins and ends in silence
    padded = np.pad(level, 1, constant_values=20.0 * math.log10(QUIETEST))
    found, facts = find_peaks(
        padded, prominence=HIGH_STANDS_OUT_DB, height=20.0 * math.log10(FLOOR)
    )
    return np.asarray(found - 1, dtype=np.int64), facts["prominences"]


def _candidates(result: Result[Trace | None], length_ms: int) -> list[_Candidate]:
    surface = result.engine.surface
    row_of = {int(event): row for row, event in enumerate(surface.event)}
    found = []
    for time_s, event in zip(result.strikes.time_s, result.strikes.event, strict=True):
        at = round(time_s * LEVELS_PER_S)
        if at >= length_ms:
            continue
        if event != BARE:
            row = row_of[int(event)]
            release = float(surface.release[row])
            kind = result.engine.timeline.events[event].kind
            modes = surface.kind_modes[surface.kind[row]]
        elif surface.own_modes:
            release, kind, modes = 0.0, "surface", surface.own_modes
        else:
            continue
        found.append(_Candidate(at, release, kind, _sharpness(modes)))
    return found


def _sharpness(modes: tuple[object, ...]) -> float:
    """How sharp a click is, by the mean pitch of its modes: 100 Hz is 0, 6.4 kHz is 1."""
    if not modes:
        return 0.5
    weight = np.array([10.0 ** (mode.gain_db / 20.0) for mode in modes])  # type: ignore[attr-defined]
    pitch = np.array([math.log(mode.frequency_hz) for mode in modes])  # type: ignore[attr-defined]
    mean = float((weight * pitch).sum() / weight.sum())
    part = (mean - math.log(DULL_HZ)) / math.log(SHARP_HZ / DULL_HZ)
    return min(max(part, 0.0), 1.0)
