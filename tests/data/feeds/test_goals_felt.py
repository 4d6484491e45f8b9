"""Each goal of a live match can be felt as soon as it arrives, in both layouts."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.data.feeds.feed_lines import encode_line
from overview_dsp.measure.perceived_level import stroke_feel, strokes
from tests.data.feeds.feeds import MATCHES, apply_line, lines_of

RATE = 16_000
GOALS = ("goal", "own_goal")


@pytest.mark.parametrize(
    "name", [MATCHES[1], *(pytest.param(one, marks=pytest.mark.soak) for one in MATCHES[2:])]
)
@pytest.mark.parametrize("layout", ["whole", "so far"])
def test_the_latest_goal_is_the_strongest_strike_of_a_sweep(name, layout, football, data_folder):
    match = ov.load_timeline(f"{data_folder}/{name}")
    live = ov.LiveTimeline(layout=layout, expected_duration_s=95 * 60.0)
    goals = 0
    for line in lines_of(match):
        apply_line(live, encode_line(line))
        if line.get("event", {}).get("kind") not in GOALS:
            continue
        goals += 1
        shown = live.padded_snapshot()
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
        # three just-noticeable differences above the frequent events
        assert level_db[new] > np.nanmedian(lesser) + 6.0, (live.now_s, level_db[new])
    assert goals == sum(match.kinds().get(kind, 0) for kind in GOALS)
    assert goals >= 2
