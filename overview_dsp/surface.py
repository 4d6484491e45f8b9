"""Timeline + preset -> surface: the friction table B(phi) and the event table.

    B = bare surface + max over events of height * weight * profile

The bare surface is `bare_surface`'s; bristles and detents, where the preset has them, lie beside it
(`bristle_field`, `well_field`). Overlapping profiles combine by their maximum, so that none is
drowned in a sum and each stays findable; every event keeps a strike of its own.

A kind whose events lie denser than its `spacing_percent` is left out as a whole: a thousand beats
of a heart would be one blur. A window that spreads them brings them up.

An event strikes at its position. One nearer than half its width to an end of the timeline strikes
half its width from that end, where its profile lets the disk go: a hand can pass it there.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from overview_dsp.bare_surface import bare_surface
from overview_dsp.bristle_field import BristleField, BristleLayer, has_bristles
from overview_dsp.errors import InputError, OverviewWarning
from overview_dsp.impacts import NONE as NO_IMPACTS
from overview_dsp.impacts import Impacts
from overview_dsp.materials import louder, modes_of
from overview_dsp.merging import strongest_of_each
from overview_dsp.presets.model import DEFAULT_KIND, Kind, Mode, Preset
from overview_dsp.profiles import bumps, profile, span
from overview_dsp.well_field import (
    DETENT_MODELS,
    DetentField,
    DetentLayer,
    energy_of,
    has_detents,
    impedance,
    shape_of,
)

if TYPE_CHECKING:
    from overview_dsp.timeline import Event, Timeline

CELLS = 65536
"""Cells of the table; `kernels.layout.CELLS` is the same number (a test holds them together)."""

MAX_EVENTS = 16384
MAX_FRICTION = 1e6
"""No event is higher, N m s/rad, however great its weight: ten million bare surfaces' friction."""

MIN_WIDTH_CELLS = 4.0
"""A profile narrower than this would fall between the table's points."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface with friction, ready for the engine.

    Attributes
    ----------
    friction : float64 (CELLS + 1,)
        B at equal steps of the surface angle phi from 0 to pi, N m s/rad; > 0.
    position : float64 (events,)
        Cursor (0..1) at which each event strikes, ascending.
    release : float64 (events,)
        Friction that lets go there, N m s/rad.
    kind : int64 (events,)
        Index into `kind_names`.
    event : int64 (events,)
        Index into the timeline's events.
    span : float64 (events, 2)
        Cursor from and to: where the event's profile exceeds a tenth of its height; without end
        (-inf, inf) where that reaches an end of the timeline.
    kind_names, kind_modes : tuples
        Event kinds with their clicks; a mode's gain includes its kind's.
    left_out : mapping of kind to count
        Events that lie too densely to be felt one by one.
    own_modes : tuple of Mode
        What the bare surface sounds like.
    impacts : Impacts
        Where it is struck, besides events.
    kind_models, own_model : tuple of str, str
        What friction the kinds are, and the bare surface.
    bristles : BristleField or None
        Where bristles grip, if anywhere.
    detents : DetentField or None
        Where detents and stops pull, if anywhere.
    """

    friction: NDArray[np.float64]
    position: NDArray[np.float64]
    release: NDArray[np.float64]
    kind: NDArray[np.int64]
    event: NDArray[np.int64]
    span: NDArray[np.float64]
    kind_names: tuple[str, ...]
    kind_modes: tuple[tuple[Mode, ...], ...]
    left_out: Mapping[str, int] = field(default_factory=dict)
    own_modes: tuple[Mode, ...] = ()
    impacts: Impacts = NO_IMPACTS
    kind_models: tuple[str, ...] = ()
    own_model: str = "viscous"
    bristles: BristleField | None = None
    detents: DetentField | None = None

    @property
    def resistance(self) -> NDArray[np.float64]:
        """What a disk at 1 rad/s is held with at the table's points, by all models, N m s/rad.

        Viscous friction, the bristles' sliding torque and the detents' pull, whichever way it goes.
        """
        total = self.friction
        if self.bristles is not None:
            total = total + self.bristles.grip
        if self.detents is not None:
            total = total + np.abs(self.detents.pull)
        return total

    def friction_at(self, phi: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """B at surface angles (rad, clamped to [0, pi]), linear between the table's points."""
        x = np.clip(np.asarray(phi, dtype=np.float64) / math.pi, 0.0, 1.0) * CELLS
        return np.interp(x, np.arange(CELLS + 1, dtype=np.float64), self.friction)

    def in_span(
        self, cursor: NDArray[np.float64], events: NDArray[np.bool_] | None = None
    ) -> NDArray[np.bool_]:
        """Whether each cursor lies in the span of any event (or of any of the marked ones)."""
        spans = self.span if events is None else self.span[events]
        inside = np.zeros(np.shape(cursor), dtype=bool)
        for first, last in spans:
            inside |= (cursor >= first) & (cursor <= last)
        return inside


def _width_cells(kind: Kind, name: str, duration_s: float) -> float:
    if kind.width_percent is not None:
        return kind.width_percent / 100.0 * CELLS
    assert kind.width_ms is not None
    cells = kind.width_ms / 1000.0 / duration_s * CELLS
    if cells < MIN_WIDTH_CELLS:
        warnings.warn(
            f"kinds.{name}: {kind.width_ms:g} ms of {duration_s:g} s is narrower than the surface "
            f"resolves; widened to {MIN_WIDTH_CELLS / CELLS * duration_s * 1000.0:.3g} ms",
            OverviewWarning,
            stacklevel=3,
        )
        return MIN_WIDTH_CELLS
    return min(cells, float(CELLS))


def build_surface(timeline: Timeline, preset: Preset) -> Surface:
    """The surface of a timeline under a preset.

    Warns (OverviewWarning) of event kinds the preset doesn't name, which take its `default`, of
    gaps too narrow to be felt, and of more events than a surface tells apart (16384): then the
    strongest in each cell, or in each two, four, ... cells, strikes for all there.

    Raises
    ------
    InputError
        The bare surface's pattern has more crests than a surface holds strikes.
    """
    by_kind = _by_felt_kind(timeline.events, preset)
    left_out = {
        name: len(by_kind.pop(name))
        for name, members in list(by_kind.items())
        if len(members) > 1 and len(members) * preset.kinds[name].spacing_percent > 100.0
    }
    felt = np.sort(np.concatenate([np.zeros(0, np.int64), *by_kind.values()]))
    under = bare_surface(timeline, preset, CELLS)
    room = MAX_EVENTS - len(under.impacts.position)
    if room < min(len(felt), 1):
        raise InputError(
            f"{len(under.impacts.position)} crests of the bare surface; with events it holds up to "
            f"{MAX_EVENTS}: make surface.pattern_period_percent longer"
        )

    unknown = sorted(kind for kind in timeline.kinds() if preset.kind_for(kind) is None)
    if unknown:
        warnings.warn(
            f"preset {preset.name!r} has no {', '.join(unknown)}: felt as its "
            f"{DEFAULT_KIND!r}; it names {', '.join(preset.kinds)}",
            OverviewWarning,
            stacklevel=2,
        )
    names = tuple(preset.kinds)
    count = len(felt)
    position = np.zeros(count)
    release = np.zeros(count)
    kind_index = np.zeros(count, dtype=np.int64)
    spans = np.zeros((count, 2))
    bare = preset.number("surface.friction")
    raised = np.zeros(CELLS + 1)
    detents = DetentLayer(preset, under.energy) if has_detents(preset) else None
    bristles = BristleLayer(preset, under.friction) if has_bristles(preset) else None
    centres = np.array([timeline.events[i].time_s for i in felt]) / timeline.duration_s * CELLS
    for name, indices in by_kind.items():
        kind = preset.kinds[name]
        width = _width_cells(kind, name, timeline.duration_s)
        members = np.searchsorted(felt, indices)
        centre = centres[members]
        height = _heights([timeline.events[i] for i in indices], name, bare * kind.height)
        shape, points = shape_of(kind)
        if detents is not None and kind.model in DETENT_MODELS:
            detents.check(name, height)
            high = height * energy_of(1.0, shape, points, width)
            for _, start, bump in bumps(shape, points, width, centre, high, CELLS):
                detents.lay(kind.model, start, bump)
            if kind.model == "end_stop":
                damping = np.full(len(centre), kind.damping)
                _raise(raised, bumps(shape, points, width, centre, damping, CELLS))
        else:
            profiles = bumps(shape, points, width, centre, height, CELLS)
            if bristles is not None and kind.model == "bristle":
                bristles.check(name, height)
                for i, start, bump in profiles:
                    bristles.raise_to(int(members[i]), start, bump)
            else:
                _raise(raised, profiles)
        margin = min(width, CELLS) / 2.0
        position[members] = np.minimum(np.maximum(centre, margin), CELLS - margin)
        there = profile(shape, position[members] - centre, width, points)
        # a ramp that falls towards its end of the timeline is over half a width from it
        release[members] = height * np.maximum(there, 0.5)
        if kind.model == "detent":
            takes = [impedance(preset, pull, width / 2.0, CELLS) for pull in height]
            release[members] = takes
        first, last = span(shape, width, points)
        # past an end the look-up stays at the end, and with it in the event
        spans[members, 0] = np.where(centre + first > 0.0, centre + first, -math.inf)
        spans[members, 1] = np.where(centre + last < CELLS, centre + last, math.inf)
        kind_index[members] = names.index(name)

    if count > room:
        order, stands_for = strongest_of_each(position, release, room)
        warnings.warn(
            f"{timeline.title or 'the timeline'}: {count} events, of which the surface tells "
            f"{len(order)} apart; where several fall together the strongest strikes, and friction "
            "is that of all; use a shorter window",
            OverviewWarning,
            stacklevel=2,
        )
    else:
        order = np.argsort(position, kind="stable")
        stands_for = np.argsort(order)
    return Surface(
        friction=under.friction + raised,
        position=position[order] / CELLS,
        release=release[order],
        kind=kind_index[order],
        event=felt[order],
        span=spans[order] / CELLS,
        kind_names=names,
        kind_modes=tuple(_modes(preset.kinds[name]) for name in names),
        left_out=left_out,
        own_modes=under.modes,
        impacts=under.impacts,
        kind_models=tuple(kind.model for kind in preset.kinds.values()),
        own_model=str(preset.values["surface.model"]),
        detents=detents.field() if detents is not None else None,
        bristles=bristles.field(stands_for) if bristles is not None else None,
    )


def _by_felt_kind(events: tuple[Event, ...], preset: Preset) -> dict[str, NDArray[np.int64]]:
    """The indices of the events that take each of the preset's kinds."""
    found: dict[str, list[int]] = {}
    for i, event in enumerate(events):
        name = preset.kind_for(event.kind) or DEFAULT_KIND
        found.setdefault(name, []).append(i)
    return {name: np.array(members) for name, members in found.items()}


def _heights(events: list[Event], name: str, ordinary: float) -> NDArray[np.float64]:
    """Friction at the top of each event of a kind."""
    heights = []
    for event in events:
        height = ordinary * event.weight
        if height > MAX_FRICTION:
            warnings.warn(
                f"{name} at {event.time_s:g} s: weight {event.weight:g} makes more friction than "
                f"a surface holds; lowered to {MAX_FRICTION:g} N·m·s/rad",
                OverviewWarning,
                stacklevel=3,
            )
            height = MAX_FRICTION
        heights.append(height)
    return np.array(heights)


def _raise(
    table: NDArray[np.float64], bumps: Iterator[tuple[int, int, NDArray[np.float64]]]
) -> None:
    """Raise the table to the profiles of events."""
    for _, start, bump in bumps:
        there = table[start : start + len(bump)]
        np.maximum(there, bump, out=there)


def _modes(kind: Kind) -> tuple[Mode, ...]:
    return louder(kind.modes or modes_of(kind.material, kind.pitch_hz, kind.ring), kind.gain_db)
