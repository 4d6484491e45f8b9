from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.devices.sensors.angles import TapTap
from overview_dsp.devices.sensors.reading import AngleSample
from overview_dsp.devices.sensors.touch_detection import DiskState, TouchRules, TwistTouch
from tests.devices.sensors.moving import RULES, course, fed, hand, lines

RATE = 200.0
NEVER: frozenset[int] = frozenset()


def twisted(degrees, rules=RULES, taps=NEVER, elsewhere=lambda n: None, place=0.0):
    """The events of a course of theta2 (rad), with the sample of each."""
    touch = TwistTouch(rules)
    events = []
    for n, theta2 in enumerate(degrees):
        disk = DiskState(elsewhere(n), place)
        event = touch.step(AngleSample(n / RATE, float(theta2), n in taps), disk)
        if event is not None:
            events.append((n, event))
    return events


def edges(events):
    """Samples at which it took hold and let go."""
    found, before = [], False
    for n, event in events:
        if event.touching != before:
            found.append((n, event.touching))
        before = event.touching
    return found


THERE_AND_BACK = course(RATE, (0, 0), (0.5, 0), (1.5, 120), (2, 120), (3, 0), (4, 0))


def test_a_turn_away_from_rest_takes_hold_and_rest_lets_go():
    (took, on), (left, off) = edges(twisted(THERE_AND_BACK))
    assert (on, off) == (True, False)
    assert math.degrees(THERE_AND_BACK[took]) == pytest.approx(10.0, abs=1.0)
    came_back = np.flatnonzero(np.degrees(THERE_AND_BACK) > 4.0)[-1]
    assert (left - came_back) / RATE == pytest.approx(0.2, abs=0.02)


def test_it_takes_hold_again_each_time():
    assert len(edges(twisted(np.concatenate([THERE_AND_BACK] * 3)))) == 6


@pytest.mark.parametrize("yields", [True, False])
def test_a_turn_takes_over_from_a_hand_that_yields_and_does_not_jump(yields):
    touch = TwistTouch(RULES)
    other = 2.0
    events = []
    # held at 60 degrees; then the other takes over; then turned on to 90
    degrees = course(RATE, (0, 0), (0.5, 60), (1.5, 60), (2.0, 90), (3.0, 90))
    for n, theta2 in enumerate(degrees):
        taken = any(one.retouch for one in events)
        elsewhere = other if n > 0.8 * RATE and not taken else None
        event = touch.step(AngleSample(n / RATE, float(theta2)), DiskState(elsewhere, 0.0, yields))
        if event is not None:
            events.append(event)
    again = [event for event in events if event.retouch]
    assert len(again) == yields
    if yields:
        assert again[0].theta2 == other
        after = [event.theta2 for event in events if event.time_s >= again[0].time_s]
        assert np.abs(np.diff(after)).max() < 0.1
        assert after[-1] == pytest.approx(math.pi / 2)
    else:
        assert events[-1].theta2 == other


def test_a_trembling_hand_at_rest_does_not_take_hold():
    dice = np.random.default_rng(1)
    assert twisted(np.radians(8.0) * dice.random(4000)) == []


def test_a_tap_tap_lets_go_and_going_back_to_rest_does_not_take_hold():
    tapped = frozenset({round(1.8 * RATE)})
    assert edges(twisted(THERE_AND_BACK, taps=tapped))[1:] == [(round(1.8 * RATE), False)]
    again = np.concatenate([THERE_AND_BACK, THERE_AND_BACK])
    assert len(edges(twisted(again, taps=tapped))) == 4


def test_another_tap_tap_takes_hold_where_it_is():
    taps = frozenset({round(1.7 * RATE), round(1.9 * RATE)})
    assert [touching for _, touching in edges(twisted(THERE_AND_BACK, taps=taps))] == [
        True, False, True, False,
    ]  # fmt: skip


@pytest.mark.parametrize(("release", "count"), [("rest", 2), ("tap", 1), ("either", 2)])
def test_a_preset_chooses_what_lets_go(release, count, football):
    rules = TouchRules.of(football.with_changes({"twist.release": release}))
    assert len(edges(twisted(THERE_AND_BACK, rules))) == count
    tap = frozenset({round(1.8 * RATE)})
    left = dict(edges(twisted(THERE_AND_BACK, rules, tap)))
    assert (round(1.8 * RATE) in left) == (release != "rest")


@pytest.mark.parametrize("place", [0.0, 1.0, math.pi])
def test_taking_hold_begins_where_the_disk_is_and_joins_smoothly(place):
    events = twisted(THERE_AND_BACK, place=place)
    assert events[0][1].theta2 == pytest.approx(place)
    given = np.array([event.theta2 for _, event in events])
    # 180 degrees in 150 ms, eased, and the hand's own way
    assert np.abs(np.diff(given)).max() < math.radians(12.0)
    for n, event in events[round(0.16 * RATE) :]:
        assert event.theta2 == THERE_AND_BACK[n] or not event.touching


def test_the_hands_change_over_without_a_jump():
    """A finger comes down at 30 degrees while the device is at 120, moves, and lets go."""
    finger = course(RATE, (0, 30), (0.3, 60))
    at = round(1.6 * RATE)

    def elsewhere(n):
        return float(finger[n - at]) if at <= n < at + len(finger) else None

    events = dict(twisted(THERE_AND_BACK, elsewhere=elsewhere))
    during = [events[n].theta2 for n in range(at, at + len(finger))]
    assert during == list(finger)
    after = np.array([events[n].theta2 for n in range(at + len(finger) - 1, at + 90)])
    assert np.abs(np.diff(after)).max() < math.radians(5.0)
    assert events[at + len(finger) + 35].theta2 == THERE_AND_BACK[at + len(finger) + 35]


def test_a_knob_rests_where_it_lay():
    start, end = math.radians(70.0), math.radians(150.0)
    assert twisted([start] * 500) == []
    assert edges(twisted([start] * 50 + [end] * 50)) == [(50, True)]


def test_a_sensor_of_touch_decides_by_itself():
    touch = TwistTouch(RULES)
    disk = DiskState(None, 1.0)
    said = [touch.step(AngleSample(n * 0.01, 1.0, touch=n in (3, 4)), disk) for n in range(7)]
    assert [None if one is None else one.touching for one in said] == [
        None, None, None, True, True, False, None,
    ]  # fmt: skip


@given(
    st.lists(
        st.tuples(st.floats(0, math.pi), st.booleans(), st.none() | st.floats(0, math.pi),
                  st.floats(0, math.pi)),
        max_size=80,
    ),
    st.booleans(), st.booleans(), st.floats(0, 0.5), st.floats(0, 0.5),
)  # fmt: skip
def test_whatever_a_hand_does_theta2_is_in_range_and_ends_let_go(steps, rest, tap, wait, join):
    touch = TwistTouch(replace(RULES, by_rest=rest, by_tap=tap, rest_s=wait, join_s=join))
    held = False
    for n, (theta2, tapped, elsewhere, place) in enumerate(steps):
        event = touch.step(AngleSample(n * 0.01, theta2, tapped), DiskState(elsewhere, place))
        if event is not None:
            assert -1e-9 <= event.theta2 <= math.pi + 1e-9
            assert event.touching or held
            held = event.touching
        assert held == touch.holding
    touch.release(1e9)
    assert not touch.holding


def pulses(*times: float, rate: float = 200.0) -> list[float]:
    found = TapTap()
    hits = {round(time * rate) for time in times}
    return [n / rate for n in range(600) if found.step(n / rate, 40.0 if n in hits else 0.5)]


def test_two_blows_soon_after_each_other_are_a_tap_tap_and_one_is_not():
    assert pulses(1.0, 1.3) == [1.3]
    assert pulses(1.0) == []
    assert pulses(1.0, 1.6) == []
    assert pulses(1.0, 1.02) == []
    assert pulses(1.0, 1.2, 1.4, 1.6) == [1.2, 1.6]


def test_a_knob_that_counts_has_no_dead_way_beyond_its_ends():
    counts = [1000, 1010, 1040, 1090, 1089, 1080]
    one = hand(columns=("t_ms", "count"))
    _, turns = fed(one, [b"\n", *lines([[10 * n, c] for n, c in enumerate(counts)])], 100.0)
    found = [turn.theta2 / math.pi for turn in turns[1:]]
    assert found == pytest.approx([0.0, 0.25, 1.0, 1.0, 39 / 40, 30 / 40])


def test_an_encoder_that_wraps_or_counts_down():
    one = hand(columns=("t_ms", "count"), encoder__wrap=256.0, encoder__reverse=True)
    counts = [5, 1, 251, 255]
    _, turns = fed(one, [b"\n", *lines([[10 * n, c] for n, c in enumerate(counts)])], 100.0)
    assert [t.theta2 / math.pi for t in turns[1:]] == pytest.approx([0, 0.1, 0.25, 0.15])


def test_a_potentiometer_and_a_roll_in_degrees():
    one = hand(columns=("t_ms", "pot"))
    _, turns = fed(one, [b"\n", *lines([[0, 0], [10, 1023], [20, 2000]])], 100.0)
    assert [turn.theta2 for turn in turns[1:]] == pytest.approx([0.0, math.pi, math.pi])
    one = hand(columns=("t_ms", "roll_deg"))
    _, turns = fed(one, [b"\n", *lines([[0, -90], [10, 190], [20, 360]])], 100.0)
    assert np.degrees([turn.theta2 for turn in turns[1:]]) == pytest.approx([90.0, 170.0, 0.0])


def test_a_knob_that_feels_no_taps_is_reported():
    one = hand(replace(RULES, by_rest=False), ("t_ms", "pot"))
    fed(one, [b"\n", *lines([[0, 0]])], 100.0)
    assert any("cannot detect taps" in said for said in one.take_messages())


def test_rules_of_touch_change_no_render_and_are_kept_by_a_saved_state(match, football):
    changed = football.with_changes(
        {"twist.release": "tap", "twist.rest_deg": 9.0, "twist.engage_deg": 1.0,
         "twist.rest_ms": 0.0, "twist.blend_ms": 0.0}
    )  # fmt: skip
    gesture = ov.sweep(0.3)
    plain = ov.render(match, football, gesture, sample_rate=8000, tail=0.1)
    assert np.array_equal(
        plain.samples, ov.render(match, changed, gesture, sample_rate=8000, tail=0.1).samples
    )
    saving, loading = ov.Engine(changed, match), ov.Engine(football, match)
    for engine in (saving, loading):
        engine.prepare(8000)
    loading.load_state(saving.save_state())
    assert TouchRules.of(loading.preset) == TouchRules.of(changed)


def test_bundled_presets_let_go_at_rest_or_by_a_tap_tap():
    for name in ("football", "series", "heart", "crowd"):
        assert ov.load_preset(name).values["twist.release"] == "either"
