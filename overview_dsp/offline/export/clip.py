"""A rendered gesture as a haptic clip: its vibration by the millisecond, and its strikes.

Phones and controllers play an amplitude over time and short strikes ("transients", "emphasis")
besides. Both are what the engine rendered, so a clip has the physics in it: the speed of the
movement, the recoil, the event that lets go late.

A strike is a knock: a peak of the felt level that stands out of its surroundings where the disk
breaks loose from an event. It is as strong as that peak, with the continuous part silent under it,
so that a player that adds the two, takes the stronger or ducks one gives the same. An event that is
felt as a swell, or not at all beside a higher one, is none; it is in the continuous part, like all
that isn't an event.

The error of a clip is measured as a finger perceives it. Felt level: RMS over 10 ms in dB, as in
`measure.felt`; both sides count as silent below 46 dB under full scale. An error of up to one just
noticeable step is no error to a finger.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from overview_dsp.design.presets.model import ClickMode
from overview_dsp.errors import InputError
from overview_dsp.offline.rendering.offline import RenderResult
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.signal.surface.fields import BASE
from overview_dsp.signal.surface.model import Surface
from overview_dsp.units import FELT_WINDOW_S, JUST_NOTICEABLE_DB

LEVELS_PER_S = 1000
"""Haptic formats count milliseconds or coarser."""

FLOOR = 10.0 ** (-46.0 / 20.0)
"""Amplitude that counts as silence, of full scale: one step of a motor driven with 8 bits."""

FELT_MS = 9
"""What is shorter isn't felt as a course of its own: a window of the felt level is 10 ms."""

MAX_CLIP_S = 600.0

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

NOTICEABLE_DB = 2.3
"""One step of amplitude on the skin (Israr and Tan 2006: 2.2 to 2.5 dB)."""


def felt_db(amplitude: NDArray[np.float64]) -> NDArray[np.float64]:
    """Amplitude in dB of full scale, silent below `FLOOR`."""
    return 20.0 * np.log10(np.maximum(amplitude, FLOOR))


def felt_level(level: NDArray[np.float64]) -> NDArray[np.float64]:
    """The level as skin takes it: its RMS over 9 ms around each millisecond, float64 (n,)."""
    energy = np.convolve(level**2, np.ones(FELT_MS) / FELT_MS, "same")
    return np.asarray(np.sqrt(np.maximum(energy, 0.0)))


@dataclass(frozen=True)
class Transient:
    """A strike of a haptic clip.

    Attributes
    ----------
    time_s : float
        When, s.
    amplitude, sharpness : float
        How strong and how sharp, 0 to 1.
    kind : str
        Of the event; empty in a clip that was read.

    Examples
    --------
    >>> ov.export.Transient(0.5, 0.8, 0.3, "goal").kind
    'goal'
    """

    time_s: float
    amplitude: float
    sharpness: float
    kind: str


@dataclass(frozen=True, eq=False)
class Clip:
    """A vibration to be written in a haptic format.

    Attributes
    ----------
    title : str
    level : float64 (n,)
        Amplitude of the vibration at each millisecond, 0..1 of full scale.
    frequency_hz : float
        Of the carrier.
    transients : tuple of Transient
        In order of time.
    surface : Surface
        What the hand moved over.
    """

    title: str
    level: NDArray[np.float64]
    frequency_hz: float
    transients: tuple[Transient, ...]
    surface: Surface

    @cached_property
    def felt(self) -> NDArray[np.float64]:
        """The level as skin takes it, float64 (n,)."""
        return felt_level(self.level)

    @property
    def duration_s(self) -> float:
        """Length in s; the last level is at its end."""
        return (len(self.level) - 1) / LEVELS_PER_S

    def under_strikes(
        self, length_ms: Callable[[Transient], int]
    ) -> tuple[NDArray[np.float64], list[int]]:
        """The continuous part: the felt level, silent while a strike is played.

        Parameters
        ----------
        length_ms : callable
            How long a player plays a strike, ms.

        Returns
        -------
        level : float64 (n,)
            Amplitude at each millisecond.
        corners : list of int
            Where it falls silent and comes back: places that a breakpoint should be at.
        """
        level = self.felt.copy()
        last = len(level) - 1
        starts = [round(strike.time_s * LEVELS_PER_S) for strike in self.transients]
        corners: list[int] = []
        for strike, (start, following) in zip(
            self.transients, itertools.pairwise([*starts, last]), strict=True
        ):
            end = min(start + length_ms(strike), following, last)
            level[start:end] = 0.0
            corners += [start - 1, start, end - 1, end]
        return level, corners


def clip_of(result: RenderResult[Trace | None]) -> Clip:
    """Make a clip of a rendered gesture, up to where its vibration has died away.

    Raises
    ------
    InputError
        It was rendered without a trace, nothing vibrates, or it is longer than ten minutes.
    """
    if result.trace is None:
        raise InputError("rendered without a trace: its envelope is needed, render with trace=True")
    if len(result.samples) > MAX_CLIP_S * result.sample_rate:
        raise InputError(
            f"{len(result.samples) / result.sample_rate:.0f} s of vibration; a clip holds up to "
            f"{MAX_CLIP_S:g} s, use a shorter gesture"
        )
    preset = result.engine.preset
    level = np.minimum(_by_millisecond(result.trace.envelope, result.sample_rate), 1.0)
    if preset.values["tactor.mute"]:
        level[:] = 0.0
    felt = np.flatnonzero(level > FLOOR)
    if not len(felt):
        raise InputError(
            "nothing vibrates in this gesture; use a longer sweep or unmute the tactor"
        )
    level = np.append(level[: felt[-1] + 1], 0.0)
    return Clip(
        result.engine.timeline.title,
        level,
        preset.number("tactor.frequency_hz"),
        strikes_of(result, felt_level(level)),
        result.engine.surface,
    )


def _by_millisecond(envelope: NDArray[np.float64], sample_rate: float) -> NDArray[np.float64]:
    """RMS of the envelope around each millisecond."""
    energy = np.concatenate([[0.0], np.cumsum(envelope * envelope)])
    frames = np.arange(len(energy), dtype=np.float64)
    count = math.ceil(len(envelope) / sample_rate * LEVELS_PER_S) + 1
    edges = (np.arange(count + 1) - 0.5) / LEVELS_PER_S * sample_rate
    edges = np.clip(edges, 0.0, len(envelope))
    width = np.maximum(np.diff(edges), 1e-9)
    mean = np.diff(np.interp(edges, frames, energy)) / width
    return np.asarray(np.sqrt(np.maximum(mean, 0.0)))


@dataclass(frozen=True)
class _Candidate:
    """An event that broke loose: when, with which friction."""

    time_ms: int
    release: float
    kind: str
    sharpness: float


def strikes_of(
    result: RenderResult[Trace | None], felt: NDArray[np.float64]
) -> tuple[Transient, ...]:
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


def _candidates(result: RenderResult[Trace | None], length_ms: int) -> list[_Candidate]:
    surface = result.engine.surface
    row_of = {int(event): row for row, event in enumerate(surface.event)}
    found = []
    for time_s, event in zip(result.strikes.time_s, result.strikes.event, strict=True):
        at = round(time_s * LEVELS_PER_S)
        if at >= length_ms:
            continue
        if event != BASE:
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


def _sharpness(modes: tuple[ClickMode, ...]) -> float:
    """Return how sharp a click is, by the mean pitch of its modes: 100 Hz is 0, 6.4 kHz is 1."""
    if not modes:
        return 0.5
    weight = np.array([10.0 ** (mode.gain_db / 20.0) for mode in modes])
    pitch = np.array([math.log(mode.frequency_hz) for mode in modes])
    mean = float((weight * pitch).sum() / weight.sum())
    part = (mean - math.log(DULL_HZ)) / math.log(SHARP_HZ / DULL_HZ)
    return min(max(part, 0.0), 1.0)


@dataclass(frozen=True)
class PerceptualError:
    """How far an exported clip is from what was rendered, as a finger takes it.

    Attributes
    ----------
    median_db, largest_db : float
        Of the level over 10 ms, dB.
    within_percent : float
        The part of the clip within one just noticeable step (2.3 dB), %.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> ov.export.export(result, "haptic", "match.haptic").error.within_percent > 50.0
    True
    """

    median_db: float
    largest_db: float
    within_percent: float


def perceptual_error(played: NDArray[np.float64], rendered: NDArray[np.float64]) -> PerceptualError:
    """Compare two amplitude curves of one value a millisecond; a missing end is silence."""
    count = max(len(played), len(rendered))
    sides = [np.pad(side, (0, count - len(side))) for side in (played, rendered)]
    error = np.abs(_windows_db(sides[0]) - _windows_db(sides[1]))
    return PerceptualError(
        float(np.median(error)),
        float(error.max()),
        float(100.0 * np.mean(error <= NOTICEABLE_DB)),
    )


def _windows_db(level: NDArray[np.float64]) -> NDArray[np.float64]:
    width = round(FELT_WINDOW_S * LEVELS_PER_S)
    padded = np.pad(level, (0, -len(level) % width))
    return felt_db(np.sqrt(np.mean(padded.reshape(-1, width) ** 2, axis=1)))
