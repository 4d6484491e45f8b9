"""Torque beside viscous friction: bristles that grip the disk, detents and stops that pull it.

Bristles, of the bare surface and of events:

    grip = surface.torque_ratio * viscous friction of the bare surface * 1 rad/s     (surface.model)

raised by events whose kind has bristles to height * weight * profile * surface.friction * 1 rad/s.
Where profiles overlap the higher one is felt, with bristles of its own kind.

Detents that the disk clicks into and stops, at events and at the ends: torque that knows no speed.

    U = pattern of the bare surface (surface.model detent) - the events' detents + the events' stops

A kind with the model `detent` is a well of its profile's shape; one with `end_stop` a stop: pressed
upon from before the event, a spring over one width, which lets go behind it; from behind it holds
against eight times as much. A height is the greatest pull here (of a stop: on its way up). Detents
that overlap combine by their maximum, stops too. Units: U in N m cells (of the table), pull in N m,
so that both hold for any shaft.

A height thus means the same torque, whichever model: what viscous friction has at 1 rad/s.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from overview_dsp.design.presets.model import EventKind, Preset
from overview_dsp.errors import OverviewWarning
from overview_dsp.signal.surface.profiles import Points, profile, reach

Array = NDArray[np.float64]

BARE = -1
"""Owner of a position whose bristles are the bare surface's."""

DETENT_MODELS = ("detent", "end_stop")
_FINE = 4096


def warn_of_lockup(preset: Preset, name: str, torque: float, lower: str) -> None:
    """Warn (OverviewWarning) if a torque (N m) can never be overcome by the finger's shaft.

    `name` is what holds, `lower` what to lower.
    """
    most = preset.number("disk.k2") * math.pi
    if torque >= most:
        warnings.warn(
            f"{name} holds the disk against {torque * 1e3:.3g} mN·m, and shaft 2 pulls with "
            f"{most * 1e3:.3g} mN·m at most: stuck there it stays; lower {lower}, or raise disk.k2",
            OverviewWarning,
            stacklevel=5,
        )


@dataclass(frozen=True)
class Bristles:
    """What bristles are like, in the parameters' own units."""

    stiffness: float
    damping: float
    static_ratio: float
    stribeck_speed: float
    break_away: float

    @classmethod
    def of_kind(cls, kind: EventKind) -> Bristles:
        """Return a kind's."""
        return cls(*(getattr(kind, one.name) for one in fields(cls)))

    @classmethod
    def of_surface(cls, preset: Preset) -> Bristles:
        """Return the bare surface's."""
        return cls(*(preset.number(f"surface.{one.name}") for one in fields(cls)))


@dataclass(frozen=True, eq=False)
class BristleField:
    """Bristles over a surface.

    Attributes
    ----------
    grip : float64 (CELLS + 1,)
        Sliding torque at the table's points, N m; 0 = no bristles.
    owner : int64 (CELLS + 1,)
        Whose they are from a point to the next: index of the surface's event, or `BARE`.
    of_kind : tuple of Bristles
        Of each of the surface's kinds.
    bare : Bristles
    """

    grip: NDArray[np.float64]
    owner: NDArray[np.int64]
    of_kind: tuple[Bristles, ...]
    bare: Bristles


class BristleLayer:
    """A field while it is laid, event by event."""

    def __init__(self, preset: Preset, ambient: NDArray[np.float64]) -> None:
        """Start with the bare surface, whose viscous friction is `ambient` (N m s/rad)."""
        self._preset = preset
        self._grip = np.zeros(len(ambient))
        if preset.values["surface.model"] == "bristle":
            self._grip = preset.number("surface.torque_ratio") * ambient
            static = self._grip.max() * preset.number("surface.static_ratio")
            warn_of_lockup(preset, "surface.torque_ratio", static, "it or surface.static_ratio")
        self._owner = np.full(len(ambient), BARE)

    def raise_to(self, event: int, first: int, bump: NDArray[np.float64]) -> None:
        """Raise the grip to an event's profile (N m s/rad) from the point `first` on."""
        here = self._grip[first : first + len(bump)]
        higher = bump > here
        here[higher] = bump[higher]
        self._owner[first : first + len(bump)][higher] = event

    def check(self, name: str, height: NDArray[np.float64]) -> None:
        """Warn (OverviewWarning) if events of a kind can never be passed."""
        static = height.max() * self._preset.kinds[name].static_ratio
        warn_of_lockup(self._preset, f"kinds.{name}", static, "its height or static_ratio")

    def field(self, number: NDArray[np.int64]) -> BristleField:
        """The field; `number` gives the events the numbers they have in the surface."""
        return BristleField(
            self._grip,
            np.append(number, BARE)[self._owner],
            tuple(Bristles.of_kind(kind) for kind in self._preset.kinds.values()),
            Bristles.of_surface(self._preset),
        )


def has_bristles(preset: Preset) -> bool:
    """Whether a preset has any."""
    models = [kind.model for kind in preset.kinds.values()]
    return "bristle" in (preset.values["surface.model"], *models)


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
