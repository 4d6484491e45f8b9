"""What a haptic format is made from: how strong the vibration is, and where something strikes.

Phones and controllers play an amplitude over time and short strikes ("transients", "emphasis")
besides. A strike is its event: as strong as what was felt of it, with the continuous part silent
under it, so that a player that adds the two, takes the stronger or ducks one gives the same.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from overview_dsp.signal.surface.model import Surface

LEVELS_PER_S = 1000
"""Haptic formats count milliseconds or coarser."""

FLOOR = 10.0 ** (-46.0 / 20.0)
"""Amplitude that counts as silence, of full scale: one step of a motor driven with 8 bits."""

FELT_MS = 9
"""What is shorter isn't felt as a course of its own: a window of the felt level is 10 ms."""

MAX_CLIP_S = 600.0


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
