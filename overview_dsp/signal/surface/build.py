"""Timeline + preset -> surface: choose the events, place them, lay their profiles, assemble.

    B = bare surface + max over events of height * weight * profile

The bare surface is `surface.bare`'s; bristles and detents, where the preset has them, lie beside it
(`surface.fields`). Overlapping profiles combine by their maximum, so that none
is drowned in a sum and each stays findable; every event keeps a strike of its own.

A kind whose events lie denser than its `spacing_percent` is left out as a whole: a thousand beats
of a heart would be one blur. A window that spreads them brings them up.

An event of viscous friction strikes where the disk enters its span, as what the finger feels of
it begins there; one of bristles, a detent or a stop at its position, where that lets go; a ramp,
which rises in both signals, at its top. An event's position is its time's, or half its width from
an end of the timeline that is nearer than that; where its span reaches an end, the disk that starts
from there strikes it at its position.

More events than a surface holds: the strongest of those that fall together strikes for all.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.data.timeline.ticks import KINDS as TICKS
from overview_dsp.design.presets.model import DEFAULT_KIND, ClickMode, EventKind, Preset
from overview_dsp.errors import InputError, OverviewWarning
from overview_dsp.kernels.layout import CELLS, MAX_EVENTS
from overview_dsp.signal.surface.angle_map import AngleMap
from overview_dsp.signal.surface.base_surface import BareSurface, bare_surface
from overview_dsp.signal.surface.fields import (
    DETENT_MODELS,
    BristleLayer,
    DetentLayer,
    energy_of,
    has_bristles,
    has_detents,
    impedance,
    shape_of,
)
from overview_dsp.signal.surface.materials import louder, modes_of
from overview_dsp.signal.surface.model import Surface
from overview_dsp.signal.surface.profiles import bumps, entries, profile, span


def thin_events(
    position: NDArray[np.float64], release: NDArray[np.float64], most: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The events to keep, at most `most` (1 or more) of them, in the order of their positions.

    Events fall together that lie in one cell; if that leaves too many, in one of twice the width,
    and so on. Of equally strong ones the first stays.

    Parameters
    ----------
    position : float64 (events,)
        Where each strikes, cells.
    release : float64 (events,)
        How strong it is.

    Returns
    -------
    kept : int64 (kept,)
        Indices of events.
    stands_for : int64 (events,)
        For each event the number, in `kept`, of the one that strikes for it.
    """
    order = np.argsort(position, kind="stable")
    cell = np.floor(position[order]).astype(np.int64)
    while len(np.unique(cell)) > most:
        cell >>= 1
    group = np.unique(cell, return_inverse=True)[1]
    strongest = np.lexsort((np.arange(len(order)), -release[order], group))
    first = np.flatnonzero(np.diff(group[strongest], prepend=-1))
    stands_for = np.empty(len(order), dtype=np.int64)
    stands_for[order] = group
    return order[strongest[first]], stands_for


MAX_FRICTION = 1e6
"""No event is higher, N m s/rad, however great its weight: ten million bare surfaces' friction."""

MIN_WIDTH_CELLS = 4.0
"""A profile narrower than this would fall between the table's points."""


@dataclass(frozen=True, eq=False)
class _Placed:
    """The events that are felt, in the timeline's order: one row each, positions in cells."""

    event: NDArray[np.int64]
    centre: NDArray[np.float64]
    position: NDArray[np.float64]
    edges: NDArray[np.float64]
    release: NDArray[np.float64]
    kind: NDArray[np.int64]
    span: NDArray[np.float64]

    @classmethod
    def of(cls, event: NDArray[np.int64], angle_map: AngleMap) -> _Placed:
        """Nothing but where each event is; the rest is for each kind to fill."""
        count = len(event)
        return cls(
            event=event,
            centre=angle_map.events[event] * CELLS,
            position=np.zeros(count),
            edges=np.zeros((count, 2)),
            release=np.zeros(count),
            kind=np.zeros(count, dtype=np.int64),
            span=np.zeros((count, 2)),
        )


class _Layers:
    """What events raise: viscous friction, and bristles and detents where the preset has them."""

    def __init__(self, preset: Preset, under: BareSurface) -> None:
        self.raised = np.zeros(CELLS + 1)
        self.detents = DetentLayer(preset, under.energy) if has_detents(preset) else None
        self.bristles = BristleLayer(preset, under.friction) if has_bristles(preset) else None

    def lay(
        self,
        kind: EventKind,
        name: str,
        members: NDArray[np.int64],
        centre: NDArray[np.float64],
        height: NDArray[np.float64],
        width: float,
    ) -> None:
        """Lay the profiles of a kind's events: `members` are their rows, the rest is in cells."""
        shape, points = shape_of(kind)
        if self.detents is not None and kind.model in DETENT_MODELS:
            self.detents.check(name, height)
            high = height * energy_of(1.0, shape, points, width)
            for _, start, bump in bumps(shape, points, width, centre, high, CELLS):
                self.detents.lay(kind.model, start, bump)
            if kind.model == "end_stop":
                damping = np.full(len(centre), kind.damping)
                self._raise(bumps(shape, points, width, centre, damping, CELLS))
            return
        profiles = bumps(shape, points, width, centre, height, CELLS)
        if self.bristles is not None and kind.model == "bristle":
            self.bristles.check(name, height)
            for i, start, bump in profiles:
                self.bristles.raise_to(int(members[i]), start, bump)
        else:
            self._raise(profiles)

    def _raise(self, profiles: Iterator[tuple[int, int, NDArray[np.float64]]]) -> None:
        for _, start, bump in profiles:
            there = self.raised[start : start + len(bump)]
            np.maximum(there, bump, out=there)


def _width_cells(kind: EventKind, name: str, duration_s: float) -> float:
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


def build_surface(timeline: Timeline, preset: Preset, angle_map: AngleMap | None = None) -> Surface:
    """Build the surface of a timeline under a preset.

    Parameters
    ----------
    timeline : Timeline
        What is felt.
    preset : Preset
        How it is felt.
    angle_map : AngleMap or None
        Map between time and angle to keep, that of another surface of the same duration; None
        makes the one of this timeline and preset.

    Returns
    -------
    Surface
        For `Engine`; friction > 0 everywhere.

    Raises
    ------
    InputError
        The bare surface's pattern has more crests than a surface holds strikes; a map of another
        duration.

    Warns
    -----
    OverviewWarning
        Event kinds the preset doesn't name, which take its `default`; gaps too narrow to be felt;
        more events than a surface holds (16384): then the strongest in each cell, or in
        each two, four, ... cells, strikes for all there.

    Examples
    --------
    >>> surface = ov.build_surface(match, football)
    >>> len(surface.event) == len(match.events)
    True
    """
    validation.instance(timeline, Timeline, "timeline", "ov.load_timeline gives one")
    validation.instance(preset, Preset, "preset", "ov.load_preset gives one")
    by_kind, omitted_events = _felt(timeline.events, preset)
    felt = np.sort(np.concatenate([np.zeros(0, np.int64), *by_kind.values()]))
    angle_map = AngleMap.of(timeline, preset) if angle_map is None else _kept(angle_map, timeline)
    under = bare_surface(timeline, preset, CELLS, angle_map)
    crests = len(under.texture_strikes.position)
    capacity = MAX_EVENTS - crests
    if capacity < min(len(felt), 1):
        raise InputError(
            f"{crests} crests of the bare surface; with events it holds up to {MAX_EVENTS}: "
            "make surface.pattern_period_percent longer"
        )
    _warn_of_unknown(timeline.kinds(), preset)
    placed = _Placed.of(felt, angle_map)
    layers = _Layers(preset, under)
    for name, indices in by_kind.items():
        kind = preset.kinds[name]
        width = _width_cells(kind, name, timeline.duration_s)
        members = np.searchsorted(felt, indices)
        ordinary = preset.number("surface.friction") * kind.height
        height = _heights([timeline.events[i] for i in indices], name, ordinary)
        layers.lay(kind, name, members, placed.centre[members], height, width)
        _place(placed, members, kind, preset, height, width)
        placed.kind[members] = tuple(preset.kinds).index(name)
    order, stands_for = _thinned(placed, capacity, timeline.title or "the timeline")
    names = tuple(preset.kinds)
    return Surface(
        friction=under.friction + layers.raised,
        position=placed.position[order] / CELLS,
        edges=placed.edges[order] / CELLS,
        release=placed.release[order],
        kind=placed.kind[order],
        event=felt[order],
        span=placed.span[order] / CELLS,
        kind_names=names,
        kind_modes=tuple(_modes(preset.kinds[name]) for name in names),
        angle_map=angle_map,
        omitted_events=omitted_events,
        own_modes=under.modes,
        texture_strikes=under.texture_strikes,
        kind_models=tuple(kind.model for kind in preset.kinds.values()),
        own_model=str(preset.values["surface.model"]),
        detents=layers.detents.field() if layers.detents is not None else None,
        bristles=layers.bristles.field(stands_for) if layers.bristles is not None else None,
    )


def _kept(angle_map: AngleMap, timeline: Timeline) -> AngleMap:
    validation.instance(angle_map, AngleMap, "angle_map", "another surface's angle_map is one")
    if angle_map.duration_s != timeline.duration_s:
        raise InputError(
            f"angle_map is for {angle_map.duration_s:g} s; must be for {timeline.duration_s:g} s"
        )
    return angle_map.on(timeline)


def _felt(
    events: tuple[Event, ...], preset: Preset
) -> tuple[dict[str, NDArray[np.int64]], dict[str, int]]:
    """The indices of the events felt as each of the preset's kinds; counts of those too dense."""
    found: dict[str, list[int]] = {}
    for i, event in enumerate(events):
        name = preset.kind_for(event.kind) or DEFAULT_KIND
        found.setdefault(name, []).append(i)
    by_kind = {name: np.array(members) for name, members in found.items()}
    omitted_events = {
        name: len(by_kind.pop(name))
        for name, members in list(by_kind.items())
        if len(members) > 1 and len(members) * preset.kinds[name].spacing_percent > 100.0
    }
    return by_kind, omitted_events


def _warn_of_unknown(kinds: Iterable[str], preset: Preset) -> None:
    # a tick is a tick under any preset
    unknown = sorted(kind for kind in set(kinds) - set(TICKS) if preset.kind_for(kind) is None)
    if unknown:
        warnings.warn(
            f"preset {preset.name!r} has no {', '.join(unknown)}: felt as its "
            f"{DEFAULT_KIND!r}; it names {', '.join(preset.kinds)}",
            OverviewWarning,
            stacklevel=3,
        )


def _place(
    placed: _Placed,
    members: NDArray[np.int64],
    kind: EventKind,
    preset: Preset,
    height: NDArray[np.float64],
    width: float,
) -> None:
    """Where a kind's events strike, what they let go there, and where each reaches."""
    shape, points = shape_of(kind)
    centre = placed.centre[members]
    margin = min(width, CELLS) / 2.0
    position = np.minimum(np.maximum(centre, margin), CELLS - margin)
    placed.position[members] = position
    if kind.model == "detent":
        takes = [impedance(preset, pull, width / 2.0, CELLS) for pull in height]
        placed.release[members] = takes
    else:
        # a ramp that falls towards its end of the timeline is over half a width from it
        there = profile(shape, position - centre, width, points)
        placed.release[members] = height * np.maximum(there, 0.5)
    first, last = span(shape, width, points)
    # past an end the look-up stays at the end, and with it in the event
    placed.span[members, 0] = np.where(centre + first > 0.0, centre + first, -math.inf)
    placed.span[members, 1] = np.where(centre + last < CELLS, centre + last, math.inf)
    own = np.stack([position, position], axis=1)
    if kind.model == "viscous":
        entry = np.array(entries(shape, width, points))
        entered = np.isfinite(placed.span[members]) & (entry != 0.0)
        own = np.where(entered, centre[:, None] + entry, own)
    placed.edges[members] = own


def _thinned(
    placed: _Placed, capacity: int, title: str
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The rows that a surface keeps, by position; for each row, which of those stands for it."""
    if len(placed.event) <= capacity:
        order = np.argsort(placed.position, kind="stable")
        return order, np.argsort(order)
    order, stands_for = thin_events(placed.position, placed.release, capacity)
    warnings.warn(
        f"{title}: {len(placed.event)} events, of which the surface keeps "
        f"{len(order)}; where several fall together the strongest strikes, and friction "
        "is that of all; use a shorter window",
        OverviewWarning,
        stacklevel=3,
    )
    return order, stands_for


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


def _modes(kind: EventKind) -> tuple[ClickMode, ...]:
    return louder(kind.modes or modes_of(kind.material, kind.pitch_hz, kind.ring), kind.gain_db)
