"""What a haptic format is made from: how strong the vibration is, and where something strikes.

Phones and controllers play an amplitude over time and short strikes ("transients", "emphasis")
besides. Both are taken from what the engine rendered, so a clip has the physics in it: the speed of
the hand, the recoil, the event that lets go late.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.rendering.offline import Result
from overview_dsp.rendering.trace import Trace
from overview_dsp.surface.bristles import BARE
from overview_dsp.surface.model import Surface

LEVELS_PER_S = 1000
"""Haptic formats count milliseconds or coarser."""

FLOOR = 10.0 ** (-46.0 / 20.0)
"""Amplitude that counts as silence, of full scale: one step of a motor driven with 8 bits."""

STRIKE_S = 0.012
"""How long a strike lasts: the sharpest emphasis of Meta's renderer. Nearer ones would overlap."""

SEPARATE_S = 0.030
"""Pulses nearer than this are felt as one (the pulse-to-vibration transition, 40 to 590 Hz): beside
a much higher event, a lower one is drowned."""

DROWNED = 0.25
"""So much lower an event is drowned; two goals are not, by each other."""

FELT_MS = 9
"""What is shorter isn't felt as a course of its own: a window of the felt level is 10 ms."""

_PEAK_S = (0.06, 0.015)
"""Its level is reached so long before or after its strike: the disk is held, then breaks loose."""

DULL_HZ, SHARP_HZ = 100.0, 6400.0
MAX_CLIP_S = 600.0


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
    >>> import overview_dsp as ov
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
        """The level as skin takes it: its RMS over 9 ms around each millisecond, float64 (n,)."""
        energy = np.convolve(self.level**2, np.ones(FELT_MS) / FELT_MS, "same")
        return np.asarray(np.sqrt(np.maximum(energy, 0.0)))

    @property
    def duration_s(self) -> float:
        """Length in s; the last level is at its end."""
        return (len(self.level) - 1) / LEVELS_PER_S


def clip_of(result: Result[Trace | None]) -> Clip:
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
        _transients(result, level),
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


def _transients(result: Result[Trace | None], level: NDArray[np.float64]) -> tuple[Transient, ...]:
    """The strikes that can be felt, without those that a higher event drowns."""
    surface = result.engine.surface
    events = result.engine.timeline.events
    release = {
        int(event): float(b) for event, b in zip(surface.event, surface.release, strict=True)
    }
    release[BARE] = 0.0
    taken = {int(event): int(kind) for event, kind in zip(surface.event, surface.kind, strict=True)}
    found: list[tuple[float, Transient]] = []
    for time, event in zip(result.strikes.time_s, result.strikes.event, strict=True):
        at = round(time * LEVELS_PER_S)
        if at >= len(level):
            continue
        before, after = (round(s * LEVELS_PER_S) for s in _PEAK_S)
        peak = level[max(0, at - before) : at + after + 1].max()
        if peak < FLOOR:
            continue
        kind, modes = "surface", surface.own_modes
        if event != BARE:
            kind, modes = events[event].kind, surface.kind_modes[taken[int(event)]]
        elif not modes:
            continue
        strike = Transient(float(time), float(peak), _sharpness(modes), kind)
        found.append((release[int(event)], strike))
    kept: list[tuple[float, Transient]] = []
    # the higher event first: a goal isn't given up for a foul beside it
    for height, strike in sorted(found, key=lambda pair: (-pair[0], pair[1].time_s)):
        if all(
            abs(strike.time_s - other.time_s)
            >= (SEPARATE_S if height < DROWNED * higher else STRIKE_S)
            for higher, other in kept
        ):
            kept.append((height, strike))
    return tuple(sorted((strike for _, strike in kept), key=lambda strike: strike.time_s))


def _sharpness(modes: tuple[object, ...]) -> float:
    """How sharp a click is, by the mean pitch of its modes: 100 Hz is 0, 6.4 kHz is 1."""
    if not modes:
        return 0.5
    weight = np.array([10.0 ** (mode.gain_db / 20.0) for mode in modes])  # type: ignore[attr-defined]
    pitch = np.array([math.log(mode.frequency_hz) for mode in modes])  # type: ignore[attr-defined]
    mean = float((weight * pitch).sum() / weight.sum())
    part = (mean - math.log(DULL_HZ)) / math.log(SHARP_HZ / DULL_HZ)
    return min(max(part, 0.0), 1.0)
