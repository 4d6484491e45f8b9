"""Surface model: friction, events, bristles and detents."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from overview_dsp.arrays import BoolArray, FloatArray, IntArray
from overview_dsp.design.presets.model import ClickMode
from overview_dsp.kernels.layout import CELLS
from overview_dsp.public import counted
from overview_dsp.signal.surface.angle_map import AngleMap
from overview_dsp.signal.surface.fields import BristleField, DetentField


@dataclass(frozen=True, eq=False)
class TextureStrikes:
    """Strikes of the base surface's pattern, which sound with its material.

    Crests or troughs: `position` (cursor, ascending), `release` (N m s/rad); float64 (n,).
    """

    position: FloatArray
    release: FloatArray


NO_TEXTURE_STRIKES = TextureStrikes(np.zeros(0), np.zeros(0))


@dataclass(frozen=True, eq=False)
class Surface:
    """Surface: friction table and event table for the engine.

    Attributes
    ----------
    friction : float64 (cells + 1,)
        B at equal steps of the surface angle phi from 0 to pi, N m s/rad; > 0.
    position : float64 (events,)
        Position (0..1) of each event, ascending.
    edges : float64 (events, 2)
        Positions at which the disk strikes the event upwards and downwards: the ends of its span,
        if friction is viscous.
    release : float64 (events,)
        Friction released there, N m s/rad.
    kind : int64 (events,)
        Index into `kind_names`.
    event : int64 (events,)
        Index into the timeline's events.
    span : float64 (events, 2)
        Range of positions in which the event's profile exceeds a tenth of its height; infinite
        (-inf, inf) where it reaches an end of the timeline.
    kind_names : tuple of str
        Event kinds.
    kind_modes : tuple of tuple of ClickMode
        Click of each kind; a mode's gain includes that of its kind.
    angle_map : AngleMap
        Map between times and positions, for `position_of` and `time_at`.
    omitted_events : mapping of str to int
        Number of events of each kind that is omitted because its events are too dense.
    own_modes : tuple of ClickMode
        Modes of the base surface.
    texture_strikes : TextureStrikes
        Strikes of the base surface.
    kind_models : tuple of str
        Friction model of each kind.
    own_model : str
        Friction model of the base surface.
    bristles : BristleField or None
        Bristles, if any.
    detents : DetentField or None
        Detents and stops, if any.
    tactor : int64 (events,) or None
        Tactor of each event, from 1, or 0 for all; None if the position chooses it.

    See Also
    --------
    build_surface : Build one from a timeline and a preset.

    Examples
    --------
    >>> surface = ov.build_surface(match, football)
    >>> surface.kind_names[surface.kind[0]]
    'period'
    """

    friction: FloatArray
    position: FloatArray
    edges: FloatArray
    release: FloatArray
    kind: IntArray
    event: IntArray
    span: FloatArray
    kind_names: tuple[str, ...]
    kind_modes: tuple[tuple[ClickMode, ...], ...]
    angle_map: AngleMap
    omitted_events: Mapping[str, int] = field(default_factory=dict)
    own_modes: tuple[ClickMode, ...] = ()
    texture_strikes: TextureStrikes = NO_TEXTURE_STRIKES
    kind_models: tuple[str, ...] = ()
    own_model: str = "viscous"
    bristles: BristleField | None = None
    detents: DetentField | None = None
    tactor: IntArray | None = None

    @property
    def resistance(self) -> FloatArray:
        """Total resistance against a disk at 1 rad/s at the table's points, N m s/rad.

        It is the sum of viscous friction, the bristles' sliding torque and the detents' absolute
        pull.
        """
        total = self.friction
        if self.bristles is not None:
            total = total + self.bristles.grip
        if self.detents is not None:
            total = total + np.abs(self.detents.pull)
        return total

    def position_of(self, time_s: ArrayLike) -> FloatArray:
        """Convert times to positions.

        Parameters
        ----------
        time_s : array_like
            Seconds from the start of the timeline (of a window: from its start), any shape;
            limited to the timeline.

        Returns
        -------
        float64
            Positions, 0 to 1, of the same shape. Simultaneous events give that of the last one.

        See Also
        --------
        time_at : The inverse.

        Examples
        --------
        >>> surface = ov.build_surface(match, football)
        >>> surface.position_of([0.0, match.duration_s])
        array([0., 1.])
        """
        return self.angle_map.position_of(time_s)

    def time_at(self, position: ArrayLike) -> FloatArray:
        """Convert positions to times.

        Parameters
        ----------
        position : array_like
            Positions, 0 to 1, any shape; limited to that range.

        Returns
        -------
        float64
            Seconds from the start of the timeline (of a window: from its start), of the same shape.

        See Also
        --------
        position_of : The inverse.

        Examples
        --------
        >>> surface = ov.build_surface(match, football)
        >>> goal = match.event("goal", 1).time_s
        >>> abs(surface.time_at(surface.position_of(goal)) - goal) < 1e-6
        np.True_
        """
        return self.angle_map.time_at(position)

    def friction_at(self, phi: FloatArray | float) -> FloatArray:
        """Look up B, linear between the table's points.

        Parameters
        ----------
        phi : float64 or float
            Surface angles, rad, clamped to [0, pi].

        Returns
        -------
        float64
            Friction, N m s/rad, of the same shape.

        Examples
        --------
        >>> surface = ov.build_surface(match, football)
        >>> surface.friction_at(0.0) == surface.friction[0]
        np.True_
        """
        x = np.asarray(phi, dtype=np.float64) / math.pi * CELLS
        return np.interp(x, np.arange(CELLS + 1, dtype=np.float64), self.friction)

    def in_span(self, cursor: FloatArray, events: BoolArray | None = None) -> BoolArray:
        """Return whether each position lies in the span of an event.

        Parameters
        ----------
        cursor : float64 (n,)
            Positions, 0 to 1.
        events : bool (events,) or None
            Mask of the events to include; None includes all.

        Returns
        -------
        bool (n,)
            True in a span.

        Examples
        --------
        >>> surface = ov.build_surface(match, football)
        >>> surface.in_span(surface.position[:2])
        array([ True,  True])
        """
        spans = self.span if events is None else self.span[events]
        inside = np.zeros(np.shape(cursor), dtype=bool)
        for first, last in spans:
            inside |= (cursor >= first) & (cursor <= last)
        return inside

    def __repr__(self) -> str:
        return (
            f"<Surface: friction {self.friction.min():.3g} to {self.friction.max():.3g} N·m·s/rad, "
            f"{counted(len(self.event), 'event')} of {counted(len(self.kind_names), 'kind')}>"
        )
