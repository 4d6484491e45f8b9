"""Engines side by side: each does what it does alone, whatever the others do."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.kernels.simd.block import FEWEST
from overview_dsp.kernels.simd.vector import SIMD_WIDTH
from overview_dsp.signal.engine.simd_batch import EngineBatch
from tests.examples import plain_preset, preset_with, timeline_of

RATE = 48_000
BLOCK = 3000
TIMELINE = timeline_of(20.0, 40.0, 50.0, 51.0, 80.0)
PRESETS = [plain_preset(), preset_with(), preset_with(disk__release="return")]
BLOCKS = st.lists(st.integers(1, BLOCK), min_size=1, max_size=5)


class Pair:
    """The same engine in a lane and alone."""

    def __init__(self, preset, seed, memory):
        self.engines = [ov.Engine(preset, TIMELINE, seed=seed) for _ in range(2)]
        for engine, place in zip(self.engines, (memory, None), strict=True):
            engine.prepare(RATE, BLOCK, memory=place)

    def each(self, what):
        for engine in self.engines:
            what(engine)

    def same(self):
        one, two = self.engines
        states = [
            engine.memory.view(np.int64)[layout.STATE : layout.TOTAL_STATE]
            for engine in self.engines
        ]
        np.testing.assert_array_equal(states[0], states[1])
        for column in ("time_s", "event", "torque", "level"):
            first, second = one.pop_strikes(), two.pop_strikes()
            np.testing.assert_array_equal(getattr(first, column), getattr(second, column))


def play(lanes, pairs, frames, trace):
    """A block of every pair (None: a lane without one), and whether lanes and alone agree."""
    engines = [pair.engines[0] if pair else None for pair in pairs]
    samples, traces = lanes.process(engines, frames, trace)
    for lane, pair in enumerate(pairs):
        if pair is None:
            continue
        out = np.zeros((frames, 2), np.float32)
        table = np.zeros((frames, 10))
        pair.engines[1].process(out, table if trace else None)
        np.testing.assert_array_equal(samples[lane], out)
        if trace:
            np.testing.assert_array_equal(traces[lane], table)
        pair.same()


@st.composite
def hands(draw):
    """Control events of a voice: samples apart, angles, holding on or not, by which source."""
    events = draw(
        st.lists(
            st.tuples(
                st.integers(0, 2000),
                st.floats(-0.5, 4.0),
                st.sampled_from([True, True, True, False]),
                st.sampled_from(["touch", "touch", "twist"]),
            ),
            max_size=12,
        )
    )
    return events


@given(
    given_hands=st.lists(hands(), min_size=SIMD_WIDTH, max_size=SIMD_WIDTH),
    presets=st.lists(st.sampled_from(PRESETS), min_size=SIMD_WIDTH, max_size=SIMD_WIDTH),
    empty=st.sets(st.integers(0, SIMD_WIDTH - 1), max_size=SIMD_WIDTH - 1),
    sizes=BLOCKS,
    trace=st.booleans(),
)
def test_every_voice_does_what_it_does_alone(given_hands, presets, empty, sizes, trace):
    lanes = EngineBatch(BLOCK)
    pairs = [
        None if lane in empty else Pair(preset, lane, lanes.memory(lane))
        for lane, preset in enumerate(presets)
    ]
    for pair, events in zip(pairs, given_hands, strict=True):
        time = 0
        for apart, theta2, touching, source in events:
            time += apart
            if pair:
                pair.each(lambda e, now=(theta2, touching, time, source): e.control(*now))
    for frames in sizes:
        play(lanes, pairs, frames, trace)


@pytest.fixture
def eight():
    lanes = EngineBatch(BLOCK)
    pairs = [Pair(PRESETS[lane % 3], lane, lanes.memory(lane)) for lane in range(SIMD_WIDTH)]
    for lane, pair in enumerate(pairs):
        for time in range(0, 12_000, 1 + 40 * lane + 30):
            theta2 = time / 12_000 * (3.0 - lane / 10)
            pair.each(lambda e, at=time, theta2=theta2: e.control(theta2, True, at))
    return lanes, pairs


def test_the_lanes_loops_are_what_is_tested_here(eight):
    lanes, pairs = eight
    engines = [pair.engines[0] for pair in pairs]
    lanes.process(engines, 100, False)
    from overview_dsp.kernels.simd import memory as lane_memory

    members = lanes.memory(0).base.view(np.int64)[lane_memory.MEMBER :][:SIMD_WIDTH]
    assert members.tolist() == [1] * SIMD_WIDTH
    assert FEWEST <= SIMD_WIDTH


def test_a_voice_that_changes_by_itself_changes_no_other(eight):
    lanes, pairs = eight
    play(lanes, pairs, 1000, False)
    pairs[2].each(lambda e: e.set("tactor.gain_db", -9.0, sample_time=1500))
    pairs[3].each(lambda e: e.set("surface.intensity_gain", 2.0, sample_time=2500))
    pairs[5].each(lambda e: e.set("disk.release", "return"))
    for frames in (700, 64, 1, 2999, 333, 3000):
        play(lanes, pairs, frames, True)


def test_a_voice_that_is_not_finite_is_reset_and_the_others_sound_on(eight):
    lanes, pairs = eight
    play(lanes, pairs, 1000, False)
    for number, column in ((1, layout.V), (4, layout.FOLLOWER), (6, layout.X)):
        pairs[number].each(lambda e, column=column: e.memory.__setitem__(column, np.nan))
    for frames in (256, 1000, 77):
        play(lanes, pairs, frames, True)
    resets = [pair.engines[0].meters.resets for pair in pairs]
    assert resets == [0, 1, 0, 0, 1, 0, 1, 0]


def test_voices_whose_channels_are_swapped_or_silent(eight):
    lanes, pairs = eight
    pairs[2].each(lambda engine: engine.set_channels(1, 0))
    pairs[5].each(lambda engine: engine.set_channels(None, 1))
    play(lanes, pairs, 2000, True)


def test_what_is_too_loud_is_held_under_the_ceiling_and_counted():
    loud = preset_with(height=200.0, click__gain_db=12.0, tactor__gain_db=12.0)
    lanes = EngineBatch(BLOCK)
    pairs = [
        Pair(loud if lane % 2 else PRESETS[0], lane, lanes.memory(lane))
        for lane in range(SIMD_WIDTH)
    ]
    for pair in pairs:
        pair.each(lambda engine: engine.control(3.0, True, 10))
    for frames in (1000, 77, 2000):
        play(lanes, pairs, frames, False)
    for lane, pair in enumerate(pairs):
        inside, alone = (engine.meters for engine in pair.engines)
        assert inside == alone
        assert (inside.limited_samples > 0) == bool(lane % 2)


def test_a_lane_without_a_voice_is_left_alone(eight):
    lanes, pairs = eight
    play(lanes, pairs, 500, False)
    before = pairs[4].engines[0].memory.copy()
    play(lanes, [*pairs[:4], None, *pairs[5:]], 500, False)
    np.testing.assert_array_equal(pairs[4].engines[0].memory.view(np.int64), before.view(np.int64))
    play(lanes, pairs, 500, True)


@pytest.mark.parametrize(
    "memory",
    [
        np.zeros(layout.TOTAL - 1),
        np.zeros(layout.TOTAL, np.float32),
        np.zeros(2 * layout.TOTAL)[::2],
        np.zeros((1, layout.TOTAL)),
    ],
)
def test_a_memory_of_another_kind_is_refused(memory):
    engine = ov.Engine(PRESETS[0], TIMELINE)
    with pytest.raises(ov.InputError, match="memory must be"):
        engine.prepare(RATE, BLOCK, memory=memory)
    with pytest.raises(ov.NotPreparedError):
        engine.process(np.zeros((10, 2), np.float32))


def test_a_vector_of_the_lanes_lies_in_one_cache_line():
    batches = [EngineBatch(64) for _ in range(3)]
    # the first voice's block follows whole rows of lanes
    assert all(batch.memory(0).ctypes.data % (8 * SIMD_WIDTH) == 0 for batch in batches)
