"""Torque in addition to viscous friction: bristles, detents and stops.

Bristles of the base surface and of events:

    grip = surface.torque_ratio * viscous friction of the base surface * 1 rad/s     (surface.model)

Events with bristles raise the grip to height * weight * profile * surface.friction * 1 rad/s.
Where profiles overlap, the higher one applies, with the bristles of its kind.

Detents and stops at events and at the ends give torque that is independent of speed:

    U = pattern of the base surface (surface.model detent) - the events' detents + the events' stops

An event with the model `detent` is an energy well with the shape of its profile. An `end_stop` is a
spring over one width before the event that releases behind it. From behind it holds
against eight times as much. The height is the highest pull (of a stop: in upward direction).
Detents that overlap combine by their maximum, and so do stops. Units: U in N m cells (of the
table), pull in N m, so that both are independent of the shaft.

A height thus means the same torque for all models: that of viscous friction at 1 rad/s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.design.presets.model import EventKind, Preset
from overview_dsp.errors import warn
from overview_dsp.signal.surface.profiles import Points, profile, reach

BASE = -1  # owner of positions with the bristles of the base surface
DETENT_MODELS = ("detent", "end_stop")
_FINE = 4096


def warn_of_lockup(preset: Preset, name: str, torque: float, lower: str) -> None:
    """Warn (OverviewWarning) if shaft 2 can never overcome a torque (N m).

    `name` is the key that holds the disk, `lower` the remedy in the message.
    """
    most = preset.number("disk.k2") * math.pi
    if torque >= most:
        warn(
            f"{name}: the disk gets stuck at {torque * 1e3:.3g} mN·m, since shaft 2 pulls with "
            f"{most * 1e3:.3g} mN·m at most; lower {lower}, or raise disk.k2",
            4,
        )


@dataclass(frozen=True)
class Bristles:
    """Parameters of bristles, in their units."""

    stiffness: float
    damping: float
    static_ratio: float
    stribeck_speed: float
    break_away: float

    @classmethod
    def of_kind(cls, kind: EventKind) -> Bristles:
        """Return the bristles of an event kind."""
        return cls(*(getattr(kind, one.name) for one in fields(cls)))

    @classmethod
    def of_surface(cls, preset: Preset) -> Bristles:
        """Return the bristles of the base surface."""
        return cls(*(preset.number(f"surface.{one.name}") for one in fields(cls)))


@dataclass(frozen=True, eq=False)
class BristleField:
    """Bristles of a surface.

    `grip` (CELLS + 1,): sliding torque at the table's points, N m; 0 = no bristles.
    `owner` (CELLS + 1,): owner from each point to the next: index of the surface's event, or
        `BASE`.
    `of_kind`, `bare`: bristles of each kind, and of the base surface.
    """

    grip: FloatArray
    owner: IntArray
    of_kind: tuple[Bristles, ...]
    bare: Bristles


class BristleLayer:
    """Field under construction, event by event."""

    def __init__(self, preset: Preset, ambient: FloatArray) -> None:
        """Start with the base surface, whose viscous friction is `ambient` (N m s/rad)."""
        self._preset = preset
        self._grip = np.zeros(len(ambient))
        if preset.values["surface.model"] == "bristle":
            self._grip = preset.number("surface.torque_ratio") * ambient
            static = self._grip.max() * preset.number("surface.static_ratio")
            warn_of_lockup(preset, "surface.torque_ratio", static, "it or surface.static_ratio")
        self._owner = np.full(len(ambient), BASE)

    def raise_to(self, event: int, first: int, bump: FloatArray) -> None:
        """Raise the grip to an event's profile (N m s/rad) from the point `first` on."""
        here = self._grip[first : first + len(bump)]
        higher = bump > here
        here[higher] = bump[higher]
        self._owner[first : first + len(bump)][higher] = event

    def check(self, name: str, height: FloatArray) -> None:
        """Warn (OverviewWarning) if the disk can never pass the events of a kind."""
        static = height.max() * self._preset.kinds[name].static_ratio
        warn_of_lockup(self._preset, f"kinds.{name}", static, "its height or static_ratio")

    def field(self, number: IntArray) -> BristleField:
        """Return the field; `number` maps events to their index in the surface."""
        return BristleField(
            self._grip,
            np.append(number, BASE)[self._owner],
            tuple(Bristles.of_kind(kind) for kind in self._preset.kinds.values()),
            Bristles.of_surface(self._preset),
        )


def has_bristles(preset: Preset) -> bool:
    """Return whether a preset has bristles."""
    models = [kind.model for kind in preset.kinds.values()]
    return "bristle" in (preset.values["surface.model"], *models)


@dataclass(frozen=True, eq=False)
class DetentField:
    """Detents of a surface.

    `pull` (CELLS + 1,): torque against the disk at the table's points, N m; positive upwards.
    `energy` (CELLS + 1,): integral of the pull from the start, N m cells.
    `end_stiffness`, `end_damping`: springs beyond the ends, N m/rad and N m s/rad.
    """

    pull: FloatArray
    energy: FloatArray
    end_stiffness: float
    end_damping: float


class DetentLayer:
    """Field under construction, event by event."""

    def __init__(self, preset: Preset, under: FloatArray) -> None:
        """Start with the energy of the base surface (N m cells)."""
        self._preset = preset
        self._under = under
        self._deep = np.zeros(len(under))
        self._high = np.zeros(len(under))

    def check(self, name: str, height: FloatArray) -> None:
        """Warn (OverviewWarning) if the disk can never pass events of this pull."""
        warn_of_lockup(self._preset, f"kinds.{name}", height.max(), "its height")

    def lay(self, model: str, start: int, bump: FloatArray) -> None:
        """Add an event's well or stop (N m cells) from the point `start` on."""
        table = self._deep if model == "detent" else self._high
        there = table[start : start + len(bump)]
        np.maximum(there, bump, out=there)

    def field(self) -> DetentField:
        """Return the field."""
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
    """Return whether a preset has detents or stops."""
    models = {preset.values["surface.model"], *(kind.model for kind in preset.kinds.values())}
    return not models.isdisjoint(DETENT_MODELS) or preset.number("surface.end_stiffness") > 0.0


def shape_of(kind: EventKind) -> tuple[str, Points]:
    """Return shape and points of a kind's profile of friction or energy."""
    return ("stop", ()) if kind.model == "end_stop" else (kind.shape, kind.points)


def energy_of(pull: float, shape: str, points: Points, width: float) -> float:
    """Return the height (N m cells) of a profile of a width (cells) and highest pull (N m)."""
    far = reach(shape, points) * width
    # only the upward direction counts for a stop
    places = np.linspace(-far, 0.0 if shape == "stop" else far, _FINE)
    steepest = np.abs(np.gradient(profile(shape, places, width, points), places)).max()
    return pull / float(steepest)


def impedance(preset: Preset, pull: float, cells: float, table: int) -> float:
    """Return the torque per speed (N m s/rad) that a well takes from a disk at its bottom.

    sqrt(stiffness * inertia) of a well whose pull is reached `cells` of a `table` from its bottom.
    """
    k1, k2 = preset.number("disk.k1"), preset.number("disk.k2")
    angle = cells / table * math.pi * k2 / (k1 + k2)
    return math.sqrt(pull / angle * preset.number("disk.inertia"))
