"""Detents and end stops: energy kept to rounding, where the disk comes to rest, what strikes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.parameters import SHAPES
from overview_dsp.kernels import layout
from overview_dsp.kernels.detents import CLOSE
from tests.examples import plain_preset, preset_with, timeline_of

J = 2e-5

LEAST_J = 1e-40  # a disk that lies in its detent; sums of energies round at the size of each


def sought(engine, way):
    """Energy (J) to which a step's pull is sought, on a way of some cells from where the disk is.

    At a kink, as between a stop's end and a hill, a way is there and back: more than its ends show.
    """
    i = min(int(min(max(engine.memory[layout.X], 0.0), layout.CELLS)), layout.CELLS - 1)
    pull = np.abs(engine.surface.detents.pull[i : i + 2]).max()
    return 2.0 * CLOSE * pull * way * engine.memory[layout.C_THETA] + LEAST_J


def clicking(height=20.0, width=2.0, model="detent", **changes):
    """A surface whose events are detents (or stops), of a disk with a soft shaft."""
    values = {"disk__inertia": J, "disk__k1": 1e-3, "disk__k2": 0.05, **changes}
    preset = preset_with(height=height, width=width, **values)
    kind = replace(preset.kinds["default"], model=model)
    return replace(preset, kinds={"default": kind})


def dial(**changes):
    """A base surface with twenty detents."""
    values = {
        "disk__inertia": J,
        "disk__k1": 1e-3,
        "disk__k2": 0.05,
        "surface__friction": 1e-3,
        "surface__model": "detent",
        "surface__pattern": "waves",
        "surface__pattern_period_percent": 5.0,
        "surface__torque_ratio": 8.0,
        "surface__material": "metal",
        **changes,
    }
    return plain_preset(**values)


def energies(engine, theta1, omega1, touching=False):
    """Energy of disk, shafts, detents, end stops and bristles, J, as they stand."""
    m = engine.memory
    k1, k2 = engine.preset.number("disk.k1"), engine.preset.number("disk.k2")
    inertia = engine.preset.number("disk.inertia")
    detents = engine.surface.detents
    place = m[layout.X]
    inside = min(max(place, 0.0), layout.CELLS)
    i = min(int(inside), layout.CELLS - 1)
    part = inside - i
    slope = detents.pull[i + 1] - detents.pull[i]
    stored = detents.energy[i] + part * (detents.pull[i] + 0.5 * part * slope)
    over = (place - inside) * m[layout.C_THETA]
    bend = m[layout.BRISTLE] * m[layout.C_THETA]
    return np.array(
        [
            inertia * omega1**2 / 2,
            (k1 + touching * k2) * theta1**2 / 2,
            stored * m[layout.C_THETA],
            detents.end_stiffness * over**2 / 2,
            m[layout.BRISTLE_STIFFNESS] * bend**2 / 2,
        ]
    )


@given(
    height=st.floats(0.0, 1000.0),
    width=st.floats(0.03, 10.0),
    shape=st.sampled_from(SHAPES),
    model=st.sampled_from(["detent", "end_stop"]),
    end=st.sampled_from([0.0, 1.0, 1000.0]),
    damping=st.sampled_from([0.0, 0.02]),
    grip=st.sampled_from([0.0, 5.0]),
    rate=st.sampled_from([8000, 48_000]),
    start=st.integers(0, 3141).map(lambda x: x / 1000.0),
)
# energies of 1e-30 J and less, at which the search for a step's energy takes the most rounds
@example(10.0, 10.0, "gaussian", "end_stop", 0.0, 0.0, 5.0, 48_000, 0.001)
@example(1.0, 5.0, "gaussian", "end_stop", 1.0, 0.0, 0.0, 8000, 0.0)
@example(864.0, 7.0, "gaussian", "end_stop", 1000.0, 0.02, 0.0, 8000, 0.0)
@example(349.0, 7.0, "gaussian", "end_stop", 1000.0, 0.0, 0.0, 8000, 0.0)
def test_let_go_the_disk_keeps_the_ledger_in_any_well(
    height, width, shape, model, end, damping, grip, rate, start
):
    preset = clicking(
        height, width, model,
        surface__friction=1e-5,
        surface__end_stiffness=end,
        surface__end_damping=damping,
        surface__model="bristle",
        surface__torque_ratio=grip,
        disk__k1=0.02,
    )  # fmt: skip
    kind = replace(preset.kinds["default"], shape=shape)
    preset = replace(preset, kinds={"default": kind})
    engine = ov.Engine(preset, timeline_of(*np.arange(5.0, 100.0, 5.0)))
    engine.prepare(rate, rate)
    engine.control(start, True)
    out, table = np.zeros((rate // 4, 2), dtype=np.float32), np.zeros((1, 10))
    engine.process(out)
    engine.control(start, False)
    for _ in range(251):  # until the disk has arrived, or for 2.5 s
        engine.process(out[: rate // 100])
        if engine.memory.view(np.int64)[layout.ENGAGED] == 0:
            break
    else:
        pytest.fail("shaft 2 is still engaged")
    engine.process(out[:1], table)
    before, omega = energies(engine, table[0, 3], table[0, 4]), table[0, 4]
    size = np.abs(before).sum()
    for _ in range(600):
        way = abs(engine.memory[layout.V])
        engine.process(out[:1], table)
        least = sought(engine, way + abs(engine.memory[layout.V]))
        after = energies(engine, table[0, 3], table[0, 4])
        mean = (omega + table[0, 4]) / 2
        lost = table[0, 6] * mean * mean / rate
        size = max(size, np.abs(after).sum())
        gained = after.sum() - before.sum()
        if grip == 0.0 and damping == 0.0:
            # nothing but viscous friction takes energy
            assert abs(gained + lost) <= 1e-12 * size + least
        else:
            assert gained <= 1e-12 * size + least
        before, omega = after, table[0, 4]


def test_the_pull_of_a_detent_is_its_heights_torque_and_closes():
    preset = clicking(height=20.0, width=2.0)
    detents = ov.build_surface(timeline_of(50.0), preset).detents
    assert np.abs(detents.pull).max() == pytest.approx(20.0 * 1e-3, rel=1e-3)
    assert detents.energy.argmin() == pytest.approx(0.5 * layout.CELLS, abs=1)
    assert abs(detents.energy[-1]) < 1e-9 * np.ptp(detents.energy)
    # to the right of its bottom it pulls back
    assert detents.pull[layout.CELLS // 2 + 300] > 0.0


def test_a_stop_is_a_spring_on_its_way_up_and_holds_eight_times_as_much_from_behind():
    detents = ov.build_surface(timeline_of(50.0), clicking(20.0, 4.0, "end_stop")).detents
    at, width = layout.CELLS // 2, round(0.04 * layout.CELLS)
    up = detents.pull[at - width : at]
    assert up.max() == pytest.approx(20e-3, rel=0.01)
    assert np.diff(up)[5:-5] == pytest.approx(20e-3 / width, rel=1e-3)
    assert detents.pull.min() == pytest.approx(-8 * 20e-3, rel=0.02)


def test_the_disk_rests_in_the_well_nearest_to_the_finger():
    preset = dial(disk__k2=0.5, surface__friction=6e-3, surface__torque_ratio=8.0 / 6.0)
    pull, k = 8e-3, 0.5
    for place in (0.17, 0.385, 0.62, 0.78):
        result = ov.render(timeline_of(), preset, ov.tap(place, 3.0), tail="none")
        cursor = result.trace.cursor[-100]
        well = round(place * 20) / 20
        assert abs(cursor - well) < abs(place - well)
        # where the shaft's pull and the well's are equal
        back = k * math.pi * (cursor - place) + pull * math.sin(2 * math.pi * 20 * cursor)
        assert back == pytest.approx(0.0, abs=0.05 * pull)
        assert result.trace.envelope[-200:-50].max() == 0.0


def test_a_swing_in_a_well_has_its_own_frequency():
    preset = dial(surface__torque_ratio=800.0)
    engine = ov.Engine(preset, timeline_of())
    engine.prepare(48_000, 48_000)
    engine.control(0.3, True)
    out, table = np.zeros((4800, 2), dtype=np.float32), np.zeros((4800, 10))
    engine.process(out, table)
    phi = math.pi * table[:, 5]
    swing = phi - phi[-100:].mean()
    crossings = np.flatnonzero((swing[:-1] < 0) & (swing[1:] >= 0))[:10]
    hz = 48_000 / np.diff(crossings).mean()
    # pull = grip sin(40 phi), phi = theta1 (k1 + k2)/k2
    k1, k2 = 1e-3, 0.05
    stiffness = 0.8 * 40 * (k1 + k2) / k2 + k1 + k2
    assert np.abs(swing).max() < 0.02
    assert hz == pytest.approx(math.sqrt(stiffness / J) / (2 * math.pi), rel=5e-3)


def test_each_well_clicks_as_the_disk_falls_into_it():
    result = ov.render(timeline_of(), dial(), ov.sweep(4.0), tail="none")
    strikes = result.strikes
    assert (strikes.event == -1).all()
    assert len(strikes) >= 19
    cursor = np.interp(strikes.time_s, result.trace.time, result.trace.cursor)
    assert np.abs(cursor * 20 - np.round(cursor * 20)).max() < 0.02
    assert set(np.round(cursor * 20).astype(int)) == set(range(1, 20))
    # as hard as the depth that it fell, or harder
    depth = 8e-3 * 0.05 / math.pi * math.pi * 0.05 / 0.051
    fallen = math.sqrt(2.0 * depth / J)
    release = result.engine.surface.texture_strikes.release[0]
    assert release == pytest.approx(math.sqrt(8e-3 * J / (math.pi / 80 * 0.05 / 0.051)))
    assert 0.3 * fallen < np.median(strikes.torque) / release < 1.5 * fallen


def test_a_well_is_struck_as_fast_as_the_disk_is_there():
    result = ov.render(timeline_of(), dial(surface__friction=3e-4), ov.sweep(6.0), tail="none")
    strikes, trace = result.strikes, result.trace
    assert len(strikes) > 60  # it swings about in each
    speed = np.abs(np.interp(strikes.time_s, trace.time, trace.omega1))
    release = result.engine.surface.texture_strikes.release[0]
    far = speed > 0.05 * speed.max()
    assert strikes.torque[far] == pytest.approx(release * speed[far], rel=0.02)


def test_wells_are_crossfaded():
    engine = ov.Engine(dial(surface__torque_ratio=0.0, disk__k2=0.5), timeline_of())
    engine.prepare(48_000, 48_000)
    engine.control(0.5 * math.pi + 0.04, True)
    out, table = np.zeros((48_000, 2), dtype=np.float32), np.zeros((48_000, 10))
    engine.process(out, table)
    still = table[-10:, 4].copy()
    engine.set("surface.torque_ratio", 50.0)
    engine.process(out, table)
    jerk = np.abs(np.diff(np.concatenate([still, table[:, 4]]), 2))
    # the whole pull at once would change the speed by pull * dt / J in a sample
    assert jerk[:1440].max() < 0.02 * (50e-3 / J / 48_000)
    assert np.ptp(table[:, 5]) > 0.005


def test_a_detent_event_clicks_and_is_named():
    result = ov.render(timeline_of(30.0, 70.0), clicking(8.0), ov.sweep(4.0), tail="none")
    assert set(result.strikes.event) == {0, 1}
    assert np.abs(result.samples[:, 0]).max() > 0.05


def test_a_stop_is_passed_one_way_and_holds_the_recoil():
    preset = clicking(4.0, 2.0, "end_stop", surface__friction=1e-3)
    result = ov.render(timeline_of(50.0), preset, ov.sweep(2.0))
    assert result.trace.cursor.max() > 0.95
    # let go, the disk comes back to the stop, and stays behind it
    assert result.trace.cursor[-1] == pytest.approx(0.5, abs=0.02)
    assert result.trace.cursor[-1] > 0.5
    assert np.all(result.samples[-1] == 0.0)


@pytest.mark.parametrize("stiffness", [0.0, 2.0, 100.0])
def test_the_end_stops_hold_an_overshooting_disk(stiffness):
    preset = plain_preset(
        disk__inertia=J, disk__k1=0.02, disk__k2=0.02, surface__friction=1e-5,
        surface__end_stiffness=stiffness, surface__material="wood",
    )  # fmt: skip
    gesture = ov.tap(1.0, 1.0) + ov.pause(1.0)
    result = ov.render(timeline_of(), preset, gesture, tail="none")
    over = result.trace.cursor.max() - 1.0
    under = -result.trace.cursor.min()
    if stiffness == 0.0:
        assert over > 0.5
        assert len(result.strikes) == 0
    else:
        omega = result.trace.omega1.max()
        most = omega * math.sqrt(J / stiffness) / (math.pi / 2)  # 1/2 J w^2 = 1/2 K x^2
        assert 0.3 * most < over < 1.1 * most
        assert 0.0 < under < 1.1 * most
        # as often as it meets them, not as long as it is there
        met = np.abs(np.diff(((result.trace.cursor < 0) | (result.trace.cursor > 1)).astype(int)))
        assert len(result.strikes) == np.ceil(met.sum() / 2)
        first = result.strikes.torque[0]
        assert first == pytest.approx(omega * math.sqrt(J * stiffness), rel=0.1)


def test_the_damping_of_the_end_stops_takes_the_bounce():
    back = []
    for damping in (0.0, 0.05):
        preset = plain_preset(
            disk__inertia=J, disk__k1=0.02, disk__k2=0.02, surface__friction=1e-5,
            surface__end_stiffness=20.0, surface__end_damping=damping,
        )  # fmt: skip
        trace = ov.render(timeline_of(), preset, ov.tap(1.0, 0.3), tail="none").trace
        met = int(np.argmax(trace.cursor > 1.0))
        arrived = trace.omega1[met]
        back.append(-trace.omega1[met : met + 2400].min() / arrived)
    assert back[0] > 0.95
    assert back[1] < 0.2


def test_no_well_is_made_where_there_is_none(match, football):
    assert ov.build_surface(match, football).detents is None
    flat = ov.build_surface(timeline_of(), dial(surface__pattern="none")).detents
    assert not flat.pull.any()


def test_wells_that_pull_nothing_change_no_bit(match, football):
    gesture = ov.sweep(0.5) + ov.pause(0.2) + ov.tap(0.7, 0.2)
    bare = football.with_values(surface__model="detent", surface__torque_ratio=0.0)
    without = ov.render(match, football, gesture, tail=0.3)
    with_none = ov.render(match, bare, gesture, tail=0.3)
    assert np.array_equal(without.samples, with_none.samples)
    for name in without.trace:
        assert np.array_equal(without.trace[name], with_none.trace[name])


def test_a_curve_makes_wells_deeper_where_it_is_high_and_none_in_a_gap():
    curve = ov.Intensity(np.array([0.0, 49.9, 50.1, 100.0]), np.array([0.0, 0.0, 1.0, 1.0]))
    timeline = ov.Timeline(
        title="", duration_s=100.0, events=(), intensity=curve, gaps=((70.0, 80.0),)
    )
    detents = ov.build_surface(timeline, dial(surface__intensity_gain=3.0)).detents
    depth = [np.ptp(detents.energy[round(c * 655.36) : round((c + 5) * 655.36)]) for c in (20, 60)]
    assert depth[1] == pytest.approx(4.0 * depth[0], rel=0.05)
    gap = detents.pull[round(76 * 655.36) : round(77 * 655.36)]
    assert np.abs(gap).max() < 0.01 * np.abs(detents.pull).max()
    # no edge pulls more than the detents do
    assert np.abs(detents.pull).max() < 8e-3 * 4.0 * 1.5
