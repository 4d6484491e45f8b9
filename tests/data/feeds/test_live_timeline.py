"""What came so far, as a timeline at any moment."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.data.feeds import feed_history
from overview_dsp.data.feeds.feed_lines import encode_line, take_line
from tests.data.feeds.feeds import MATCHES, lines_of, read_prefix

KINDS = st.sampled_from(["goal", "foul", "period", "near_miss", "deal"])
TIMES = st.integers(0, 6000).map(float)
EVENTS = st.builds(ov.Event, TIMES, KINDS, st.sampled_from(["", "a", "b"]))


@pytest.mark.parametrize("name", MATCHES)
def test_a_match_that_is_told_is_what_the_reader_makes_of_as_much_of_the_file(name, data_folder):
    match = ov.load_timeline(f"{data_folder}/{name}")
    live = ov.LiveTimeline(map="so far")
    came = []
    for line in lines_of(match):
        before = live.revision
        take_line(live, encode_line(line))
        if "event" in line:
            came.append(line["event"])
        if live.revision == before or "end" in line or not came:
            continue
        if "event" in line or len(came) % 7 == 0:
            snapshot = live.snapshot()
            events = [ov.Event(**one) for one in came]
            read = read_prefix(events, live.now_s or 1.0)
            assert snapshot.duration_s == read.duration_s
            assert snapshot.events == read.events
            assert snapshot.intensity == read.intensity
            assert snapshot.gaps == ()
            assert snapshot.known_until_s is None
    assert live.ended
    assert live.snapshot() == match


@pytest.mark.parametrize("name", ["world-cup-final-2018", "made-up-share"])
def test_a_timeline_with_samples_is_the_same_at_its_end(name):
    told = ov.load_timeline(name)
    live = ov.LiveTimeline()
    for line in lines_of(told):
        take_line(live, encode_line(line))
    assert live.snapshot() == told


@given(st.lists(EVENTS, max_size=30), st.lists(TIMES, max_size=10), st.data())
@settings(max_examples=60)
def test_order_and_repetition_change_nothing(events, clocks, data):
    first = ov.LiveTimeline("x", map="so far")
    gone = data.draw(st.lists(st.sampled_from(events), max_size=5)) if events else []
    first.append(events=events)
    for clock in clocks:
        first.append(clock_s=clock)
    for event in gone:
        first.retract(event)
    jobs = [("event", one) for one in events] * 2 + [("clock", one) for one in clocks]
    jobs = data.draw(st.permutations(jobs + [("gone", one) for one in gone]))
    second = ov.LiveTimeline("x", map="so far")
    for what, value in jobs:
        if what == "event":
            second.append(events=[value])
        elif what == "clock":
            second.append(clock_s=value)
        else:
            second.retract(value)
    one, other = first.snapshot(), second.snapshot()
    assert sorted(one.events, key=repr) == sorted(other.events, key=repr)
    assert set(one.events) == set(events) - set(gone)
    assert (one.duration_s, one.gaps, one.notes) == (other.duration_s, other.gaps, other.notes)
    if one.intensity is not None:
        np.testing.assert_allclose(one.intensity.value, other.intensity.value, rtol=1e-12)


@given(
    st.lists(
        st.one_of(
            st.tuples(st.just("event"), EVENTS),
            st.tuples(st.just("retract"), EVENTS),
            st.tuples(st.just("sample"), st.tuples(TIMES, st.floats(-1e3, 1e3))),
            st.tuples(st.just("clock"), TIMES),
            st.tuples(st.just("gap"), st.tuples(TIMES, TIMES)),
            st.tuples(st.just("map"), st.sampled_from(["whole", "so far"])),
            st.tuples(st.just("expect"), st.floats(1.0, 1e4) | st.none()),
            st.tuples(st.just("end"), st.floats(1.0, 1e4) | st.none()),
        ),
        max_size=25,
    )
)
@settings(max_examples=80)
def test_whatever_comes_each_snapshot_is_a_timeline_up_to_now(jobs):
    live = ov.LiveTimeline()
    for what, value in jobs:
        before, last = live.revision, live.snapshot()
        if what == "event":
            live.append(events=[value])
        elif what == "retract":
            live.retract(value)
        elif what == "sample":
            live.append(intensity=[value])
        elif what == "clock":
            live.append(clock_s=value)
        elif what == "gap" and value[0] < value[1]:
            live.gap(*value)
        elif what == "map":
            live.map = value
        elif what == "expect":
            live.expect_s = value
        elif what == "end":
            live.end(value)
        shown = live.snapshot()
        # one that is given again is the same object, and nothing else has changed
        assert (live.revision == before) == (shown is last)
        assert shown.duration_s >= live.now_s
        happened = shown.duration_s if shown.known_until_s is None else shown.known_until_s
        assert all(event.time_s <= happened for event in shown.events)
        if shown.known_until_s is not None:
            assert not live.ended
            assert shown.known_until_s == live.now_s


def test_a_retracted_event_stays_away_also_if_it_comes_late_or_again():
    goal = ov.Event(786.0, "goal", "1-0")
    live = ov.LiveTimeline()
    assert not live.retract(goal)
    live.append(events=[goal, ov.Event(10.0, "foul")])
    assert live.snapshot().kinds() == {"foul": 1}
    live.append(events=[ov.Event(800.0, "goal", "1-0")], ids=["g1"])
    assert live.retract("g1")
    live.append(events=[ov.Event(801.0, "goal", "1-0")], ids=["g1"])
    assert live.snapshot().kinds() == {"foul": 1}
    assert [change.what for change in live.changes_since(0)] == ["added", "added", "retracted"]


def test_a_corrected_event_replaces_the_one_of_its_name_and_a_repetition_brings_neither_back():
    live = ov.LiveTimeline()
    first, second = ov.Event(10.0, "goal", "1-0 A"), ov.Event(11.0, "own_goal", "1-0 B")
    live.append(events=[first], ids=["7"])
    live.append(events=[second], ids=["7"])
    assert live.snapshot().events == (second,)
    revision = live.revision
    live.append(events=[first], ids=["7"])
    live.append(events=[second], ids=["7"])
    assert live.revision == revision
    assert live.snapshot().events == (second,)


def test_the_whole_map_has_a_future_and_is_extended_when_play_goes_on():
    live = ov.LiveTimeline(expect_s=5700.0)
    live.append(events=[ov.Event(100.0, "goal")])
    assert (live.snapshot().duration_s, live.snapshot().known_until_s) == (5700.0, 100.0)
    live.append(clock_s=5700.0)
    assert (live.snapshot().duration_s, live.snapshot().known_until_s) == (5700.0, None)
    live.append(clock_s=5701.0)
    assert live.snapshot().duration_s == pytest.approx(5985.0)
    assert live.snapshot().known_until_s == 5701.0
    live.end()
    assert (live.snapshot().duration_s, live.snapshot().known_until_s) == (5701.0, None)


def test_a_silent_stretch_of_a_feed_with_a_clock_is_a_gap_until_it_is_told():
    live = ov.LiveTimeline(map="so far")
    for clock in (30.0, 60.0, 90.0):
        live.append(clock_s=clock)
    live.append(clock_s=900.0, events=[ov.Event(890.0, "foul")])
    assert live.snapshot().gaps == ((90.0, 890.0),)
    assert live.snapshot().gap_reasons == ("the feed was silent",)
    live.append(events=[ov.Event(500.0, "foul")])
    assert live.snapshot().gaps == ((90.0, 500.0), (500.0, 890.0))
    for clock in range(90, 900, 100):
        live.append(clock_s=float(clock))
    assert live.snapshot().gaps == ()


def test_a_clock_that_is_told_for_the_first_time_leaves_no_gap_before_it():
    live = ov.LiveTimeline()
    live.append(events=[ov.Event(10.0, "foul"), ov.Event(2000.0, "foul")], clock_s=2900.0)
    assert live.snapshot().gaps == ()


def test_minutes_without_an_event_are_no_gap_where_no_clock_is_told():
    live = ov.LiveTimeline()
    live.append(events=[ov.Event(10.0, "foul"), ov.Event(2000.0, "foul")])
    assert live.snapshot().gaps == ()


def test_what_is_wrong_is_refused_whole():
    live = ov.LiveTimeline()
    good = ov.Event(10.0, "foul")
    for bad in (
        {"events": [good, "goal"]},
        {"events": [good], "intensity": [(1.0, float("nan"))]},
        {"events": [good], "clock_s": -1.0},
        {"events": [good], "clock_s": 1e30},
        {"events": [good, ov.Event(1e30, "foul")]},
        {"events": [good], "ids": ["a", "b"]},
    ):
        with pytest.raises(ov.InputError):
            live.append(**bad)
    assert live.revision == 0
    for value in (0.0, -1.0, float("inf"), "95m"):
        with pytest.raises(ov.InputError, match="expect"):
            live.expect_s = value
    with pytest.raises(ov.InputError, match="whole, so far"):
        live.map = "half"


def test_too_many_events_leave_out_the_commonest_and_never_the_goal(monkeypatch):
    monkeypatch.setattr(feed_history, "MAX_EVENTS", 100)
    live = ov.LiveTimeline()
    live.append(events=[ov.Event(5.5, "goal")])
    for n in range(1000):
        live.append(events=[ov.Event(float(n), "foul")])
    shown = live.snapshot()
    assert shown.kinds()["goal"] == 1
    assert 40 <= len(shown.events) <= 100
    assert shown.events[-1].time_s > 980.0
    assert live.left_out + len(shown.events) == 1001
    assert any("too many" in note for note in shown.notes)


def test_too_many_samples_are_merged_two_by_two_and_the_loudest_stays(monkeypatch):
    monkeypatch.setattr(feed_history, "MAX_SAMPLES", 64)
    live = ov.LiveTimeline(silence_s=1e6)
    for n in range(10_000):
        live.append(intensity=[(float(n), 9.0 if n == 777 else 1.0)])
    curve = live.snapshot().intensity
    assert curve.count <= 64
    assert curve.last_s == 9999.0
    assert curve.value.max() == 9.0
    assert abs(curve.time_s[int(np.argmax(curve.value))] - 777.0) < 1.0


def test_an_event_that_was_retracted_by_its_id_before_it_came_stays_away():
    live = ov.LiveTimeline()
    assert not live.retract("g9")
    live.append(events=[ov.Event(786.0, "goal", "1-0")], ids=["g9"])
    live.append(events=[ov.Event(800.0, "goal", "1-0")], ids=["g10"])
    assert [event.time_s for event in live.snapshot().events] == [800.0]
