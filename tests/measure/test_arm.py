"""What an arm gets, measured: against disks whose lag is known, and against tables made by hand."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.measure.arm import (
    cards_over_goals,
    crossings,
    felt_above,
    felt_range_db,
    outward,
    scrubbed,
    spread_db,
)
from overview_dsp.measure.event_table import FeltEvents, stroke_events
from overview_dsp.measure.perceived_level import Stroke, strokes
from tests.examples import plain_preset, preset_with, timeline_of

RATE = 16_000.0


def overdamped(time_constant_s, stiffness=0.5, height=0.5):
    """A disk that lags a steady finger by this time, B / (k1 + k2), and does not ring."""
    return preset_with(
        height=height,
        width=0.5,
        disk__k1=0.2 * stiffness,
        disk__k2=0.8 * stiffness,
        disk__inertia=2e-6,
        surface__friction=time_constant_s * stiffness,
    )


RIGID, SOFT = overdamped(0.01), overdamped(3.0, stiffness=1e-2)
EVENTS = timeline_of(10.0, 30.0, 50.0, 70.0, 90.0)


def way_out(preset, timeline, gesture):
    (table,) = outward(preset, [timeline], {"": gesture})[""]
    return table


def rendered(preset, timeline, gesture):
    (done,) = ov.render_many([ov.RenderJob(timeline, preset, gesture)], RATE, tail=3.0, trace=True)
    return done


def test_the_lag_of_an_overdamped_disk_is_its_time_constant():
    slow, quick = (
        way_out(overdamped(s, 0.05, height=1e-3), EVENTS, ov.sweep(5.0)) for s in (0.2, 0.05)
    )
    late = slow.position > 0.4
    # what smooths the finger's movement delays both
    assert (slow.lag_ms - quick.lag_ms)[late] == pytest.approx(150.0, abs=2.0)
    assert 50.0 <= quick.lag_ms[late].max() <= 65.0
    # at a steady speed the distance is the time
    assert slow.lag_percent[late] == pytest.approx(slow.lag_ms[late] / 50.0, abs=0.01)


def test_a_rigid_disk_reaches_everything_and_a_soft_one_is_reported():
    arms = {"arm 1 s": ov.arm(1.0), "flick": ov.flick(0.15)}
    rigid, soft = (ov.measure.arm_report(one, [EVENTS], arms) for one in (RIGID, SOFT))
    for stroke in rigid.strokes:
        assert (stroke.events, stroke.missed, stroke.main_missed) == (5, 0, 0)
        assert stroke.lag_ms[2] < 30.0
    assert not any("never reaches" in line for line in rigid.warnings())
    arm = soft.strokes[0]
    assert arm.events == 5
    assert 0 < arm.missed == arm.main_missed < 5
    assert f"arm 1 s never reaches {arm.missed} of 5 events" in soft.warnings()[0]
    # a tap's disk arrives, or turns back before
    assert all(turn == pytest.approx(target, abs=0.012) for target, turn in rigid.taps)
    assert soft.taps[-1][1] < 0.9
    # scrubbing is followed or not
    assert all(crossings == followed for _, crossings, followed, _ in rigid.scrubs)
    assert all(followed == 0 for _, _, followed, _ in soft.scrubs[1:])
    assert [crossings for _, crossings, _, _ in rigid.scrubs] == [5 * 9, 5 * 18]


def test_the_report_is_plain_data_and_a_table_with_the_sweep_beside_the_arm():
    report = ov.measure.arm_report(RIGID, [EVENTS])
    names = [stroke.name for stroke in report.strokes]
    assert names[:4] == ["sweep 1 s", "sweep 2 s", "sweep 4 s", "sweep 6 s"]
    assert names[4:] == ["arm 1 s", "arm 2 s", "arm 4 s", "arm 6 s", "flick 0.15 s"]
    plain = json.loads(json.dumps(report.to_json(), allow_nan=False))
    assert plain["strokes"][0]["lag_ms"].keys() == {"median", "p95", "worst"}
    assert plain["scrubs"][1] == {"hz": 2.0, "crossings": 90, "followed": 90} | {
        "felt": report.scrubs[1][3]
    }
    assert plain["curve_db"]["median"] is None
    table = report.table()
    assert all(name in table for name in names)
    assert "scrub 2 Hz: 90 of 90 crossings followed" in table


def test_no_timelines_gives_a_one_line_error():
    with pytest.raises(ov.InputError, match="no timelines"):
        ov.measure.arm_report(RIGID, [])


def test_an_outward_stroke_ends_where_the_disk_turns_back():
    touching = np.array([1, 1, 1, 0, 0, 0, 0, 0], dtype=float)
    arrives = np.array([0.0, 0.2, 0.4, 0.6, 0.8, 0.7, 0.3, 0.0])
    assert strokes(touching, arrives) == [Stroke("out", 0, 5), Stroke("recoil", 5, 8)]
    recoils = np.array([0.0, 0.2, 0.4, 0.3, 0.2, 0.1, 0.05, 0.0])
    assert strokes(touching, recoils) == [Stroke("out", 0, 3), Stroke("recoil", 3, 8)]


def test_a_disk_that_arrives_after_the_release_reaches_what_it_passes_then():
    done = rendered(RIGID, EVENTS, ov.sweep(2.0))
    count = len(done.trace.time)
    released = done.trace.time > 1.0
    # the same course of the disk, by a finger that releases halfway at full pace
    table = np.column_stack([done.trace[name] for name in done.trace] + [np.ones(count)])
    names = (*done.trace, "engaged")
    table[released, names.index("touching")] = 0.0
    sweep = done.job.gesture
    before = sweep.time_s <= 1.0
    early = ov.Gesture(
        np.append(sweep.time_s[before], 1.0),
        np.append(sweep.theta2[before], np.pi),
        np.append(sweep.touching[before], False),
        1.0,
    )
    moved = replace(done, trace=ov.Trace(table, names), job=replace(done.job, gesture=early))
    out = next(stroke_events(moved))
    assert out.turn == pytest.approx(1.0, abs=0.01)
    assert out.reached.all()
    # the finger passes half of the timeline
    assert out.target == pytest.approx(0.5)
    assert out.passed.tolist() == [True, True, False, False, False]
    assert np.isfinite(out.lag_ms[:2]).all()


def test_an_event_at_an_end_of_the_timeline_is_not_passed():
    table = way_out(RIGID, timeline_of(0.0, 50.0, 100.0), ov.arm(1.0))
    assert table.passed.tolist() == [False, True, False]


def test_an_event_that_the_disk_enters_and_does_not_cross_is_not_reached():
    wide = preset_with(height=0.5, width=10.0, disk__k1=0.1, disk__k2=0.4, disk__inertia=2e-6)
    table = way_out(wide, timeline_of(50.0), ov.sweep(2.0, 0.0, 0.48))
    assert table.start[0] < table.turn < 0.49
    assert not table.reached[0]
    assert np.isfinite(table.level_db[0])
    assert np.isnan(table.lag_ms[0])


def test_a_recoil_has_rows_for_the_events_that_the_disk_passes_again():
    timeline = timeline_of(20.0, 40.0, 80.0)
    done = rendered(RIGID, timeline, ov.sweep(2.0, 0.0, 0.6))
    out, back = stroke_events(done)
    assert out.reached.tolist() == back.reached.tolist() == [True, True, False]
    assert back.passed.tolist() == [True, True, False]
    assert back.first_s[1] < back.first_s[0]
    assert np.isnan(back.lag_ms).all()


def table_of(kinds, levels, times=None, apart_s=0.2, detected=True, reached=True):
    """A hand-made table of events that lie apart."""
    count = len(kinds)
    times = np.arange(count) * 60.0 if times is None else np.array(times, float)
    at = 1.0 + apart_s * np.arange(count)
    place = np.linspace(0.1, 0.9, count)
    return FeltEvents(
        name="fast",
        timeline=EVENTS,
        stroke=Stroke("out", 0, 1),
        sample_rate=RATE,
        target=1.0,
        turn=1.0,
        event=np.arange(count),
        kind=np.array(kinds),
        time_s=times,
        position=place,
        start=place - 0.001,
        end=place + 0.001,
        passed=np.ones(count, bool),
        reached=np.broadcast_to(reached, count).copy(),
        first_s=at,
        last_s=at + 0.01,
        lag_ms=np.zeros(count),
        lag_percent=np.zeros(count),
        level_db=np.array(levels, float),
        sharpness=np.ones(count),
        duration_ms=np.ones(count),
        detected=np.broadcast_to(detected, count).copy(),
        release=np.ones(count),
        click_s=at,
        click_db=np.zeros(count),
        click_lag_ms=np.zeros(count),
        merged=np.zeros(count, bool),
        lost_to=np.full(count, ""),
        pulse_s=at,
        free_db=-50.0,
        course=np.zeros(1),
        level=np.zeros(1),
        arrived_s=1e-3,
        slope=0.0,
    )


def test_a_spread_is_of_one_kind_that_is_reached():
    table = table_of(["goal", "goal", "own_goal", "goal"], [-10.0, -14.0, -30.0, -40.0])
    assert spread_db(table, "goal") == 30.0
    table = replace(table, reached=np.array([True, True, True, False]))
    assert spread_db(table, "goal") == 4.0
    assert spread_db(table, "goal", last=0.2) == 0.0


def test_a_card_is_compared_with_the_goals_of_ten_minutes():
    table = table_of(["goal", "yellow_card", "goal", "red_card"], [-10.0, -18.0, -12.0, -9.0])
    table = replace(table, time_s=np.array([0.0, 300.0, 550.0, 700.0]))
    assert cards_over_goals(table) == [-8.0, 3.0]


def test_an_event_is_felt_if_it_is_detected_and_above_the_weakest_kind():
    table = table_of(["foul", "goal", "goal", "goal"], [-20.0, -10.0, -25.0, -10.0])
    table = replace(table, detected=np.array([True, True, True, False]))
    assert felt_above(table, table.of("goal"), "foul").tolist() == [False, True, False, False]
    # a foul within 30 ms of a goal has the goal's level
    at = np.array([1.19, 1.2, 1.4, 1.6])
    near = replace(table, first_s=at, last_s=at + 0.01)
    assert felt_above(near, near.of("goal"), "foul").tolist() == [False, True, True, False]


@pytest.mark.parametrize("gain", [0.0, 4.0])
def test_the_felt_range_follows_the_curve(gain):
    rise = ov.Intensity(np.array([0.0, 100.0]), np.array([0.0, 1.0]))
    timeline = replace(timeline_of(), intensity=rise)
    preset = plain_preset(
        disk__inertia=2e-6, surface__intensity_gain=gain, disk__k1=2e-2, disk__k2=8e-2
    )
    felt = felt_range_db(way_out(preset, timeline, ov.sweep(4.0)))
    # medians: 10th and 90th percentile of the curve, at equal speed
    known = (
        preset.number("tactor.compression") * 20.0 * np.log10((1 + 0.9 * gain) / (1 + 0.1 * gain))
    )
    assert felt == pytest.approx(known, abs=1.0)


def test_crossings_are_felt_where_a_pulse_of_the_event_comes():
    stiff = ov.load_preset("football").with_values(disk__k2=0.1)
    goal = ov.Timeline("one", 100.0, (ov.Event(50.0, "goal"),))
    (felt,) = scrubbed(stiff, [goal], ("goal",), 1.0)
    assert [followed for followed, _ in felt] == [True] * 9
    assert sum(there for _, there in felt) >= 8
    # a bare surface gives a pulse too, where the finger is fastest: here one of -37 dBFS
    gesture = ov.scrub(0.5, 0.02, 1.0)
    bare = plain_preset(disk__k2=0.1, surface__friction=1e-3, disk__inertia=2e-6)
    (done,) = ov.render_many([ov.RenderJob(timeline_of(50.0), bare, gesture)], RATE, trace=True)
    assert crossings(done, 0, 1.0) == [(True, False)] * 9


def test_a_crossing_of_less_than_a_millisecond_is_felt():
    narrow = preset_with(
        height=60.0, width=0.01, disk__k2=0.1, disk__inertia=2e-5, surface__friction=1e-4
    )
    gesture = ov.scrub(0.5, 0.02, 2.0)
    (done,) = ov.render_many([ov.RenderJob(timeline_of(50.0), narrow, gesture)], RATE, trace=True)
    start, end = done.surface.span[0]
    on = (done.trace.cursor >= start) & (done.trace.cursor <= end)
    lengths = np.diff(np.flatnonzero(np.diff(on)))[::2] / RATE
    assert len(lengths) >= 18
    assert np.median(lengths) < 1e-3
    assert crossings(done, 0, 2.0) == [(True, True)] * 18
