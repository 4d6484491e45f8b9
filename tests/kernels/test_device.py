"""The device's stage: what is kept for a delay, and how long callbacks took."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.kernels import layout
from overview_dsp.kernels.device.callback import record_busy_time
from overview_dsp.kernels.device.output_stage import finish_block
from overview_dsp.live.output.settings import MAX_DELAY_MS, OutputSettings

BLOCKS = (1, 7_000, 64, 20_000, 33)


@pytest.mark.parametrize("channels", [2, 3])
@pytest.mark.parametrize("rate", [1_000.0, 48_000.0, 192_000.0])
def test_the_longest_delay_gives_back_what_was_passed_through(match, football, rate, channels):
    engine = ov.Engine(football, match)
    engine.prepare(rate, max(BLOCKS))
    memory = engine.memory
    w = memory.view(np.int64)
    OutputSettings().write(memory, rate, at_once=True)
    rng = np.random.default_rng(1)
    given_ = rng.uniform(-1.0, 1.0, (sum(BLOCKS), channels)).astype(np.float32)
    got = given_.copy()
    delay = round(MAX_DELAY_MS * 1e-3 * rate)
    start = 0
    for i, frames in enumerate(BLOCKS):
        if i == len(BLOCKS) - 2:
            w[layout.L_DELAY_WANTED : layout.L_DELAY_WANTED + 2] = delay
        finish_block(memory, w, got[start : start + frames].reshape(-1), frames, channels)
        start += frames
    later = start - BLOCKS[-1]  # the crossfade is over
    assert np.array_equal(got[: BLOCKS[0] + BLOCKS[1]], given_[: BLOCKS[0] + BLOCKS[1]])
    assert np.array_equal(got[later:, :2], given_[later - delay : start - delay, :2])
    assert np.array_equal(got[later:, 2:], given_[later:, 2:])


@numba.njit
def recorded(f64, i64, seconds):
    record_busy_time(f64, i64, seconds, 64)


@given(seconds=st.one_of(st.floats(0.0, 2e-6), st.floats(1e-6, 30.0)))
def test_a_callbacks_time_is_counted_in_its_part_of_an_octave(seconds):
    f64 = np.zeros(layout.L_BUSY + layout.BUSY_BINS)
    i64 = f64.view(np.int64)
    recorded(f64, i64, seconds)
    bins = i64[layout.L_BUSY : layout.L_BUSY + layout.BUSY_BINS]
    assert bins.sum() == 1
    exact = layout.BINS_PER_OCTAVE * math.log2(max(seconds / layout.SHORTEST_S, 1.0))
    found = int(bins.argmax())
    last = layout.BUSY_BINS - 1
    assert found <= exact + 1e-9
    assert exact < found + 1 + 1e-9 or found == last
