"""Detents the disk clicks into, hills that stop it, stops at the ends: torque that knows no speed.

    U = pattern of the bare surface (surface.model detent) - the events' detents + the events' stops

A kind with the model `detent` is a well of its profile's shape; one with `end_stop` a stop: pressed
upon from before the event, a spring over one width, which lets go behind it; from behind it holds
against eight times as much. A height means the same torque, whichever model: what viscous friction
has at 1 rad/s; here it is the greatest pull (of a stop: on its way up). Detents that overlap
combine by their maximum, stops too.

Units: U in N m cells (of the table), pull in N m, so that both hold for any shaft.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.design.presets.model import EventKind, Preset
from overview_dsp.signal.surface.lockup import warn_of_lockup
from overview_dsp.signal.surface.profiles import Points, profile, reach

Array = NDArray[np.float64]

DETENT_MODELS = ("detent", "end_stop")
_FINE = 4096


@dataclass(frozen=True, eq=False)
class DetentField:
    """Detents over a surface.

    Attributes
    ----------
    pull : float64 (CELLS + 1,)
        Torque against the disk at the table's points, N m; its sign is that of the way up.
    energy : float64 (CELLS + 1,)
        Its integral from the start, N m cells.
    end_stiffness, end_damping : float
        Of the springs beyond the ends, N m/rad and N m s/rad.
    """

    pull: Array
    energy: Array
    end_stiffness: float
    end_damping: float


class DetentLayer:
    """A field while it is laid, event by event."""

    def __init__(self, preset: Preset, under: Array) -> None:
        """Start with the bare surface's own energy (N m cells)."""
        self._preset = preset
        self._under = under
        self._deep = np.zeros(len(under))
        self._high = np.zeros(len(under))

    def check(self, name: str, height: Array) -> None:
        """Warn (OverviewWarning) if events of a kind, whose pull is given, hold for good."""
        warn_of_lockup(self._preset, f"kinds.{name}", height.max(), "its height")

    def lay(self, model: str, start: int, bump: Array) -> None:
        """Lay an event's well or stop (N m cells) from the point `start` on."""
        table = self._deep if model == "detent" else self._high
        there = table[start : start + len(bump)]
        np.maximum(there, bump, out=there)

    def field(self) -> DetentField:
        """The field."""
        energy = self._under + self._high - self._deep
        pull = np.gradient(energy)
        between = 0.5 * (pull[1:] + pull[:-1])
        stiffness = self._preset.number("surface.end_stiffness")
        return DetentField(
            pull,
            np.concatenate([[0.0], np.cumsum(between)]),
            stiffness,
            self._preset.number("surface.end_damping") if stiffness > 0.0 else 0.0,
        )


def has_detents(preset: Preset) -> bool:
    """Whether a preset has detents or stops."""
    models = {preset.values["surface.model"], *(kind.model for kind in preset.kinds.values())}
    return not models.isdisjoint(DETENT_MODELS) or preset.number("surface.end_stiffness") > 0.0


def shape_of(kind: EventKind) -> tuple[str, Points]:
    """The shape and the points of a kind's profile: of its friction, or of its energy."""
    return ("stop", ()) if kind.model == "end_stop" else (kind.shape, kind.points)


def energy_of(pull: float, shape: str, points: Points, width: float) -> float:
    """Height (N m cells) of a profile of some width (cells) whose greatest pull is given (N m)."""
    far = reach(shape, points) * width
    # a stop's pull is that of its way up
    places = np.linspace(-far, 0.0 if shape == "stop" else far, _FINE)
    steepest = np.abs(np.gradient(profile(shape, places, width, points), places)).max()
    return pull / float(steepest)


def impedance(preset: Preset, pull: float, cells: float, table: int) -> float:
    """Torque per speed (N m s/rad) that a well takes from a disk at its bottom.

    sqrt(stiffness * inertia) of a well whose pull is reached `cells` of a `table` from its bottom.
    """
    k1, k2 = preset.number("disk.k1"), preset.number("disk.k2")
    angle = cells / table * math.pi * k2 / (k1 + k2)
    return math.sqrt(pull / angle * preset.number("disk.inertia"))
