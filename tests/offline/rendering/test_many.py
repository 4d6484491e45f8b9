from __future__ import annotations

import itertools
import threading
import weakref
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.design.gestures.model import Change
from overview_dsp.offline.rendering import many
from overview_dsp.signal.surface import cache as surface_cache
from overview_dsp.signal.surface.cache import SurfaceCache
from tests.examples import plain_preset, preset_with, timeline_of
from tests.profiles import share

RATE = 8000


def modelled(model, **values):
    """A preset whose events are of another friction model."""
    preset = preset_with(**values)
    kind = replace(preset.kinds["default"], model=model)
    return replace(preset, kinds={"default": kind})


TIMELINES = [timeline_of(), timeline_of(20.0, 50.0, 80.0), timeline_of(50.0)]
PRESETS = [
    plain_preset(),
    preset_with(),
    modelled("bristle", height=5.0),
    modelled("detent", height=2.0),
    modelled("end_stop", height=2.0),
    preset_with(disk__release="return"),
]
GESTURES = [
    ov.sweep(0.2),
    ov.tap(0.7, 0.1),
    ov.tap(0.2, 0.05) + ov.pause(0.1) + ov.sweep(0.1, 0.9, 0.3),
    ov.pause(0.0),
]
ALL = [
    ov.RenderJob(t, p, g, s)
    for t, p, g, s in itertools.product(TIMELINES, PRESETS, GESTURES, (0, 1))
]


def same(result, job, tail, trace, rate=RATE):
    alone = ov.render(job.timeline, job.preset, job.gesture, rate, job.seed, tail=tail, trace=trace)
    assert result.job is job
    assert result.sample_rate == alone.sample_rate
    assert result.samples.dtype == np.float32
    np.testing.assert_array_equal(result.samples, alone.samples)
    for column in ("time_s", "event", "torque", "level"):
        np.testing.assert_array_equal(
            getattr(result.strikes, column), getattr(alone.strikes, column)
        )
    assert (result.trace is None) == (alone.trace is None)
    if alone.trace is not None:
        for name, column in alone.trace.items():
            np.testing.assert_array_equal(result.trace[name], column)
    np.testing.assert_array_equal(result.surface.friction, alone.engine.surface.friction)


@settings(max_examples=share(0.3))
@given(
    chosen=st.lists(st.sampled_from(ALL), max_size=12),
    threads=st.integers(1, 4),
    tail=st.sampled_from(["none", 0.1]),
    trace=st.booleans(),
)
def test_each_voice_has_the_bits_it_has_alone(chosen, threads, tail, trace):
    results = list(ov.render_many(chosen, RATE, tail=tail, trace=trace, threads=threads))
    assert len(results) == len(chosen)
    for result, job in zip(results, chosen, strict=True):
        same(result, job, tail, trace)


def test_each_voice_ends_where_it_ends_alone():
    chosen = ALL[:: len(ALL) // 7]
    for result, job in zip(ov.render_many(chosen, RATE), chosen, strict=True):
        same(result, job, "rest", False)


def test_no_block_size_changes_a_bit(monkeypatch):
    chosen = ALL[3::11]
    whole = [result.samples for result in ov.render_many(chosen, RATE, tail=0.2)]
    monkeypatch.setattr(many, "BLOCK", 37)
    for samples, result in zip(whole, ov.render_many(chosen, RATE, tail=0.2), strict=True):
        np.testing.assert_array_equal(result.samples, samples)


def test_combinations_come_with_seeds_fastest():
    found = list(ov.render_jobs(TIMELINES[:2], PRESETS[:2], GESTURES[:1], range(3)))
    assert len(found) == 12
    assert [job.seed for job in found[:4]] == [0, 1, 2, 0]
    assert found[3].preset is PRESETS[1]
    assert found[6].timeline is TIMELINES[1]


def test_jobs_are_read_as_results_are_requested():
    taken = []

    def endless():
        for seed in itertools.count():
            taken.append(seed)
            yield ov.RenderJob(TIMELINES[1], PRESETS[1], GESTURES[1], seed)

    results = ov.render_many(endless(), RATE, tail="none", threads=2)
    for _ in range(5):
        next(results)
    assert len(taken) <= 5 + 2 * many.WAITING * many.GROUP
    results.close()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("jobs")]


def test_of_long_voices_fewer_are_taken_before_their_turn(monkeypatch):
    taken = []

    def endless():
        for seed in itertools.count():
            taken.append(seed)
            yield ov.RenderJob(TIMELINES[1], PRESETS[1], GESTURES[1], seed)

    # of two of these gestures, click and tactor
    monkeypatch.setattr(many, "GROUP_BYTES", 1.5 * GESTURES[1].duration_s * RATE * 2 * 4)
    results = ov.render_many(endless(), RATE, tail="none", threads=1)
    next(results)
    assert len(taken) == 2 * many.WAITING
    results.close()
    taken.clear()
    # a trace is nine times as large
    results = ov.render_many(endless(), RATE, tail="none", trace=True, threads=1)
    next(results)
    assert len(taken) == many.WAITING
    results.close()


def test_results_keep_no_engine_alive():
    results = ov.render_many(ALL[:8], RATE, tail="none", threads=1)
    references = [weakref.ref(result) for result in results]
    assert not [one for one in references if one() is not None]


def test_an_invalid_job_is_an_error_at_its_turn():
    good = ov.RenderJob(TIMELINES[1], PRESETS[1], GESTURES[1])
    bad = replace(good, preset=preset_with(tactor__frequency_hz=900.0))
    results = ov.render_many([good, bad, good], 1000, tail="none", threads=1)
    with pytest.raises(ov.InputError, match="too high"):
        list(results)
    ok = ov.render_many([replace(good, preset=preset_with(tactor__frequency_hz=250.0))], 1000)
    assert next(ok).sample_rate == 1000.0


def test_a_take_with_an_invalid_change_does_not_affect_other_jobs():
    good = ov.RenderJob(TIMELINES[1], PRESETS[1], GESTURES[1])
    change = Change(0.05, {"set": {"tactor.frequency_hz": 900.0}})
    bad = replace(good, gesture=replace(GESTURES[1], changes=(change,)))
    chosen = [good, good, good, bad, good, good, good]
    renderer = many.VoiceRenderer(1000, SurfaceCache())
    done = dict(renderer.render(enumerate(chosen), "none", ()))
    assert isinstance(done.pop(3), ov.InputError)
    for result in done.values():
        same(result, good, "none", False, 1000)
    results = ov.render_many(chosen, 1000, tail="none", threads=1)
    assert len([next(results) for _ in range(3)]) == 3
    with pytest.raises(ov.InputError):
        next(results)


@pytest.mark.parametrize("threads", [0, -1, 1.5, True, "2"])
def test_an_invalid_number_of_threads_is_refused_at_once(threads):
    with pytest.raises(ov.InputError, match="threads"):
        ov.render_many([], threads=threads)
    with pytest.raises(ov.InputError, match="tail"):
        ov.render_many([], tail="never")


def test_a_surface_is_built_once_for_all_it_serves(monkeypatch):
    built = []

    def counted(timeline, preset):
        built.append(preset)
        return ov.build_surface(timeline, preset)

    monkeypatch.setattr(surface_cache, "build_surface", counted)
    cache = SurfaceCache(most=2)
    preset = preset_with()
    first = cache.surface(TIMELINES[1], preset)
    # louder, heavier: on the same surface
    other = preset.with_changes({"tactor.gain_db": -3.0, "disk.inertia": 2e-4})
    assert cache.surface(TIMELINES[1], other) is first
    assert len(built) == 1
    cache.surface(TIMELINES[1], preset.with_changes({"surface.friction": 2e-3}))
    cache.surface(TIMELINES[2], preset)
    assert len(built) == 3
    # the least used has gone
    cache.surface(TIMELINES[1], preset)
    assert len(built) == 4


@settings(max_examples=share(0.6))
@given(data=st.data())
def test_an_engine_started_again_is_as_new(data):
    one, two = data.draw(st.sampled_from(ALL)), data.draw(st.sampled_from(ALL))
    engine = ov.Engine(one.preset, one.timeline, seed=one.seed)
    engine.prepare(RATE, 512)
    out = np.zeros((512, 2), np.float32)
    engine.control(2.0, True)
    engine.set("click.gain_db", -3.0)
    engine.process(out)
    engine.control(1.0, False, 5000)
    engine.restart(two.preset, two.timeline, seed=two.seed)
    new = ov.Engine(two.preset, two.timeline, seed=two.seed)
    new.prepare(RATE, 512)
    expected = np.zeros((512, 2), np.float32)
    for theta2, touching in [(1.5, True), (3.0, True), (3.0, False)] * 3:
        for each, block in ((engine, out), (new, expected)):
            each.control(theta2, touching)
            each.process(block)
        np.testing.assert_array_equal(out, expected)
    assert engine.save_state() == new.save_state()
    assert engine.timeline is two.timeline


def test_many_events_at_once_are_those_given_one_by_one():
    events = [(0.1 * i, i % 3 != 0, 40 * i, i % 6) for i in range(30)]
    theta2, touching, times, sources = (np.array(column) for column in zip(*events, strict=True))
    one, two = (ov.Engine(preset_with(), TIMELINES[1]) for _ in range(2))
    out = np.zeros((2000, 2), np.float32)
    expected = np.zeros((2000, 2), np.float32)
    for engine in (one, two):
        engine.prepare(RATE, 2000)
    one.control_all(theta2, touching, times, sources.astype(np.int8))
    for theta, touch, time, source in events:
        two.control(theta, touch, time, ov.gestures.SOURCES[source])
    one.process(out)
    two.process(expected)
    assert np.abs(out).max() > 0.0
    np.testing.assert_array_equal(out, expected)


def test_more_events_than_the_queue_holds_are_refused_completely():
    engine = ov.Engine(preset_with(), TIMELINES[1])
    engine.prepare(RATE, 100)
    count = 4097
    times = np.zeros(count, np.int64)
    sources = np.zeros(count, np.int8)
    with pytest.raises(ov.OverviewError, match="4097 control events of 'touch'"):
        engine.control_all(np.ones(count), np.ones(count, bool), times, sources)
    with pytest.raises(ov.InputError, match="source"):
        engine.control_all(np.ones(1), np.ones(1, bool), times[:1], np.array([6], np.int8))
    engine.process(np.zeros((100, 2), np.float32))
    assert not engine.meters.touching


def test_the_kernel_runs_without_the_interpreters_lock():
    frames = 2_000_000
    engine = ov.Engine(preset_with(), TIMELINES[1])
    engine.prepare(RATE, frames)
    engine.control(2.0, True)
    out = np.zeros((frames, 2), np.float32)
    thread = threading.Thread(target=engine.process, args=(out,))
    thread.start()
    seen = set()
    while thread.is_alive():
        seen.add(engine.sample_time)
    # under the lock, nothing between its beginning and its end could be seen
    assert len(seen - {0, frames}) > 1
