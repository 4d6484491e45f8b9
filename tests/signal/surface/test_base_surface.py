"""The base surface: curve, pattern, gaps and detents put together, against the formulas."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.signal.surface import base_surface
from overview_dsp.signal.surface.angle_map import AngleMap
from overview_dsp.signal.surface.fields import impedance
from overview_dsp.signal.surface.materials import modes_of
from overview_dsp.signal.surface.patterns import pattern
from tests.examples import plain_preset, timeline_of

CELLS = 2000
PERIOD = 5.0  # percent: 100 cells
RAMP = ov.Timeline("ramp", 10.0, (), ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 1.0])))
GAPPED = replace(RAMP, gaps=((2.0, 4.0),))
LOUD = 3.0 ** (np.arange(CELLS + 1) / CELLS)  # intensity_gain 2
INSIDE = (np.arange(CELLS + 1) >= 400) & (np.arange(CELLS + 1) <= 800)


def build_base_surface(timeline, preset, cells):
    return base_surface.build_base_surface(timeline, preset, cells, AngleMap.of(timeline, preset))


def made_of(made="waves", **values):
    given = {
        "surface__friction": 2e-3,
        "surface__intensity_gain": 2.0,
        "surface__pattern": made,
        "surface__pattern_height": 3.0,
        "surface__pattern_period_percent": PERIOD,
        "surface__gap_height": 4.0,
        "surface__gap_period_percent": 1.0,
        **values,
    }
    return plain_preset(**given)


@pytest.mark.parametrize("made", ["waves", "beats", "grains"])
@pytest.mark.parametrize("model", ["viscous", "bristle"])
def test_a_growing_pattern_is_the_same_ratio_of_friction_at_every_value(made, model):
    preset = made_of(made, surface__model=model, surface__pattern_grows=True)
    bare = build_base_surface(RAMP, preset, CELLS)
    expected = 2e-3 * LOUD * (1.0 + 3.0 * pattern(made, CELLS, PERIOD))
    assert bare.friction == pytest.approx(expected, rel=1e-12)


def test_crests_of_a_growing_pattern_are_struck_harder_where_the_curve_is_high():
    values = {"surface__material": "glass", "surface__pattern_grows": True}
    bare = build_base_surface(RAMP, made_of(**values), CELLS)
    at = np.arange(20) * 100 + 50
    assert bare.texture_strikes.position == pytest.approx(at / CELLS)
    assert bare.texture_strikes.release == pytest.approx(3.0 * 2e-3 * LOUD[at])


def test_detents_grow_with_the_curve_with_or_without_the_key():
    one, other = (
        build_base_surface(
            RAMP, made_of(surface__model="detent", surface__pattern_grows=grows), CELLS
        )
        for grows in (False, True)
    )
    assert np.array_equal(one.energy, other.energy)
    assert np.array_equal(one.friction, other.friction)


@pytest.mark.parametrize("made", ["none", "waves", "teeth"])
@pytest.mark.parametrize("model", ["viscous", "bristle"])
def test_friction_is_the_curve_and_the_pattern_in_bare_surfaces(made, model):
    bare = build_base_surface(RAMP, made_of(made, surface__model=model), CELLS)
    expected = 2e-3 * (LOUD + 3.0 * pattern(made, CELLS, PERIOD))
    assert bare.friction == pytest.approx(expected, rel=1e-12)
    assert not bare.energy.any()


@pytest.mark.parametrize(
    ("points", "felt"), [((0.0, 1.0), [0.0, 0.5, 1.0]), ((1.0, 0.2, 0.0), [1.0, 0.2, 0.0])]
)
def test_a_drawn_map_says_how_much_of_the_ambience_is_felt_at_each_intensity(points, felt):
    bare = build_base_surface(RAMP, replace(made_of("none"), points=points), CELLS)
    expected = 2e-3 * 3.0 ** np.interp(np.arange(CELLS + 1) / CELLS, [0.0, 0.5, 1.0], felt)
    assert bare.friction == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("grows", [False, True])
@pytest.mark.parametrize(("made", "under"), [("none", 1.0), ("waves", 4.0)])
def test_the_ribs_of_a_gap_stand_out_of_the_pattern_too(made, under, grows):
    bare = build_base_surface(GAPPED, made_of(made, surface__pattern_grows=grows), CELLS)
    turns = (np.arange(CELLS + 1)[INSIDE] - 400) / 20.0
    ribs = 0.1 + (4.0 - 0.1) * np.sin(np.pi * turns) ** 4
    assert bare.friction[INSIDE] == pytest.approx(2e-3 * under * ribs, rel=1e-9)
    height = LOUD if grows else 1.0
    outside = 2e-3 * (LOUD + 3.0 * height * pattern(made, CELLS, PERIOD))
    assert bare.friction[~INSIDE] == pytest.approx(outside[~INSIDE])


@pytest.mark.parametrize(("model", "grip"), [("viscous", 1.0), ("bristle", 2.5)])
def test_crests_are_struck_as_hard_as_the_pattern_adds_and_sound_of_the_material(model, grip):
    values = {
        "surface__model": model, "surface__torque_ratio": 2.5, "surface__material": "glass",
        "surface__pitch_hz": 700.0, "surface__decay_scale": 0.5, "surface__gain_db": -4.0,
    }  # fmt: skip
    bare = build_base_surface(GAPPED, made_of(**values), CELLS)
    at = np.arange(20) * 100.0 + 50.0
    at = at[(at < 400) | (at > 800)]
    assert bare.texture_strikes.position == pytest.approx(at / CELLS)
    assert bare.texture_strikes.release == pytest.approx(np.full(16, grip * 3.0 * 2e-3))
    rings = modes_of("glass", 700.0, 0.5)
    assert bare.modes == tuple(replace(mode, gain_db=mode.gain_db - 4.0) for mode in rings)
    silent = build_base_surface(GAPPED, made_of(**{**values, "surface__material": "none"}), CELLS)
    assert silent.modes == ()
    assert len(silent.texture_strikes.position) == 0


def test_detents_pull_as_the_grip_says_and_are_as_deep_as_the_curve_is_high():
    values = {"surface__model": "detent", "surface__torque_ratio": 1.5, "surface__material": "wood"}
    bare = build_base_surface(RAMP, made_of(**values), CELLS)
    # in place of friction
    assert bare.friction == pytest.approx(2e-3 * LOUD)
    course = pattern("waves", CELLS, PERIOD)
    # half the height of a sine times its wave number is its steepest slope, here 3e-3 N m
    unit = 3e-3 / (math.pi / 100.0)
    # each period's mean in its middle, straight from one to the next; the last point begins one
    means = LOUD[:-1].reshape(20, 100).mean(axis=1)
    depth = np.interp(np.arange(CELLS + 1), 50.0 + 100.0 * np.arange(21), [*means, LOUD[-1]])
    assert bare.energy == pytest.approx(unit * course * depth, rel=1e-3, abs=1e-9)
    pull = np.abs(np.gradient(bare.energy / depth)).max()
    assert pull == pytest.approx(3e-3, rel=1e-3)
    # the disk falls into the troughs, a quarter of a period from the steepest slope
    assert bare.texture_strikes.position == pytest.approx(np.arange(100, CELLS, 100) / CELLS)
    expected = impedance(made_of(**values), 3e-3, 25.0, CELLS)
    assert bare.texture_strikes.release == pytest.approx(np.full(19, expected))


@pytest.mark.parametrize("values", [{"surface__torque_ratio": 0.0}, {"surface__pattern": "none"}])
def test_what_pulls_nothing_is_no_detent_and_strikes_nothing(values):
    given = {"surface__model": "detent", "surface__material": "wood", "surface__torque_ratio": 1.0}
    bare = build_base_surface(timeline_of(), made_of(**{**given, **values}), CELLS)
    assert not bare.energy.any()
    assert np.isfinite(bare.energy).all()
    assert len(bare.texture_strikes.position) == 0


def test_a_gap_has_no_detents_and_halves_those_of_a_period_it_covers_by_half():
    flat = replace(timeline_of(), gaps=((20.0, 42.5),))  # cells 400 to 850
    values = {"surface__model": "detent", "surface__torque_ratio": 1.5}
    bare = build_base_surface(flat, made_of(**values), CELLS)
    depth = [bare.energy[100 * n + 49 : 100 * n + 52].max() for n in range(20)]
    full = 3e-3 / (math.pi / 100.0)
    # the end of a gap is in it, and periods begin with their first point
    expected = np.array([full] * 4 + [0.0] * 4 + [0.49 * full] + [full] * 11)
    assert depth == pytest.approx(expected, rel=0.02, abs=0.02 * full)
