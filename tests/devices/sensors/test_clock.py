from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.devices.sensors.reading import Counters
from overview_dsp.devices.sensors.stream import WRAP, ArrivalClock, StampClock


def stamped(stamps, name="t_us"):
    counters = Counters()
    clock = StampClock(counters)
    return clock.times([{name: float(stamp)} for stamp in stamps], 0.0), counters


@given(st.integers(0, WRAP - 1), st.lists(st.integers(1, 9_000_000), max_size=30))
def test_a_clock_is_unwrapped_from_any_start(start, steps):
    stamps = [(start + sum(steps[:n])) % WRAP for n in range(len(steps) + 1)]
    times, counters = stamped(stamps)
    assert np.allclose(times, np.cumsum([0, *steps]) * 1e-6, rtol=0, atol=1e-6)
    assert counters.clock_wraps == (start + sum(steps)) // WRAP
    assert counters.clock_restarts == 0


@pytest.mark.parametrize(("name", "unit"), [("t_us", 1e-6), ("t_ms", 1e-3), ("t_s", 1.0)])
def test_stamps_come_in_three_units(name, unit):
    times, _ = stamped([round(5.0 / unit), round(5.0 / unit) + round(2.0 / unit)], name)
    assert times == pytest.approx([0.0, 2.0])


def test_a_device_that_begins_again_goes_on_where_it_was_and_is_counted():
    times, counters = stamped([50_000_000, 50_001_000, 300, 1300])
    assert times == pytest.approx([0.0, 0.001, 0.001, 0.002])
    assert all(b > a for a, b in pairwise(times))
    assert (counters.clock_restarts, counters.clock_wraps) == (1, 0)


def test_a_repeated_and_a_disordered_sample_are_dropped():
    times, counters = stamped([5_000_000, 5_001_000, 5_001_000, 5_000_500, 5_002_000])
    assert [time is None for time in times] == [False, False, True, True, False]
    assert (counters.repeated, counters.disordered) == (1, 1)


@pytest.mark.parametrize("rate", [25.0, 100.0, 285.7, 1000.0, 2000.0])
def test_jitter_of_arrival_is_taken_off(rate):
    """Bursts every 16 ms at worst, as USB serial adapters send: the times are even all the same."""
    dice = np.random.default_rng(3)
    true = np.arange(round(rate * 12)) / rate
    arrival = np.ceil((true + 1e-3 * dice.random(len(true))) / 0.016) * 0.016
    clock = ArrivalClock()
    times = []
    for moment in np.unique(arrival):
        times += clock.times([{}] * int((arrival == moment).sum()), moment)
    late = len(true) // 2
    steps = np.diff(times[late:])
    assert (steps > 0.0).all()
    # batches come up to 16 ms late, evenly spread: the loop rests in the middle
    wander = np.array(times[late:]) - true[late:]
    assert np.ptp(wander) < 0.008
    assert np.mean(steps) == pytest.approx(1.0 / rate, rel=2e-3)


def test_an_interruption_is_no_jitter():
    clock = ArrivalClock()
    for n in range(1000):
        clock.times([{}], n * 0.01)
    (after,) = clock.times([{}], 15.0)
    assert after == 15.0


@given(st.lists(st.tuples(st.integers(1, 5), st.floats(0.0, 2.0)), max_size=80))
def test_times_never_go_back_whenever_samples_arrive(batches):
    clock = ArrivalClock()
    now, last = 0.0, 0.0
    for count, later in batches:
        now += later
        for time in clock.times([{}] * count, now):
            assert time >= last
            last = time


def test_a_sensor_that_changes_its_pace_is_followed():
    clock = ArrivalClock()
    true = np.cumsum(np.r_[np.full(1000, 0.010), np.full(3000, 0.0103)])
    found = np.array([time for moment in true for time in clock.times([{}], moment)])
    assert np.abs(found - true)[2500:].max() < 2e-4
