"""The audio-plugin face: life cycle, control, parameters, latency, tail, state, hostile input."""

from __future__ import annotations

import itertools
import json
import math
import tracemalloc
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.kernels import layout
from tests.examples import plain_preset, preset_with, timeline_of
from tests.signal.engine.test_bits import load

CLAP_RATES = [
    1000.0, 1234.5678, 8000.0, 12345.678, 22050.0, 44100.0, 45678.901, 48000.0, 88200.0, 96000.0,
    123456.78, 192000.0, 384000.0, 768000.0,
]  # fmt: skip


def prepared(preset, timeline, rate=48_000, block=4096, seed=0):
    engine = ov.Engine(preset, timeline, seed=seed)
    engine.prepare(rate, block)
    return engine


def run(engine, frames, block=4096):
    out = np.full((frames, 2), np.nan, dtype=np.float32)
    trace = np.full((frames, 10), np.nan)
    for start in range(0, frames, block):
        engine.process(out[start : start + block], trace[start : start + block])
    return out, trace


# --- life cycle -----------------------------------------------------------------------------------


def test_using_it_before_prepare_says_so(match, football):
    engine = ov.Engine(football, match)
    for call in (
        lambda: engine.process(np.zeros((16, 2), dtype=np.float32)),
        lambda: engine.control(1.0, True),
        engine.reset,
        lambda: engine.meters,
        lambda: engine.latency_samples,
    ):
        with pytest.raises(ov.NotPreparedError, match="prepare"):
            call()


def test_a_block_larger_than_prepared_says_so_and_processes_nothing(match, football):
    engine = prepared(football, match, block=512)
    out = np.full((513, 2), 7.0, dtype=np.float32)
    with pytest.raises(ov.NotPreparedError, match="513"):
        engine.process(out)
    assert np.all(out == 7.0)
    assert engine.sample_time == 0


@pytest.mark.parametrize("rate", [0.0, 999.0, 768_001.0, -48_000.0, math.nan, math.inf])
def test_a_sample_rate_out_of_range_is_refused(match, football, rate):
    with pytest.raises(ov.InputError, match=r"sample_rate is .* Hz; must be 1000 to 768000 Hz"):
        prepared(football, match, rate)


def test_a_carrier_too_high_for_the_rate_is_refused_at_prepare_and_at_set(match, football):
    with pytest.raises(ov.InputError, match=r"tactor\.frequency_hz"):
        prepared(football.with_changes({"tactor.frequency_hz": 500.0}), match, 1000.0)
    engine = prepared(football, match, 1000.0)
    with pytest.raises(ov.InputError, match=r"tactor\.frequency_hz"):
        engine.set("tactor.frequency_hz", 450.0)
    assert engine.parameters["tactor.frequency_hz"].value == 250.0


@pytest.mark.parametrize(
    "out",
    [
        np.zeros((16, 2)),
        np.zeros(32, dtype=np.float32),
        np.zeros((2, 16), dtype=np.float32).T,
        np.zeros((16, 1), dtype=np.float32),
        [[0.0, 0.0]],
    ],
)
def test_an_output_of_the_wrong_kind_is_refused(match, football, out):
    with pytest.raises(ov.InputError, match="out "):
        prepared(football, match).process(out)


def test_it_may_be_prepared_again_at_another_rate(match, football):
    again = prepared(football, match, 44_100)
    load(again, ov.tap(0.5, 0.1))
    run(again, 8000)
    again.prepare(22_050, 4096)
    load(again, ov.sweep(0.2))
    direct = prepared(football, match, 22_050)
    load(direct, ov.sweep(0.2))
    assert np.array_equal(run(again, 9000)[0], run(direct, 9000)[0])


@pytest.mark.parametrize("rate", CLAP_RATES)
def test_every_rate_plays_finite_and_under_the_ceiling(match, football, rate):
    engine = prepared(football, match, rate)
    load(engine, ov.tap(0.9, 0.6))  # which unfolds over two seconds, past the kick-off by then
    out, trace = run(engine, round(0.7 * rate))
    assert np.isfinite(out).all()
    assert np.isfinite(trace).all()
    assert np.abs(out).max() <= 10 ** (-1 / 20)
    assert np.abs(out[:, 1]).max() > 0.1
    assert trace[:, 5].max() > 0.1


@pytest.mark.parametrize("size", [1, 10, 17, 256, 1536, 2027, 16384])
def test_every_sample_of_a_block_is_written_and_none_beyond(match, football, size):
    engine = prepared(football, match, block=16384)
    engine.control(2.0, True)
    whole = np.full((size + 8, 3), np.nan, dtype=np.float32)
    engine.process(whole[:size])
    assert np.isfinite(whole[:size]).all()
    assert np.isnan(whole[size:]).all()
    assert np.all(whole[:size, 2] == 0.0)


def test_processing_allocates_no_memory_that_stays(match, football):
    engine = prepared(football, match, block=256)
    out = np.zeros((256, 2), dtype=np.float32)
    load(engine, ov.sweep(1.0))
    engine.process(out)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        peak = before
        for _ in range(200):
            tracemalloc.reset_peak()
            engine.process(out)
            peak = max(peak, tracemalloc.get_traced_memory()[1])
        after = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    # only passing views and numbers to the kernel, never an array of samples
    assert peak - before < 4096
    assert after - before < 4096


def test_channels_can_be_mapped_to_a_four_channel_pad(match, football):
    engine = prepared(football, match)
    reference = prepared(football, match)
    engine.set_channels(click=None, tactor=3)
    engine.control(2.0, True)
    reference.control(2.0, True)
    four = np.full((2000, 4), np.nan, dtype=np.float32)
    two = np.zeros((2000, 2), dtype=np.float32)
    engine.process(four)
    reference.process(two)
    assert np.array_equal(four[:, 3], two[:, 1])
    assert np.all(four[:, :3] == 0.0)


def test_two_channels_may_be_swapped_but_not_shared(match, football):
    engine = prepared(football, match)
    reference = prepared(football, match)
    engine.set_channels(click=1, tactor=0)
    for one in (engine, reference):
        one.control(2.0, True)
    outs = [run(one, 2000)[0] for one in (engine, reference)]
    assert np.array_equal(outs[0], outs[1][:, ::-1])
    with pytest.raises(ov.InputError, match="share"):
        engine.set_channels(click=1, tactor=1)
    engine.set_channels(click=None, tactor=0)
    assert np.all(run(engine, 500)[0][:, 1] == 0.0)


# --- control --------------------------------------------------------------------------------------


def test_an_event_acts_at_its_sample_and_not_before():
    engine = prepared(plain_preset(), timeline_of())
    engine.control(1.0, True, 777)
    _, trace = run(engine, 1000)
    assert np.all(trace[:777, 2] == 0.0)
    assert np.all(trace[777:, 2] == 1.0)
    assert np.all(trace[:777, 7] == 0.0)
    assert trace[777, 7] > 0.0


def test_an_event_without_a_time_acts_at_the_next_block():
    engine = prepared(plain_preset(), timeline_of())
    run(engine, 100)
    engine.control(1.0, True)
    _, trace = run(engine, 10)
    assert trace[0, 2] == 1.0


def test_a_late_event_acts_at_once_and_is_counted():
    engine = prepared(plain_preset(), timeline_of())
    run(engine, 100)
    engine.control(1.0, True, 50)
    _, trace = run(engine, 10)
    assert trace[0, 2] == 1.0
    assert engine.meters.late_events == 1


def test_a_tap_is_the_same_step_wherever_the_hand_was():
    traces = []
    for before in (0.0, 3.0):
        engine = prepared(plain_preset(), timeline_of())
        engine.control(before, False, 0)
        engine.control(2.0, True, 500)
        traces.append(run(engine, 4000)[1])
    assert np.array_equal(traces[0][500:], traces[1][500:])
    assert traces[0][500, 1] == pytest.approx(2.0)


def test_touch_and_twist_with_the_same_events_give_the_same_bits(match, football):
    outs = []
    for source in ("touch", "twist"):
        engine = prepared(football, match)
        gesture = ov.sweep(0.3)
        for stamp, theta2, touching in zip(
            gesture.stamps(48_000), gesture.theta2, gesture.touching, strict=True
        ):
            engine.control(float(theta2), bool(touching), int(stamp), source=source)
        outs.append(run(engine, 20_000))
    assert np.array_equal(outs[0][0], outs[1][0])
    assert np.array_equal(outs[0][1], outs[1][1])


def test_the_last_to_touch_holds_the_disk_until_it_lets_go():
    engine = prepared(plain_preset(), timeline_of())
    engine.control(1.0, True, 0, source="twist")
    engine.control(2.0, True, 100, source="touch")
    engine.control(0.5, True, 200, source="twist")  # still held by touch
    engine.control(2.0, False, 10_000, source="touch")  # twist takes it over, without a step
    engine.control(0.5, False, 30_000, source="twist")
    _, trace = run(engine, 32_000)
    theta2, touching = trace[:, 1], trace[:, 2]
    assert theta2[50] == pytest.approx(1.0)
    assert np.allclose(theta2[100:10_000], 2.0)
    assert np.all(touching[:30_000] == 1.0)
    assert np.all(touching[30_000:] == 0.0)
    assert np.abs(np.diff(theta2[9_000:])).max() < 0.01
    assert theta2[29_999] == pytest.approx(0.5)


@pytest.mark.parametrize("order", list(itertools.permutations(("touch", "serial", "remote"))))
def test_of_the_hands_that_still_touch_the_latest_takes_over(order):
    engine = prepared(plain_preset(), timeline_of())
    for at, source in enumerate(order):
        engine.control(1.0 + at, True, 100 * at, source=source)
    holders = []
    for source in reversed(order):
        run(engine, 400)
        holders.append(engine.active_input)
        engine.control(0.0, False, source=source)
    run(engine, 400)
    assert holders == [(source, 1.0 + at) for at, source in reversed([*enumerate(order)])]
    assert engine.active_input is None


def test_at_the_same_sample_the_order_of_sources_is_fixed():
    for order in (("touch", "twist"), ("twist", "touch")):
        engine = prepared(plain_preset(), timeline_of())
        for source in order:
            engine.control({"touch": 1.0, "twist": 2.0}[source], True, 10, source=source)
        _, trace = run(engine, 20)
        assert trace[15, 1] == pytest.approx(2.0)  # twist comes second, so it touched last


@pytest.mark.parametrize("theta2", [math.nan, math.inf, -math.inf, 1e30, -1e30, 4.0, 5e-324])
def test_a_hostile_angle_is_survived_and_counted(match, football, theta2):
    rigid = football.with_changes(
        {"clutch.max_speed_ratio": 0.0}
    )  # else the trace has where it slipped to
    engine = prepared(rigid, match)
    engine.control(1.0, True, 0)
    engine.control(theta2, True, 1000)
    out, trace = run(engine, 48_000)
    assert np.isfinite(out).all()
    assert np.isfinite(trace).all()
    meters = engine.meters
    assert meters.rejected_events == (0 if math.isfinite(theta2) else 1)
    assert meters.clamped_events == (1 if math.isfinite(theta2) and abs(theta2) > 3.2 else 0)
    assert meters.resets == 0
    if not math.isfinite(theta2):
        assert np.allclose(trace[:, 1], 1.0)  # the hand stays where it was
    assert 0.0 <= trace[-1, 1] <= math.pi


def test_a_full_ring_drops_the_event_counts_it_and_says_so_once():
    engine = prepared(plain_preset(), timeline_of())
    for _ in range(layout.RING):
        engine.control(1.0, True)
    with pytest.warns(ov.OverviewWarning, match="dropped"):
        engine.control(1.0, True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        engine.control(1.0, True)
    assert engine.meters.dropped_events == 2
    run(engine, 10)
    engine.control(1.0, True)
    assert engine.meters.dropped_events == 2


@given(
    events=st.lists(
        st.tuples(
            st.floats(allow_nan=True, allow_infinity=True, width=64),
            st.booleans(),
            st.integers(0, 3000),
            st.sampled_from(["touch", "twist", "remote"]),
        ),
        max_size=40,
    )
)
def test_any_hands_leave_output_and_state_finite_and_without_denormals(match, football, events):
    engine = prepared(football, match, 8000)
    for theta2, touching, stamp, source in sorted(events, key=lambda event: event[2]):
        engine.control(theta2, touching, stamp, source)
    out, trace = run(engine, 6000)
    assert np.isfinite(out).all()
    assert np.isfinite(trace).all()
    assert engine.meters.resets == 0
    assert np.abs(out).max() <= 10 ** (-1 / 20)
    assert not denormal(out).any()
    assert not denormal(float_state(engine)).any()


def denormal(values):
    return (values != 0.0) & (np.abs(values) < np.finfo(values.dtype).tiny)


INTEGER_COLUMNS = {
    layout.CLOCK, layout.ENGAGED, layout.HOLDER, layout.TOUCH_COUNT, layout.NEXT_LOWER,
    layout.NEXT_UPPER, layout.ACTIVE_SLOT, layout.FADING_SLOT, layout.FADE_LEFT, layout.NOISE,
    layout.RINGING,
}  # fmt: skip


def float_state(engine):
    """The float64 columns of the state, from the memory block itself."""
    columns = [
        column for column in range(layout.STATE, layout.RINGING) if column not in INTEGER_COLUMNS
    ]
    bank = [*range(layout.BANK, layout.PULSE_KEY), *range(layout.PULSE_REST, layout.METERS)]
    return engine.memory[np.concatenate([columns, bank])]


def test_a_state_that_is_not_finite_is_reset_silenced_and_counted(match, football):
    engine = prepared(football, match)
    engine.control(1.0, True, 0)
    run(engine, 1000)
    engine.memory[layout.V] = math.nan
    out, _ = run(engine, 256, 256)
    assert np.all(out == 0.0)
    assert engine.meters.resets == 1
    assert engine.sample_time == 1256
    engine.control(1.0, True)
    out, _ = run(engine, 4096)
    assert np.isfinite(out).all()
    assert np.abs(out).max() > 0.0


# --- parameters -----------------------------------------------------------------------------------


def test_parameters_give_range_unit_default_and_value(football, match):
    engine = ov.Engine(football, match)
    assert set(engine.parameters) == set(ov.presets.PARAMETERS)
    for id, setting in engine.parameters.items():
        assert setting.id == id
        assert setting.doc.endswith(".")
        assert setting.check(setting.value) == setting.value
        assert setting.check(setting.default) == setting.default


@pytest.mark.parametrize(
    ("id", "value"),
    [
        ("tactor.gain_db", math.nan),
        ("tactor.gain_db", 12.1),
        ("tactor.gain_db", "loud"),
        ("tactor.mute", 1.0),
        ("disk.release", "drop"),
        ("tactor.gain", 0.0),
        ("kinds.goal.height", -1.0),
        ("kinds.nothing.height", 1.0),
        ("kinds.goal.depth", 1.0),
    ],
)
def test_a_wrong_parameter_is_refused_and_nothing_changes(match, football, id, value):
    engine = prepared(football, match)
    before = engine.save_state()
    with pytest.raises(ov.InputError):
        engine.set(id, value)
    assert engine.save_state() == before


def test_a_wrong_name_is_answered_with_the_nearest():
    engine = ov.Engine(plain_preset(), timeline_of())
    with pytest.raises(ov.InputError, match=r"tactor\.gain_db"):
        engine.set("tactor.gain_dB", 0.0)


def test_gain_changes_the_level_by_just_that_many_db(match, football):
    outs = []
    for gain in (0.0, -6.0):
        engine = prepared(football.with_changes({"tactor.gain_db": gain}), match)
        load(engine, ov.sweep(1.0))
        outs.append(run(engine, 30_000)[0][:, 1])
    quiet = np.abs(outs[0]) < 0.2  # where the limiter sleeps
    ratio = np.sqrt(np.mean(outs[1][quiet] ** 2) / np.mean(outs[0][quiet] ** 2))
    assert 20 * np.log10(ratio) == pytest.approx(-6.0, abs=0.1)


def test_mute_is_exact_silence_on_its_channel_alone(match, football):
    engine = prepared(football.with_changes({"click.mute": True}), match)
    load(engine, ov.sweep(0.5))
    out, _ = run(engine, 30_000)
    assert np.all(out[:, 0] == 0.0)
    assert np.abs(out[:, 1]).max() > 0.1


def test_a_parameter_glides_without_a_step_and_arrives_exactly(match, football):
    engine = prepared(football, match)
    engine.set("tactor.gain_db", -40.0, sample_time=100)
    assert engine.memory[layout.C_TACTOR_GAIN] == 1.0
    run(engine, 5000)
    assert engine.memory[layout.C_TACTOR_GAIN] == 10 ** (-40.0 / 20)


def test_return_keeps_shaft_2_and_takes_the_hand_back_to_the_start():
    recoil = prepared(plain_preset(), timeline_of())
    back = prepared(plain_preset(disk__release="return"), timeline_of())
    cursors = []
    for engine in (recoil, back):
        engine.control(2.0, True, 0)
        engine.control(2.0, False, 40_000)
        _, trace = run(engine, 80_000)
        cursors.append(trace[:, 5])
    assert cursors[0][39_999] == cursors[1][39_999]
    assert abs(cursors[1][60_000]) < 0.3 * cursors[0][60_000]


def test_two_writers_of_parameters_leave_the_output_finite(match, football):
    engine = prepared(football, match, 8000, 64)
    random = np.random.default_rng(5)
    live = [
        id for id, known in ov.presets.PARAMETERS.items() if not known.surface and not known.choices
    ]
    engine.control(2.0, True)
    for _ in range(300):
        for id in random.choice(live, 2, replace=False):
            known = ov.presets.PARAMETERS[id]
            engine.set(id, float(random.choice([known.low, known.default, known.high])))
        out, _ = run(engine, 64, 64)
        assert np.isfinite(out).all()
        assert np.abs(out).max() <= 10 ** (-1 / 20)


# --- latency and tail -----------------------------------------------------------------------------


@pytest.mark.parametrize("rate", [8000.0, 48_000.0, 192_000.0])
@pytest.mark.parametrize("smoothing", [1.0, 4.0, 20.0])
def test_latency_is_reported_truly(rate, smoothing):
    """An impulse of the hand: the centroid of what the disk gets is the delay."""
    engine = prepared(plain_preset(input__smoothing_ms=smoothing), timeline_of(), rate)
    start = 200
    engine.control(1.0, True, 0)
    engine.control(1.5, True, start)
    engine.control(1.0, True, start + 1)
    frames = round(rate * smoothing * 1e-3 * 40) + start
    _, trace = run(engine, frames)
    response = trace[:, 1] - 1.0
    centroid = (response * np.arange(frames)).sum() / response.sum() - start
    assert abs(engine.latency_samples - centroid) <= 0.5 + 1e-6
    assert trace[start, 7] != trace[start - 1, 7]  # and it begins to act at once


def test_a_tap_has_no_latency():
    engine = prepared(plain_preset(), timeline_of())
    engine.control(1.0, True, 100)
    out, trace = run(engine, 2000)
    assert trace[100, 7] > 0.0
    assert np.flatnonzero(out[:, 1])[0] <= 100 + 48


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"disk.release": "return"},
        {"tactor.decay_ms": 200.0, "click.gain_db": 12.0},
        {"surface.friction": 1e-4, "texture.gain_db": -20.0},
        {"surface.friction": 1e-3, "disk.k1": 1e-2},
    ],
)
def test_output_is_exactly_zero_within_the_reported_tail(match, football, changes):
    engine = prepared(football.with_changes(changes), match, 8000)
    gesture = ov.tap(1.0, 0.8)
    load(engine, gesture)
    release = round(gesture.duration_s * 8000)
    tail = math.ceil(engine.tail_seconds * 8000)
    out, _ = run(engine, release + tail + 8000)
    assert np.abs(out[release:]).max() > 0.01
    assert np.all(out[release + tail :] == 0.0)
    assert tail < 60 * 8000


def test_sixty_seconds_of_silence_leave_no_denormal_and_no_sound(match, football):
    engine = prepared(football, match, 8000)
    load(engine, ov.tap(0.7, 0.5))
    run(engine, 8000 * 60)
    out, _ = run(engine, 8000)
    assert np.all(out == 0.0)
    assert not denormal(float_state(engine)).any()


def test_the_disk_comes_to_exact_rest_without_denormals():
    engine = prepared(plain_preset(disk__k1=1.0), timeline_of(), 1000.0)
    engine.control(1.0, True, 0)
    engine.control(1.0, False, 500)
    for _ in range(700):
        run(engine, 4096)
        assert not denormal(float_state(engine)).any()
    assert engine.meters.cursor == 0.0


def test_holding_still_on_an_event_is_silent():
    timeline = timeline_of(50.0)
    engine = prepared(preset_with(), timeline)
    engine.control(math.pi / 2, True, 0)
    run(engine, 48_000 * 12)
    out, trace = run(engine, 4800)
    assert trace[-1, 5] == pytest.approx(0.5, abs=1e-3)
    assert np.all(out == 0.0)


# --- state ----------------------------------------------------------------------------------------


def test_state_round_trips_byte_for_byte(match, football):
    engine = prepared(football, match, seed=11)
    engine.set("tactor.gain_db", -3.25)
    engine.set("kinds.goal.width_ms", 9000.0)
    saved = engine.save_state()
    other = prepared(ov.load_preset("football"), match)
    other.load_state(saved)
    assert other.save_state() == saved
    load(engine, ov.sweep(0.3))
    engine.reset()
    for one in (engine, other):
        load(one, ov.sweep(0.3))
    assert np.array_equal(run(engine, 20_000)[0], run(other, 20_000)[0])


@given(data=st.binary(max_size=300))
def test_garbage_is_not_a_state(match, football, data):
    engine = ov.Engine(football, match)
    before = engine.save_state()
    with pytest.raises(ov.InputError):
        engine.load_state(data)
    assert engine.save_state() == before


@pytest.mark.parametrize("seed", range(3))
def test_a_megabyte_of_garbage_is_refused(match, football, seed):
    data = np.random.default_rng(seed).bytes(1 << 20)
    with pytest.raises(ov.InputError):
        ov.Engine(football, match).load_state(data)


@given(data=st.data())
def test_a_state_with_a_field_broken_is_refused_or_valid(match, football, data):
    engine = ov.Engine(football, match)
    state = json.loads(engine.save_state())
    place = state
    key = data.draw(st.sampled_from(sorted(place)))
    while isinstance(place[key], dict) and place[key] and data.draw(st.booleans()):
        place = place[key]
        key = data.draw(st.sampled_from(sorted(place)))
    place[key] = data.draw(
        st.none() | st.integers() | st.floats() | st.text(max_size=5) | st.lists(st.none())
    )
    before = engine.save_state()
    try:
        engine.load_state(json.dumps(state).encode())
    except ov.InputError:
        assert engine.save_state() == before


def test_a_hand_that_rests_at_the_start_leaves_no_denormals():
    engine = prepared(plain_preset(input__smoothing_ms=0.5), timeline_of(), 8000)
    engine.control(1.0, True, 0)
    engine.control(0.0, True, 100)
    for _ in range(30):
        run(engine, 2048)
        assert not denormal(float_state(engine)).any()


def test_an_engine_is_shown_with_its_preset_its_data_and_its_rate():
    engine = ov.Engine(preset_with(), timeline_of(5.0))
    shown = f"<Engine: {engine.preset.name!r} on {engine.timeline.title!r}, "
    assert repr(engine) == shown + "not prepared>"
    engine.prepare(8000, 64)
    assert repr(engine) == shown + "8000 Hz>"


def test_it_says_since_when_the_disk_is_at_the_finger():
    rate = 8000
    engine = prepared(preset_with(height=1.0), timeline_of(50.0), rate)
    assert engine.settled_at is None
    engine.control(3.0, True)
    run(engine, 8)
    assert engine.settled_at is None  # on its way
    run(engine, 4 * rate)
    arrived = engine.settled_at
    assert 8 < arrived < 4 * rate
    run(engine, rate)
    assert engine.settled_at == arrived
    engine.control(3.0, False)
    run(engine, 8)
    assert engine.settled_at is None
