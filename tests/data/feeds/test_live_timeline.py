"""Snapshots of a live timeline at any time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.data.feeds import feed_history
from overview_dsp.data.feeds.feed_lines import encode_line
from tests.data.feeds.feeds import MATCHES, apply_line, lines_of, read_prefix

KINDS = st.sampled_from(["goal", "foul", "period", "near_miss", "deal"])
TIMES = st.integers(0, 6000).map(float)
EVENTS = st.builds(ov.Event, TIMES, KINDS, st.sampled_from(["", "a", "b"]))


@pytest.mark.parametrize("name", MATCHES)
def test_each_snapshot_of_a_match_equals_the_file_until_then(name, data_folder):
    match = ov.load_timeline(f"{data_folder}/{name}")
    live = ov.LiveTimeline(layout="so far")
    received = []
    for line in lines_of(match):
        before = live.revision
        apply_line(live, encode_line(line))
        if "event" in line:
            received.append(line["event"])
        if live.revision == before or "end" in line or not received:
            continue
        if "event" in line or len(received) % 7 == 0:
            snapshot = live.snapshot()
            events = [ov.Event(**one) for one in received]
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
    recorded = ov.load_timeline(name)
    live = ov.LiveTimeline()
    for line in lines_of(recorded):
        apply_line(live, encode_line(line))
    assert live.snapshot() == recorded


@given(st.lists(EVENTS, max_size=30), st.lists(TIMES, max_size=10), st.data())
@settings(max_examples=60)
def test_order_and_repetition_have_no_effect(events, clocks, data):
    first = ov.LiveTimeline("x", layout="so far")
    retracted = data.draw(st.lists(st.sampled_from(events), max_size=5)) if events else []
    first.append(events=events)
    for clock in clocks:
        first.append(clock_s=clock)
    for event in retracted:
        first.retract(event)
    jobs = [("event", one) for one in events] * 2 + [("clock", one) for one in clocks]
    jobs = data.draw(st.permutations(jobs + [("retract", one) for one in retracted]))
    second = ov.LiveTimeline("x", layout="so far")
    for action, value in jobs:
        if action == "event":
            second.append(events=[value])
        elif action == "clock":
            second.append(clock_s=value)
        else:
            second.retract(value)
    one, other = first.snapshot(), second.snapshot()
    assert sorted(one.events, key=repr) == sorted(other.events, key=repr)
    counted = {event for event in one.events if event.kind != "withdrawn_goal"}
    assert counted == set(events) - set(retracted)
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
            st.tuples(st.just("layout"), st.sampled_from(["whole", "so far"])),
            st.tuples(st.just("expect"), st.floats(1.0, 1e4) | st.none()),
            st.tuples(st.just("end"), st.floats(1.0, 1e4) | st.none()),
        ),
        max_size=25,
    )
)
@settings(max_examples=80)
def test_each_snapshot_is_a_timeline_until_now_after_any_changes(jobs):
    live = ov.LiveTimeline()
    for action, value in jobs:
        before, last = live.revision, live.snapshot()
        if action == "event":
            live.append(events=[value])
        elif action == "retract":
            live.retract(value)
        elif action == "sample":
            live.append(intensity=[value])
        elif action == "clock":
            live.append(clock_s=value)
        elif action == "gap" and value[0] < value[1]:
            live.gap(*value)
        elif action == "layout":
            live.layout = value
        elif action == "expect":
            live.expected_duration_s = value
        elif action == "end":
            live.end(value)
        shown = live.snapshot()
        # an unchanged snapshot is the same object
        assert (live.revision == before) == (shown is last)
        assert shown.duration_s >= live.now_s
        known_until_s = shown.duration_s if shown.known_until_s is None else shown.known_until_s
        assert all(event.time_s <= known_until_s for event in shown.events)
        if shown.known_until_s is not None:
            assert not live.ended
            assert shown.known_until_s == live.now_s


def test_a_retracted_event_stays_retracted_if_it_arrives_late_or_again():
    goal = ov.Event(786.0, "goal", "1-0")
    live = ov.LiveTimeline()
    assert not live.retract(goal)
    live.append(events=[goal, ov.Event(10.0, "foul")])
    assert live.snapshot().kinds() == {"foul": 1}
    live.append(events=[ov.Event(800.0, "goal", "1-0")], ids=["g1"])
    assert live.retract("g1")
    live.append(events=[ov.Event(801.0, "goal", "1-0")], ids=["g1"])
    assert live.snapshot().kinds() == {"foul": 1}
    assert [change.action for change in live.changes_since(0)] == ["added", "added", "retracted"]


def test_a_corrected_event_replaces_the_one_with_its_id_also_when_both_are_repeated():
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


def test_the_whole_layout_has_a_future_and_is_extended_when_the_clock_passes_its_end():
    live = ov.LiveTimeline(expected_duration_s=5700.0)
    live.append(events=[ov.Event(100.0, "goal")])
    assert (live.snapshot().duration_s, live.snapshot().known_until_s) == (5700.0, 100.0)
    live.append(clock_s=5700.0)
    assert (live.snapshot().duration_s, live.snapshot().known_until_s) == (5700.0, None)
    live.append(clock_s=5701.0)
    assert live.snapshot().duration_s == pytest.approx(5985.0)
    assert live.snapshot().known_until_s == 5701.0
    live.end()
    assert (live.snapshot().duration_s, live.snapshot().known_until_s) == (5701.0, None)


def test_silence_of_a_feed_with_a_clock_is_a_gap_until_data_for_it_arrive():
    live = ov.LiveTimeline(layout="so far")
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


def test_there_is_no_gap_before_the_first_clock_line():
    live = ov.LiveTimeline()
    live.append(events=[ov.Event(10.0, "foul"), ov.Event(2000.0, "foul")], clock_s=2900.0)
    assert live.snapshot().gaps == ()


def test_minutes_without_an_event_are_no_gap_in_a_feed_without_a_clock():
    live = ov.LiveTimeline()
    live.append(events=[ov.Event(10.0, "foul"), ov.Event(2000.0, "foul")])
    assert live.snapshot().gaps == ()


def test_an_invalid_value_is_an_error_and_nothing_is_added():
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
            live.expected_duration_s = value
    with pytest.raises(ov.InputError, match="whole, so far"):
        live.layout = "half"


def test_too_many_events_omit_the_most_frequent_kind_and_never_the_goal(monkeypatch):
    monkeypatch.setattr(feed_history, "MAX_EVENTS", 100)
    live = ov.LiveTimeline()
    live.append(events=[ov.Event(5.5, "goal")])
    for n in range(1000):
        live.append(events=[ov.Event(float(n), "foul")])
    shown = live.snapshot()
    assert shown.kinds()["goal"] == 1
    assert 40 <= len(shown.events) <= 100
    assert shown.events[-1].time_s > 980.0
    assert live.omitted_events + len(shown.events) == 1001
    assert any("too many" in note for note in shown.notes)


def test_too_many_samples_are_merged_in_pairs_and_the_maximum_stays(monkeypatch):
    monkeypatch.setattr(feed_history, "MAX_SAMPLES", 64)
    live = ov.LiveTimeline(silence_s=1e6)
    for n in range(10_000):
        live.append(intensity=[(float(n), 9.0 if n == 777 else 1.0)])
    curve = live.snapshot().intensity
    assert curve.count <= 64
    assert curve.last_s == 9999.0
    assert curve.value.max() == 9.0
    assert abs(curve.time_s[int(np.argmax(curve.value))] - 777.0) < 1.0


def test_an_event_whose_id_was_retracted_earlier_is_not_added():
    live = ov.LiveTimeline()
    assert not live.retract("g9")
    live.append(events=[ov.Event(786.0, "goal", "1-0")], ids=["g9"])
    live.append(events=[ov.Event(800.0, "goal", "1-0")], ids=["g10"])
    assert [event.time_s for event in live.snapshot().events] == [800.0]


def test_another_label_in_a_document_that_is_read_again_withdraws_no_goal():
    live = ov.LiveTimeline()
    goals = [ov.Event(60.0, "goal", "1-0 Smith"), ov.Event(60.0, "goal", "2-0 Jones")]
    live.replace(ov.Timeline("", 100.0, goals))
    seen = live.revision
    live.replace(ov.Timeline("", 100.0, [ov.Event(60.0, "goal", "1-0 A. Smith"), goals[1]]))
    assert live.changes_since(seen) == ()
    assert live.snapshot().events[0].label == "1-0 A. Smith"
    live.replace(ov.Timeline("", 100.0, [ov.Event(60.0, "goal", "1-0 Smith (A.)")]))
    assert [(one.action, one.event) for one in live.changes_since(seen)] == [
        ("retracted", goals[1])
    ]


def test_a_retracted_goal_is_a_withdrawn_goal_until_another_one_corrects_it():
    live = ov.LiveTimeline(expected_duration_s=5700.0)
    goal, foul = ov.Event(786.0, "goal", "1-0 Parris 14'"), ov.Event(900.0, "foul")
    live.append(events=[goal, foul], ids=["g", "f"])
    live.retract("g")
    live.retract("f")
    withdrawn = ov.Event(786.0, "withdrawn_goal", "Parris")
    live.append(clock_s=1000.0)
    assert live.snapshot().events == (withdrawn,)
    assert live.snapshot().intensity is None or live.snapshot().intensity.count <= 1
    assert [(one.action, one.event.kind) for one in live.changes_since(0)] == [
        ("added", "goal"),
        ("added", "foul"),
        ("retracted", "goal"),
        ("added", "withdrawn_goal"),
        ("retracted", "foul"),
    ]
    live.append(events=[ov.Event(780.0, "goal", "1-0 Parris 13'")])
    assert live.snapshot().kinds() == {"goal": 1}


def test_a_goal_that_is_retracted_before_it_arrives_is_withdrawn_too():
    live = ov.LiveTimeline(expected_duration_s=5700.0)
    goal = ov.Event(786.0, "goal", "1-0")
    live.retract(goal)
    live.append(events=[goal], clock_s=800.0)
    assert live.snapshot().kinds() == {"withdrawn_goal": 1}
    revision = live.revision
    live.append(events=[goal], clock_s=800.0)
    assert live.revision == revision


def test_a_goal_that_a_new_document_lacks_is_withdrawn_at_its_position():
    live = ov.LiveTimeline()
    foul, goal = ov.Event(10.0, "foul"), ov.Event(786.0, "goal", "1-0 Parris")
    live.replace(ov.Timeline("A - B", 1000.0, (foul, goal)))
    live.replace(ov.Timeline("A - B", 1100.0, (foul,)))
    assert live.snapshot().events == (foul, ov.Event(786.0, "withdrawn_goal", "Parris"))
    marked = ov.Timeline("A - B", 1200.0, (foul, ov.Event(780.0, "withdrawn_goal", "Parris")))
    live.replace(marked)
    assert live.snapshot() == marked
