"""The table of felt events: its rows and columns where they are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.measure.event_table import felt_events, stroke_events
from tests.measure.test_feel_report import FAST, preset_of, timeline_of

BESIDE = ov.Timeline(
    "beside",
    duration_s=10.0,
    events=(ov.Event(2.0, "low"), ov.Event(5.0, "high"), ov.Event(5.05, "low")),
)


def test_there_is_a_table_for_each_stroke_by_gesture_and_then_by_timeline():
    one, other = timeline_of("a", "b"), timeline_of("a")
    gestures = {"fast": ov.sweep(1.0), "tap": ov.tap(1.0, 1.0)}
    parts = []
    tables = felt_events(preset_of(a=20.0, b=9.0), [one, other], gestures, progress=parts.append)
    assert [(table.name, table.timeline) for table in tables] == [
        (name, timeline)
        for gesture in gestures
        for timeline in (one, other)
        for name in (gesture, f"{gesture} recoil")
    ]
    assert [table.kind.tolist() for table in tables[:4]] == [["a", "b"]] * 2 + [["a"]] * 2
    assert parts == [0.25, 0.5, 0.75, 1.0]


def test_an_event_stands_out_by_its_level_over_that_of_no_event():
    (out, _) = felt_events(preset_of(faint=0.02, high=60.0), [timeline_of("faint", "high")], FAST)
    assert out.contrast_db == pytest.approx(out.level_db - out.free_db)
    assert out.masked.tolist() == [True, False]
    assert out.sharpness[1] > 100.0 * out.sharpness[0]
    assert out.contrast_db[1] > 12.0
    assert 10.0 < out.duration_ms[1] < 40.0


def test_events_struck_within_30_ms_merge_and_the_weaker_one_is_lost():
    (out, _) = felt_events(preset_of(low=6.0, high=60.0), [BESIDE], FAST)
    assert out.merged.tolist() == [False, True, True]
    assert out.lost_to.tolist() == ["", "", "high"]
    assert np.diff(out.click_s)[1] < 0.030
    equal = ov.Timeline("", 10.0, (ov.Event(5.0, "a"), ov.Event(5.05, "a")))
    (out, _) = felt_events(preset_of(a=20.0), [equal], FAST)
    assert out.merged.all()
    assert out.lost_to.tolist() == ["", ""]


def test_an_event_that_is_not_reached_has_no_level_and_is_not_masked():
    preset, timeline = preset_of(a=20.0), timeline_of("a", "a", "a")
    (out, _) = felt_events(preset, [timeline], {"part": ov.sweep(1.0, 0.0, 0.6)})
    for column in (out.level_db, out.sharpness, out.duration_ms, out.click_s, out.click_db):
        assert np.isfinite(column).tolist() == [True, True, False]
    assert not out.masked.any()
    assert not out.merged.any()


def test_a_touch_of_one_frame_is_a_stroke_without_a_course():
    job = ov.RenderJob(timeline_of("a"), preset_of(a=20.0), ov.tap(0.5, 0.1))
    (done,) = ov.render_many([job], 8000, trace=True)
    table = np.column_stack([done.trace[name] for name in done.trace])
    table[1:, list(done.trace).index("engaged")] = 0.0
    table[:, list(done.trace).index("cursor")] = 0.0
    (out, *_) = stroke_events(replace(done, trace=ov.Trace(table, tuple(done.trace))), "tap")
    assert (out.stroke.start, out.stroke.stop) == (0, 1)
    assert np.isnan(out.free_db)
    assert not out.reached.any()


def test_wrong_gestures_and_no_timelines_give_a_one_line_error():
    with pytest.raises(ov.InputError, match="give them by name"):
        felt_events(preset_of(), [BESIDE], [ov.sweep(1.0)])
    with pytest.raises(ov.InputError, match="no timelines"):
        felt_events(preset_of(), [])
