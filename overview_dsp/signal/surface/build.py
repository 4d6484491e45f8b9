"""Construction of a surface: select and position events, combine their profiles, assemble.

    B = base surface + max over events of height * weight * profile

`base_surface` builds the base surface. `fields` adds bristles and detents, if the preset has them.
Overlapping profiles combine by their maximum, so that none disappears in a sum. Every event keeps a
strike of its own.

A kind whose events are denser than its `spacing_percent` is omitted completely: a thousand heart
beats would be indistinguishable. Shorter windows with larger distances show them.

An event of viscous friction strikes where the disk enters its span, since its friction begins
there. Events of bristles, detents and stops strike at their position, where torque is released. A
ramp strikes at its top. The position of an event is that of its time, but at least half its width
from the ends of the timeline. If its span reaches an end, a disk that starts there strikes it at
its position.

If there are more events than a surface holds, the strongest of neighbouring events strikes for all.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.data.timeline.ticks import KINDS as TICKS
from overview_dsp.design.presets.model import DEFAULT_KIND, ClickMode, EventKind, Preset
from overview_dsp.design.presets.parameters import KIND_PARAMETERS
from overview_dsp.errors import InputError, warn
from overview_dsp.kernels.layout import CELLS, MAX_EVENTS
from overview_dsp.signal.surface.angle_map import AngleMap
from overview_dsp.signal.surface.base_surface import BaseSurface, build_base_surface
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


def thin_events(position: FloatArray, release: FloatArray, most: int) -> tuple[IntArray, IntArray]:
    """Select at most `most` (1 or more) events, in the order of their positions.

    Events in one cell are merged. If too many remain, cells of twice the width are used, and so on.
    Of equally strong events the first is kept. `position` (cells) and `release` are those of each
    strike.

    Returns the indices of the kept events, and for each event the index, among these, of the event
    that strikes for it.
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
"""Highest friction of an event, N m s/rad: ten million times that of a base surface."""

MIN_WIDTH_CELLS = 4.0
"""Least width of a profile; narrower ones would fall between the table's points."""


class _Placed:
    """Table of the events on a surface, in the timeline's order; positions in cells."""

    def __init__(self, event: IntArray, angle_map: AngleMap) -> None:
        """Start with events and centres; `fill` adds the rest."""
        self.event = event
        self.centre = angle_map.events[event] * CELLS
        self.position, self.release = np.zeros((2, len(event)))
        self.edges, self.span = np.zeros((2, len(event), 2))
        self.kind = np.zeros(len(event), dtype=np.int64)

    def fill(
        self, members: IntArray, kind: EventKind, preset: Preset, height: FloatArray, width: float
    ) -> None:
        """Fill position, edges, release and span of a kind's events."""
        shape, points = shape_of(kind)
        centre = self.centre[members]
        margin = min(width, CELLS) / 2.0
        position = np.minimum(np.maximum(centre, margin), CELLS - margin)
        self.position[members] = position
        if kind.model == "detent":
            takes = [impedance(preset, pull, width / 2.0, CELLS) for pull in height]
            self.release[members] = takes
        else:
            # a ramp that falls towards the timeline's end is above half its height there
            there = profile(shape, position - centre, width, points)
            self.release[members] = height * np.maximum(there, 0.5)
        first, last = span(shape, width, points)
        # beyond an end of the timeline the look-up stays at the end and thus in the event
        self.span[members, 0] = np.where(centre + first > 0.0, centre + first, -math.inf)
        self.span[members, 1] = np.where(centre + last < CELLS, centre + last, math.inf)
        own = np.stack([position, position], axis=1)
        if kind.model == "viscous":
            entry = np.array(entries(shape, width, points))
            entered = np.isfinite(self.span[members]) & (entry != 0.0)
            own = np.where(entered, centre[:, None] + entry, own)
        self.edges[members] = own


class _Layers:
    """Layers of events: viscous friction, and bristles and detents if the preset has them."""

    def __init__(self, preset: Preset, under: BaseSurface) -> None:
        self.raised = np.zeros(CELLS + 1)
        self.detents = DetentLayer(preset, under.energy) if has_detents(preset) else None
        self.bristles = BristleLayer(preset, under.friction) if has_bristles(preset) else None

    def lay(
        self,
        kind: EventKind,
        name: str,
        members: IntArray,
        centre: FloatArray,
        height: FloatArray,
        width: float,
    ) -> None:
        """Add the profiles of a kind's events; `members` are their rows, lengths are in cells."""
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

    def _raise(self, profiles: Iterator[tuple[int, int, FloatArray]]) -> None:
        for _, start, bump in profiles:
            there = self.raised[start : start + len(bump)]
            np.maximum(there, bump, out=there)


def _width_cells(kind: EventKind, name: str, duration_s: float) -> float:
    if kind.width_percent is not None:
        return kind.width_percent / 100.0 * CELLS
    assert kind.width_ms is not None
    cells = kind.width_ms / 1000.0 / duration_s * CELLS
    if cells < MIN_WIDTH_CELLS:
        warn(
            f"kinds.{name}.width_ms is {kind.width_ms:g} of {duration_s:g} s, below the surface's "
            f"resolution; widened to {MIN_WIDTH_CELLS / CELLS * duration_s * 1000.0:.3g} ms",
            2,
        )
        return MIN_WIDTH_CELLS
    return min(cells, float(CELLS))


def build_surface(timeline: Timeline, preset: Preset, angle_map: AngleMap | None = None) -> Surface:
    """Build the surface of a timeline and a preset.

    Parameters
    ----------
    timeline : Timeline
        Data of the surface.
    preset : Preset
        Parameters of feel and sound.
    angle_map : AngleMap or None
        Map between time and angle of another surface of the same duration; None
        makes a map of this timeline and preset.

    Returns
    -------
    Surface
        Surface for `Engine`; friction > 0 everywhere.

    Raises
    ------
    InputError
        The pattern has more crests than a surface holds strikes, or the map has another duration.

    Warns
    -----
    OverviewWarning
        Unknown event kinds, which use the preset's `default`; gaps too narrow to be perceived;
        more events than a surface holds (16384), where the strongest event in each cell, or in
        2, 4, ... cells, strikes for all of them.

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
    if angle_map is None:
        angle_map = AngleMap.of(timeline, preset)
    else:
        validation.instance(angle_map, AngleMap, "angle_map", "another surface's angle_map is one")
        if angle_map.duration_s != timeline.duration_s:
            raise InputError(
                f"angle_map is for {angle_map.duration_s:g} s; must be for "
                f"{timeline.duration_s:g} s"
            )
        angle_map = angle_map.on(timeline)
    under = build_base_surface(timeline, preset, CELLS, angle_map)
    crests = len(under.texture_strikes.position)
    capacity = MAX_EVENTS - crests
    if capacity < min(len(felt), 1):
        raise InputError(
            f"the pattern has {crests} crests; crests and events must be at most {MAX_EVENTS}: "
            "make surface.pattern_period_percent longer"
        )
    _warn_of_unknown(timeline.kinds(), preset)
    placed = _Placed(felt, angle_map)
    layers = _Layers(preset, under)
    for name, indices in by_kind.items():
        kind = preset.kinds[name]
        width = _width_cells(kind, name, timeline.duration_s)
        members = np.searchsorted(felt, indices)
        ordinary = preset.number("surface.friction") * kind.height
        height = _heights([timeline.events[i] for i in indices], name, ordinary)
        layers.lay(kind, name, members, placed.centre[members], height, width)
        placed.fill(members, kind, preset, height, width)
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
        tactor=_tactors(timeline, preset, felt[order], placed.kind[order]),
    )


def _tactors(
    timeline: Timeline, preset: Preset, events: IntArray, kinds: IntArray
) -> IntArray | None:
    """Return the tactor of each event by `tactor.routing`; None if its position chooses it."""
    routing = preset.values["tactor.routing"]
    if routing == "position":
        return None
    if routing == "team":
        return np.array([timeline.events[event].side for event in events], dtype=np.int64)
    number = KIND_PARAMETERS["tactor"].choices.index  # all, 1, 2, ...
    return np.array([number(kind.tactor) for kind in preset.kinds.values()])[kinds]


def _felt(events: tuple[Event, ...], preset: Preset) -> tuple[dict[str, IntArray], dict[str, int]]:
    """Return the events' indices by kind of the preset, and the counts of omitted kinds."""
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
        warn(
            f"preset {preset.name!r} has no {', '.join(unknown)}; these events use its kind "
            f"{DEFAULT_KIND!r}; its kinds: {', '.join(preset.kinds)}",
            2,
        )


def _thinned(placed: _Placed, capacity: int, title: str) -> tuple[IntArray, IntArray]:
    """Return the kept rows by position, and for each row the kept one that strikes for it."""
    if len(placed.event) <= capacity:
        order = np.argsort(placed.position, kind="stable")
        return order, np.argsort(order)
    order, stands_for = thin_events(placed.position, placed.release, capacity)
    warn(
        f"{title}: the surface keeps {len(order)} of {len(placed.event)} events; the strongest of "
        "neighbouring events strikes, and friction includes all of them; use a shorter window",
        2,
    )
    return order, stands_for


def _heights(events: list[Event], name: str, ordinary: float) -> FloatArray:
    """Return the highest friction of each event of a kind."""
    heights = []
    for event in events:
        height = ordinary * event.weight
        if height > MAX_FRICTION:
            warn(
                f"{name} at {event.time_s:g} s: weight {event.weight:g} gives more friction than "
                f"a surface holds; lowered to {MAX_FRICTION:g} N·m·s/rad",
                2,
            )
            height = MAX_FRICTION
        heights.append(height)
    return np.array(heights)


def _modes(kind: EventKind) -> tuple[ClickMode, ...]:
    return louder(
        kind.modes or modes_of(kind.material, kind.pitch_hz, kind.decay_scale), kind.gain_db
    )
