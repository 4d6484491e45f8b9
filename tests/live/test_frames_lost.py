"""What an output lost, by the clock: it only grows, and no jitter or drift is in it."""

from __future__ import annotations

import random

import pytest

from overview_dsp.live.output.reconnecting_stream import FramesLost

RATE, BLOCK = 48_000, 256


def watch(delivered, seconds, jitter_s=0.02):
    """Look about 40 times a second at an output that has delivered `delivered(time_s)` frames."""
    dice, lost, time_s = random.Random(1), FramesLost(), 0.0
    counts = []
    while time_s < seconds:
        time_s += 0.005 + jitter_s * dice.random()
        frames = int(delivered(time_s)) // BLOCK * BLOCK
        lost.update(100.0 + time_s, frames, RATE, BLOCK)
        counts.append(lost.count)
    assert counts == sorted(counts)
    return lost


@pytest.mark.parametrize("drift", [-300e-6, 0.0, 300e-6])
def test_an_output_with_a_clock_of_its_own_loses_nothing(drift):
    assert watch(lambda t: t * RATE * (1.0 + drift), 600.0).count == 0


def test_gaps_add_up_and_are_not_taken_back_by_an_output_that_hurries_later():
    def delivered(t):
        behind = 0.1 * (t > 10.0) + 0.05 * (t > 20.0) - 0.1 * (t > 30.0)
        return (t - behind) * RATE

    assert watch(delivered, 40.0).count == pytest.approx(0.15 * RATE, abs=2 * BLOCK)


def test_a_pause_before_a_restart_does_not_count_as_lost_frames():
    lost = watch(lambda t: t * RATE, 5.0)
    lost.restart()
    for i in range(200):
        lost.update(300.0 + 0.02 * i, 5 * RATE + 0.02 * i * RATE, RATE, BLOCK)
    assert lost.count == 0
