"""The torque's integral: what a motor that is told a few hundred times a second must not miss."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.kernels import layout

RATE = 48_000


def played(match, football, blocks):
    """The trace's torque, and the integral after each block, of one flick over the match."""
    engine = ov.Engine(football, match)
    engine.prepare(RATE, max(blocks))
    for n in range(400):
        engine.control(np.pi * n / 400, True, sample_time=60 * n)
    torque, looks = [], [engine.torque_integral]
    for frames in blocks:
        trace = np.zeros((frames, len(layout.TRACE_COLUMNS)))
        engine.process(np.zeros((frames, 2), dtype=np.float32), trace)
        torque.append(trace[:, layout.TRACE_COLUMNS.index("torque")])
        looks.append(engine.torque_integral)
    return np.concatenate(torque), looks


def test_the_integral_is_the_torque_summed_and_its_time_the_clock(match, football):
    torque, looks = played(match, football, [256] * 120)
    assert looks[0] == (0.0, 0.0)
    for n, (time_s, impulse) in enumerate(looks):
        assert time_s == pytest.approx(256 * n / RATE, abs=1e-12)
        assert impulse == pytest.approx(torque[: 256 * n].sum() / RATE, rel=1e-12, abs=1e-18)
    assert np.abs(torque).max() > 1e-3


def test_no_partition_into_blocks_changes_a_bit_of_it(match, football):
    one = played(match, football, [256] * 60)[1][-1]
    other = played(match, football, [1, 255, 64, 700, 4100, 240, 10000])[1][-1]
    assert one == other


def test_it_begins_again_with_reset(match, football):
    engine = ov.Engine(football, match)
    engine.prepare(RATE, 512)
    engine.control(2.0, True)
    engine.process(np.zeros((512, 2), dtype=np.float32))
    assert engine.torque_integral[1] != 0.0
    engine.reset()
    assert engine.torque_integral == (0.0, 0.0)
