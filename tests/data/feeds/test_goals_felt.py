"""Every goal of a match that is told can be felt the moment it has come, in both maps."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.data.feeds.feed_lines import encode_line, take_line
from overview_dsp.measure.perceived_level import stroke_feel, strokes
from tests.data.feeds.feeds import MATCHES, lines_of

RATE = 16_000
GOALS = ("goal", "own_goal")


@pytest.mark.parametrize(
    "name", [MATCHES[1], *(pytest.param(one, marks=pytest.mark.soak) for one in MATCHES[2:])]
)
@pytest.mark.parametrize("map", ["whole", "so far"])
def test_a_goal_that_has_just_come_is_the_hardest_knock_of_a_sweep(
    name, map, football, data_folder
):
    match = ov.load_timeline(f"{data_folder}/{name}")
    live = ov.LiveTimeline(map=map, expect_s=95 * 60.0)
    came = 0
    for line in lines_of(match):
        take_line(live, encode_line(line))
        if line.get("event", {}).get("kind") not in GOALS:
            continue
        came += 1
        shown = live.felt()
        result = ov.render(shown, football, ov.sweep(3.0), sample_rate=RATE)
        surface, trace = result.engine.surface, result.trace
        stroke = strokes(trace.touching, trace.cursor)[0]
        level_db = stroke_feel(stroke, surface, trace, result.samples[:, 1], RATE).event_db
        kinds = np.array([shown.events[event].kind for event in surface.event])
        at = [shown.events[event].time_s for event in surface.event]
        new = at.index(line["event"]["time_s"]) + [
            kind for kind, when in zip(kinds, at, strict=True) if when == line["event"]["time_s"]
        ].index(line["event"]["kind"])
        lesser = level_db[np.isin(kinds, ["foul", "near_miss"])]
        # three just noticeable steps above what happens all the time
        assert level_db[new] > np.nanmedian(lesser) + 6.0, (live.now_s, level_db[new])
    assert came == sum(match.kinds().get(kind, 0) for kind in GOALS)
    assert came >= 2
