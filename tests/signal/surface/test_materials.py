"""Named materials: their modes, and where the base surface is struck."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.presets.parameters import KIND_PARAMETERS, MATERIALS
from overview_dsp.kernels import layout
from overview_dsp.kernels.layout import MAX_MODES
from overview_dsp.signal.engine.surface_slots import timeline_events
from overview_dsp.signal.surface.base_surface import crests_of, troughs_of
from overview_dsp.signal.surface.materials import louder, modes_of
from tests.examples import plain_preset, preset_with, timeline_of

PITCH = KIND_PARAMETERS["pitch_hz"]


@given(st.sampled_from(MATERIALS), st.floats(PITCH.low, PITCH.high))
def test_every_material_at_every_pitch_is_a_click_a_kind_may_have(material, pitch):
    modes = modes_of(material, pitch)
    kind = ov.EventKind(height=1.0, width_percent=1.0, modes=modes)
    assert (len(kind.modes) == 0) == (material == "none")
    assert len(modes) <= MAX_MODES
    if modes:
        assert modes[0].frequency_hz == pitch
        assert (np.diff([mode.frequency_hz for mode in modes]) > 0.0).all()


def test_materials_are_distinguished_by_how_long_they_ring():
    decay = {name: modes_of(name, 1000.0)[0].decay_ms for name in MATERIALS if name != "none"}
    order = sorted(decay, key=decay.__getitem__)
    assert order == ["card", "plastic", "wood", "glass", "metal"]
    # a just noticeable step of decay is about a third: each is well beyond
    assert all(decay[b] > 2.0 * decay[a] for a, b in itertools.pairwise(order))


def test_a_struck_bar_of_wood_decays_by_its_internal_friction():
    first, second, *_ = modes_of("wood", 440.0)
    assert first.decay_ms == pytest.approx(1000.0 * math.log(1000.0) / (math.pi * 440.0 * 0.02))
    assert second.frequency_hz / first.frequency_hz == pytest.approx(2.757)
    assert second.decay_ms == pytest.approx(first.decay_ms / 2.757, rel=1e-9)


def test_modes_that_are_given_win_over_the_material():
    given_ = ov.ClickMode(1234.0, 50.0)
    base = preset_with(modes=())
    for modes, expected in (((given_,), (given_,)), ((), modes_of("glass", 2000.0))):
        kind = replace(base.kinds["default"], material="glass", pitch_hz=2000.0, modes=modes)
        preset = replace(base, kinds={"default": kind})
        assert ov.build_surface(timeline_of(50.0), preset).kind_modes == (expected,)


def rough(**changes):
    values = {
        "surface__pattern": "waves",
        "surface__pattern_height": 3.0,
        "surface__pattern_period_percent": 5.0,
        "surface__material": "card",
        "click__gain_db": 12.0,
        **changes,
    }
    return plain_preset(**values)


def test_a_crest_of_the_pattern_strikes_the_material():
    result = ov.render(timeline_of(), rough(), ov.sweep(4.0, 0.0, 0.985), tail=1.0)
    # on the way out, which goes on until the disk has arrived
    held = result.trace.engaged > 0.5
    assert not held[-1]
    release = result.trace.time[held][-1]
    strikes = result.strikes
    assert (strikes.event == -1).all()
    crests = (np.arange(20) + 0.5) / 20
    time = np.interp(crests, result.trace.cursor[held], result.trace.time[held])
    out = strikes.time_s[strikes.time_s <= release]
    assert out == pytest.approx(time, abs=2e-3)
    assert np.abs(result.samples[:, 0]).max() > 0.01


def test_a_surface_without_material_or_pattern_strikes_nothing():
    for bare in (rough(surface__material="none"), rough(surface__pattern="none")):
        result = ov.render(timeline_of(), bare, ov.sweep(1.0), tail="none")
        assert len(result.strikes) == 0


def test_events_among_crests_keep_their_numbers():
    timeline = timeline_of(70.0, 20.0, 50.0)
    preset = replace(rough(), kinds=preset_with(width=0.5).kinds)
    surface = ov.build_surface(timeline, preset)
    count = len(surface.position) + len(surface.texture_strikes.position)
    events = timeline_events(surface)[:count]
    assert events[events >= 0].tolist() == surface.event.tolist()
    assert timeline_events(surface)[-1] == -1
    result = ov.render(timeline, preset, ov.sweep(5.0), tail="none")
    out = result.strikes.time_s < 5.5
    assert result.strikes.event[out & (result.strikes.event >= 0)].tolist() == [
        int(event) for event in surface.event
    ]
    # and bristles name the same events
    kind = replace(preset.kinds["default"], model="bristle", height=1.0)
    stuck = replace(preset, kinds={"default": kind})
    engine = ov.render(timeline, stuck, ov.sweep(2.0), tail="none").engine
    base = layout.SURFACES + layout.SLOT_OWNER
    cells = (engine.surface.position * layout.CELLS).astype(int)
    owners = engine.memory.view(np.int64)[base + cells]
    assert timeline_events(engine.surface)[owners].tolist() == engine.surface.event.tolist()


def test_gaps_have_no_crests():
    whole = ov.build_surface(timeline_of(), rough())
    gapped = replace(timeline_of(), gaps=((40.0, 60.0),))
    surface = ov.build_surface(gapped, rough())
    assert len(whole.texture_strikes.position) == 20
    assert len(surface.texture_strikes.position) == 16


def test_events_that_crests_leave_no_capacity_for_fall_together():
    times = np.linspace(1.0, 99.0, 16_000)
    preset = rough(surface__pattern_period_percent=0.05)
    with pytest.warns(ov.OverviewWarning, match="16000 events"):
        surface = ov.build_surface(timeline_of(*times), preset)
    crests = len(surface.texture_strikes.position)
    assert crests == 2000
    assert 0 < len(surface.position) <= layout.MAX_EVENTS - crests


def test_what_is_held_rings_as_much_shorter_at_the_same_pitches():
    free, held = modes_of("metal", 2000.0), modes_of("metal", 2000.0, 0.1)
    assert [mode.frequency_hz for mode in held] == [mode.frequency_hz for mode in free]
    assert held[0].decay_ms == pytest.approx(0.1 * free[0].decay_ms)


def test_modes_end_at_20_khz_and_no_decay_leaves_what_a_mode_may_have():
    pitch = 20_000.0 / 2.32
    assert [mode.frequency_hz for mode in modes_of("glass", pitch)] == [pitch, pitch * 2.32]
    assert len(modes_of("glass", math.nextafter(pitch, 1e5))) == 1
    assert modes_of("metal", 20.0)[0].decay_ms == 5000.0
    assert modes_of("card", 4000.0, 0.1)[0].decay_ms == 1.0


def test_each_mode_is_softer_than_the_one_before_by_what_the_surface_lets_through():
    assert [mode.gain_db for mode in modes_of("glass", 500.0)] == [0.0, -2.5, -5.0, -7.5, -10.0]
    raised = louder(modes_of("card", 500.0), -7.0)
    assert [mode.gain_db for mode in raised] == [-7.0, -10.0, -13.0, -16.0]
    assert [(mode.frequency_hz, mode.decay_ms) for mode in raised] == [
        (mode.frequency_hz, mode.decay_ms) for mode in modes_of("card", 500.0)
    ]


def test_crests_and_troughs_of_a_course():
    course = np.array([1.0, 0.2, 0.5, 0.5, 0.1, 0.1, 0.8, 0.3, 0.4])
    top, bottom = crests_of(course, np.full(9, 3.0)), troughs_of(course, 5.0)
    # of a flat top the first point; the ends are none
    assert top.position == pytest.approx(np.array([2, 6]) / 8)
    assert top.release == pytest.approx([1.5, 2.4])
    assert bottom.position == pytest.approx(np.array([1, 4, 7]) / 8)
    assert bottom.release.tolist() == [5.0, 5.0, 5.0]
    assert crests_of(np.array([0.0, 1.0, 0.0]), np.ones(3)).position.tolist() == [0.5]
