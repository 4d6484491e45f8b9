"""What a window shows besides the events it was cut with: details and ticks."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from datetime import datetime

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overview_dsp.data.readers.data_file import parse_json
from overview_dsp.data.readers.native import decode, encode
from overview_dsp.data.timeline import Event, Timeline
from overview_dsp.data.timeline.ticks import KINDS as TICKS
from overview_dsp.data.timeline.ticks import MOST_TICKS, window_ticks
from overview_dsp.data.timeline.window_events import (
    APART,
    MOST_BY_RULE,
    MOST_DETAILS,
    ranks,
    window_events,
)
from overview_dsp.errors import InputError
from tests.data.timeline.strategies import without_ticks


def touches(*times: float, weight: float = 1.0) -> tuple[Event, ...]:
    return tuple(Event(time, "touch", weight=weight) for time in times)


def busy(count: int) -> Timeline:
    return Timeline(
        "busy",
        5000.0,
        (Event(2500.0, "goal"),),
        details=touches(*np.linspace(0.0, 5000.0, count).tolist()),
    )


def filled(details: tuple[Event, ...], events: tuple[Event, ...], duration_s: float) -> set[Event]:
    """The details that a window shows, the first of them first."""
    return set(window_events(events, (), (), details, duration_s)) - set(events)


def test_details_are_no_events_of_the_whole() -> None:
    timeline = busy(2001)
    assert timeline.kinds() == {"goal": 1}
    assert len(timeline.details) == 2001


@pytest.mark.parametrize("count", [400, 20_000, 200_000])
def test_a_window_shows_as_many_as_a_hand_tells_apart_however_many_there_are(count: int) -> None:
    timeline = busy(count)
    for width in (5000.0, 2500.0, 1250.0, 60.0):
        part = timeline.window(2500.0 - width / 2.0, 2500.0 + width / 2.0)
        own = without_ticks(part)
        ticks = len(part.events) - len(own)
        assert len(part.events) == min(MOST_DETAILS, len(part.details) + ticks + 1)
        if len(own) > 50:
            thirds = np.histogram([event.time_s for event in own], 3, (0.0, width))[0]
            assert thirds.min() > 0.6 * thirds.max()  # from all of it


def test_shots_come_before_passes() -> None:
    random = np.random.default_rng(1)
    shots = touches(*random.uniform(0.0, 5000.0, 100).tolist(), weight=1.5)
    passes = touches(*random.uniform(0.0, 5000.0, 5000).tolist())
    timeline = Timeline("m", 5000.0, (Event(2500.0, "goal"),), details=(*shots, *passes))
    shown = without_ticks(timeline.window(0.0, 5000.0))
    assert sum(event.weight == 1.5 for event in shown) == len(shots)
    assert len(shown) > len(shots)


@given(st.integers(0, 3000), st.floats(0.0, 1.0), st.integers(0, 10**6))
def test_as_one_zooms_what_was_shown_stays_and_the_number_never_falls_until_all_is_shown(
    count: int, at: float, seed: int
) -> None:
    random = np.random.default_rng(seed)
    times = np.unique(np.round(random.uniform(0.0, 5400.0, count) ** 2 / 5400.0, 2))
    goal = Event(round(5400.0 * at, 1), "goal")
    timeline = Timeline("m", 5400.0, (goal,), details=touches(*times.tolist()))
    before, width = 0, 5400.0
    while width > 1.0:
        start = min(max(goal.time_s - 0.75 * width, 0.0), 5400.0 - width)
        part = timeline.window(start, start + width)
        shown = [event for event in part.events if event.kind == "touch"]
        assert len(part.events) >= before or len(shown) == len(part.details)
        assert any(event.kind in TICKS for event in part.events)
        before, width = len(part.events), width / 2.0


def test_ranks_take_the_heavier_first_and_divide_time_evenly() -> None:
    assert ranks(touches(1.0, 2.0, 3.0, 4.0)).tolist() == [0, 2, 1, 3]
    assert ranks((Event(1.0, "a"), Event(2.0, "a", weight=2.0))).tolist() == [1, 0]
    assert ranks(()).tolist() == []


def test_a_window_of_a_window_shows_what_that_window_shows_of_the_whole() -> None:
    timeline = busy(20_001)
    part = timeline.window(2400.0, 2550.0).window(80.0, 110.0)
    direct = timeline.window(2480.0, 2510.0)
    assert [(e.kind, e.label) for e in part.events] == [(e.kind, e.label) for e in direct.events]
    assert [e.time_s for e in part.events] == pytest.approx([e.time_s for e in direct.events])


def test_of_two_too_close_the_first_is_shown_and_the_other_only_where_there_is_room() -> None:
    near = touches(30.0, 30.0001)
    others = touches(*np.linspace(31.0, 99.0, MOST_DETAILS - 1).tolist())
    assert filled((*near, *others), (), 100.0) == {near[0], *others}
    assert filled((*near, *others[1:]), (), 100.0) == {*near, *others[1:]}
    assert filled(touches(30.0), (Event(30.0, "touch"),), 100.0) == set()  # it is there


@given(st.lists(st.floats(0.0, 100.0), max_size=80, unique=True), st.lists(st.floats(0.0, 100.0)))
def test_those_that_can_be_told_apart_come_first_and_all_if_there_is_room(
    times: list[float], others: list[float]
) -> None:
    events = tuple(Event(time, "goal", str(i)) for i, time in enumerate(sorted(others)))
    details = touches(*times)
    shown = filled(details, events, 100.0)
    room = max(0, MOST_DETAILS - len(events))
    assert len(shown) == min(room, len(details))
    hidden = set(details) - shown
    taken = np.array([event.time_s for event in (*events, *shown)])
    if any(np.abs(taken - event.time_s).min() >= APART * 100.0 for event in hidden):
        # one that is apart is left out only for others that are
        gaps = np.diff(np.sort(taken))
        assert all(np.sum(np.abs(taken - event.time_s) < APART * 100.0) == 1 for event in shown), (
            gaps
        )


def test_details_are_checked_as_events_are_and_kept_in_a_native_file() -> None:
    timeline = busy(11)
    assert decode(parse_json(encode(timeline).decode(), "x")) == timeline
    with pytest.raises(InputError, match=r"details: the touch at 101\.0 s is after the end"):
        Timeline("t", 100.0, (Event(1.0, "goal"),), details=touches(101.0))
    document = {"overview_timeline": 1, "duration_s": 9.0, "details": [{"time_s": 1, "kind": "A"}]}
    with pytest.raises(InputError, match=r"details\[0\]\.kind"):
        decode({**document, "events": [{"time_s": 1, "kind": "a"}]})


@pytest.mark.parametrize(
    ("from_s", "width_s", "kind", "label"),
    [
        (0.0, 5400.0, "minute", "minute 5"),
        (1000.0, 1200.0, "minute", "minute 17"),
        (1000.0, 60.0, "second", "16:45"),
        (1000.0, 2.0, "second", "16:40.1"),
        (0.0, 86_400.0, "hour", "hour 1"),
        (0.0, 30 * 86_400.0, "day", "day 2"),
    ],
)
def test_a_part_without_a_calendar_has_ticks_of_the_wholes_clock(
    from_s: float, width_s: float, kind: str, label: str
) -> None:
    marks = window_ticks(None, from_s, width_s)
    assert (marks[0].kind, marks[0].label) == (kind, label)


@pytest.mark.parametrize(
    ("width_s", "label"),
    [
        (86_400.0 * 365, "July 2019"),
        (86_400.0 * 60, "week of 2019-06-17"),
        (86_400.0 * 7, "2019-06-16"),
        (86_400.0 * 2, "2019-06-16"),
        (86_400.0, "10:00"),
        (60.0, "09:00:05"),
    ],
)
def test_a_part_with_a_calendar_has_months_before_weeks_before_days_before_hours(
    width_s: float, label: str
) -> None:
    assert label in [mark.label for mark in window_ticks(datetime(2019, 6, 15, 9), 0.0, width_s)]


@given(
    st.floats(0.0, 1e6),
    st.floats(1e-4, 1e9),
    st.none() | st.datetimes(datetime(1, 1, 1), datetime(9000, 1, 1)),
)
def test_no_part_is_without_a_tick(from_s: float, width_s: float, start: datetime | None) -> None:
    marks = window_ticks(start, from_s, width_s)
    assert 1 <= len(marks) <= MOST_TICKS
    assert all(0.0 < mark.time_s < width_s for mark in marks)
    if start is None:
        assert len(marks) >= 8
    assert all(a.time_s < b.time_s for a, b in itertools.pairwise(marks))


def test_no_more_is_asked_of_the_rules_than_a_window_takes() -> None:
    asked = []

    def found() -> Iterator[Event]:
        for second in range(10_000):
            asked.append(second)
            yield Event(float(second), "peak")

    shown = window_events((), (), found(), (), 10_000.0)
    assert len(shown) == MOST_BY_RULE
    assert len(asked) < 2000
    asked.clear()
    given = tuple(Event(float(second), "goal") for second in range(MOST_BY_RULE))
    assert window_events(given, (), found(), (), 10_000.0) == given
    assert asked == []
