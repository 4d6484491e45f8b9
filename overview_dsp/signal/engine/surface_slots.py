"""Surface slots: write surfaces to the memory block and map its strikes back to events.

The kernel's log stores the number of an event within the surface of that time. `SurfaceHistory`
finds the surface and the event.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING

import numpy as np

from overview_dsp.arrays import BoolArray, FloatArray, IntArray
from overview_dsp.kernels import layout
from overview_dsp.kernels.derive import derive_clicks
from overview_dsp.signal.surface.fields import BASE, BristleField, DetentField
from overview_dsp.signal.surface.model import Surface

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Timeline

MOST = 256  # number of surfaces remembered; older strikes are attributed to the base surface

STEEP = 0.2
"""Change of friction between neighbouring cells, relative to the base surface, that is steep."""

_STRIKES = {
    "viscous": layout.STRIKE_BY_APPROACH,
    "bristle": layout.STRIKE_BY_TORQUE,
    "detent": layout.STRIKE_BY_SPEED,
    "end_stop": layout.STRIKE_BY_TORQUE,
}


def write_surface(m: FloatArray, slot: int, surface: Surface) -> None:
    """Write a surface's friction, events and clicks to slot 0, 1 or 2 of the block `m`.

    The sample rate must be in the block.
    """
    w = m.view(np.int64)
    base = layout.SURFACES + slot * layout.SLOT_SIZE
    table = m[base + layout.SLOT_TABLE :][: 2 * (layout.CELLS + 1)]
    _write_table(table, surface.friction)
    mean = 0.5 * (surface.friction[1:] + surface.friction[:-1])
    m[base + layout.SLOT_INTEGRAL] = 0.0
    m[base + layout.SLOT_INTEGRAL + 1 :][: layout.CELLS] = np.cumsum(mean)
    w[base + layout.SLOT_STEEP :][: layout.CELLS // layout.STEEP_BLOCK + 1] = _steep(surface)
    order = _strike_order(surface)
    count = len(order)
    w[base + layout.SLOT_EVENTS] = count
    crests = surface.texture_strikes.position
    edges = np.concatenate([surface.edges, np.stack([crests, crests], axis=1)])[order]
    for side, edge, event in (
        (0, layout.SLOT_LOWER, layout.SLOT_LOWER_EVENT),
        (1, layout.SLOT_UPPER, layout.SLOT_UPPER_EVENT),
    ):
        ascending = np.argsort(edges[:, side], kind="stable")
        m[base + edge :][:count] = edges[ascending, side] * layout.CELLS
        w[base + event :][:count] = ascending
    release = np.concatenate([surface.release, surface.texture_strikes.release])
    m[base + layout.SLOT_RELEASE :][:count] = release[order]
    own = np.full(len(surface.texture_strikes.position), layout.MAX_KINDS)
    w[base + layout.SLOT_KIND :][:count] = np.concatenate([surface.kind, own])[order]
    w[base + layout.SLOT_MODELS] = 0
    m[base + layout.SLOT_HOLD] = 0.0
    for bank, model in [*enumerate(surface.kind_models), (layout.MAX_KINDS, surface.own_model)]:
        row = base + layout.BRISTLES + bank * layout.BRISTLE_PARAMETERS
        w[row + layout.P_STRIKE] = _STRIKES[model]
    if surface.detents is not None:
        _write_detents(m, base, surface.detents)
    if surface.bristles is not None:
        rank = np.append(np.argsort(order), BASE)
        _write_bristles(m, base, surface.bristles, rank)
    _write_clicks(m, base, surface)
    derive_clicks(m, w, base)


def timeline_events(surface: Surface) -> IntArray:
    """Return the timeline's events by the kernel's event numbers; `BASE` is the base surface.

    The last entry is the base surface, too.
    """
    own = np.full(len(surface.texture_strikes.position), BASE)
    return np.append(np.concatenate([surface.event, own])[_strike_order(surface)], BASE)


def _strike_order(surface: Surface) -> IntArray:
    """Return the order of positions of the surface's events followed by its texture strikes."""
    position = np.concatenate([surface.position, surface.texture_strikes.position])
    return np.argsort(position, kind="stable")


def _steep(surface: Surface) -> BoolArray:
    """Return for each block of cells whether it or a neighbour has a steep edge."""
    friction = surface.friction
    cells = np.flatnonzero(np.abs(np.diff(friction)) > STEEP * friction.min())
    edges = np.zeros(layout.CELLS // layout.STEEP_BLOCK + 1, dtype=bool)
    edges[cells // layout.STEEP_BLOCK] = True
    found = edges.copy()
    found[1:] |= edges[:-1]
    found[:-1] |= edges[1:]
    return found


def _write_table(table: FloatArray, values: FloatArray) -> None:
    """Write values at the table's points, interleaved with the slopes between them."""
    table[0::2] = values
    table[1:-1:2] = np.diff(values)
    table[-1] = 0.0


def _write_clicks(m: FloatArray, base: int, surface: Surface) -> None:
    """Write the clicks of each kind and of the base surface."""
    w = m.view(np.int64)
    w[base + layout.KIND_CLICK :][: layout.BANKS] = 0
    for kind, modes in [*enumerate(surface.kind_modes), (layout.MAX_KINDS, surface.own_modes)]:
        w[base + layout.KIND_CLICK + kind] = len(modes)
        at = base + layout.CLICKS + kind * layout.MAX_MODES * layout.CLICK_SIZE
        for mode in modes:
            m[at + layout.CLICK_FREQUENCY_HZ] = mode.frequency_hz
            m[at + layout.CLICK_DECAY_MS] = mode.decay_ms
            m[at + layout.CLICK_GAIN_DB] = mode.gain_db
            at += layout.CLICK_SIZE


def _write_bristles(m: FloatArray, base: int, field: BristleField, rank: IntArray) -> None:
    w = m.view(np.int64)
    w[base + layout.SLOT_MODELS] |= layout.HAS_BRISTLES
    _write_table(m[base + layout.SLOT_SLIDING_TORQUE :][: 2 * (layout.CELLS + 1)], field.grip)
    w[base + layout.SLOT_OWNER :][: layout.CELLS + 1] = rank[field.owner]
    stuck = max(kind.static_ratio for kind in (*field.of_kind, field.bare))
    m[base + layout.SLOT_HOLD] += float(field.grip.max()) * stuck
    for bank, bristles in [*enumerate(field.of_kind), (layout.MAX_KINDS, field.bare)]:
        row = base + layout.BRISTLES + bank * layout.BRISTLE_PARAMETERS
        # the columns are in the order of the fields
        m[row + layout.P_STIFFNESS : row + layout.P_BREAK_AWAY + 1] = astuple(bristles)


def _write_detents(m: FloatArray, base: int, field: DetentField) -> None:
    m.view(np.int64)[base + layout.SLOT_MODELS] |= layout.HAS_DETENTS
    _write_table(m[base + layout.SLOT_PULL :][: 2 * (layout.CELLS + 1)], field.pull)
    m[base + layout.SLOT_DETENT_ENERGY :][: layout.CELLS + 1] = field.energy
    m[base + layout.SLOT_END_STIFFNESS] = field.end_stiffness
    m[base + layout.SLOT_END_DAMPING] = field.end_damping
    m[base + layout.SLOT_HOLD] += float(np.abs(field.pull).max())


@dataclass
class _PastSurface:
    change: int  # number of the change to it, for `ControlQueues.applied_at`
    sample: int | None  # first sample of its use; None while it is pending
    events: IntArray  # of `timeline_events`
    timeline: Timeline


class SurfaceHistory:
    """Surfaces in use since the last call that read strikes.

    Thread: one that changes surfaces, one that reads strikes.
    """

    def __init__(self, applied_at: Callable[[int], int | None]) -> None:
        self._applied_at = applied_at
        self._surfaces: deque[_PastSurface] = deque(maxlen=MOST)
        self._lock = threading.Lock()  # never taken by the audio thread

    def reset(self, surface: Surface, timeline: Timeline) -> None:
        """Clear the history and start with a surface."""
        with self._lock:
            self._surfaces.clear()
            self._surfaces.append(_PastSurface(-1, 0, timeline_events(surface), timeline))

    def add(self, change: int, surface: Surface, timeline: Timeline) -> None:
        """Add the surface of a pushed change."""
        with self._lock:
            self._resolve()  # before the queue forgets it
            self._surfaces.append(_PastSurface(change, None, timeline_events(surface), timeline))

    def _resolve(self) -> None:
        for one in self._surfaces:
            if one.sample is None:
                one.sample = self._applied_at(one.change)

    def find(
        self, numbers: IntArray, times: FloatArray, now: int
    ) -> tuple[IntArray, list[Timeline | None]]:
        """Return events and timelines of strikes from their numbers and times (samples).

        An event of -1 is the base surface. Later calls get strikes from sample `now` on.
        """
        with self._lock:
            self._resolve()
            under = [one for one in self._surfaces if one.sample is not None]
            starts = np.array([one.sample for one in under])
            which = np.searchsorted(starts, times, side="right") - 1
            events = np.full(len(numbers), -1, dtype=np.int64)
            timelines: list[Timeline | None] = [None] * len(numbers)
            for index in np.unique(which[which >= 0]):
                mine = np.flatnonzero(which == index)
                known = under[index].events
                events[mine] = known[np.minimum(numbers[mine], len(known) - 1)]
                for i in mine:
                    timelines[i] = under[index].timeline
            while len(self._surfaces) > 1:
                following = self._surfaces[1].sample
                if following is None or following > now:
                    break
                self._surfaces.popleft()
        return events, timelines
