"""Clocks of pages, host and samples, and several inputs on one engine, without a network."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.web.messages import RemoteEvent
from overview_dsp.web.remote_inputs import (
    MAX_DELAY_S,
    SILENCE_TIMEOUT_S,
    PageClock,
    RemoteInputs,
    SampleClock,
)
from tests.profiles import share

RATE, BLOCK = 48_000, 256


class Machine:
    """An engine that runs in simulated time."""

    def __init__(self, match, football):
        self.engine = ov.Engine(football, match)
        self.engine.prepare(RATE, BLOCK)
        self.out = np.zeros((BLOCK, 2), np.float32)
        self.now = 100.0
        self._started = self.now
        self.inputs = RemoteInputs(self.engine, lambda: self.now)

    def to(self, seconds):
        """Play until a time."""
        while self.now < seconds - 1e-9:
            self.now = min(self.now + 0.002, seconds)
            while self.engine.sample_time < (self.now - self._started) * RATE:
                self.engine.process(self.out)
            self.inputs.update_clock()

    @property
    def applied(self):
        return self.engine.pop_applied(0)[0]


@pytest.fixture
def machine(match, football):
    return Machine(match, football)


@given(
    st.floats(-1e6, 1e6),
    st.lists(st.tuples(st.floats(0.0, 0.2), st.floats(0.0, 0.2)), min_size=1, max_size=30),
)
def test_the_offset_of_a_page_is_within_half_the_shortest_round_trip(offset, trips):
    clock = PageClock()
    at = 1000.0
    for there, back in trips:
        clock.add(at, at + there + offset, at + there + back)
        at += 0.25
    shortest = min(there + back for there, back in trips)
    assert abs(clock.host_time(500.0 + offset) - 500.0) <= shortest / 2.0 + 1e-6


def test_a_reply_before_its_ping_is_ignored():
    clock = PageClock()
    clock.add(5.0, 1.0, 4.0)
    assert clock.round_trip_s is None


def test_the_delay_follows_the_slowest_recent_event_and_is_bounded(machine):
    remote = machine.inputs.join()
    remote.clock.add(100.0, 100.0, 100.0)
    ages = (
        (100.1, 0.02, 0.02),
        (100.2, 0.005, 0.02),
        (100.3, 5.0, MAX_DELAY_S),
        (102.6, -1.0, 0.0),
    )
    for now_s, age_s, delay_s in ages:
        machine.to(now_s)
        machine.inputs.move(remote, (RemoteEvent(machine.now - age_s, 1.0, True),))
        assert math.isclose(remote.delay.value, delay_s, abs_tol=1e-9)


def test_the_sample_of_the_current_time_is_in_the_next_block(machine):
    clock = SampleClock(machine.engine)
    for step in range(1, 600):
        machine.to(100.0 + step * 0.0031)
        clock.update(machine.now)
        sample = clock.sample_at(machine.now)
        assert 0 <= sample - machine.engine.sample_time <= 2 * BLOCK or step < 5
        assert abs(clock.time_of(sample) - machine.now) < 1e-3
    assert clock.is_running(machine.now)
    assert not clock.is_running(machine.now + 1.0)


def test_a_movement_keeps_its_timing_when_events_are_delayed(machine):
    random = np.random.default_rng(3)
    remote = machine.inputs.join()
    offset = -77.0
    machine.to(100.1)
    remote.clock.add(machine.now, machine.now + offset, machine.now)
    moments = 100.2 + 0.01 * np.arange(100)
    arrivals = np.maximum.accumulate(moments + 0.001 + 0.03 * random.random(100))
    for moment, arrival in zip(moments, arrivals, strict=True):
        machine.to(arrival)
        theta2 = float(moment - 100.2)
        machine.inputs.move(remote, (RemoteEvent(moment + offset, theta2, True),))
    machine.to(101.5)
    applied = machine.applied
    assert len(applied) == 100
    steady = np.diff(applied["sample"][30:])
    # the delay settles; then the events are 10 ms apart, as they were created
    assert np.abs(steady - 0.01 * RATE).max() <= 0.001 * RATE
    assert np.abs(np.diff(arrivals[30:]) - 0.01).max() > 0.01


@given(
    st.lists(
        st.tuples(
            st.integers(0, 2),
            st.sampled_from(["touch", "release", "leave", "lie", "wait"]),
            st.floats(0.0, math.pi),
            st.floats(0.0, 1e9),
        ),
        max_size=25,
    )
)
@settings(max_examples=share(0.5))
def test_events_stay_in_order_and_the_disk_is_released_at_the_end(match, football, steps):
    machine = Machine(match, football)
    inputs = [machine.inputs.join() for _ in range(3)]
    machine.to(100.1)
    for which, what, theta2, page_s in steps:
        remote = inputs[which]
        if what == "leave":
            machine.inputs.leave(remote)
            inputs[which] = machine.inputs.join()
        elif what == "lie":
            remote.clock.add(machine.now - 0.01, page_s, machine.now)
        elif what == "wait":
            machine.to(machine.now + 0.05)
        else:
            machine.inputs.move(remote, (RemoteEvent(page_s, theta2, what == "touch"),))
    for remote in inputs:
        machine.inputs.leave(remote)
    machine.to(machine.now + MAX_DELAY_S + 0.05)
    assert not machine.engine.meters.touching
    assert machine.engine.meters.late_events == 0
    applied = machine.applied
    assert (np.diff(applied["sample"]) >= 0).all()


def test_only_inputs_that_touch_can_be_silent(machine):
    remote = machine.inputs.join()
    machine.to(102.0)
    assert not machine.inputs.is_silent(remote)
    machine.inputs.move(remote, (RemoteEvent(0.0, 1.0, True),))
    machine.to(102.0 + SILENCE_TIMEOUT_S - 0.01)
    assert not machine.inputs.is_silent(remote)
    machine.to(102.0 + SILENCE_TIMEOUT_S + 0.01)
    assert machine.inputs.is_silent(remote)


def test_without_sound_movements_are_dropped_but_releases_are_applied(machine):
    remote = machine.inputs.join()
    machine.to(100.2)
    machine.inputs.move(remote, (RemoteEvent(0.0, 1.0, True),))
    machine.to(100.3)
    machine.now += 5.0  # the output has stopped
    for _ in range(5000):
        machine.inputs.move(remote, (RemoteEvent(0.0, 2.0, True),))
    machine.inputs.leave(remote)
    machine.engine.process(machine.out)
    applied = machine.applied
    assert applied["theta2"][applied["touching"]].tolist() == [1.0]
    assert not machine.engine.meters.touching
    assert machine.engine.meters.dropped_events == 0
