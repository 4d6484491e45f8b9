from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.analysis.crowd_excitement import (
    AMBIENT,
    AMPLITUDES,
    FALL_S,
    FOOTBALL_KINDS,
    MAX_DURATION_S,
    MAX_EVENTS,
    RISE_S,
    crowd_curve,
    derive_intensity,
)
from overview_dsp.data.timeline import Event, Intensity

EVENTS = st.lists(
    st.builds(
        Event,
        st.floats(0.0, 6000.0),
        st.sampled_from(sorted(FOOTBALL_KINDS)),
        weight=st.floats(1e-9, 1e308),
    ),
    max_size=30,
)


def excess(curve: Intensity) -> np.ndarray:
    """What an isolated event contributes, the ambient floor taken out."""
    return 1.0 - (1.0 - curve.value) / (1.0 - AMBIENT)


def test_the_curve_is_the_documented_formula() -> None:
    curve = crowd_curve([Event(1000.0, "goal")], 3000.0)
    goal = AMPLITUDES["goal"]
    since = curve.time_s - 1000.0
    expected = goal * np.where(since < 0, np.exp(since / RISE_S), np.exp(-since / FALL_S))
    np.testing.assert_allclose(excess(curve), expected, atol=1e-12)


def test_excitement_rises_over_a_shorter_time_than_it_falls() -> None:
    curve = crowd_curve([Event(1000.0, "goal")], 3000.0)
    above = curve.time_s[excess(curve) >= AMPLITUDES["goal"] / np.e]
    assert 1000.0 - above[0] == pytest.approx(RISE_S, abs=5.0)
    assert above[-1] - 1000.0 == pytest.approx(FALL_S, abs=5.0)
    assert RISE_S < FALL_S / 2


def test_an_isolated_event_is_the_peak_and_all_goes_down_from_it() -> None:
    curve = crowd_curve([Event(1003.7, "foul")], 3000.0)
    peak = int(np.argmax(curve.value))
    assert curve.time_s[peak] == 1003.7
    assert np.all(np.diff(curve.value[: peak + 1]) >= 0.0)
    assert np.all(np.diff(curve.value[peak:]) <= 0.0)
    assert curve.value[peak] - curve.value[0] > 0.1


def test_a_goal_stands_out_above_a_card_and_a_card_above_a_foul() -> None:
    heights = [
        crowd_curve([Event(1000.0, kind)], 3000.0).value.max()
        for kind in ("goal", "red_card", "near_miss", "yellow_card", "foul")
    ]
    assert heights == sorted(heights, reverse=True)


def test_a_foul_stays_visible_in_the_noise_after_a_goal() -> None:
    goal = Event(1000.0, "goal")
    without, with_foul = crowd_curve([goal], 3000.0), crowd_curve([goal, Event(1060, "foul")], 3000)
    at = 1060.0
    low = np.interp(at, without.time_s, without.value)
    assert np.interp(at, with_foul.time_s, with_foul.value) > low + 0.03


@given(EVENTS, st.floats(6000.0, 7000.0))
def test_the_curve_is_bounded_and_has_a_point_at_every_event(
    events: list[Event], duration_s: float
) -> None:
    curve = crowd_curve(events, duration_s)
    assert curve.value.min() >= AMBIENT - 1e-12
    assert curve.value.max() <= 1.0
    assert np.isin([event.time_s for event in events], curve.time_s).all()
    assert curve.time_s[0] == 0.0
    assert curve.time_s[-1] == duration_s
    assert np.diff(curve.time_s).max() <= 5.0


@given(EVENTS, st.sampled_from(sorted(FOOTBALL_KINDS)), st.floats(0.0, 6000.0))
def test_one_more_event_never_lowers_the_curve(
    events: list[Event], kind: str, time_s: float
) -> None:
    before = crowd_curve(events, 6000.0)
    after = crowd_curve([*events, Event(time_s, kind)], 6000.0)
    common = np.isin(after.time_s, before.time_s)
    assert np.all(after.value[common] >= before.value - 1e-12)


def test_an_event_of_weight_two_counts_as_two() -> None:
    twice = crowd_curve([Event(50.0, "foul", "a"), Event(50.0, "foul", "b")], 100.0)
    np.testing.assert_allclose(
        crowd_curve([Event(50.0, "foul", weight=2.0)], 100.0).value.max(), twice.value.max()
    )


def test_other_kinds_are_silent() -> None:
    assert crowd_curve([Event(50.0, "beat")], 100.0).value.tolist() == [1.0 - (1.0 - AMBIENT)] * 21
    assert derive_intensity([Event(50.0, "beat")], 100.0) == (None, "", ())


def test_a_timeline_too_long_or_too_full_for_a_crowd_gets_a_note_instead() -> None:
    intensity, provenance, notes = derive_intensity([Event(0.0, "goal")], MAX_DURATION_S + 1.0)
    assert (intensity, provenance) == (None, "")
    assert "no crowd-excitement curve" in notes[0]
    many = [Event(0.1 * i, "goal") for i in range(MAX_EVENTS + 1)]
    assert derive_intensity(many, 1e4)[0] is None
    assert derive_intensity(many[:3], MAX_DURATION_S)[0] is not None
