"""Timeline + preset -> surface: the friction table B(phi) and the event table.

    B = friction * (1 + ambience * intensity + pattern)
        + max over events of height * weight * profile

The intensity is the timeline's curve scaled to 0..1; where data is missing there are ribs instead
(`gap_ribs`). Overlapping profiles combine by their maximum,
so that none is drowned in a sum and each stays findable; every event keeps a strike of its own.

A kind whose events lie denser than its `spacing_percent` is left out as a whole: a thousand beats
of a heart would be one blur. A window that spreads them brings them up.

An event strikes at its place. One nearer than half its width to an end of the timeline strikes half
its width from that end, where its profile lets the disk go: a hand can pass it there.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError, OverviewWarning
from overview_dsp.gap_ribs import ribs
from overview_dsp.presets.model import DEFAULT_KIND, Kind, Mode, Preset
from overview_dsp.profiles import Points, profile, reach, span
from overview_dsp.surface_pattern import pattern

if TYPE_CHECKING:
    from overview_dsp.timeline import Event, Timeline

CELLS = 65536
"""Cells of the table; `kernels.layout.CELLS` is the same number (a test holds them together)."""

MAX_EVENTS = 16384
MAX_FRICTION = 1e6
"""No event is higher, N m s/rad, however great its weight: ten million bare surfaces' friction."""

AT_A_TIME = 1 << 17
"""Points of profiles worked out at once."""

MIN_WIDTH_CELLS = 4.0
"""A profile narrower than this would fall between the table's points."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface with friction, ready for the engine.

    Attributes
    ----------
    friction : float64 (CELLS + 1,)
        B at equal steps of the surface angle phi from 0 to pi, N m s/rad; > 0.
    place : float64 (events,)
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
    """

    friction: NDArray[np.float64]
    place: NDArray[np.float64]
    release: NDArray[np.float64]
    kind: NDArray[np.int64]
    event: NDArray[np.int64]
    span: NDArray[np.float64]
    kind_names: tuple[str, ...]
    kind_modes: tuple[tuple[Mode, ...], ...]
    left_out: Mapping[str, int] = field(default_factory=dict)

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

    Warns (OverviewWarning) of event kinds the preset doesn't name, which take its `default`, and
    of gaps too narrow to be felt.

    Raises
    ------
    InputError
        More events than the surface has cells.
    """
    by_kind = _by_felt_kind(timeline.events, preset)
    left_out = {
        name: len(by_kind.pop(name))
        for name, members in list(by_kind.items())
        if len(members) > 1 and len(members) * preset.kinds[name].spacing_percent > 100.0
    }
    felt = np.sort(np.concatenate([np.zeros(0, np.int64), *by_kind.values()]))
    if len(felt) > MAX_EVENTS:
        raise InputError(
            f"{timeline.title or 'the timeline'}: {len(felt)} events; "
            f"a surface holds up to {MAX_EVENTS}, use a shorter window"
        )
    bare = preset.number("surface.friction")
    intensity = timeline.normalised_levels(CELLS)
    ambient = bare * (1.0 + preset.number("surface.ambience") * intensity)
    made_of = preset.values["surface.pattern"]
    if made_of != "none":
        period = preset.number("surface.pattern_period_percent")
        ridge = bare * preset.number("surface.pattern_height")
        ambient += ridge * pattern(str(made_of), CELLS, period)
    if timeline.gaps:
        missing, friction = ribs(
            timeline.gaps,
            timeline.duration_s,
            CELLS,
            preset.number("surface.gap_height"),
            preset.number("surface.gap_period_percent"),
        )
        ambient[missing] = bare * friction

    unknown = sorted({event.kind for event in timeline.events} - set(preset.kinds))
    if unknown:
        warnings.warn(
            f"preset {preset.name!r} has no {', '.join(unknown)}: felt as its "
            f"{DEFAULT_KIND!r}; it names {', '.join(preset.kinds)}",
            OverviewWarning,
            stacklevel=2,
        )
    names = tuple(preset.kinds)
    count = len(felt)
    place = np.zeros(count)
    release = np.zeros(count)
    kind_index = np.zeros(count, dtype=np.int64)
    spans = np.zeros((count, 2))
    raised = np.zeros(CELLS + 1)
    centres = np.array([timeline.events[i].time_s for i in felt]) / timeline.duration_s * CELLS
    for name, indices in by_kind.items():
        kind = preset.kinds[name]
        width = _width_cells(kind, name, timeline.duration_s)
        members = np.searchsorted(felt, indices)
        centre = centres[members]
        height = _heights([timeline.events[i] for i in indices], name, bare * kind.height)
        _raise(raised, kind.shape, kind.points, width, centre, height)
        margin = min(width, CELLS) / 2.0
        place[members] = np.minimum(np.maximum(centre, margin), CELLS - margin)
        there = profile(kind.shape, place[members] - centre, width, kind.points)
        # a ramp that falls towards its end of the timeline is over half a width from it
        release[members] = height * np.maximum(there, 0.5)
        first, last = span(kind.shape, width, kind.points)
        # past an end the look-up stays at the end, and with it in the event
        spans[members, 0] = np.where(centre + first > 0.0, centre + first, -math.inf)
        spans[members, 1] = np.where(centre + last < CELLS, centre + last, math.inf)
        kind_index[members] = names.index(name)

    order = np.argsort(place, kind="stable")
    return Surface(
        friction=ambient + raised,
        place=place[order] / CELLS,
        release=release[order],
        kind=kind_index[order],
        event=felt[order],
        span=spans[order] / CELLS,
        kind_names=names,
        kind_modes=tuple(_modes(preset.kinds[name]) for name in names),
        left_out=left_out,
    )


def _by_felt_kind(events: tuple[Event, ...], preset: Preset) -> dict[str, NDArray[np.int64]]:
    """The indices of the events that take each of the preset's kinds."""
    found: dict[str, list[int]] = {}
    for i, event in enumerate(events):
        name = event.kind if event.kind in preset.kinds else DEFAULT_KIND
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
    table: NDArray[np.float64],
    shape: str,
    points: Points,
    width: float,
    centre: NDArray[np.float64],
    height: NDArray[np.float64],
) -> None:
    """Raise the table to the profiles of events of one shape and width (cells)."""
    most = reach(shape, points) * width
    low = np.floor(centre - most)
    steps = np.arange(math.ceil(2.0 * most) + 2)
    begin = np.maximum(low, 0.0).astype(np.int64)
    end = np.minimum(np.ceil(centre + most), CELLS).astype(np.int64) + 1
    skipped = begin - low.astype(np.int64)
    rows = max(1, AT_A_TIME // len(steps))
    for start in range(0, len(centre), rows):
        some = slice(start, start + rows)
        distance = low[some, None] + steps - centre[some, None]
        bumps = height[some, None] * profile(shape, distance, width, points)
        for bump, a, b, skip in zip(bumps, begin[some], end[some], skipped[some], strict=True):
            np.maximum(table[a:b], bump[skip : skip + b - a], out=table[a:b])


def _modes(kind: Kind) -> tuple[Mode, ...]:
    return tuple(
        Mode(mode.frequency_hz, mode.decay_ms, mode.gain_db + kind.gain_db) for mode in kind.modes
    )
