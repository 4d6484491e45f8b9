"""Where bristles grip the disk, how hard, and what they are like: of the bare surface, of events.

    grip = surface.grip * viscous friction of the bare surface * 1 rad/s     (surface.model)

raised by events whose kind has bristles to height * weight * profile * surface.friction * 1 rad/s.

A height thus means the same torque, whichever model: what viscous friction has at 1 rad/s. Where
profiles overlap the higher one is felt, with bristles of its own kind.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.design.presets.model import EventKind, Preset
from overview_dsp.signal.surface.lockup import warn_of_lockup

BARE = -1
"""Owner of a position whose bristles are the bare surface's."""


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
        """A kind's."""
        return cls(
            kind.stiffness,
            kind.damping,
            kind.static_ratio,
            kind.stribeck_speed,
            kind.break_away,
        )

    @classmethod
    def of_surface(cls, preset: Preset) -> Bristles:
        """The bare surface's."""
        number = preset.number
        return cls(
            number("surface.stiffness"),
            number("surface.damping"),
            number("surface.static_ratio"),
            number("surface.stribeck_speed"),
            number("surface.break_away"),
        )


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
            self._grip = preset.number("surface.grip") * ambient
            static = self._grip.max() * preset.number("surface.static_ratio")
            warn_of_lockup(preset, "surface.grip", static, "it or surface.static_ratio")
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
