"""Takeover: who holds the disk, and that nothing jumps that isn't a step."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from overview_dsp.devices.controllers.control_messages import AngleChanged, TouchEnded, TouchStarted
from overview_dsp.devices.controllers.source import ControllerSource
from overview_dsp.devices.sensors.touch_detection import DiskState
from tests.devices.sensors.moving import RULES

TICK = 0.005


def played(hand, moves, until, elsewhere=lambda t: None, place=0.0, yields=False, since=0.0):
    """The events of moves (time, move), with a tick every 5 ms."""
    events = []
    waiting = list(moves)
    for n in range(round(since / TICK), round(until / TICK)):
        now = n * TICK
        found = DiskState(elsewhere(now), place, yields)
        while waiting and waiting[0][0] <= now:
            events += hand.move(waiting.pop(0)[1], now, found)
        events += hand.tick(now, found)
    return events


def turned(name, *points):
    """Moves of a control along straight lines between (time, theta2), every 10 ms."""
    times = np.arange(points[0][0], points[-1][0], 0.01)
    angles = np.interp(times, *zip(*points, strict=True))
    return [(float(t), AngleChanged(name, float(a))) for t, a in zip(times, angles, strict=True)]


def test_a_fader_touches_at_the_disk_moves_it_and_releases_at_rest():
    moves = [(0.0, AngleChanged("fader", 1.0)), (0.1, AngleChanged("fader", 2.0))]
    moves += [(1.0, AngleChanged("fader", 0.0))]
    events = played(ControllerSource(RULES), moves, 2.0, place=0.4)
    assert events[0].theta2 == pytest.approx(0.4)
    assert events[0].time_s == pytest.approx(0.1)
    before = [event for event in events if event.time_s < 1.0]
    assert before[-1].theta2 == pytest.approx(2.0)
    assert np.abs(np.diff([event.theta2 for event in before])).max() < 0.15
    assert not events[-1].touching
    assert events[-1].time_s == pytest.approx(1.0 + RULES.rest_s, abs=0.02)


def test_replaced_rules_decide_how_long_a_fader_must_rest():
    hand = ControllerSource(RULES)
    played(hand, turned("fader", (0, 0), (0.5, 2.0)), 1.0)
    hand.rules = replace(RULES, rest_s=RULES.rest_s + 1.0)
    events = played(hand, [(1.0, AngleChanged("fader", 0.0))], 4.0, since=1.0)
    assert not events[-1].touching
    assert events[-1].time_s == pytest.approx(2.0 + RULES.rest_s, abs=0.02)


def test_a_fader_at_rest_sends_no_events_and_keeps_its_touch():
    events = played(ControllerSource(RULES), turned("fader", (0, 0), (0.5, 2.0)), 30.0)
    assert events[-1].touching
    assert events[-1].time_s < 1.0


def test_a_touch_is_a_step_from_any_disk_angle():
    hand = ControllerSource(RULES)
    events = played(
        hand,
        [(0.1, TouchStarted("a", 1.0)), (0.2, TouchStarted("a", 1.5)), (0.3, TouchEnded("a"))],
        0.5,
        place=2,
    )
    assert [(event.theta2, event.touching) for event in events] == [
        (1.0, True), (1.5, True), (1.5, False)
    ]  # fmt: skip
    assert not hand.holding


def test_each_key_is_a_step_and_the_last_pressed_key_holds_the_disk():
    hand = ControllerSource(RULES)
    moves = [
        (0.1, TouchStarted("a", 1.0)),
        (0.2, TouchStarted("b", 2.0)),
        (0.3, TouchEnded("b")),
        (0.4, TouchEnded("a")),
    ]
    events = played(hand, moves, 0.5)
    assert [(event.theta2, event.touching, event.retouch) for event in events] == [
        (1.0, True, False), (2.0, True, True), (1.0, True, False), (1.0, False, False)
    ]  # fmt: skip


def test_releasing_an_earlier_key_has_no_effect():
    moves = [(0.1, TouchStarted("a", 1.0)), (0.2, TouchStarted("b", 2.0)), (0.3, TouchEnded("a"))]
    events = played(ControllerSource(RULES), moves, 0.5)
    assert [event.theta2 for event in events] == [1.0, 2.0]


def test_a_second_fader_takes_over_without_a_jump():
    moves = [*turned("a", (0, 0), (0.5, 2.5)), *turned("b", (1, 0.0), (2, 1.0))]
    hand = ControllerSource(RULES)
    events = played(hand, moves, 3.0)
    assert np.abs(np.diff([event.theta2 for event in events])).max() < 0.25
    assert events[-1].theta2 == pytest.approx(0.99)
    # and back
    back = played(
        hand, [(3, AngleChanged("a", 2.5)), (3.05, AngleChanged("a", 2.8))], 4.0, since=3.0
    )
    assert np.abs(np.diff([0.99, *(event.theta2 for event in back)])).max() < 0.1
    assert back[-1].theta2 == 2.8


def test_a_wheel_that_springs_back_does_not_take_over():
    moves = [*turned("wheel", (0, 0), (0.5, 2.5)), *turned("b", (1, 0.0), (2, 1.0))]
    hand = ControllerSource(RULES)
    before = played(hand, moves, 3.0)
    after = played(
        hand,
        [*turned("wheel", (3, 2.5), (3.2, 0.0)), (3.2, AngleChanged("wheel", 0.0))],
        4.0,
        since=3.0,
    )
    assert after == []
    assert before[-1].touching
    assert hand.holding


def test_during_a_touch_a_fader_follows_and_takes_over_at_the_release():
    moves = [
        *turned("a", (0, 0), (0.5, 2.0)),
        (1.0, TouchStarted("f", 0.5)),
        (1.5, AngleChanged("a", 2.5)),
    ]
    hand = ControllerSource(RULES)
    events = played(hand, [*moves, (2.0, TouchEnded("f"))], 3.0)
    assert [event.theta2 for event in events if 1.0 <= event.time_s < 2.0] == [0.5]
    after = [event for event in events if event.time_s >= 2.0]
    assert all(event.touching for event in after)
    assert np.abs(np.diff([0.5, *(event.theta2 for event in after)])).max() < 0.15
    assert after[-1].theta2 == 2.5


def test_a_turned_fader_takes_over_from_another_source_that_yields():
    moves = [*turned("a", (0, 0), (0.5, 1.0)), *turned("a", (1.0, 1.0), (1.5, 1.5))]
    held = []

    def elsewhere(now):
        # a device of another source took over at 0.7 s, and yields to the retake
        return 3.0 if now > 0.7 and not held else None

    hand = ControllerSource(RULES)
    events = []
    for n in range(400):
        now = n * TICK
        while moves and moves[0][0] <= now:
            events += hand.move(moves.pop(0)[1], now, DiskState(elsewhere(now), 0.0, True))
            held += [one for one in events if one.retouch]
        events += hand.tick(now, DiskState(elsewhere(now), 0.0, True))
    (again,) = [event for event in events if event.retouch]
    assert again.theta2 == 3.0
    assert 1.1 < again.time_s < 1.4
    assert events[-1].theta2 == pytest.approx(1.49, abs=0.02)


def test_a_control_that_sends_touches_is_no_longer_treated_as_a_fader():
    hand = ControllerSource(RULES)
    events = played(
        hand, [*turned("theta2", (0, 0), (0.5, 2)), (1.0, TouchStarted("theta2", 1.0))], 2.0
    )
    assert events[-1].theta2 == 1.0
    assert len([event for event in events if event.time_s > 0.7]) == 1
    (last,) = hand.move(TouchEnded("theta2"), 3.0)
    assert not last.touching
    assert not hand.holding


def test_a_lost_controller_releases_all_touches():
    hand = ControllerSource(RULES)
    assert hand.release(0.0) is None
    played(hand, [*turned("a", (0, 0), (0.5, 2)), (0.6, TouchStarted("f", 1.0))], 1.0)
    assert hand.release(1.0).touching is False
    assert not hand.holding
    assert hand.tick(1.1) == []


NAMES = st.sampled_from(["a", "b"])
ANGLES = st.floats(0.0, math.pi)
MOVES = st.one_of(
    st.builds(AngleChanged, NAMES, ANGLES),
    st.builds(TouchStarted, st.sampled_from(["a", "f"]), ANGLES),
    st.builds(TouchEnded, st.sampled_from(["a", "f", None])),
    st.none(),
)


@example([(AngleChanged("a", 0.0), None, False), (AngleChanged("a", 1.0), None, False),
          (TouchEnded("a"), None, False), (AngleChanged("a", 0.0), None, False)])  # fmt: skip
@given(st.lists(st.tuples(MOVES, st.one_of(st.none(), ANGLES), st.booleans()), max_size=60))
def test_any_messages_give_valid_events_and_every_touch_can_be_released(course):
    hand = ControllerSource(RULES)
    touching = False
    for n, (move, elsewhere, yields) in enumerate(course):
        now = 0.03 * n
        disk = DiskState(elsewhere, 0.0, yields)
        events = [] if move is None else hand.move(move, now, disk)
        events += hand.tick(now, disk)
        for event in events:
            assert 0.0 <= event.theta2 <= math.pi
            touching = event.touching
        assert touching == hand.holding
    last = hand.release(99.0)
    assert (last is not None) == touching
    assert not hand.holding
