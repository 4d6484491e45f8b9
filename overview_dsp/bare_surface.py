"""The surface before any event: friction that follows the curve, its pattern, ribs in the gaps.

    B = friction * (1 + ambience * intensity + pattern_height * pattern)

The intensity is the timeline's curve scaled to 0..1; where data is missing there are ribs instead
(`gap_ribs`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from overview_dsp.gap_ribs import ribs
from overview_dsp.impacts import NONE, Impacts, impacts_of
from overview_dsp.materials import louder, modes_of
from overview_dsp.presets.model import Mode, Preset
from overview_dsp.surface_pattern import pattern

if TYPE_CHECKING:
    from overview_dsp.timeline import Timeline


@dataclass(frozen=True, eq=False)
class BareSurface:
    """Its friction at the table's points (N m s/rad), what it sounds like, where it is struck."""

    friction: NDArray[np.float64]
    modes: tuple[Mode, ...]
    impacts: Impacts


def bare_surface(timeline: Timeline, preset: Preset, cells: int) -> BareSurface:
    """The bare surface of a timeline under a preset, on a table of cells + 1 points.

    Warns (OverviewWarning) of gaps too narrow to be felt.
    """
    bare = preset.number("surface.friction")
    intensity = timeline.normalised_levels(cells)
    friction = bare * (1.0 + preset.number("surface.ambience") * intensity)
    material = str(preset.values["surface.material"])
    modes = louder(
        modes_of(material, preset.number("surface.pitch_hz"), preset.number("surface.ring")),
        preset.number("surface.gain_db"),
    )
    made_of = str(preset.values["surface.pattern"])
    top = bare * preset.number("surface.pattern_height")
    course = np.zeros(cells + 1)
    if made_of != "none":
        course = pattern(made_of, cells, preset.number("surface.pattern_period_percent"))
        friction += top * course
    if timeline.gaps:
        missing, ribbed = ribs(
            timeline.gaps,
            timeline.duration_s,
            cells,
            preset.number("surface.gap_height"),
            preset.number("surface.gap_period_percent"),
        )
        friction[missing] = bare * ribbed
        course[missing] = 0.0
    return BareSurface(friction, modes, impacts_of(course, top) if modes else NONE)
