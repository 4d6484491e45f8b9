"""Friction models as a whole: energy, bits, what is felt held still, creaks, the end of a tail."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.describe import bristle_hold
from overview_dsp.kernels import layout
from tests.examples import preset_with, timeline_of
from tests.interpreted import interpreted
from tests.profiles import share

RATE = 48_000


def creaking(**changes):
    """A base surface with bristles that creak, and two events."""
    values = {
        "disk__inertia": 2e-5,
        "disk__k1": 5e-3,
        "disk__k2": 0.5,
        "surface__friction": 1e-4,
        "surface__model": "bristle",
        "surface__torque_ratio": 50.0,
        "surface__stribeck_speed": 0.5,
        **changes,
    }
    return preset_with(height=20.0, **values)


def sticky(height=4.0, width=2.0, **kind):
    """A viscous surface whose events have bristles."""
    preset = preset_with(height=height, width=width, disk__inertia=2e-5)
    bristled = replace(preset.kinds["default"], model="bristle", **kind)
    return replace(preset, kinds={"default": bristled})


def test_bristles_without_grip_change_no_bit(match, football):
    gesture = ov.sweep(0.5) + ov.pause(0.2) + ov.tap(0.7, 0.2)
    bare = football.with_values(surface__model="bristle", surface__torque_ratio=0.0)
    without = ov.render(match, football, gesture, tail=0.3)
    with_none = ov.render(match, bare, gesture, tail=0.3)
    assert np.array_equal(without.samples, with_none.samples)
    for name in without.trace:
        assert np.array_equal(without.trace[name], with_none.trace[name])


def test_a_surface_without_bristles_carries_none(match, football):
    assert ov.build_surface(match, football).bristles is None


def test_the_height_of_bristles_is_the_torque_that_viscous_friction_has_at_1_rad_s():
    preset, timeline = sticky(), timeline_of(30.0, 70.0)
    field = ov.build_surface(timeline, preset).bristles
    viscous = replace(preset.kinds["default"], model="viscous")
    friction = ov.build_surface(
        timeline, replace(preset, kinds={"default": viscous})
    ).friction - preset.number("surface.friction")
    assert np.allclose(field.grip, friction, rtol=1e-12)
    owned = field.owner[field.grip > 0.0]
    assert set(owned) == {0, 1}
    assert (np.diff(owned) >= 0).all()
    assert (ov.build_surface(timeline, preset).friction == preset.number("surface.friction")).all()


def test_what_resists_is_the_same_height_in_every_model():
    tops = {}
    for model in ("viscous", "bristle", "detent"):
        preset = sticky()
        kind = replace(preset.kinds["default"], model=model)
        preset = replace(preset, kinds={"default": kind})
        tops[model] = ov.build_surface(timeline_of(50.0), preset).resistance.max()
    assert tops["viscous"] == pytest.approx(5e-3)
    assert tops["bristle"] == pytest.approx(5e-3)
    assert tops["detent"] == pytest.approx(5e-3, rel=1e-3)


def test_bristles_that_no_spring_can_pull_over_are_named():
    with pytest.warns(
        ov.OverviewWarning, match=r"kinds\.default: the disk gets stuck at.*disk\.k2"
    ):
        ov.build_surface(timeline_of(50.0), sticky(height=1000.0))
    with pytest.warns(ov.OverviewWarning, match=r"surface\.torque_ratio: the disk gets stuck"):
        ov.build_surface(timeline_of(), creaking(surface__torque_ratio=10_000.0))


@settings(max_examples=share(0.5))
@given(
    stiffness=st.floats(0.1, 1e6),
    other=st.floats(0.1, 1e6),
    damping=st.floats(0.0, 1.0),
    static=st.floats(1.0, 20.0),
    grip=st.floats(0.0, 100.0),
    rate=st.sampled_from([8000, 48_000]),
)
def test_let_go_the_energy_never_rises(stiffness, other, damping, static, grip, rate):
    """Of disk, spring and bristles, over two kinds and the base surface."""
    preset = creaking(
        surface__stiffness=stiffness,
        surface__damping=damping,
        surface__torque_ratio=grip,
        disk__k1=0.05,
    )
    kind = replace(
        preset.kinds["default"],
        model="bristle",
        stiffness=other,
        static_ratio=static,
        height=2.0 * grip,
        width_percent=2.0,
        shape="plateau",
    )
    preset = replace(preset, kinds={"default": kind, "soft": replace(kind, stiffness=stiffness)})
    events = tuple(ov.Event(5.0 * i, ("default", "soft")[i % 2]) for i in range(1, 20))
    timeline = ov.Timeline(title="", duration_s=100.0, events=events)
    engine = ov.Engine(preset, timeline)
    engine.prepare(rate, rate)
    engine.control(2.5, True)
    out = np.zeros((rate // 2, 2), dtype=np.float32)
    engine.process(out)
    engine.control(2.5, False)
    engine.process(out[:1])
    while engine.meters.engaged:  # the shaft gives energy until the disk has arrived
        engine.process(out[: rate // 100])
    table = np.zeros((1, 10))
    energies = []
    grip, before = engine.surface.bristles.grip, engine.meters.cursor
    for _ in range(1500):
        engine.process(out[:1], table)
        _, _, _, theta1, omega1, *_ = table[0]
        bend = engine.memory[layout.BRISTLE] * engine.memory[layout.C_THETA]
        stored = engine.memory[layout.BRISTLE_STIFFNESS] * bend * bend / 2
        # never more torque than breaks it loose, thereabouts
        cells = np.array([before, table[0, 5]]) * layout.CELLS
        around = 8 + 2 * abs(cells[1] - cells[0])
        first, last = int(cells.min() - around), int(cells.max() + around)
        near = grip[min(max(0, first), len(grip) - 1) : max(1, last)].max()  # beyond an end: there
        held = engine.memory[layout.BRISTLE_STIFFNESS] * abs(bend)
        assert held <= max(2.0, static) * near * (1.0 + 1e-9)
        before = table[0, 5]
        energies.append(2e-5 * omega1**2 / 2 + 0.05 * theta1**2 / 2 + stored)
    assert np.isfinite(energies).all()
    assert (np.diff(energies) <= 1e-12 * energies[0]).all()


def test_a_finger_held_still_stops_the_disk_within_what_the_bristles_hold():
    preset = creaking()
    static_torque = 50.0 * 1e-4 * 2.0
    held = static_torque / (0.5 + 5e-3) + static_torque / preset.number("surface.stiffness")
    assert bristle_hold(preset)["held_within_percent"] == pytest.approx(
        100.0 * static_torque / 0.5 / math.pi
    )
    for place in (0.2, 0.5, 0.9):
        result = ov.render(timeline_of(), preset, ov.tap(place, 3.0), tail="none")
        off = math.pi * abs(result.trace.cursor[-100] - place)
        assert off <= held * (0.5 + 5e-3) / 0.5
        # and there it is silent, however hard they hold
        assert result.trace.envelope[-200:-50].max() == 0.0


def test_a_disk_pulled_slowly_creaks_and_one_pulled_fast_slides():
    timeline = timeline_of()
    slow = ov.render(timeline, creaking(), ov.sweep(8.0), tail="none")
    fast = ov.render(timeline, creaking(), ov.sweep(0.5), tail="none")
    assert len(slow.strikes) > 50
    assert (slow.strikes.event == -1).all()
    assert len(slow.strikes.of_events()) == 0
    assert len(fast.strikes) < 5
    # a slip lets go of static minus sliding torque at most
    most = 50.0 * 1e-4
    assert (slow.strikes.torque > 0.05 * most).all()
    assert (slow.strikes.torque < 1.01 * most).all()
    # regularly: each slip as far as the last
    between = np.diff(slow.strikes.time_s[5:45])
    assert between.std() < 0.1 * between.mean()


@pytest.mark.parametrize("stiffness", [20.0, 1e3, 1e6])
def test_pulled_slowly_the_disk_slips_as_far_as_its_description_says(stiffness):
    preset = creaking(surface__stribeck_speed=0.2, surface__stiffness=stiffness)
    strikes = ov.render(timeline_of(), preset, ov.sweep(8.0, 0.0, 0.1), tail="none").strikes
    assert len(strikes) > 8
    # a disk that swings in its bristles doesn't slip
    slips = 100.0 * 0.1 / 8.0 * np.diff(strikes.time_s[:8])
    said = bristle_hold(preset)["slip_percent"]
    assert said == pytest.approx(100.0 * 2.0 * 5e-3 / 0.5 / math.pi)
    assert slips[1:] == pytest.approx(said, rel=0.12)


def test_a_stuck_disk_moves_on_when_the_grip_is_lowered():
    engine = ov.Engine(creaking(), timeline_of())
    engine.prepare(RATE, RATE)
    engine.control(0.0, True)
    out = np.zeros((RATE, 2), dtype=np.float32)
    engine.process(out[:100])
    engine.control(0.015, True)  # 7.5 mN m, of the 10 that break it loose
    engine.process(out)
    assert math.pi * engine.meters.cursor < 0.001
    engine.set("surface.torque_ratio", 2.0)
    engine.process(out)
    assert abs(math.pi * engine.meters.cursor - 0.015) <= 2.0 * 2e-4 / 0.5 * 1.05


def test_a_grip_that_comes_back_remembers_no_slip():
    engine = ov.Engine(creaking(), timeline_of())
    engine.prepare(RATE, RATE)
    out = np.zeros((RATE, 2), dtype=np.float32)
    engine.control(0.0, True)
    engine.process(out[:100])
    engine.control(0.015, True)  # stuck, and pulled at
    engine.process(out)
    engine.set("surface.model", "viscous")
    engine.process(out)
    engine.pop_strikes()
    engine.control(3.0, True)
    engine.process(out[:2000])
    engine.set("surface.model", "bristle")
    engine.process(out[:1000])
    assert engine.meters.cursor > 0.1
    assert len(engine.pop_strikes()) == 0


def test_no_static_torque_makes_no_creak():
    result = ov.render(
        timeline_of(), creaking(surface__static_ratio=1.0), ov.sweep(8.0), tail="none"
    )
    assert len(result.strikes) <= 1


def test_an_event_with_bristles_strikes_where_it_is_passed_and_its_slips_are_its_own():
    preset = sticky(stribeck_speed=0.2)
    result = ov.render(timeline_of(30.0, 70.0), preset, ov.sweep(3.0), tail="none")
    assert set(result.strikes.event) == {0, 1}
    top = 4.0 * 1e-3
    assert (result.strikes.torque <= top * 1.01).all()
    assert np.isclose(result.strikes.torque, top, rtol=0.02).sum() >= 2


def test_stuck_for_good_the_tail_ends():
    preset = creaking(disk__k1=1e-3)
    result = ov.render(timeline_of(), preset, ov.sweep(2.0, 0.0, 0.9))
    assert result.trace.cursor[-1] > 0.8  # held where it was let go
    assert result.trace.time[-1] < 5.0
    assert np.all(result.samples[-1] == 0.0)


@pytest.mark.parametrize("model", ["bristle", "detent", "end_stop"])
def test_the_stated_tail_is_long_enough(model):
    preset = creaking(surface__friction=1e-3, surface__torque_ratio=3.0, surface__material="glass")
    kind = replace(preset.kinds["default"], model=model, height=5.0)
    preset = replace(preset, kinds={"default": kind})
    if model != "bristle":
        preset = preset.with_values(surface__model="detent", surface__pattern="waves")
    engine = ov.Engine(preset, timeline_of(20.0, 45.0, 80.0))
    engine.prepare(RATE, RATE)
    out = np.zeros((RATE, 2), dtype=np.float32)
    engine.control(3.0, True)
    engine.process(out)
    engine.control(3.0, False)
    for _ in range(math.ceil(engine.tail_seconds)):
        engine.process(out)
    engine.process(out)
    assert not out.any()


def schedule(engine):
    engine.control(0.3, True, 0)
    for i in range(60):
        engine.control(0.3 + 0.04 * i, True, 200 * i)
    stiffer = engine.preset.with_values(surface__torque_ratio=30.0, surface__stiffness=5000.0)
    engine.set_preset(stiffer, sample_time=4000)
    engine.set("kinds.default.model", "bristle", sample_time=8000)
    engine.set("disk.k2", 0.3, sample_time=9000)
    engine.control(2.0, False, 12_500)


def played(sizes, frames=16_000):
    preset = creaking(surface__end_stiffness=5.0, surface__material="wood")
    kind = replace(preset.kinds["default"], height=40.0)
    kinds = {name: replace(kind, model=name) for name in ("detent", "end_stop")}
    preset = replace(preset, kinds={"default": kind, **kinds})
    events = [ov.Event(5.0 + 3.0 * i, ("default", "detent", "end_stop")[i % 3]) for i in range(30)]
    engine = ov.Engine(preset, ov.Timeline(title="", duration_s=100.0, events=tuple(events)))
    engine.prepare(RATE, frames)
    schedule(engine)
    out = np.zeros((frames, 2), dtype=np.float32)
    trace = np.zeros((frames, 10))
    start = 0
    for size in sizes:
        stop = min(frames, start + size)
        engine.process(out[start:stop], trace[start:stop])
        start = stop
    return out, trace, engine.pop_strikes()


def test_no_block_size_changes_a_bit_in_any_model():
    whole = played([16_000])
    assert len(whole[2]) > 5
    for size in (1, 64, 333):
        parts = played([size] * (16_000 // size + 1))
        assert np.array_equal(whole[0], parts[0])
        assert np.array_equal(whole[1], parts[1])
        assert np.array_equal(whole[2].time_s, parts[2].time_s)


def test_crossfading_between_models_stays_smooth():
    _, trace, _ = played([16_000])
    speed = np.abs(np.diff(trace[:, 4]))
    assert np.isfinite(trace).all()
    for at in (4000, 8000):
        assert speed[at : at + 2000].max() < 3.0 * speed[:4000].max()


def all_models():
    out, trace, strikes = played([6000], 6000)
    assert len(strikes) > 1
    return out.tobytes() + trace.tobytes() + strikes.torque.tobytes()


def test_compiled_and_interpreted_models_give_the_same_bits():
    compiled = all_models()
    assert len(compiled) > 6000 * (8 + 72)
    assert interpreted("tests.signal.surface.test_friction_models", "all_models()") == compiled


def test_a_saved_state_holds_the_models():
    engine = ov.Engine(sticky(static_ratio=3.0), timeline_of(30.0))
    other = ov.Engine(preset_with(), timeline_of(30.0))
    other.load_state(engine.save_state())
    assert other.preset == engine.preset
    assert other.preset.kinds["default"].static_ratio == 3.0
    assert other.surface.bristles is not None
