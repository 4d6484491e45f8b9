"""The clocks of pages, host and samples, and what many hands do to one engine; no network."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.web.clocks import MAX_DELAY_S, Delay, PageClock, SampleClock
from overview_dsp.web.hands import SILENCE_S, RemoteHands
from overview_dsp.web.messages import RemoteEvent
from tests.profiles import share

RATE, BLOCK = 48_000, 256


class Machine:
    """An engine whose blocks come in time, and a clock that we set."""

    def __init__(self, match, football):
        self.engine = ov.Engine(football, match)
        self.engine.prepare(RATE, BLOCK)
        self.out = np.zeros((BLOCK, 2), np.float32)
        self.now = 100.0
        self._started = self.now
        self.hands = RemoteHands(self.engine, lambda: self.now)

    def to(self, seconds):
        """Play until then."""
        while self.now < seconds - 1e-9:
            self.now = min(self.now + 0.002, seconds)
            while self.engine.sample_time < (self.now - self._started) * RATE:
                self.engine.process(self.out)
            self.hands.look()

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
        clock.note(at, at + there + offset, at + there + back)
        at += 0.25
    shortest = min(there + back for there, back in trips)
    assert abs(clock.host_time(500.0 + offset) - 500.0) <= shortest / 2.0 + 1e-6


def test_an_answer_from_before_its_ping_is_no_answer():
    clock = PageClock()
    clock.note(5.0, 1.0, 4.0)
    assert not clock.known


def test_waiting_follows_the_slowest_of_the_last_seconds_and_is_bounded():
    delay = Delay()
    assert delay.note(0.0, 0.02) == 0.02
    assert delay.note(0.1, 0.005) == 0.02
    assert delay.note(0.2, 5.0) == MAX_DELAY_S
    assert delay.note(2.5, -1.0) == 0.0


def test_a_sample_of_now_is_in_the_next_block(machine):
    clock = SampleClock(machine.engine)
    for step in range(1, 600):
        machine.to(100.0 + step * 0.0031)
        clock.look(machine.now)
        sample = clock.sample_at(machine.now)
        assert 0 <= sample - machine.engine.sample_time <= 2 * BLOCK or step < 5
        assert abs(clock.time_of(sample) - machine.now) < 1e-3
    assert clock.runs(machine.now)
    assert not clock.runs(machine.now + 1.0)


def test_a_movement_keeps_its_course_however_late_its_events_come(machine):
    random = np.random.default_rng(3)
    hand = machine.hands.join()
    offset = -77.0
    machine.to(100.1)
    hand.clock.note(machine.now, machine.now + offset, machine.now)
    moments = 100.2 + 0.01 * np.arange(100)
    comes = np.maximum.accumulate(moments + 0.001 + 0.03 * random.random(100))
    for moment, arrival in zip(moments, comes, strict=True):
        machine.to(arrival)
        theta2 = float(moment - 100.2)
        machine.hands.move(hand, (RemoteEvent(moment + offset, theta2, True),))
    machine.to(101.5)
    applied = machine.applied
    assert len(applied) == 100
    steady = np.diff(applied["sample"][30:])
    # the delay settles; then the events lie as they were made, 10 ms apart
    assert np.abs(steady - 0.01 * RATE).max() <= 0.001 * RATE
    assert np.abs(np.diff(comes[30:]) - 0.01).max() > 0.01


@given(
    st.lists(
        st.tuples(
            st.integers(0, 2),
            st.sampled_from(["touch", "let go", "leave", "lie", "wait"]),
            st.floats(0.0, math.pi),
            st.floats(0.0, 1e9),
        ),
        max_size=25,
    )
)
@settings(max_examples=share(0.5))
def test_whatever_hands_do_events_stay_in_order_and_nothing_sticks(match, football, steps):
    machine = Machine(match, football)
    hands = [machine.hands.join() for _ in range(3)]
    machine.to(100.1)
    for which, what, theta2, page_s in steps:
        hand = hands[which]
        if what == "leave":
            machine.hands.leave(hand)
            hands[which] = machine.hands.join()
        elif what == "lie":
            hand.clock.note(machine.now - 0.01, page_s, machine.now)
        elif what == "wait":
            machine.to(machine.now + 0.05)
        else:
            machine.hands.move(hand, (RemoteEvent(page_s, theta2, what == "touch"),))
    for hand in hands:
        machine.hands.leave(hand)
    machine.to(machine.now + MAX_DELAY_S + 0.05)
    assert not machine.engine.meters.touching
    assert machine.engine.meters.late_events == 0
    applied = machine.applied
    assert (np.diff(applied["sample"]) >= 0).all()


def test_silence_is_only_of_hands_that_touch(machine):
    hand = machine.hands.join()
    machine.to(102.0)
    assert not machine.hands.silent(hand)
    machine.hands.move(hand, (RemoteEvent(0.0, 1.0, True),))
    machine.to(102.0 + SILENCE_S - 0.01)
    assert not machine.hands.silent(hand)
    machine.to(102.0 + SILENCE_S + 0.01)
    assert machine.hands.silent(hand)


def test_where_no_sound_runs_a_movement_is_dropped_and_letting_go_is_not(machine):
    hand = machine.hands.join()
    machine.to(100.2)
    machine.hands.move(hand, (RemoteEvent(0.0, 1.0, True),))
    machine.to(100.3)
    machine.now += 5.0  # the output is gone
    for _ in range(5000):
        machine.hands.move(hand, (RemoteEvent(0.0, 2.0, True),))
    machine.hands.leave(hand)
    machine.engine.process(machine.out)
    applied = machine.applied
    assert applied["theta2"][applied["touching"]].tolist() == [1.0]
    assert not machine.engine.meters.touching
    assert machine.engine.meters.dropped_events == 0
