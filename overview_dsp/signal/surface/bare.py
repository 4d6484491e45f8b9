"""The surface before any event: friction that follows the curve, its pattern, ribs in the gaps.

    B = friction * ((1 + ambience)**intensity + pattern_height * pattern)

The intensity is the timeline's curve scaled to 0..1, mixed with its rank (`surface.rank`), through
the preset's map (`points`) where it has one. Equal steps of it are equal ratios of friction, which
a finger takes for equal steps (Weber's law). Where data is missing there are ribs instead
(`gaps.ribs`), and what hasn't happened yet is smooth and heavy (`future`). With the model `detent`
the pattern is detents in place of friction, deeper where there is more of it (a period's mean); in
a gap and in the future there are none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from overview_dsp.design.presets.model import ClickMode, Preset
from overview_dsp.signal.surface.angle_map import AngleMap
from overview_dsp.signal.surface.detents import impedance
from overview_dsp.signal.surface.future import heaviness, rise
from overview_dsp.signal.surface.gaps import pattern, ribs
from overview_dsp.signal.surface.lockup import warn_of_lockup
from overview_dsp.signal.surface.materials import louder, modes_of
from overview_dsp.signal.surface.rank import known_levels, mixed_with_rank
from overview_dsp.signal.surface.texture_strikes import NONE, TextureStrikes, crests_of, troughs_of

if TYPE_CHECKING:
    from overview_dsp.data.timeline import Timeline


Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BareSurface:
    """The bare surface.

    Attributes
    ----------
    friction : float64 (cells + 1,)
        Viscous friction at the table's points, N m s/rad.
    energy : float64 (cells + 1,)
        Of its detents, N m cells (`well_field`).
    modes : tuple of ClickMode
        What it sounds like.
    texture_strikes : TextureStrikes
        Where it is struck.
    """

    friction: NDArray[np.float64]
    energy: NDArray[np.float64]
    modes: tuple[ClickMode, ...]
    texture_strikes: TextureStrikes


def bare_surface(
    timeline: Timeline, preset: Preset, cells: int, angle_map: AngleMap
) -> BareSurface:
    """The bare surface of a timeline under a preset, on a table of cells + 1 points.

    Warns (OverviewWarning) of gaps too narrow to be felt.
    """
    number = preset.number
    bare, model = number("surface.friction"), preset.values["surface.model"]
    intensity, rise_of_mean = _intensity(timeline, preset, cells, angle_map)
    steepness = math.log1p(number("surface.ambience"))
    loud = np.exp(steepness * intensity)
    ground = bare
    if rise_of_mean:  # the rank keeps the mean of log B, and ribs stand on its lowest level
        bare *= math.exp(-steepness * rise_of_mean)
        ground = bare * loud.min()
    friction = bare * loud
    made_of = str(preset.values["surface.pattern"])
    period = number("surface.pattern_period_percent")
    course = pattern(made_of, cells, period)
    top = bare * number("surface.pattern_height")
    if made_of != "none" and model != "detent":
        friction += top * course
    known = np.ones(cells + 1)
    if timeline.gaps:
        missing, ribbed = ribs(
            tuple((start, end) for start, end in angle_map.evened(timeline.gaps).tolist()),
            timeline.duration_s,
            cells,
            number("surface.gap_height"),
            number("surface.gap_period_percent"),
        )
        # ribs stand out of the pattern too
        friction[missing] = ribbed * (ground + (top if made_of != "none" else 0.0))
        known[missing] = 0.0
    if timeline.until_s is not None:
        heavy = number("surface.friction") * heaviness(number("surface.ambience"))
        begun = rise(float(angle_map.position_of(timeline.until_s)), cells)
        friction += begun * (heavy - friction)
        friction[begun == 1.0] = heavy  # to the bit, whatever the past: a page is not sent it anew
        known[begun > 0.0] = 0.0
    material = str(preset.values["surface.material"])
    free = modes_of(material, number("surface.pitch_hz"), number("surface.ring"))
    modes = louder(free, number("surface.gain_db"))
    energy = np.zeros(cells + 1)
    strikes = NONE
    if model == "detent":
        pull = number("surface.grip") * bare
        warn_of_lockup(preset, "surface.grip", pull * loud.max(), "it")
        width = period / 100.0 * cells
        energy = _detents(course, pull, width, loud * known)
        if modes and pull > 0.0:
            strikes = troughs_of(course * known, impedance(preset, pull, width / 4.0, cells))
    elif modes:
        grip = number("surface.grip") if model == "bristle" else 1.0
        strikes = crests_of(course * known, grip * top)
    return BareSurface(friction, energy, modes, strikes)


def _intensity(
    timeline: Timeline, preset: Preset, cells: int, angle_map: AngleMap
) -> tuple[Array, float]:
    """The curve at the table's points as it is felt, and by how much its rank raises the mean."""
    even = timeline.normalised_levels(cells)
    plain = felt = angle_map.at_even_positions(even)
    share = preset.number("surface.rank_share")
    if share > 0.0:
        felt = mixed_with_rank(plain, known_levels(timeline, even), share)
    if preset.points:
        steps = np.linspace(0.0, 1.0, len(preset.points))
        plain, felt = (np.interp(levels, steps, preset.points) for levels in (plain, felt))
    return felt, float((felt - plain).mean()) if share > 0.0 else 0.0


def _detents(course: Array, pull: float, period: float, loud: Array) -> Array:
    """Energy (N m cells) of detents whose steepest slope pulls with `pull` N m where loud is 1."""
    steepest = float(np.abs(np.gradient(course)).max())
    if steepest == 0.0:
        return np.zeros(len(course))
    positions = np.arange(len(course))
    # constant over a period, so that a quick curve makes no detents of its own
    number = (positions / period).astype(np.int64)
    means = np.bincount(number, loud) / np.bincount(number)
    centres = (np.arange(len(means)) + 0.5) * period
    return pull / steepest * course * np.interp(positions, centres, means)
