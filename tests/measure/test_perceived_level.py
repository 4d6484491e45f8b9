"""The felt level against signals whose level is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import overview_dsp as ov
from overview_dsp.measure.perceived_level import (
    Stroke,
    event_levels,
    passages,
    stroke_feel,
    strokes,
    window_db,
)
from overview_dsp.signal.surface.build import build_surface
from tests.examples import preset_with, timeline_of

RATE = 8000.0


def test_a_full_scale_sine_has_minus_3_db():
    sine = np.sin(2 * np.pi * 250.0 * np.arange(8000) / RATE).astype(np.float32)
    starts, level = window_db(sine, RATE)
    assert len(starts) == 100
    assert level == pytest.approx(-3.01, abs=0.2)


def test_silence_has_the_lowest_level_and_no_warning():
    _, level = window_db(np.zeros(800, dtype=np.float32), RATE)
    assert np.all(level == -200.0)


def test_windows_may_begin_between_samples():
    rate = 22_050.0
    ramp = np.linspace(0.0, 1.0, 22_050).astype(np.float32)
    starts, level = window_db(ramp, rate)
    middle = (starts + 0.005 * rate) / rate
    assert level[20:] == pytest.approx(20 * np.log10(middle[20:]), abs=0.05)


def test_strokes_are_detected_by_touch_and_end_where_the_disk_is_back():
    touching = np.array([0, 0, 1, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0], dtype=float)
    cursor = np.array([0, 0, 0.1, 0.3, 0.5, 0.3, 0.1, 0.005, 0.001, 0.2, 0.4, 0.3, 0.2])
    assert strokes(touching, cursor) == [
        Stroke("out", 2, 5),
        Stroke("recoil", 5, 8),
        Stroke("out", 9, 11),
        Stroke("recoil", 11, 13),
    ]


def test_an_event_gets_its_own_level_and_the_rest_its_median():
    surface = build_surface(timeline_of(50.0), preset_with(height=5.0, width=4.0))
    frames = 8000
    cursor = np.linspace(0.0, 1.0, frames)
    inside = (cursor > surface.span[0, 0]) & (cursor < surface.span[0, 1])
    tactor = np.sin(2 * np.pi * 250.0 * np.arange(frames) / RATE) * np.where(inside, 0.5, 0.05)
    columns = {"cursor": cursor, "torque": np.where(inside, 2.0, 1.0)}
    feel = stroke_feel(Stroke("out", 0, frames), surface, columns, tactor.astype(np.float32), RATE)
    assert feel.event_free_db == pytest.approx(20 * math.log10(0.05) - 3.01, abs=0.1)
    assert feel.event_db[0] == pytest.approx(20 * math.log10(0.5) - 3.01, abs=0.1)
    assert feel.rise[0] == pytest.approx(1.0 * RATE)


def test_an_event_that_is_shorter_than_a_window_has_the_level_of_the_windows_over_it():
    surface = build_surface(timeline_of(50.0), preset_with(height=5.0, width=4.0))
    frames, at = 8000, 4003
    cursor = np.where(np.arange(frames) < at, 0.1, 0.9)
    cursor[at : at + 2] = 0.5  # 0.25 ms, in which no window starts
    tactor = np.zeros(frames, np.float32)
    tactor[at - 40 : at] = 1.0  # half a window
    columns = {"cursor": cursor, "torque": np.zeros(frames)}
    feel = stroke_feel(Stroke("out", 0, frames), surface, columns, tactor, RATE)
    assert feel.event_db == pytest.approx([-3.01], abs=0.2)


def test_an_event_that_was_not_passed_has_no_level():
    surface = build_surface(timeline_of(20.0, 90.0), preset_with())
    cursor = np.linspace(0.0, 0.5, 4000)
    columns = {"cursor": cursor, "torque": np.ones(4000)}
    feel = stroke_feel(
        Stroke("out", 0, 4000), surface, columns, np.ones(4000, dtype=np.float32), RATE
    )
    assert np.isfinite(feel.event_db[0])
    assert np.isnan(feel.event_db[1])


def test_an_events_level_is_that_of_its_strongest_stroke():
    timeline, preset = timeline_of(20.0, 50.0, 90.0), preset_with(height=8.0, width=3.0)
    gesture = ov.sweep(0.5, 0.0, 0.7) + ov.pause(0.2) + ov.sweep(0.1, 0.0, 0.6)
    result = ov.render(timeline, preset, gesture, RATE)
    surface, tactor = result.engine.surface, result.samples[:, 1]
    levels = [
        stroke_feel(stroke, surface, result.trace, tactor, RATE).event_db
        for stroke in strokes(result.trace.touching, result.trace.cursor)
    ]
    assert len(levels) >= 3
    strongest = np.fmax.reduce(levels)
    np.testing.assert_array_equal(event_levels(surface, result.trace, tactor, RATE), strongest)
    assert np.isfinite(strongest[:2]).all()
    assert np.isnan(strongest[2])


@given(
    steps=st.lists(st.floats(-0.02, 0.02) | st.floats(-0.3, 0.3), min_size=1, max_size=700),
    start=st.floats(0.0, 1.0),
)
def test_a_passage_lasts_from_the_first_to_the_last_frame_on_an_event(steps, start):
    surface = build_surface(timeline_of(20.0, 50.0, 90.0), preset_with(height=8.0, width=3.0))
    cursor = np.clip(start + np.cumsum(steps), 0.0, 1.0)
    events, firsts, lasts = passages(surface, cursor)
    found = {i: ends for i, *ends in zip(events.tolist(), firsts, lasts, strict=True)}
    for i, (first, last) in enumerate(surface.span):
        inside = np.flatnonzero((cursor >= first) & (cursor <= last))
        lower, upper = surface.edges[i]
        enters = cursor[0] < lower <= cursor.max() or cursor.min() < upper <= cursor[0]
        passes = cursor.min() < surface.position[i] <= cursor.max()
        passed = len(inside) > 0 and (enters or passes)
        assert (i in found) == passed
        if passed:
            assert found[i] == [inside[0], inside[-1]]


def test_an_event_that_was_skipped_is_passed_when_the_disk_is_on_it():
    surface = build_surface(timeline_of(20.0, 50.0, 90.0), preset_with(height=8.0, width=3.0))
    cursor = np.repeat([0.0, 1.0], 500)
    # to and fro over all three, and later once on two of them
    cursor[600:650] = 0.0
    cursor[720:730] = 0.2
    cursor[[800, 850]] = 0.5
    events, firsts, lasts = passages(surface, cursor)
    assert events.tolist() == [0, 1]
    assert firsts.tolist() == [720, 800]
    assert lasts.tolist() == [729, 850]
