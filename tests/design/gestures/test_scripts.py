from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov

PLACES = st.floats(0.0, 1.0)


@given(st.floats(1e-3, 20.0), PLACES, PLACES)
def test_a_sweep_moves_steadily_from_start_to_end_and_releases(seconds, start, end):
    gesture = ov.sweep(seconds, start, end)
    assert gesture.touching[:-1].all()
    assert not gesture.touching[-1]
    assert gesture.time_s[0] == 0.0
    assert gesture.theta2[0] == start * math.pi
    assert gesture.theta2[-1] == pytest.approx(end * math.pi, abs=1e-12)
    # it releases where and when it arrived: that the disk follows is the kernel's
    assert gesture.duration_s == gesture.time_s[-1] == gesture.time_s[-2] == seconds
    assert gesture.theta2[-1] == gesture.theta2[-2]
    line = start + (end - start) * gesture.time_s / seconds
    assert np.allclose(gesture.theta2, line * math.pi, atol=1e-9)
    assert gesture.theta2.min() >= 0.0
    assert gesture.theta2.max() <= math.pi


@given(st.floats(1e-3, 20.0))
def test_a_moving_hand_gives_at_least_a_hundred_control_events_a_second(seconds):
    moving = ov.sweep(seconds).time_s[:-1]
    assert np.diff(moving).max() <= 0.01 + 1e-9


@given(PLACES, st.floats(1e-3, 100.0))
def test_a_tap_is_one_step_a_hold_and_a_release(position, hold):
    gesture = ov.tap(position, hold)
    assert gesture.time_s.tolist() == [0.0, hold]
    assert gesture.theta2.tolist() == [position * math.pi] * 2
    assert gesture.touching.tolist() == [True, False]
    assert gesture.duration_s == hold


def test_a_tap_without_a_time_is_released_at_once():
    assert ov.tap(0.8).time_s.tolist() == [0.0, 0.05]
    assert ov.parse_gesture("tap:0.8").duration_s == 0.05


def test_a_tap_after_another_gesture_is_the_same_step():
    before = ov.sweep(0.1, 0.3, 0.9) + ov.pause(0.1)
    joined = before + ov.tap(0.5, 0.2)
    assert np.array_equal(joined.theta2[-2:], ov.tap(0.5, 0.2).theta2)


@given(st.floats(0.02, 20.0), st.floats(0.0, 3.0))
def test_an_arm_speeds_up_and_slows_down_and_releases_without_waiting(seconds, rest):
    gesture = ov.arm(seconds, rest)
    moving = gesture.time_s <= seconds
    time_s, place = gesture.time_s[:-1], gesture.theta2[:-1] / math.pi
    assert (place[0], place[-1]) == (0.0, 1.0)
    assert (np.diff(place) >= 0.0).all()
    # symmetrical, at rest at both ends, 15/8 of the mean speed in the middle
    assert np.allclose(place + place[::-1], 1.0, atol=1e-12)
    speed = np.diff(place) / np.diff(time_s) * seconds
    assert speed.max() <= 1.875 + 1e-9
    if seconds > 1.0:
        assert speed.max() > 1.87
        assert max(speed[0], speed[-1]) < 0.01
    assert moving.any()
    assert gesture.touching[:-1].all()
    assert not gesture.touching[-1]
    assert gesture.duration_s == gesture.time_s[-1] == pytest.approx(seconds + rest)


def test_a_flick_is_the_same_movement_in_a_fraction_of_a_second():
    assert np.array_equal(ov.flick().theta2, ov.arm(0.3).theta2)
    assert ov.flick(0.15).duration_s == pytest.approx(0.25)


@given(PLACES, st.floats(0.001, 0.2), st.sampled_from([0.5, 1.0, 2.0, 5.0]))
def test_scrubbing_moves_back_and_forth_over_a_position(position, width, hz):
    gesture = ov.scrub(position, width, hz, seconds=4.0)
    place = gesture.theta2 / math.pi
    wave = (gesture.time_s >= 1.2 - 1e-9) & gesture.touching
    low, high = max(position - width, 0.0), min(position + width, 1.0)
    assert place[wave].min() == pytest.approx(low, abs=1e-12)
    assert place[wave].max() == pytest.approx(high, abs=1e-3 * width)
    assert place[0] == 0.0
    # it rests where the oscillation starts
    assert np.allclose(place[gesture.time_s <= 1.2].max(), low)
    assert np.abs(np.diff(place[wave])).max() <= 2.0 * math.pi * hz * width / 200.0 + 1e-12
    if low > 0.0 and high < 1.0:
        above = place[wave] > position
        assert np.count_nonzero(np.diff(above)) == pytest.approx(8 * hz, abs=1)
    assert gesture.touching[:-1].all()
    assert not gesture.touching[-1]
    assert gesture.duration_s == pytest.approx(5.2)


def test_a_pause_has_no_events():
    gesture = ov.pause(2.5)
    assert len(gesture.time_s) == 0
    assert gesture.duration_s == 2.5
    assert ov.pause(0.0).duration_s == 0.0


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ov.sweep(0.0), "sweep's duration"),
        (lambda: ov.sweep(-1.0), "more than 0"),
        (lambda: ov.sweep(math.nan), "nan"),
        (lambda: ov.sweep(math.inf), "inf"),
        (lambda: ov.sweep(1e9), "86400"),
        (lambda: ov.sweep(1.0, -0.1), "sweep's start"),
        (lambda: ov.sweep(1.0, 0.0, 1.1), "sweep's end"),
        (lambda: ov.sweep(1.0, math.nan), "0 .start. to 1 .end."),
        (lambda: ov.tap(1.5), "tap's position"),
        (lambda: ov.tap(0.5, 0.0), "tap's hold"),
        (lambda: ov.arm(0.0), "arm's movement"),
        (lambda: ov.arm(1.0, -0.1), "rest of an arm"),
        (lambda: ov.flick(math.nan), "flick"),
        (lambda: ov.scrub(1.1, 0.02, 2.0), "position of scrubbing"),
        (lambda: ov.scrub(0.5, 0.0, 2.0), "width of scrubbing"),
        (lambda: ov.scrub(0.5, 0.02, 21.0), "up to 20 Hz"),
        (lambda: ov.scrub(0.5, 0.02, 2.0, 0.0), "duration of scrubbing"),
        (lambda: ov.pause(-0.5), "rest"),
        (lambda: ov.pause(math.nan), "rest"),
    ],
)
def test_a_movement_out_of_range_is_an_error_of_one_line_with_the_range(make, words):
    with pytest.raises(ov.InputError, match=words) as error:
        make()
    assert "\n" not in str(error.value)


def test_joined_gestures_follow_one_another():
    first, second = ov.sweep(0.5), ov.tap(0.8, 0.25)
    both = first + ov.pause(1.0) + second
    count = len(first.time_s)
    assert np.array_equal(both.time_s[:count], first.time_s)
    assert np.array_equal(both.time_s[count:], second.time_s + (first.duration_s + 1.0))
    assert np.array_equal(both.theta2, np.concatenate([first.theta2, second.theta2]))
    assert both.duration_s == pytest.approx(first.duration_s + 1.0 + 0.25)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"time_s": [0.0, 2.0, 1.0]}, "goes back at event 3: 1 s after 2 s"),
        ({"time_s": [-1.0, 0.0, 1.0]}, "not negative"),
        ({"time_s": [0.0, math.nan, 1.0]}, "finite"),
        ({"time_s": [0.0, 1.0, 1e300]}, "0 to 604800"),
        ({"theta2": [0.0]}, "equally long"),
        ({"duration_s": 0.5}, "before its last event"),
        ({"duration_s": math.nan}, "out of range"),
        ({"duration_s": math.inf}, "out of range"),
    ],
)
def test_an_invalid_gesture_is_an_error_of_one_line(changes, words):
    good = {
        "time_s": [0.0, 1.0, 1.0],
        "theta2": [0.0, 1.0, 1.0],
        "touching": [True, True, False],
        "duration_s": 3.0,
    }
    ov.Gesture(**good)
    with pytest.raises(ov.InputError, match=words):
        ov.Gesture(**{**good, **changes})


def test_a_gesture_keeps_its_own_copy_that_cannot_be_changed():
    times = np.array([0.0, 1.0])
    gesture = ov.Gesture(times, np.zeros(2), np.array([True, False]), 1.0)
    times[1] = 0.5
    assert gesture.time_s[1] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        gesture.theta2[0] = 1.0


@given(st.integers(0, 10**9), st.sampled_from([1000, 8000, 44_100, 48_000, 192_000]))
def test_an_event_falls_on_the_sample_nearest_to_its_time(sample, rate):
    sample %= 3600 * rate
    gesture = ov.Gesture(np.array([sample / rate]), np.zeros(1), np.zeros(1, bool), 3600.0)
    assert gesture.stamps(rate).tolist() == [sample]
