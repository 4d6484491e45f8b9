"""What a zoom on a goal feels like: three times as many things one by one, the goal above all."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.data.timeline.time_expressions import zoom_window
from overview_dsp.measure.perceived_level import count_resolved_events, stroke_feel, strokes
from tests.data.timeline.strategies import without_ticks

SLOW_S = 15.0
"""A sweep of twelve degrees a second, for the whole and for the part."""

MATCHES = ("world-cup-final-2018", "15986", "22936", "69321")


@pytest.fixture(scope="module")
def load(request):
    @cache
    def by_name(name):
        if not name.isdigit():
            return ov.load_timeline(name)
        folder = request.getfixturevalue("data_folder")
        return ov.load_timeline(folder / "football" / "statsbomb" / f"{name}.json")

    return by_name


def out_stroke(timeline, preset, seconds):
    result = ov.render(timeline, preset, ov.sweep(seconds))
    (stroke, *_) = strokes(result.trace.engaged, result.trace.cursor)
    return stroke, result.engine.surface, result.trace, result.samples[:, 1], result.sample_rate


@pytest.mark.parametrize("name", MATCHES)
def test_about_a_goal_three_times_as_many_events_a_degree_are_felt_or_most_there_are(
    load, football, name
):
    timeline = load(name)
    whole = count_resolved_events(*out_stroke(timeline, football, SLOW_S))
    for number in range(1, timeline.kinds()["goal"] + 1):
        part = timeline.window(*zoom_window(timeline, f"goal:{number}"))
        # both are half a turn: a degree of one is a degree of the other
        felt = count_resolved_events(*out_stroke(part, football, SLOW_S))
        assert felt >= min(3 * whole, 0.6 * len(part.events))  # or what there is


@pytest.mark.parametrize("width", [None, 90, 20])
def test_zoomed_in_the_goal_still_stands_out_of_everything_around_it(load, football, width):
    timeline = load("world-cup-final-2018")
    for seconds in (2.0, 6.0):
        spec = "goal:2" if width is None else f"goal:2:{width}"
        part = timeline.window(*zoom_window(timeline, spec))
        stroke, surface, trace, tactor, rate = out_stroke(part, football, seconds)
        feel = stroke_feel(stroke, surface, trace, tactor, rate)
        kinds = np.array([part.events[event].kind for event in surface.event])
        goal = feel.event_db[kinds == "goal"].min()
        assert goal - np.nanmedian(feel.event_db[kinds == "touch"]) >= 6.0


def test_each_step_of_a_zoom_shows_more_of_what_led_to_the_goal(load):
    timeline = load("world-cup-final-2018")
    goal = timeline.event("goal", 2).time_s
    lead = []
    for width in (timeline.duration_s, 1200.0, 588.0, 300.0, 120.0, 60.0):
        part = timeline.window(max(0.0, goal - 0.75 * width), min(goal + 0.25 * width, 5880.0))
        before = goal - max(0.0, goal - 0.75 * width)
        lead.append(sum(before - 45.0 <= e.time_s < before for e in without_ticks(part)))
    assert sorted(lead) == lead
    assert lead[-1] >= lead[0] + 5
