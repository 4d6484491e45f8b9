"""The slip clutch: the ledger, its bounds, a hand's pace; rigid where it is off."""

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


def clutched(catch_up: float = 1.1, unfold_s: float = 1.8, **values: float) -> ov.Preset:
    preset = plain_preset()
    changed = {"disk.catch_up": catch_up, "disk.unfold_s": unfold_s, **values}
    return replace(preset, values={**preset.values, **changed})


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


@settings(max_examples=60, deadline=None)
@given(HAND, st.floats(0.2, 5.0), st.floats(0.0, 5.0))
def test_the_ledger_holds_with_the_rest_position_that_was_used(hand, catch_up, unfold_s):
    preset = clutched(catch_up, unfold_s)
    events = events_of(hand)
    trace = played(preset, events, events[-1][0] + 0.2, surface=bumpy)
    assert np.abs(ledger(trace, preset)).max() <= 1e-12


@settings(max_examples=60, deadline=None)
@given(HAND, st.floats(0.2, 5.0), st.floats(0.0, 5.0))
def test_shaft_2_never_pulls_harder_nor_the_other_way_than_a_rigid_one(hand, catch_up, unfold_s):
    events = events_of(hand)
    seconds = events[-1][0] + 0.2
    trace = played(clutched(catch_up, unfold_s), events, seconds, surface=bumpy)
    rigid = played(clutched(0.0), events, seconds, surface=bumpy)
    held = trace.touching == 1.0
    # without a clutch the trace holds the smoothed hand, whatever the disk does
    before = np.concatenate([[0.0], trace.cursor[:-1]])[held] * math.pi
    hand_at, used = rigid.theta2[held], trace.theta2[held]
    low, high = np.minimum(before, hand_at), np.maximum(before, hand_at)
    assert (used >= low - 1e-12).all()
    assert (used <= high + 1e-12).all()


@settings(max_examples=40, deadline=None)
@given(HAND, st.floats(0.5, 3.0), st.floats(0.3, 3.0))
def test_a_held_finger_is_reached_from_anywhere_and_then_nothing_moves(hand, catch_up, unfold_s):
    events = [*events_of(hand), (sum(step for step, _, _ in hand) + 0.01, 2.0, True)]
    wait = 12.0 * unfold_s / min(catch_up, 1.0)
    trace = played(clutched(catch_up, unfold_s), events, events[-1][0] + wait, 8_000.0)
    assert trace.cursor[-1] == pytest.approx(2.0 / math.pi, abs=1e-3)
    energy = trace.theta1[-4000:].std() + np.abs(trace.omega1[-4000:]).max()
    assert energy < 1e-2


def test_off_it_is_a_rigid_shaft_to_the_bit():
    events = [(0.0, 0.0, True), (0.1, 1.0, True), (0.4, 3.0, True), (0.9, 3.0, False)]
    off = played(clutched(0.0, 0.0), events, 1.5, surface=bumpy)
    other = played(clutched(0.0, 3.0), events, 1.5, surface=bumpy)
    for column in off:
        assert np.array_equal(off[column], other[column])
    plain = played(plain_preset(), events, 1.5, surface=bumpy)
    assert np.array_equal(plain.theta1, off.theta1)


@pytest.mark.parametrize("unfold_s", [0.9, 1.8, 2.5])
def test_a_tap_unfolds_at_the_pace_that_was_chosen(unfold_s):
    events = [(0.0, math.pi, True)]
    trace = played(clutched(1.0, unfold_s), events, 2.0 * unfold_s)
    middle = (trace.cursor > 0.3) & (trace.cursor < 0.7)
    pace = np.ptp(trace.cursor[middle]) / np.ptp(trace.time[middle])
    assert pace == pytest.approx(1.0 / unfold_s, rel=0.02)


def test_a_tap_is_the_same_step_wherever_the_hand_was():
    rest = [(6.0, 2.0, True)]
    seconds = 7.0
    from_nowhere = played(clutched(), rest, seconds)
    slow = [(0.0, 0.2, True), (0.05, 0.21, True), (0.1, 0.0, False)]
    after = played(clutched(), [*slow, *rest], seconds)
    began = round(6.0 * RATE)
    # the disk has come back to the start; what follows is the same to its last traces
    assert np.abs(after.cursor[began:] - from_nowhere.cursor[began:]).max() < 1e-6


def test_behind_an_event_the_disk_goes_on_at_about_the_hands_pace():
    seconds = 3.0
    count = 600
    events = [(seconds * i / count, math.pi * i / count, True) for i in range(count + 1)]
    hand = 1.0 / seconds
    fast = {}
    for name, preset in (("clutch", clutched(1.1)), ("rigid", clutched(0.0))):
        trace = played(preset, events, seconds, surface=bumpy)
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


@pytest.mark.parametrize(("catch_up", "unfold_s"), [(1.1, 1.8), (0.5, 8.0), (3.0, 0.0)])
def test_a_finger_that_rests_is_silent_within_the_tail(catch_up, unfold_s):
    engine = ov.Engine(clutched(catch_up, unfold_s), timeline_of(30.0, 50.0))
    engine.prepare(8_000, 8_000)
    engine.control(math.pi, True)
    out = np.zeros((8_000, 2), dtype=np.float32)
    for _ in range(math.ceil(engine.tail_seconds)):
        engine.process(out)
    assert not out[-1].any()
    assert engine.meters.silent_samples > 0
