"""Windows one after the other: in, out, along, from event to event."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.data.timeline.time_expressions import NARROWEST_S, Zoom
from overview_dsp.errors import InputError

EVENTS = tuple(Event(time, "goal") for time in (100.0, 500.0, 900.0))
TIMELINE = Timeline("t", 1000.0, EVENTS)


def test_zooming_in_and_out_again_is_where_it_was() -> None:
    zoom = Zoom.whole(TIMELINE)
    closer = zoom.scaled(4.0, 300.0, 0.3)
    assert closer.window == pytest.approx((225.0, 475.0))
    assert closer.scaled(0.25, 300.0, 0.3).window == pytest.approx((0.0, 1000.0))


@given(
    st.floats(0.0, 999.0),
    st.floats(NARROWEST_S, 1000.0),
    st.floats(1e-3, 1e3),
    st.floats(0.0, 1.0),
)
def test_the_moment_under_the_hand_stays_there(
    start: float, width: float, factor: float, about: float
) -> None:
    zoom = Zoom(TIMELINE, start, min(start + width, 1000.0))
    moment = zoom.start_s + about * zoom.width_s
    after = zoom.scaled(factor, moment, about)
    assert 0.0 <= after.start_s < after.end_s <= 1000.0
    wanted = min(max(zoom.width_s / factor, NARROWEST_S), 1000.0)
    assert after.width_s == pytest.approx(wanted, rel=1e-6)
    if after.start_s > 0.0 and after.end_s < 1000.0:
        assert after.start_s + about * after.width_s == pytest.approx(moment, abs=1e-6)
    # at the ends it's as near as it can be, and still shown
    assert after.start_s - 1e-6 <= moment <= after.end_s + 1e-6


def test_zooming_stops_at_the_narrowest_and_at_the_whole() -> None:
    zoom = Zoom.whole(TIMELINE).scaled(1e9, 1000.0, 1.0)
    assert zoom.window == (1000.0 - NARROWEST_S, 1000.0)
    assert zoom.scaled(1e-9, 999.75, 0.5).window == (0.0, 1000.0)
    short = Timeline("s", 0.1, (Event(0.05, "a"),))
    assert Zoom.whole(short).scaled(10.0, 0.05, 0.5).window == (0.0, 0.1)


def test_events_follow_each_other_over_the_whole_and_not_only_in_the_window() -> None:
    zoom = Zoom(TIMELINE, 400.0, 600.0)
    assert [zoom.next_event_s(at) for at in (0.0, 100.0, 600.0, 900.0)] == [
        100.0,
        500.0,
        900.0,
        None,
    ]
    assert [zoom.previous_event_s(at) for at in (1000.0, 900.0, 100.0)] == [900.0, 500.0, None]


def test_a_window_moves_to_a_moment_beyond_it_and_stays_for_one_within() -> None:
    zoom = Zoom(TIMELINE, 400.0, 600.0)
    assert zoom.showing(450.0) is zoom
    assert zoom.showing(900.0).window == (750.0, 950.0)
    assert zoom.showing(100.0).window == (0.0, 200.0)
    assert zoom.showing(1000.0).window == (800.0, 1000.0)


def test_a_window_that_is_none_is_refused() -> None:
    with pytest.raises(InputError, match="empty or outside"):
        Zoom(TIMELINE, 5.0, 5.0)
