"""Differences between timelines, and timelines made from them."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings

import overview_dsp as ov
from overview_dsp.data.feeds.feed_lines import encode_line
from overview_dsp.data.feeds.timeline_diff import apply_diff, timeline_diff
from tests.data.feeds.feeds import apply_line, lines_of
from tests.data.timeline.strategies import timelines


@given(timelines(), timelines())
@settings(max_examples=60)
def test_a_difference_turns_the_old_timeline_into_the_new_one(old, new):
    change = json.loads(json.dumps(timeline_diff(old, new)))
    made = apply_diff(old, change)
    assert made == new
    assert apply_diff(made, change) == new


def test_the_differences_of_a_match_are_small_and_add_up_to_the_match(match):
    live = ov.LiveTimeline("m")
    mine = live.snapshot()
    most = 0
    for line in lines_of(match)[:-1]:
        apply_line(live, encode_line(line))
        shown = live.snapshot()
        change = json.dumps(timeline_diff(mine, shown))
        most = max(most, len(change))
        mine = apply_diff(mine, json.loads(change))
        assert mine == shown
    assert most < 1000


def test_a_derived_curve_is_named_and_not_included():
    live = ov.LiveTimeline("m", expected_duration_s=5700.0)
    live.append(events=[ov.Event(10.0, "goal")], clock_s=60.0)
    before = live.snapshot()
    live.append(events=[ov.Event(50.0, "foul")], clock_s=90.0)
    change = timeline_diff(before, live.snapshot())
    assert change["curve"] == "excitement"
    assert apply_diff(before, change) == live.snapshot()


def test_a_series_with_window_events_is_included_in_full():
    share = ov.load_timeline("made-up-share")
    change = json.loads(json.dumps(timeline_diff(ov.load_timeline("world-cup-final-2018"), share)))
    made = apply_diff(share, change)
    assert made == share
    third = share.duration_s / 3.0
    assert made.window(0.0, third).events == share.window(0.0, third).events


@pytest.mark.parametrize(
    "bad",
    [
        {"duration_s": "long"},
        {"new": [{"time_s": 3}]},
        {"curve": {"keep": 9}},
        {"curve": {"keep": 10**9, "time_s": [], "value": [], "unit": "", "percentiles": [0, 100]}},
        {"gaps": 3},
        {"whole": []},
        {"start": "tomorrow"},
    ],
)
def test_an_invalid_difference_is_a_one_line_error(bad):
    curve = ov.Intensity(np.arange(3.0), np.arange(3.0))
    with pytest.raises(ov.InputError) as raised:
        apply_diff(ov.Timeline("x", 10.0, (), curve), bad)
    assert "\n" not in str(raised.value)
