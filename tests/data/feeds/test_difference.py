"""From one timeline to the next and back to the bit."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings

import overview_dsp as ov
from overview_dsp.data.feeds.difference import applied, difference
from overview_dsp.data.feeds.feed_lines import encode_line, take_line
from tests.data.feeds.feeds import lines_of
from tests.data.timeline.strategies import timelines


@given(timelines(), timelines())
@settings(max_examples=60)
def test_a_change_makes_the_next_timeline_of_the_last(old, new):
    change = json.loads(json.dumps(difference(old, new)))
    made = applied(old, change)
    assert made == new
    assert applied(made, change) == new


def test_the_changes_of_a_match_are_small_and_lead_to_its_end(match):
    live = ov.LiveTimeline("m")
    mine = live.snapshot()
    most = 0
    for line in lines_of(match)[:-1]:
        take_line(live, encode_line(line))
        shown = live.snapshot()
        change = json.dumps(difference(mine, shown))
        most = max(most, len(change))
        mine = applied(mine, json.loads(change))
        assert mine == shown
    assert most < 1000


def test_a_derived_curve_is_named_and_not_sent():
    live = ov.LiveTimeline("m", expect_s=5700.0)
    live.append(events=[ov.Event(10.0, "goal")], clock_s=60.0)
    before = live.snapshot()
    live.append(events=[ov.Event(50.0, "foul")], clock_s=90.0)
    change = difference(before, live.snapshot())
    assert change["curve"] == "excitement"
    assert applied(before, change) == live.snapshot()


def test_a_series_that_finds_its_events_in_windows_is_there_as_a_whole():
    share = ov.load_timeline("made-up-share")
    change = json.loads(json.dumps(difference(ov.load_timeline("world-cup-final-2018"), share)))
    made = applied(share, change)
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
def test_what_is_no_change_is_one_line(bad):
    curve = ov.Intensity(np.arange(3.0), np.arange(3.0))
    with pytest.raises(ov.InputError) as refused:
        applied(ov.Timeline("x", 10.0, (), curve), bad)
    assert "\n" not in str(refused.value)
