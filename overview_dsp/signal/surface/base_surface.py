"""Base surface without events: friction from the intensity curve, a pattern, ribs in gaps.

    B = friction * ((1 + intensity_gain)**intensity + pattern_height * pattern)

With `pattern_grows` this pattern is multiplied by the curve's own ratio, so that its ribs are as
strong, relative to the friction around them, at a high value as at a low one:

    B = friction * (1 + intensity_gain)**intensity * (1 + pattern_height * pattern)

The intensity is the timeline's curve scaled to 0..1 and mixed with its rank, so that mostly low
curves have perceptible changes:

    value' = (1 - share) * value + share * rank(value)

A preset may map it further (`points`). The rank of a value is the share of time with lower values,
and the mean rank for equal values. Only times with data count: neither gaps nor the future. Equal
steps of intensity are equal ratios of friction, which are perceived as equal steps (Weber's law).

Gaps in the data have ribs instead (`patterns`). The future of a live timeline is smooth and heavy.
It has neither strikes nor pattern nor ribs. From the present on, friction rises smoothly within a
few hundredths of the surface, to more than a curve can reach. The disk sinks into it instead of
hitting a stop, so the present is not mistaken for an event.

With the model `detent` the pattern consists of detents instead of friction. Their depth follows the
mean friction of a period. Gaps and the future have none.

The disk strikes the base surface at the crests of its pattern. Like an event, a crest stores torque
of the arriving disk and releases it; its release is the friction, or the grip, that the
pattern adds at the crest. For a pattern of detents the disk strikes their troughs. A surface
without material has no strikes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from overview_dsp.arrays import BoolArray, FloatArray, IntArray
from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.gaps import in_gap
from overview_dsp.design.presets.model import ClickMode, Preset
from overview_dsp.signal.surface.angle_map import AngleMap
from overview_dsp.signal.surface.fields import impedance, warn_of_lockup
from overview_dsp.signal.surface.materials import louder, modes_of
from overview_dsp.signal.surface.model import NO_TEXTURE_STRIKES, TextureStrikes
from overview_dsp.signal.surface.patterns import pattern, ribs

SOFT_END = 0.03
"""Width of the rise of friction at the present: wider than any event of the bundled presets."""

OVER_THE_CURVE = 2.0
"""Friction of the future relative to the base surface at the highest intensity. A ratio of 1.2, the
Weber fraction of damping, may be missed; a ratio of 2 is not."""


@dataclass(frozen=True, eq=False)
class BaseSurface:
    """Base surface.

    `friction`: viscous friction at the table's cells + 1 points, N m s/rad.
    `energy`: energy of its detents there, N m cells.
    `modes`: modes of its sound.
    `texture_strikes`: strikes of its pattern.
    """

    friction: FloatArray
    energy: FloatArray
    modes: tuple[ClickMode, ...]
    texture_strikes: TextureStrikes


def build_base_surface(
    timeline: Timeline, preset: Preset, cells: int, angle_map: AngleMap
) -> BaseSurface:
    """Build the base surface of a timeline and a preset on a table of cells + 1 points.

    Warns (OverviewWarning) of gaps too narrow to be perceived.
    """
    number = preset.number
    bare, model = number("surface.friction"), preset.values["surface.model"]
    intensity, rise_of_mean = _intensity(timeline, preset, cells, angle_map)
    steepness = math.log1p(number("surface.intensity_gain"))
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
    height = top * loud if preset.values["surface.pattern_grows"] else np.full(cells + 1, top)
    if made_of != "none" and model != "detent":
        friction += height * course
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
        friction[missing] = ribbed * (ground + (height.min() if made_of != "none" else 0.0))
        known[missing] = 0.0
    if timeline.known_until_s is not None:
        heaviness = OVER_THE_CURVE * (1.0 + number("surface.intensity_gain"))
        heavy = number("surface.friction") * heaviness
        begun = rise(float(angle_map.position_of(timeline.known_until_s)), cells)
        friction += begun * (heavy - friction)
        friction[begun == 1.0] = heavy  # exact, so that an unchanged future is not sent to pages
        known[begun > 0.0] = 0.0
    material = str(preset.values["surface.material"])
    free = modes_of(material, number("surface.pitch_hz"), number("surface.decay_scale"))
    modes = louder(free, number("surface.gain_db"))
    energy = np.zeros(cells + 1)
    strikes = NO_TEXTURE_STRIKES
    if model == "detent":
        pull = number("surface.torque_ratio") * bare
        warn_of_lockup(preset, "surface.torque_ratio", pull * loud.max(), "it")
        width = period / 100.0 * cells
        energy = _detents(course, pull, width, loud * known)
        if modes and pull > 0.0:
            strikes = troughs_of(course * known, impedance(preset, pull, width / 4.0, cells))
    elif modes:
        grip = number("surface.torque_ratio") if model == "bristle" else 1.0
        strikes = crests_of(course * known, grip * height)
    return BaseSurface(friction, energy, modes, strikes)


def _intensity(
    timeline: Timeline, preset: Preset, cells: int, angle_map: AngleMap
) -> tuple[FloatArray, float]:
    """Return the intensity at the table's points, and by how much the rank raises its mean."""
    even = timeline.normalised_levels(cells)
    plain = felt = angle_map.at_even_positions(even)
    share = preset.number("surface.rank_share")
    if share > 0.0:
        felt = mixed_with_rank(plain, even[_ranked(timeline, cells)], share)
    if preset.points:
        steps = np.linspace(0.0, 1.0, len(preset.points))
        plain, felt = (np.interp(levels, steps, preset.points) for levels in (plain, felt))
    return felt, float((felt - plain).mean()) if share > 0.0 else 0.0


def _ranked(timeline: Timeline, cells: int) -> BoolArray:
    """Return which of cells + 1 even times have a rank: those with data of a curve that varies."""
    curve = timeline.intensity
    if curve is None or curve.is_constant:
        return np.zeros(cells + 1, dtype=bool)
    until_s = timeline.known_until_s
    last = curve.last_s if until_s is None else min(curve.last_s, until_s)
    times = np.linspace(0.0, timeline.duration_s, cells + 1)
    return (times >= curve.first_s) & (times <= last) & ~in_gap(timeline.gaps, times)


def rank_step(timeline: Timeline, preset: Preset, cells: int) -> float:
    """Return the difference that one rank makes to the logarithm of friction; 0 without ranks."""
    steepness = math.log1p(preset.number("surface.intensity_gain"))
    known = int(_ranked(timeline, cells).sum())
    return steepness * preset.number("surface.rank_share") / max(known, 1)


def _detents(course: FloatArray, pull: float, period: float, loud: FloatArray) -> FloatArray:
    """Return the energy (N m cells) of detents with a highest pull of `pull` N m times `loud`."""
    steepest = float(np.abs(np.gradient(course)).max())
    if steepest == 0.0:
        return np.zeros(len(course))
    positions = np.arange(len(course))
    # constant over a period, so that a fast curve does not add detents
    number = (positions / period).astype(np.int64)
    means = np.bincount(number, loud) / np.bincount(number)
    centres = (np.arange(len(means)) + 0.5) * period
    return pull / steepest * course * np.interp(positions, centres, means)


def rise(now: float, cells: int) -> FloatArray:
    """Return the weight of the future at each point of a table: 0, then a smooth rise to 1.

    `now` is the position of the present, 0 to 1.
    """
    part = np.clip((np.arange(cells + 1) / cells - now) / SOFT_END, 0.0, 1.0)
    return part * part * (3.0 - 2.0 * part)


def mixed_with_rank(levels: FloatArray, known: FloatArray, share: float) -> FloatArray:
    """Return levels (0 to 1) mixed with their rank among the known levels.

    Levels without a curve or of a constant curve are returned unchanged.
    """
    ordered = np.sort(known)
    if not len(ordered) or ordered[0] == ordered[-1]:
        return levels
    lower, upper = (np.searchsorted(ordered, levels, side=side) for side in ("left", "right"))
    rank = (lower + upper) / (2.0 * len(ordered))
    return np.asarray((1.0 - share) * levels + share * rank)


def crests(course: FloatArray) -> IntArray:
    """Return the points that are higher than the one before and not lower than the next."""
    inner = course[1:-1]
    return np.flatnonzero((inner > course[:-2]) & (inner >= course[2:])) + 1


def crests_of(course: FloatArray, height: FloatArray) -> TextureStrikes:
    """Return strikes at the crests of a pattern (0 to 1), where 1 is the `height`, N m s/rad."""
    at = crests(course)
    return TextureStrikes(at / (len(course) - 1), height[at] * course[at])


def troughs_of(course: FloatArray, impedance: float) -> TextureStrikes:
    """Return strikes at the troughs of a pattern of detents with an `impedance` in N m s/rad."""
    at = crests(-course)
    return TextureStrikes(at / (len(course) - 1), np.full(len(at), impedance))
