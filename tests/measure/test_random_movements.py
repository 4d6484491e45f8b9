"""Random hands: what they have in common, and that they differ in what they should."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov


@pytest.fixture(scope="module")
def hands():
    return [ov.measure.random_movement(seed) for seed in range(60)]


def test_each_random_movement_spans_the_timeline_and_releases_at_its_end(hands):
    for hand in hands:
        assert hand.theta2[0] == 0.0
        assert hand.theta2[-1] == hand.theta2.max() == np.pi
        assert hand.theta2.min() >= 0.0
        assert hand.touching[:-1].all()
        assert not hand.touching[-1]
        assert hand.duration_s == hand.time_s[-1] == hand.time_s[-2]


def test_some_turn_back_some_hesitate_and_all_change_their_pace(hands):
    back = still = 0
    for hand in hands:
        pace = np.diff(hand.theta2[:-1]) * 200.0 / np.pi
        back += pace.min() < -0.01
        still += bool((np.abs(pace[40:-40]) < 1e-9).any())
        moving = np.abs(pace[np.abs(pace) > 0.02])
        assert np.percentile(moving, 90) > 1.3 * np.percentile(moving, 10)
        # no jumps, but for the end, where it stops as a sweep does
        assert np.abs(np.diff(pace[:-1])).max() < 0.15
    assert 15 < back < 60
    assert 10 < still < 60


def test_random_movements_have_different_durations(hands):
    seconds = [hand.duration_s for hand in hands]
    assert min(seconds) < 4.0
    assert max(seconds) > 8.0


def test_a_seed_gives_the_same_movement(hands):
    again = ov.measure.random_movement(11)
    assert np.array_equal(hands[11].theta2, again.theta2)
    assert not np.array_equal(hands[11].theta2, hands[12].theta2)


def test_the_disk_reaches_the_end_in_a_random_movement(match, football):
    result = ov.render(match, football, ov.measure.random_movement(3), sample_rate=8000)
    assert result.trace.cursor.max() > 0.99
