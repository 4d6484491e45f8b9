"""The slip clutch: the ledger, its limits, a hand's pace; the release; rigid where it is off."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from tests.examples import plain_preset, timeline_of
from tests.kernels.test_two_disk import ledger, played

RATE = 48_000.0
HAND = st.lists(
    st.tuples(st.floats(0.0005, 0.2), st.floats(0.0, math.pi), st.booleans()),
    min_size=1,
    max_size=25,
)
CLUTCHES = st.builds(
    lambda *values: dict(zip(KEYS, values, strict=True)),
    st.floats(0.2, 5.0),
    st.floats(0.0, 5.0),
    st.just(0.0) | st.floats(0.005, 2.0),
    st.just(0.0) | st.floats(0.2, 10.0),
    st.just(0.0) | st.floats(0.2, 10.0),
    st.floats(0.0, 2.0),
)
KEYS = (
    "max_speed_ratio",
    "tap_duration_s",
    "time_constant_s",
    "windup_ratio",
    "max_speed",
    "backlash_percent",
)
WHOLE = dict(zip(KEYS, (2.0, 3.0, 0.06, 2.0, 1.0, 0.3), strict=True))
"""As in football."""


def clutched(ratio: float = 1.1, tap_s: float = 1.8, **values: float) -> ov.Preset:
    clutch = {"max_speed_ratio": ratio, "tap_duration_s": tap_s, **values}
    return plain_preset(**{f"clutch__{key}": value for key, value in clutch.items()})


def bumpy(surface: ov.Surface) -> ov.Surface:
    """Friction that rises a hundredfold in a few places."""
    table = surface.friction.copy()
    for at in (9_000, 20_000, 20_300, 51_000):
        table[at : at + 60] *= 100.0
    return replace(surface, friction=table)


def events_of(hand):
    times = np.cumsum([step for step, _, _ in hand])
    return [
        (float(time), theta2, touching)
        for time, (_, theta2, touching) in zip(times, hand, strict=True)
    ]


def steady(seconds: float, count: int = 600, to: float = 1.0):
    return [(seconds * i / count, to * math.pi * i / count, True) for i in range(count + 1)]


@settings(max_examples=80, deadline=None)
@given(HAND, CLUTCHES)
def test_the_ledger_holds_with_the_rest_position_that_was_used(hand, clutch):
    preset = clutched(clutch.pop("max_speed_ratio"), clutch.pop("tap_duration_s"), **clutch)
    events = events_of(hand)
    trace = played(preset, events, events[-1][0] + 0.2, surface=bumpy)
    assert np.abs(ledger(trace, preset)).max() <= 1e-12


@settings(max_examples=80, deadline=None)
@given(HAND, CLUTCHES)
def test_shaft_2_never_pulls_harder_nor_the_other_way_than_a_rigid_one(hand, clutch):
    events = [event for event in events_of(hand) if event[2]] or [(0.01, 1.0, True)]
    seconds = events[-1][0] + 0.2
    backlash = math.pi * clutch["backlash_percent"] / 100.0
    preset = clutched(clutch.pop("max_speed_ratio"), clutch.pop("tap_duration_s"), **clutch)
    trace = played(preset, events, seconds, surface=bumpy)
    rigid = played(clutched(0.0), events, seconds, surface=bumpy)
    held = trace.engaged == 1.0
    # without a clutch the trace holds the smoothed hand, whatever the disk does
    before = np.concatenate([[0.0], trace.cursor[:-1]])[held] * math.pi
    hand_at, used = rigid.theta2[held], trace.theta2[held]
    low, high = np.minimum(before, hand_at - backlash), np.maximum(before, hand_at + backlash)
    assert (used >= low - 1e-12).all()
    assert (used <= high + 1e-12).all()


@settings(max_examples=40, deadline=None)
@given(HAND, st.floats(0.5, 3.0), st.floats(0.3, 3.0), st.floats(0.0, 1.0))
def test_a_held_finger_is_reached_from_anywhere_and_then_nothing_moves(
    hand, ratio, tap_s, backlash
):
    events = [*events_of(hand), (sum(step for step, _, _ in hand) + 0.01, 2.0, True)]
    preset = clutched(ratio, tap_s, backlash_percent=backlash)
    trace = played(preset, events, events[-1][0] + 12.0 * tap_s, 8_000.0)
    assert trace.cursor[-1] == pytest.approx(2.0 / math.pi, abs=1e-3 + backlash / 100.0)
    energy = trace.theta1[-4000:].std() + np.abs(trace.omega1[-4000:]).max()
    assert energy < 1e-2


def test_off_it_is_a_rigid_shaft_to_the_bit():
    events = [(0.0, 0.0, True), (0.1, 1.0, True), (0.4, 3.0, True), (0.9, 3.0, False)]
    off = played(clutched(0.0, 0.0), events, 1.5, surface=bumpy)
    limits = {key: WHOLE[key] for key in KEYS[2:]}
    other = played(clutched(0.0, 3.0, **limits), events, 1.5, surface=bumpy)
    for column in off:
        assert np.array_equal(off[column], other[column])
    plain = played(plain_preset(), events, 1.5, surface=bumpy)
    assert np.array_equal(plain.theta1, off.theta1)


@pytest.mark.parametrize("tap_s", [0.9, 1.8, 2.5])
def test_a_tap_takes_the_time_that_was_chosen(tap_s):
    events = [(0.0, math.pi, True)]
    trace = played(clutched(1.0, tap_s), events, 2.0 * tap_s)
    middle = (trace.cursor > 0.3) & (trace.cursor < 0.7)
    pace = np.ptp(trace.cursor[middle]) / np.ptp(trace.time[middle])
    assert pace == pytest.approx(1.0 / tap_s, rel=0.02)


def test_a_tap_is_the_same_step_wherever_the_hand_was():
    rest = [(12.0, 2.0, True)]
    seconds = 13.0
    whole = clutched(2.0, 3.0, **{key: WHOLE[key] for key in KEYS[2:]})
    from_nowhere = played(whole, rest, seconds)
    slow = [(0.0, 0.2, True), (0.05, 0.21, True), (0.1, 0.0, False)]
    after = played(whole, [*slow, *rest], seconds)
    began = round(12.0 * RATE)
    # the disk has come back to the start; what follows is the same to its last traces
    assert np.abs(after.cursor[began:] - from_nowhere.cursor[began:]).max() < 1e-6


def test_behind_an_event_the_disk_goes_on_at_about_the_hands_pace():
    seconds = 3.0
    hand = 1.0 / seconds
    fast = {}
    for name, preset in (("clutch", clutched(1.1)), ("rigid", clutched(0.0))):
        trace = played(preset, steady(seconds), seconds, surface=bumpy)
        speed = np.gradient(trace.cursor, trace.time)
        fast[name] = speed[trace.cursor > 0.16].max() / hand
    assert fast["clutch"] < 1.3
    assert fast["rigid"] > 1.5 * fast["clutch"]


def test_a_jump_of_the_hand_gives_it_no_pace():
    jump = [(0.0, 0.1, True), (1.0, 0.1, True), (1.001, 3.0, True)]
    trace = played(clutched(1.0, 2.0), jump, 4.0)
    after = trace.time > 1.1
    speed = np.gradient(trace.cursor, trace.time)[after]
    assert speed.max() < 1.6 / 2.0


@pytest.mark.parametrize("max_speed", [0.4, 0.8])
def test_nothing_pulls_the_disk_faster_than_its_highest_speed(max_speed):
    trace = played(clutched(2.0, 0.1, max_speed=max_speed), steady(0.5), 5.0)
    speed = np.gradient(trace.cursor, trace.time)
    assert speed.max() == pytest.approx(max_speed, rel=0.02)


def lag_of(time_constant_s: float) -> float:
    preset = clutched(2.0, 3.0, time_constant_s=time_constant_s)
    preset = preset.with_changes({"disk.k2": 0.1})
    trace = played(preset, steady(2.0), 2.0, surface=bumpy)
    return float(np.mean(trace.time / 2.0 - trace.cursor))


def test_a_longer_time_constant_lags_more():
    lags = [lag_of(seconds) for seconds in (0.02, 0.1, 0.5)]
    assert lags[0] < lags[1] < lags[2]


def held_stretch(windup_ratio: float) -> float:
    """Stretch of shaft 2 (timelines) 50 ms after the disk met a ridge, far behind the hand."""

    def ridge(surface):
        table = surface.friction.copy()
        table[20_000:20_200] *= 3000.0
        return replace(surface, friction=table)

    preset = clutched(2.0, 1.0, windup_ratio=windup_ratio)
    trace = played(preset, [(0.0, math.pi, True)], 3.0, surface=ridge)
    met = int(np.argmax(trace.cursor >= 20_000 / 65_536)) + round(0.05 * RATE)
    return float(trace.theta2[met] / math.pi - trace.cursor[met])


def test_a_ridge_is_pulled_by_no_more_than_the_hands_pace_winds_up():
    # a tap in 1 s: 50 ms wind up 0.05 timelines at its pace
    assert held_stretch(1.0) < held_stretch(0.0) - 0.1
    assert held_stretch(1.0) < 0.25


def test_tremor_within_the_backlash_moves_nothing():
    quiet = clutched(2.0, 1.0, backlash_percent=0.5)
    rng = np.random.default_rng(1)
    hand = [(0.0, 1.0, True)]
    hand += [(4.0 + 0.005 * i, 1.0 + float(rng.uniform(-0.005, 0.005)), True) for i in range(400)]
    trace = played(quiet, hand, 6.0)
    still = trace.time > 4.0
    assert np.ptp(trace.cursor[still]) < 1e-4
    shaken = played(clutched(2.0, 1.0), hand, 6.0)
    assert np.ptp(shaken.cursor[still]) > 10.0 * np.ptp(trace.cursor[still])


def test_a_hand_that_slows_down_at_its_end_keeps_the_pace_while_the_disk_is_behind():
    part = np.arange(121) / 120.0
    hand = part**3 * (10 - 15 * part + 6 * part**2)
    events = [(float(t), math.pi * float(p), True) for t, p in zip(part, hand, strict=True)]
    trace = played(clutched(2.0, 4.0, time_constant_s=0.06, max_speed=1.0), events, 2.5)
    arrived = trace.time[np.argmax(trace.cursor > 0.99)]
    assert 1.0 < arrived < 1.6  # at the pace of a tap alone the rest would take 1.5 s more


# --- release --------------------------------------------------------------------------------------


@pytest.mark.parametrize("touch_s", [0.0, 0.001, 0.3])
@pytest.mark.parametrize("position", [0.1, 0.5, 0.97])
@pytest.mark.parametrize("tap_s", [0.0, 1.8])
def test_a_tap_goes_all_the_way_however_short_its_touch(position, touch_s, tap_s):
    preset = clutched(1.5 if tap_s else 0.0, tap_s)
    theta2 = position * math.pi
    trace = played(preset, [(0.0, theta2, True), (touch_s, theta2, False)], 4.0, surface=bumpy)
    freed = int(np.argmin(trace.engaged))
    assert trace.cursor[freed - 1] == pytest.approx(position, abs=0.0065)
    assert not trace.engaged[freed:].any()
    assert trace.touching.sum() == pytest.approx(touch_s * RATE, abs=1.0)
    assert trace.cursor[-1] < trace.cursor[freed] / 2.0


def test_a_disk_that_cannot_arrive_is_released_after_two_and_a_half_seconds():
    preset = clutched(1.0, 10.0)
    trace = played(preset, [(0.0, 3.0, True), (0.5, 3.0, False)], 4.0)
    freed = trace.time[np.argmin(trace.engaged)]
    assert freed == pytest.approx(3.0 + 1.0 / RATE, abs=1e-9)
    assert trace.cursor.max() < 0.9


def test_a_new_touch_takes_the_disk_at_once_on_its_way():
    preset = clutched(1.0, 3.0)
    events = [(0.0, 3.0, True), (0.1, 3.0, False), (0.6, 0.1, True)]
    trace = played(preset, events, 2.0)
    assert trace.engaged.all()
    touched = round(0.6 * RATE)
    assert trace.cursor.max() < trace.cursor[touched] + 0.02  # it only slows down
    assert trace.cursor[-1] < trace.cursor[touched]


def test_a_release_that_returns_waits_for_the_arrival_too():
    preset = clutched(1.5, 1.0).with_changes({"disk.release": "return"})
    trace = played(preset, [(0.0, 2.0, True), (0.05, 2.0, False)], 4.0)
    assert trace.engaged.all()
    assert trace.cursor.max() == pytest.approx(2.0 / math.pi, abs=0.02)
    assert trace.cursor[-1] < 0.01


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.0, math.pi), st.floats(0.001, 0.6)), min_size=1, max_size=3),
    st.integers(1, 700),
)
def test_where_it_is_released_does_not_depend_on_the_blocks(taps, block):
    preset = clutched(2.0, 1.0, **{key: WHOLE[key] for key in KEYS[2:]})
    preset = preset.with_changes(
        {"tactor.slow_gain_exponent": 0.5, "tactor.recoil_gain_exponent": 0.6}
    )
    rate, frames = 8_000, 8_000
    sounds, traces = [], []
    for size in (frames, block):
        engine = ov.Engine(preset, timeline_of(30.0, 50.0))
        engine.prepare(rate, size)
        at = 0
        for theta2, seconds in taps:
            engine.control(theta2, True, at)
            at += round(seconds * rate)
            engine.control(theta2, False, at)
            at += 200
        out = np.zeros((frames, 2), dtype=np.float32)
        trace = np.zeros((frames, 10))
        for start in range(0, frames, size):
            part = slice(start, min(start + size, frames))
            engine.process(out[part], trace[part])
        sounds.append(out)
        traces.append(trace)
        still = engine.meters.still_samples
        sounds.append(np.array([still]))
    assert np.array_equal(sounds[0], sounds[2])
    assert np.array_equal(traces[0], traces[1])
    assert sounds[1] == sounds[3]


# --- output gains ---------------------------------------------------------------------------------


def test_gains_change_what_is_felt_and_neither_disk_nor_clicks():
    plain = clutched(2.0, 3.0)
    raised = plain.with_changes(
        {"tactor.slow_gain_exponent": 0.5, "tactor.recoil_gain_exponent": 0.6}
    )
    events = [*steady(8.0, 1600), (8.0, math.pi, False)]
    before, after = (played(preset, events, 12.0) for preset in (plain, raised))
    for column in before:
        assert np.array_equal(before[column], after[column]) == (column != "envelope")
    compression = plain.number("tactor.compression")
    middle = (before.time > 3.0) & (before.time < 7.0)
    gain = after.envelope[middle] / before.envelope[middle]
    # 1/8 timeline a second, weak torque: compressed as a power
    assert gain.mean() == pytest.approx((0.4 * 8.0) ** (0.5 * compression), rel=0.03)
    recoil = (before.time > 9.0) & (before.cursor > 0.1) & (before.envelope > 1e-4)
    gain = after.envelope[recoil] / before.envelope[recoil]
    expected = before.cursor[recoil] ** (-0.6 * compression)
    assert gain == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize(("ratio", "tap_s"), [(1.1, 1.8), (0.5, 8.0), (3.0, 0.0)])
def test_a_finger_that_rests_is_silent_within_the_tail(ratio, tap_s):
    engine = ov.Engine(clutched(ratio, tap_s), timeline_of(30.0, 50.0))
    engine.prepare(8_000, 8_000)
    engine.control(math.pi, True)
    out = np.zeros((8_000, 2), dtype=np.float32)
    for _ in range(math.ceil(engine.tail_seconds)):
        engine.process(out)
    assert not out[-1].any()
    assert engine.meters.silent_samples > 0
