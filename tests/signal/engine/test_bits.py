"""Bit for bit: partitions, reset, seeds, compiled against plain Python."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from tests.interpreted import interpreted
from tests.profiles import share

RATE = 48_000
FRAMES = 40_000
PARTITIONS = [1, 10, 17, 64, 256, 1536, 2027, 16384]


def load(engine, gesture):
    for stamp, theta2, touching in zip(
        gesture.stamps(engine.sample_rate), gesture.theta2, gesture.touching, strict=True
    ):
        engine.control(float(theta2), bool(touching), int(stamp))


def schedule(engine):
    """A sweep, another hand, parameters and a surface, all stamped."""
    load(engine, ov.sweep(0.4))
    engine.control(1.0, True, 12_000, source="twist")
    engine.control(2.0, True, 15_001, source="twist")
    engine.control(2.0, False, 21_000, source="twist")
    engine.set("tactor.gain_db", -9.0, sample_time=3_333)
    engine.set("disk.k2", 6e-3, sample_time=5_000)
    engine.set("surface.intensity_gain", 2.0, sample_time=9_999)
    engine.set("kinds.goal.height", 40.0, sample_time=18_000)
    engine.set("click.mute", True, sample_time=30_000)


def played(engine, sizes):
    out = np.full((FRAMES, 2), np.nan, dtype=np.float32)
    trace = np.full((FRAMES, 10), np.nan)
    start = 0
    for size in sizes:
        stop = min(FRAMES, start + size)
        engine.process(out[start:stop], trace[start:stop])
        start = stop
        if start == FRAMES:
            break
    assert start == FRAMES
    return out, trace


@pytest.fixture(scope="module")
def engine(match, football):
    engine = ov.Engine(football, match, seed=3)
    engine.prepare(RATE, FRAMES)
    return engine


def fresh(football, match, seed=3):
    engine = ov.Engine(football, match, seed=seed)
    engine.prepare(RATE, FRAMES)
    return engine


@pytest.fixture(scope="module")
def whole(match, football):
    engine = fresh(football, match)
    schedule(engine)
    return played(engine, [FRAMES])


def test_the_schedule_sounds(whole):
    out, trace = whole
    assert np.abs(out).max(axis=0).min() > 0.05
    assert np.isfinite(trace).all()


@pytest.mark.parametrize("size", PARTITIONS)
def test_no_block_size_changes_a_bit(match, football, whole, size):
    engine = fresh(football, match)
    schedule(engine)
    out, trace = played(engine, [size] * (FRAMES // size + 1))
    assert np.array_equal(out, whole[0])
    assert np.array_equal(trace, whole[1])


@settings(max_examples=share(0.3))
@given(st.lists(st.integers(1, 3000), min_size=5, max_size=200))
def test_no_random_partition_changes_a_bit(match, football, whole, sizes):
    engine = fresh(football, match)
    schedule(engine)
    out, trace = played(engine, [*sizes, FRAMES])
    assert np.array_equal(out, whole[0])
    assert np.array_equal(trace, whole[1])


def test_a_trace_changes_no_sample(match, football, whole):
    engine = fresh(football, match)
    schedule(engine)
    out = np.empty((FRAMES, 2), dtype=np.float32)
    engine.process(out)
    assert np.array_equal(out, whole[0])


def test_reset_is_as_new(match, football):
    gesture = ov.sweep(0.3) + ov.tap(0.6, 0.2)
    new = fresh(football, match)
    load(new, gesture)
    expected = played(new, [FRAMES])
    used = fresh(football, match)
    load(used, ov.tap(0.9, 0.4))
    played(used, [333] * 200)
    used.control(1.0, True)
    used.reset()
    load(used, gesture)
    again = played(used, [FRAMES])
    assert np.array_equal(expected[0], again[0])
    assert np.array_equal(expected[1], again[1])


def test_reset_keeps_the_parameters_and_the_surface(match, football):
    changed = fresh(football, match)
    changed.set("tactor.gain_db", -6.0)
    changed.set("kinds.goal.height", 30.0)
    played(changed, [FRAMES])
    changed.reset()
    load(changed, ov.sweep(0.5))
    preset = changed.preset
    direct = fresh(preset, match)
    load(direct, ov.sweep(0.5))
    assert np.array_equal(played(changed, [FRAMES])[0], played(direct, [FRAMES])[0])


def test_a_seed_repeats_every_bit_and_another_differs(match, football):
    outs = []
    for seed in (3, 3, 4):
        engine = fresh(football, match, seed)
        load(engine, ov.sweep(0.5))
        outs.append(played(engine, [FRAMES])[0])
    assert np.array_equal(outs[0], outs[1])
    assert not np.array_equal(outs[0][:, 0], outs[2][:, 0])
    assert np.array_equal(outs[0][:, 1], outs[2][:, 1])  # the grain is heard, not felt


def short_tap():
    """0.2 s that hold strikes, a release, the limiter and the grain: samples and trace."""
    result = ov.render("world-cup-final-2018", "football", ov.tap(0.95, 0.12), tail=0.08)
    table = np.column_stack([result.trace[name] for name in result.trace])
    return result.samples.tobytes() + table.tobytes()


def test_compiled_and_interpreted_kernels_give_the_same_bits():
    compiled = short_tap()
    assert len(compiled) > 9600 * (8 + 72)
    assert interpreted("tests.signal.engine.test_bits", "short_tap()") == compiled
