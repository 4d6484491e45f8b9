"""What lies beside friction: bristles and detents, laid by hand, against their definitions."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.presets.parameters import SHAPES
from overview_dsp.signal.surface.fields import (
    BASE,
    BristleLayer,
    Bristles,
    DetentLayer,
    energy_of,
    has_bristles,
    has_detents,
    impedance,
    shape_of,
    warn_of_lockup,
)
from overview_dsp.signal.surface.model import Surface
from overview_dsp.signal.surface.profiles import profile
from tests.examples import K1, K2, plain_preset, preset_with, timeline_of

LIKE = {
    "stiffness": 200.0,
    "damping": 2e-3,
    "static_ratio": 3.0,
    "stribeck_speed": 0.2,
    "break_away": 0.4,
}


def of_model(model, **changes):
    preset = preset_with(**changes)
    return replace(preset, kinds={"default": replace(preset.kinds["default"], model=model)})


# --- bristles -------------------------------------------------------------------------------------


def test_bristles_are_those_of_the_higher_profile_and_of_the_surface_elsewhere():
    values = {f"surface__{key}": value for key, value in LIKE.items()}
    preset = of_model("bristle", surface__model="bristle", surface__torque_ratio=2.0, **values)
    layer = BristleLayer(preset, np.full(10, 1e-3))
    layer.raise_to(0, 1, np.array([1e-3, 5e-3, 5e-3, 3e-3]))
    layer.raise_to(1, 3, np.array([5e-3, 4e-3, 2e-3, 3e-3]))
    field = layer.field(np.array([7, 4]))
    assert field.grip == pytest.approx(1e-3 * np.array([2, 2, 5, 5, 4, 2, 3, 2, 2, 2]))
    assert field.owner.tolist() == [BASE, BASE, 7, 7, 4, BASE, 4, BASE, BASE, BASE]
    assert field.bare == Bristles(**LIKE)
    (kind,) = preset.kinds.values()
    assert field.of_kind == (Bristles.of_kind(kind),)


def test_the_bristles_of_a_kind_are_as_the_kind_says():
    assert Bristles.of_kind(ov.EventKind(1.0, 1.0, **LIKE)) == Bristles(**LIKE)


def test_a_surface_without_bristles_of_its_own_grips_only_at_events():
    layer = BristleLayer(of_model("bristle", surface__torque_ratio=2.0), np.full(4, 1e-3))
    assert layer.field(np.zeros(0, np.int64)).grip.tolist() == [0.0] * 4


@pytest.mark.parametrize(
    ("surface", "kind", "bristles", "detents"),
    [
        ("viscous", "viscous", False, False),
        ("bristle", "viscous", True, False),
        ("viscous", "bristle", True, False),
        ("detent", "viscous", False, True),
        ("viscous", "detent", False, True),
        ("viscous", "end_stop", False, True),
        ("detent", "bristle", True, True),
    ],
)
def test_a_preset_has_what_its_surface_or_any_kind_has(surface, kind, bristles, detents):
    preset = of_model(kind, surface__model=surface)
    viscous = {**preset_with().kinds, "other": preset.kinds["default"]}
    for given in (preset, replace(preset, kinds=viscous)):
        assert has_bristles(given) == bristles
        assert has_detents(given) == detents
    assert has_detents(preset.with_changes({"surface.end_stiffness": 1.0}))


# --- detents --------------------------------------------------------------------------------------


def test_detents_combine_by_the_deepest_stops_by_the_highest_and_both_add_to_what_is_under():
    preset = plain_preset(surface__end_stiffness=0.5, surface__end_damping=0.02)
    under = np.linspace(0.0, 1.0, 11)
    layer = DetentLayer(preset, under)
    layer.lay("detent", 2, np.array([1.0, 3.0, 1.0]))
    layer.lay("detent", 3, np.array([2.0, 2.0, 2.0]))
    layer.lay("end_stop", 4, np.array([1.0, 2.0]))
    layer.lay("end_stop", 5, np.array([1.0, 2.0]))
    energy = under - [0, 0, 1, 3, 2, 2, 0, 0, 0, 0, 0] + [0, 0, 0, 0, 1, 2, 2, 0, 0, 0, 0]
    field = layer.field()
    # the slope between its neighbours; at the ends that of the last step
    assert field.pull[1:-1] == pytest.approx((energy[2:] - energy[:-2]) / 2.0)
    assert field.pull[[0, -1]] == pytest.approx([energy[1] - energy[0], energy[-1] - energy[-2]])
    # the energy is what the pull takes on the way, straight between points
    assert field.energy[0] == 0.0
    assert np.diff(field.energy) == pytest.approx((field.pull[1:] + field.pull[:-1]) / 2.0)
    assert (field.end_stiffness, field.end_damping) == (0.5, 0.02)


def test_ends_without_a_spring_have_no_damper():
    preset = plain_preset(surface__end_stiffness=0.0, surface__end_damping=0.02)
    field = DetentLayer(preset, np.zeros(5)).field()
    assert (field.end_stiffness, field.end_damping) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("shape", "points"),
    [*((shape, ()) for shape in (*SHAPES, "stop")), ("gaussian", (0.0, 1.0, 0.5, 0.0))],
)
@pytest.mark.parametrize("width", [10.0, 700.0])
def test_the_energy_of_a_well_has_the_stated_pull_where_it_is_steepest(shape, points, width):
    height = energy_of(6e-3, shape, points, width)
    # a stop's is that of its way up
    at = np.linspace(-2.0, 0.0 if shape == "stop" else 2.0, 400_001) * width
    pull = np.abs(np.diff(height * profile(shape, at, width, points)) / np.diff(at)).max()
    assert pull == pytest.approx(6e-3, rel=0.01)


def test_a_spring_pressed_over_one_width_holds_twice_its_energy_over_its_width():
    # U = h (1 + d/w)**2, whose slope at the event is 2 h / w
    assert energy_of(1e-2, "stop", (), 50.0) == pytest.approx(1e-2 * 50.0 / 2.0, rel=1e-3)


def test_a_wells_impedance_is_the_root_of_its_stiffness_and_the_disks_inertia():
    preset = plain_preset(disk__inertia=3e-5)
    angle = 20.0 / 1000.0 * math.pi * K2 / (K1 + K2)
    assert impedance(preset, 8e-3, 20.0, 1000) == pytest.approx(math.sqrt(8e-3 / angle * 3e-5))


def test_a_stop_has_a_shape_of_its_own_and_all_others_the_kinds():
    kind = ov.EventKind(1.0, 1.0, shape="plateau", points=(0.0, 1.0))
    assert shape_of(replace(kind, model="end_stop")) == ("stop", ())
    assert shape_of(replace(kind, model="detent")) == ("plateau", (0.0, 1.0))


# --- what holds for good --------------------------------------------------------------------------


def test_a_torque_as_great_as_the_finger_pulls_at_most_is_warned_of():
    preset = plain_preset()
    most = K2 * math.pi
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_of_lockup(preset, "it", math.nextafter(most, 0.0), "that")
    with pytest.warns(
        ov.OverviewWarning, match=r"it: the disk gets stuck at 31\.4 mN.* with 31\.4 mN.*lower that"
    ):
        warn_of_lockup(preset, "it", most, "that")


@pytest.mark.parametrize(
    ("preset", "told"),
    [
        # 31.4 mN m is what shaft 2 pulls with; heights are in 1e-3 N m
        (of_model("detent", height=31.0), None),
        (
            of_model("detent", height=32.0),
            r"kinds\.default: the disk gets stuck at 32 mN.*lower its height,",
        ),
        (of_model("end_stop", height=32.0), r"kinds\.default: the disk gets stuck at 32 mN"),
        (of_model("bristle", height=15.0), None),  # twice that until it slides
        (
            of_model("bristle", height=16.0),
            r"kinds\.default: the disk gets stuck at 32 mN.*lower its height or static_ratio,",
        ),
        (plain_preset(surface__model="bristle", surface__torque_ratio=15.0), None),
        (
            plain_preset(surface__model="bristle", surface__torque_ratio=16.0),
            r"^surface\.torque_ratio: the disk gets stuck at 32 mN.*"
            r"lower it or surface\.static_ratio,",
        ),
        (plain_preset(surface__model="detent", surface__torque_ratio=31.0), None),
        (
            plain_preset(surface__model="detent", surface__torque_ratio=32.0),
            r"surface\.torque_ratio: the disk gets stuck at 32 mN.*lower it,",
        ),
    ],
)
def test_what_holds_the_disk_for_good_is_warned_of(preset, told):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        ov.build_surface(timeline_of(50.0), preset)
    assert len(caught) == (told is not None)
    if told:
        with pytest.warns(ov.OverviewWarning, match=told):
            ov.build_surface(timeline_of(50.0), preset)


def test_detents_hold_where_the_curve_is_highest():
    curve = ov.Intensity(np.array([0.0, 100.0]), np.array([0.0, 1.0]))
    timeline = ov.Timeline("ramp", 100.0, (), curve)
    preset = plain_preset(
        surface__model="detent", surface__torque_ratio=16.0, surface__intensity_gain=1.0
    )
    with pytest.warns(
        ov.OverviewWarning, match=r"^surface\.torque_ratio: the disk gets stuck at 32 mN"
    ):
        ov.build_surface(timeline, preset)


# --- the surface ----------------------------------------------------------------------------------


def test_what_resists_is_friction_and_grip_and_pull_together():
    timeline = timeline_of(20.0, 60.0)
    kinds = {
        "default": of_model("bristle", height=2.0).kinds["default"],
        "dent": of_model("detent", height=3.0).kinds["default"],
    }
    events = (ov.Event(20.0, "default"), ov.Event(60.0, "dent"))
    surface = ov.build_surface(
        replace(timeline, events=events), replace(plain_preset(), kinds=kinds)
    )
    expected = surface.friction + surface.bristles.grip + np.abs(surface.detents.pull)
    assert np.array_equal(surface.resistance, expected)
    assert surface.detents.pull.min() < -2e-3
    plain = ov.build_surface(timeline_of(), plain_preset())
    assert np.array_equal(plain.resistance, plain.friction)


def test_a_span_holds_its_ends():
    surface = ov.build_surface(timeline_of(30.0, 60.0), preset_with(width=2.0))
    assert isinstance(surface, Surface)
    first, last = surface.span[0]
    cursor = np.array([math.nextafter(first, 0.0), first, last, math.nextafter(last, 1.0)])
    assert surface.in_span(cursor).tolist() == [False, True, True, False]
    assert surface.in_span(cursor, np.array([False, True])).tolist() == [False] * 4
