"""What replaces preset, data, surface or seed: at its sample, all of it, and told afterwards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.design.presets.serialization import preset_to_dict
from overview_dsp.kernels import layout
from overview_dsp.kernels.derive import FADE_S, GLIDE_S
from overview_dsp.signal.engine import coefficients
from tests.examples import plain_preset, preset_with, timeline_of, with_friction
from tests.signal.engine.test_engine import prepared, run

RATE = 8000
FADE = round(FADE_S * RATE)
FLAT, FULL = (
    ov.Timeline(
        "level", 10.0, (), ov.Intensity(np.array([0.0, 5.0, 10.0]), np.array([low, 1.0, low]))
    )
    for low in (0.0, 1.0)
)
FOUR = plain_preset(surface__friction=4e-3)
BASE = timeline_of()

# what is done, the friction after it, and what a recording is told
CHANGES = {
    "set": (
        lambda engine, at: engine.set("surface.friction", 4e-3, at),
        {"set": {"surface.friction": 4e-3}},
    ),
    "set of a kind": (
        lambda engine, at: engine.set("kinds.default.height", 3.0, at),
        {"set": {"kinds.default.height": 3.0}},
    ),
    "preset": (lambda engine, at: engine.set_preset(FOUR, at), {"preset": preset_to_dict(FOUR)}),
    "timeline": (lambda engine, at: engine.set_timeline(FULL, at), None),
    "window": (
        lambda engine, at: engine.set_timeline(FULL, at, window=(10.0, 20.0)),
        {"window": [10.0, 20.0]},
    ),
    "surface": (
        lambda engine, at: engine.set_surface(ov.build_surface(BASE, FOUR), at),
        None,
    ),
}


def level_preset():
    """1e-3 where the data is 0, 4e-3 where it is 1; events as wide as a fifth, and of no height."""
    return preset_with(height=0.0, width=20.0, shape="plateau", surface__intensity_gain=3.0)


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_begins_at_its_sample_and_a_fade_later_its_surface_is_felt(name):
    change, note = CHANGES[name]
    quiet = ov.Timeline("quiet", 10.0, (ov.Event(5.0, "default"),), None)
    engine = prepared(level_preset(), quiet, RATE)
    engine.control(np.pi / 2, True)
    run(engine, RATE)
    before = (engine.preset, engine.timeline, engine.surface)
    change(engine, RATE + 500)
    assert engine.pop_changes() == []
    friction = run(engine, 500 + FADE + 500)[1][:, 6]
    assert np.all(friction[:500] == 1e-3)
    assert np.all(friction[501 : 500 + FADE] > 1e-3)
    assert friction[500 + FADE :] == pytest.approx(4e-3, rel=1e-6)
    assert engine.pop_changes() == [(RATE + 500, note)]
    assert engine.pop_changes() == []
    assert (engine.preset is before[0]) == (name in ("timeline", "window", "surface"))
    assert engine.timeline is (FULL if name in ("timeline", "window") else before[1])
    assert engine.surface is not before[2]
    assert engine.surface.friction_at(np.pi / 2) == pytest.approx(4e-3, rel=1e-6)
    # and it stays: as a new engine with what it says it has
    direct = ov.Engine(engine.preset, engine.timeline, surface=engine.surface)
    direct.prepare(RATE, 4096)
    engine.reset()
    assert np.array_equal(played(engine), played(direct))


def played(engine):
    engine.control(2.0, True)
    engine.control(1.0, False, 1000)
    return np.column_stack(run(engine, 2000))


def test_a_preset_is_taken_over_whole():
    engine = prepared(plain_preset(), BASE, RATE)
    engine.set_preset(FOUR.with_changes({"tactor.gain_db": -20.0, "disk.release": "return"}))
    run(engine, 1000)
    assert engine.preset.number("tactor.gain_db") == -20.0
    assert engine.memory[layout.C_TACTOR_GAIN] == pytest.approx(0.1)
    engine.control(2.0, True)
    engine.control(2.0, False, 2000)
    assert np.all(run(engine, 3000)[1][1:, 9] == 1.0)  # the shaft stays


def test_changes_are_reported_in_order_once_each_when_they_have_been_applied():
    engine = prepared(plain_preset(), BASE, RATE)
    engine.set("tactor.gain_db", -3.0, 100)
    engine.set("tactor.gain_db", -6.0, 100)
    engine.set("click.gain_db", -9.0, 900)
    run(engine, 500)
    expected = [(100, {"set": {"tactor.gain_db": gain}}) for gain in (-3.0, -6.0)]
    assert engine.pop_changes() == expected
    run(engine, 500)
    engine.set("tactor.gain_db", -6.0)  # nothing new
    assert engine.pop_changes() == [(900, {"set": {"click.gain_db": -9.0}})]


def test_of_changes_that_nobody_asks_for_the_latest_are_kept():
    engine = prepared(plain_preset(), BASE, RATE)
    count = layout.HOST_RING + 50
    for n in range(count):
        engine.set("tactor.gain_db", -1.0 - n % 2)
        run(engine, 1)
    taken = engine.pop_changes()
    assert [sample for sample, _ in taken] == list(range(50, count))


@pytest.mark.parametrize("rate", [1000.0, 48_000.0])
def test_a_glide_and_a_fade_take_their_milliseconds_at_any_rate(rate):
    engine = prepared(plain_preset(), BASE, rate)
    engine.control(2.0, True)
    engine.set("tactor.gain_db", -20.0)
    engine.set("surface.friction", 2e-3)
    glide, fade = round(GLIDE_S * rate), round(FADE_S * rate)
    gains, friction = [], []
    for _ in range(fade + 2):
        friction.append(run(engine, 1)[1][0, 6])
        gains.append(engine.memory[layout.C_TACTOR_GAIN])
    assert np.flatnonzero(np.array(gains) == gains[-1])[0] == pytest.approx(glide, abs=1)
    assert np.flatnonzero(np.array(friction) == 2e-3)[0] == pytest.approx(fade, abs=1)


def test_reset_ends_a_glide_at_its_end():
    engine = prepared(plain_preset(), BASE, RATE)
    for id, value in (("tactor.gain_db", -20.0), ("disk.k1", 5e-3), ("output.ceiling_db", -9.0)):
        engine.set(id, value)
    run(engine, 10)
    engine.set("tactor.gain_db", -30.0, 10_000)  # and one that waits is the preset's too
    engine.reset()
    expected = prepared(engine.preset, BASE, RATE).memory[: layout.COEFFS].copy()
    assert np.array_equal(engine.memory[: layout.COEFFS], expected)
    run(engine, 1)
    assert np.array_equal(engine.memory[: layout.COEFFS], expected)
    assert engine.pop_changes() == []


def test_changes_that_find_the_queue_full_change_nothing():
    engine = prepared(plain_preset(), BASE, RATE)
    for n in range(layout.HOST_RING - 1):  # a place is kept for a surface
        engine.set("tactor.gain_db", -1.0 - n % 2, 10_000)
    before = engine.save_state()
    with pytest.raises(ov.OverviewError, match="1023 parameter changes are pending"):
        engine.set("tactor.gain_db", -9.0)
    assert engine.save_state() == before
    engine.set("tactor.gain_db", engine.preset.values["tactor.gain_db"])  # nothing to push


# --- another preset, timeline and seed in the same memory -----------------------------------------


def test_restarted_it_is_as_a_new_one_and_what_does_not_fit_changes_nothing():
    engine = prepared(plain_preset(), timeline_of(20.0), RATE, seed=5)
    played(engine)
    timeline, preset = timeline_of(70.0, 80.0), preset_with(height=3.0)
    given = ov.build_surface(timeline, preset)
    for seed, surface in ((3, None), (4, given), (None, None)):
        engine.restart(
            preset, timeline, surface=surface, **({} if seed is None else {"seed": seed})
        )
        new = prepared(preset, timeline, RATE, seed=seed or 0)
        assert (engine.seed, engine.preset, engine.timeline) == (seed or 0, preset, timeline)
        assert (engine.surface is given) == (surface is given)
        assert np.array_equal(played(engine), played(new))
    before = (engine.seed, engine.preset, engine.timeline, engine.surface)
    with pytest.raises(ov.InputError, match=r"tactor\.frequency_hz"):
        prepared(preset, timeline, 1000).restart(plain_preset(tactor__frequency_hz=500.0), BASE)
    assert (engine.seed, engine.preset, engine.timeline, engine.surface) == before


def test_what_is_left_out_is_the_default():
    engine = ov.Engine(plain_preset(), BASE)
    assert (engine.seed, engine.sample_rate) == (0, 0.0)
    engine.prepare()
    assert engine.sample_rate == 48_000.0
    engine.process(np.zeros((512, 2), dtype=np.float32))
    with pytest.raises(ov.NotPreparedError):
        engine.process(np.zeros((513, 2), dtype=np.float32))
    given = with_friction(engine.surface, np.full(layout.CELLS + 1, 5e-3))
    assert ov.Engine(plain_preset(), BASE, surface=given).surface is given


def test_a_block_is_one_frame_or_more():
    engine = prepared(plain_preset(), BASE, RATE, block=1)
    run(engine, 3, 1)
    assert engine.sample_time == 3
    engine.prepare(768_000, 1)
    with pytest.raises(ov.InputError, match="max_block_size is 0; must be at least 1"):
        engine.prepare(RATE, 0)


def test_a_given_memory_is_the_engines_own():
    memory = np.zeros(layout.TOTAL)
    engine = ov.Engine(plain_preset(), BASE)
    engine.prepare(RATE, 512, memory=memory)
    assert engine.memory is memory
    assert memory[layout.S_SAMPLE_RATE] == RATE
    for wrong in (
        np.zeros(layout.TOTAL, np.float32),
        np.zeros(layout.TOTAL - 1),
        np.zeros((1, layout.TOTAL)),
        np.zeros(2 * layout.TOTAL)[::2],
    ):
        with pytest.raises(ov.InputError, match="memory must be"):
            engine.prepare(RATE, 512, memory=wrong)


def test_kernels_that_are_compiled_already_are_not_announced(capsys, monkeypatch):
    run(prepared(plain_preset(), BASE, RATE), 1)
    capsys.readouterr()
    monkeypatch.setattr(coefficients, "_announced", set())
    prepared(plain_preset(), BASE, RATE)
    assert capsys.readouterr() == ("", "")


# --- hands and what is reported -------------------------------------------------------------------


def test_events_given_together_are_those_given_one_by_one():
    one, all_ = (prepared(preset_with(), timeline_of(30.0), RATE) for _ in range(2))
    theta2 = np.linspace(0.1, 2.0, 50)
    touching = np.arange(50) % 20 != 19
    stamps = np.arange(50) * 40
    sources = (np.arange(50) % 3).astype(np.int8)
    for row in zip(theta2, touching, stamps, sources, strict=True):
        one.control(float(row[0]), bool(row[1]), int(row[2]), ov.gestures.SOURCES[row[3]])
    all_.control_all(theta2, touching, stamps, sources)
    assert np.array_equal(run(one, 3000)[1], run(all_, 3000)[1])
    rows, count = all_.pop_applied(0)
    assert count == 50
    assert np.array_equal(np.sort(rows["theta2"]), theta2)
    assert np.array_equal(rows["sample"], stamps)
    assert np.array_equal(rows["source"], sources)
    assert np.array_equal(rows["touching"], touching)
    later, count = all_.pop_applied(45)
    assert np.array_equal(later, rows[45:])


def test_strikes_are_named_by_the_surface_that_was_struck():
    preset = preset_with(height=5.0)
    engine = prepared(preset, timeline_of(20.0, 40.0, 60.0), RATE)
    engine.control(np.pi, True)
    run(engine, RATE)
    strikes = engine.pop_strikes()
    assert strikes.event.tolist() == [0, 1, 2]
    assert np.all((strikes.time_s > 0.0) & (strikes.time_s < 1.0))
    assert np.all(np.diff(strikes.time_s) > 1e-3)
    assert len(engine.pop_strikes()) == 0
    other = replace(timeline_of(), events=(ov.Event(10.0, "default"), ov.Event(50.0, "default")))
    engine.set_timeline(other)
    run(engine, RATE)
    engine.control(0.0, True)
    run(engine, RATE)
    assert engine.pop_strikes().event.tolist() == [1, 0]
    engine.reset()
    engine.control(np.pi, True)
    run(engine, RATE)
    assert engine.pop_strikes().event.tolist() == [0, 1]


def test_the_tactor_of_a_torque_is_the_vibration_alone():
    engine = prepared(plain_preset(), BASE, RATE)
    tone = engine.tactor_of(np.repeat([0.0, 0.02, 0.0], RATE))
    assert tone.shape == (3 * RATE,)
    assert np.all(tone[:RATE] == 0.0)
    assert np.abs(tone[RATE : 2 * RATE]).max() > 0.1
    assert np.all(tone[-RATE // 4 :] == 0.0)


def test_a_channel_that_is_nowhere_takes_no_place_and_the_default_is_0_and_1():
    one, other = (prepared(preset_with(), timeline_of(5.0), RATE) for _ in range(2))
    one.set_channels(click=0, tactor=None)
    alone = np.full((2000, 1), np.nan, dtype=np.float32)
    for engine in (one, other):
        engine.control(2.0, True)
    one.process(alone)
    both = run(other, 2000)[0]
    assert np.array_equal(alone[:, 0], both[:, 0])
    one.set_channels(None, None)
    assert not run(one, 500)[0].any()
    one.set_channels()
    run(other, 500)
    assert np.array_equal(run(one, 500)[0], run(other, 500)[0])
    with pytest.raises(ov.InputError, match="channel is -1; must be 0 or more"):
        one.set_channels(click=-1)


@pytest.mark.parametrize(
    "trace",
    [
        np.zeros((16, layout.TRACE), np.float32),
        np.zeros((15, layout.TRACE)),
        np.zeros((16, layout.TRACE - 1)),
        np.zeros((layout.TRACE, 16)).T,
    ],
)
def test_a_trace_of_the_wrong_kind_is_refused(trace):
    engine = prepared(plain_preset(), BASE, RATE)
    with pytest.raises(ov.InputError, match="trace must be"):
        engine.process(np.zeros((16, 2), dtype=np.float32), trace)
    locked = np.zeros((16, 2), dtype=np.float32)
    locked.flags.writeable = False
    with pytest.raises(ov.InputError, match="out must be a writable"):
        engine.process(locked)
