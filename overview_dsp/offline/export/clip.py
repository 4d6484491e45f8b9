"""Haptic clip of a rendered gesture: vibration per millisecond, and strikes.

Phones and controllers play an amplitude curve and short strikes ("transients", "emphasis").
Both come from the engine's output, so a clip includes the physics: the speed of the
movement, the recoil, and delayed release of events.

A strike is a prominent peak of the felt level where the disk breaks loose from an event. It has the
amplitude of that peak, with the continuous part silent, so that players that add the two, use the
stronger or duck one give the same result. An event that rises slowly, or is masked by a higher one,
is not a strike but belongs to the continuous part, like everything else.

The error of a clip is perceptual. Felt level: RMS over 10 ms in dB, as in `measure`; levels more
than 46 dB below full scale count as silence. Errors of up to one JND are imperceptible.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.design.presets.model import ClickMode
from overview_dsp.errors import InputError
from overview_dsp.offline.rendering.offline import RenderResult
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.signal.surface.fields import BASE
from overview_dsp.signal.surface.model import Surface
from overview_dsp.units import FELT_WINDOW_S, JUST_NOTICEABLE_DB

LEVELS_PER_S = 1000  # resolution of haptic formats: milliseconds or coarser

FLOOR = 10.0 ** (-46.0 / 20.0)
"""Amplitude that counts as silence relative to full scale: one step of an 8-bit motor drive."""

FELT_MS = 9  # averaging time of the felt level, ms; shorter changes are imperceptible
MAX_CLIP_S = 600.0

STANDS_OUT_DB = 12.0
"""Least prominence of a pulse's peak: its height above the minimum between it and a higher one.
Five JNDs."""

HIGH, HIGH_STANDS_OUT_DB = 0.25, JUST_NOTICEABLE_DB
"""Friction relative to the surface's highest from which on an event is a strike wherever its pulse
is perceptible."""

QUIETEST = FLOOR / 32.0  # lower limit of levels for the detection of pulses

KNOCK_MS = (-4, 20)
"""Range of delays from an event's strike to its pulse's peak: a tactor with a short rise time
reaches it 5 to 10 ms after the disk has broken loose."""

ONSET_MS = 4  # time from a pulse's onset to its felt peak: half the window of the felt level
NEAR_MS = 5  # longest distance of a strike from the moment at which the disk broke loose

SEPARATE_MS = 12
"""Least distance of strikes, to avoid overlap: the sharpest emphasis of Meta's renderer."""

MUCH_LOWER = 0.05
"""Ratio of friction below which an event must not strike harder than another one. For example, a
foul with the felt level of the weakest goal, due to their positions in the gesture, is no strike.
"""

DULL_HZ, SHARP_HZ = 100.0, 6400.0

NOTICEABLE_DB = 2.3  # JND of amplitude on the skin (Israr and Tan 2006: 2.2 to 2.5 dB)


def felt_db(amplitude: FloatArray) -> FloatArray:
    """Return an amplitude in dB of full scale, limited to `FLOOR`."""
    return 20.0 * np.log10(np.maximum(amplitude, FLOOR))


def felt_level(level: FloatArray) -> FloatArray:
    """Return the felt level: RMS over 9 ms around each millisecond, float64 (n,)."""
    energy = np.convolve(level**2, np.ones(FELT_MS) / FELT_MS, "same")
    return np.asarray(np.sqrt(np.maximum(energy, 0.0)))


@dataclass(frozen=True)
class Transient:
    """A strike of a haptic clip.

    Attributes
    ----------
    time_s : float
        Time, s.
    amplitude, sharpness : float
        Strength and sharpness, 0 to 1.
    kind : str
        Kind of the event; empty in a clip from a file.

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
    """Vibration for export to haptic formats.

    `level`: amplitude of the vibration at each millisecond, 0..1 of full scale.
    `frequency_hz`: frequency of the carrier.
    `transients`: strikes in order of time.
    """

    title: str
    level: FloatArray
    frequency_hz: float
    transients: tuple[Transient, ...]
    surface: Surface

    @cached_property
    def felt(self) -> FloatArray:
        """Perceived level at each millisecond, float64 (n,)."""
        return felt_level(self.level)

    @property
    def duration_s(self) -> float:
        """Duration in s; the last level is at its end."""
        return (len(self.level) - 1) / LEVELS_PER_S

    def under_strikes(self, length_ms: Callable[[Transient], int]) -> tuple[FloatArray, list[int]]:
        """Return the felt level at each millisecond, with silence during strikes.

        `length_ms` returns the duration of a strike on a player, ms. It also returns the starts and
        ends of the silence, which need breakpoints.
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
    """Make a clip of a rendered gesture up to the end of its vibration.

    InputError for a result without trace or vibration, or longer than ten minutes.
    """
    if result.trace is None:
        raise InputError("the result has no trace, which is needed; render with trace=True")
    if len(result.samples) > MAX_CLIP_S * result.sample_rate:
        raise InputError(
            f"the result has {len(result.samples) / result.sample_rate:.0f} s; a clip holds up to "
            f"{MAX_CLIP_S:g} s; use a shorter gesture"
        )
    preset = result.engine.preset
    level = np.minimum(level_by_ms(result.trace.envelope, result.sample_rate), 1.0)
    if preset.values["tactor.mute"]:
        level[:] = 0.0
    felt = np.flatnonzero(level > FLOOR)
    if not len(felt):
        raise InputError("the gesture has no vibration; use a longer sweep or unmute the tactor")
    level = np.append(level[: felt[-1] + 1], 0.0)
    return Clip(
        result.engine.timeline.title,
        level,
        preset.number("tactor.frequency_hz"),
        strikes_of(result, felt_level(level)),
        result.engine.surface,
    )


def level_by_ms(envelope: FloatArray, sample_rate: float) -> FloatArray:
    """Return the RMS of an envelope, whose samples are held, around each millisecond."""
    energy = np.concatenate([[0.0], np.cumsum(envelope * envelope)])
    count = math.ceil(len(envelope) / sample_rate * LEVELS_PER_S) + 1
    edges = np.clip((np.arange(count + 1) - 0.5) / LEVELS_PER_S * sample_rate, 0.0, len(envelope))
    width = np.maximum(np.diff(edges), 1e-9)
    mean = np.diff(np.interp(edges, np.arange(len(energy)), energy)) / width
    return np.asarray(np.sqrt(np.maximum(mean, 0.0)))


@dataclass(frozen=True)
class _Candidate:
    """Event from which the disk broke loose, with time and friction."""

    time_ms: int
    release: float
    kind: str
    sharpness: float


def strikes_of(result: RenderResult[Trace | None], felt: FloatArray) -> tuple[Transient, ...]:
    """Return the strikes of a render in order of time; `felt`: level at each millisecond."""
    peaks, prominences = _pulses(felt)
    above_floor = 20.0 * np.log10(felt[peaks] / FLOOR)
    outstanding = peaks[np.minimum(prominences, above_floor) >= STANDS_OUT_DB]
    high = HIGH * result.engine.surface.release.max(initial=0.0)
    found: list[tuple[_Candidate, int, float]] = []
    # the higher of two events at a pulse gets the strike
    for one in sorted(_candidates(result, len(felt)), key=lambda one: (-one.release, one.time_ms)):
        after = peaks - one.time_ms
        own = peaks[(after >= KNOCK_MS[0]) & (after <= KNOCK_MS[1])]
        if one.release < high:
            own = np.intersect1d(own, outstanding)
        if not len(own):
            continue
        peak = int(own[np.argmin(np.abs(own - one.time_ms))])
        onset = min(max(peak - ONSET_MS, one.time_ms - NEAR_MS, 0), one.time_ms + NEAR_MS)
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


def _pulses(felt: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the peaks of the felt level, ms, ascending, and their prominence, dB."""
    from scipy.signal import find_peaks

    level = 20.0 * np.log10(np.maximum(felt, QUIETEST))
    # the clip starts and ends in silence
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
    """Return the sharpness of a click from the mean pitch of its modes: 100 Hz to 6.4 kHz."""
    if not modes:
        return 0.5
    weight = np.array([10.0 ** (mode.gain_db / 20.0) for mode in modes])
    pitch = np.array([math.log(mode.frequency_hz) for mode in modes])
    mean = float((weight * pitch).sum() / weight.sum())
    part = (mean - math.log(DULL_HZ)) / math.log(SHARP_HZ / DULL_HZ)
    return min(max(part, 0.0), 1.0)


@dataclass(frozen=True)
class PerceptualError:
    """Perceptual difference between an exported clip and the render, while either is felt.

    Attributes
    ----------
    median_db, largest_db : float
        Error of the level over 10 ms, dB.
    within_percent : float
        Part of the felt time with an error below one JND (2.3 dB), %.
    worst_event : Transient or None
        Strike with the largest error in the 30 ms after it.
    worst_db : float
        That error, dB.

    Examples
    --------
    >>> result = ov.render(match, football, ov.sweep(0.5), sample_rate=8000)
    >>> ov.export.export(result, "haptic", "match.haptic").error.within_percent > 50.0
    True
    """

    median_db: float
    largest_db: float
    within_percent: float
    worst_event: Transient | None = field(default=None, repr=False)
    worst_db: float = 0.0


def perceptual_error(
    played: FloatArray, rendered: FloatArray, strikes: Iterable[Transient] = ()
) -> PerceptualError:
    """Compare two amplitude curves with one value per millisecond; a missing end is silence.

    Windows in which both are at `FLOOR` or below don't count.
    """
    width = round(FELT_WINDOW_S * LEVELS_PER_S)
    count = math.ceil(max(len(played), len(rendered)) / width) * width
    sides = np.stack([np.pad(side, (0, count - len(side))) for side in (played, rendered)])
    levels = felt_db(np.sqrt(np.mean(sides.reshape(2, -1, width) ** 2, axis=2)))
    error = np.abs(levels[0] - levels[1])
    felt = error[levels.max(axis=0) > felt_db(np.array(FLOOR))]
    if not len(felt):
        return PerceptualError(0.0, 0.0, 100.0)
    worst, worst_db = None, 0.0
    for strike in strikes:
        first = int(strike.time_s / FELT_WINDOW_S)
        if (most := float(error[first : first + 3].max(initial=0.0))) > worst_db:
            worst, worst_db = strike, most
    within = float(100.0 * np.mean(felt <= NOTICEABLE_DB))
    return PerceptualError(float(np.median(felt)), float(felt.max()), within, worst, worst_db)
