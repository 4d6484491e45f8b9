"""Small things that are felt in short windows only."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.errors import InputError
from overview_dsp.readers.native import decode, encode
from overview_dsp.readers.source import parse_json
from overview_dsp.timeline import Event, Timeline
from overview_dsp.timeline.fine_events import APART, MOST, shown_details


def touches(*times: float, weight: float = 1.0) -> tuple[Event, ...]:
    return tuple(Event(time, "touch", weight=weight) for time in times)


def busy(count: int) -> Timeline:
    return Timeline(
        "busy",
        5000.0,
        (Event(2500.0, "goal"),),
        details=touches(*np.linspace(0.0, 5000.0, count).tolist()),
    )


def test_details_are_no_events_of_the_whole() -> None:
    timeline = busy(2001)
    assert timeline.kinds() == {"goal": 1}
    assert len(timeline.details) == 2001


def test_the_shorter_a_window_is_the_more_of_what_happens_in_it_is_an_event() -> None:
    times = np.unique(np.random.default_rng(1).uniform(0.0, 5000.0, 20_000))  # four a second
    timeline = Timeline("busy", 5000.0, (Event(2500.0, "goal"),), details=touches(*times.tolist()))
    shares = []
    for width in (2000.0, 110.0, 60.0, 30.0, 10.0):
        part = timeline.window(2500.0 - width, 2500.0)
        shares.append((len(part.events) - 1) / len(part.details))
    assert shares[0] == 0.0
    assert 0.4 < shares[1] < 0.8
    assert sorted(shares) == shares
    assert shares[-1] > 0.85


def test_a_window_of_more_details_than_can_mean_anything_shows_none() -> None:
    assert len(shown_details(touches(*np.arange(MOST).tolist()), (), 1e4)) > MOST / 20
    assert shown_details(touches(*np.arange(MOST + 1).tolist()), (), 1e4) == ()
    assert shown_details((), (), 100.0) == ()


def test_a_window_of_a_window_shows_more_and_nothing_twice() -> None:
    timeline = busy(20_001)
    part = timeline.window(2400.0, 2550.0).window(80.0, 110.0)
    direct = timeline.window(2480.0, 2510.0)
    for one in (part, direct):
        times = [event.time_s for event in one.events]
        assert len(set(times)) == len(times)
        assert min(np.diff(times)) >= APART * 30.0
    assert len(part.events) == pytest.approx(len(direct.events), rel=0.1)


def test_of_two_too_close_the_heavier_is_shown_and_an_event_before_both() -> None:
    details = (*touches(10.0, 30.0), *touches(10.1, 30.1, weight=2.0))
    shown = shown_details(details, (Event(30.05, "goal"),), 100.0)
    assert [(event.time_s, event.weight) for event in shown] == [(10.1, 2.0)]


@given(st.lists(st.floats(0.0, 100.0), max_size=80, unique=True), st.lists(st.floats(0.0, 100.0)))
def test_whatever_is_shown_is_apart_and_nothing_that_is_apart_is_left_out(
    times: list[float], others: list[float]
) -> None:
    events = tuple(Event(time, "goal", str(i)) for i, time in enumerate(sorted(others)))
    shown = shown_details(touches(*sorted(times)), events, 100.0)
    apart = APART * 100.0
    taken = np.array([event.time_s for event in (*events, *shown)])
    for detail in shown:
        assert np.count_nonzero(np.abs(taken - detail.time_s) < apart) == 1
    for time in set(times) - {event.time_s for event in shown}:
        assert np.abs(taken - time).min() < apart


def test_details_are_checked_as_events_are_and_kept_in_a_native_file() -> None:
    timeline = busy(11)
    assert decode(parse_json(encode(timeline).decode(), "x")) == timeline
    with pytest.raises(InputError, match=r"details: the touch at 101\.0 s is after the end"):
        Timeline("t", 100.0, (Event(1.0, "goal"),), details=touches(101.0))
    document = {"overview_timeline": 1, "duration_s": 9.0, "details": [{"time_s": 1, "kind": "A"}]}
    with pytest.raises(InputError, match=r"details\[0\]\.kind"):
        decode({**document, "events": [{"time_s": 1, "kind": "a"}]})
