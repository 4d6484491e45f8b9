"""What the football preset feels like: the tactor channel of real matches, stroke by stroke.

Level is the RMS over 10 ms windows in dB; see `measure.perceived_level` for strokes,
spans and medians.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.data.analysis.crowd_excitement import crowd_curve
from overview_dsp.measure.perceived_level import stroke_feel, strokes
from overview_dsp.units import JUST_NOTICEABLE_DB

SWEEPS = (1.0, 2.0, 3.0, 6.0)
GOALS = ("goal", "own_goal")
STATSBOMB = ("15986", "22936", "69321")
MATCHES = ("bundled", "busy", *STATSBOMB)


def busy_match():
    """Goals early, late and in a row, more of everything than a match has."""
    random = np.random.default_rng(1)
    length = 5700.0
    events = [ov.Event(time, "period") for time in (0.0, 2850.0, length)]
    events += [ov.Event(part * length, "goal") for part in (0.08, 0.5, 0.53, 0.95)]
    for kind, count in (("foul", 25), ("yellow_card", 4), ("near_miss", 8)):
        events += [ov.Event(float(t), kind) for t in random.uniform(20, length - 20, count)]
    return ov.Timeline(
        title="busy", duration_s=length, events=tuple(events), intensity=crowd_curve(events, length)
    )


@pytest.fixture(scope="module")
def timeline_named(request):
    def load(name):
        if name == "bundled":
            return ov.load_timeline("world-cup-final-2018")
        if name == "busy":
            return busy_match()
        folder = request.getfixturevalue("data_folder")
        return ov.load_timeline(folder / "football" / "statsbomb" / f"{name}.json")

    return cache(load)


@pytest.fixture(scope="module")
def feels(timeline_named, football):
    """Feel of each stroke of a gesture over a match: (name, feel, goals, fouls), and the render."""

    @cache
    def measure(name, kind, value):
        timeline = timeline_named(name)
        gesture = ov.sweep(value) if kind == "sweep" else ov.tap(value, 3.0)
        result = ov.render(timeline, football, gesture)
        surface = result.engine.surface
        kinds = np.array([timeline.events[event].kind for event in surface.event])
        found = {
            stroke.name: stroke_feel(
                stroke, surface, result.trace, result.samples[:, 1], result.sample_rate
            )
            for stroke in strokes(result.trace.engaged, result.trace.cursor)
        }
        return result, found, np.isin(kinds, GOALS), kinds == "foul"

    return measure


@pytest.mark.parametrize("name", MATCHES)
def test_at_least_a_third_of_a_match_is_free_of_events(timeline_named, football, name):
    surface = ov.build_surface(timeline_named(name), football)
    assert 1.0 - surface.in_span(np.linspace(0.0, 1.0, 100_001)).mean() >= 0.3


@pytest.mark.parametrize("stroke", ["out", "recoil"])
@pytest.mark.parametrize("seconds", SWEEPS)
@pytest.mark.parametrize("name", MATCHES)
def test_every_goal_stands_out_of_the_rest_and_of_the_fouls(feels, name, seconds, stroke):
    _, found, goals, fouls = feels(name, "sweep", seconds)
    feel = found[stroke]
    assert np.isfinite(feel.event_db[goals]).all(), "a goal was not reached"
    foul = np.nanmedian(feel.event_db[fouls])
    assert feel.event_db[goals].min() - feel.event_free_db >= 6.0
    assert feel.event_db[goals].min() - foul >= JUST_NOTICEABLE_DB
    assert foul - feel.event_free_db >= JUST_NOTICEABLE_DB


@pytest.mark.parametrize("stroke", ["out", "recoil"])
@pytest.mark.parametrize("seconds", SWEEPS)
@pytest.mark.parametrize("name", MATCHES)
def test_a_goal_is_at_least_twice_as_sharp_as_a_foul(feels, name, seconds, stroke):
    _, found, goals, fouls = feels(name, "sweep", seconds)
    assert found[stroke].rise[goals].min() >= 2.0 * np.nanmedian(found[stroke].rise[fouls])


@pytest.mark.parametrize("name", MATCHES)
def test_the_disk_does_not_ring(feels, name):
    for gesture in [("sweep", seconds) for seconds in SWEEPS] + [("tap", 1.0), ("tap", 0.5)]:
        result = feels(name, *gesture)[0]
        end = gesture[1] if gesture[0] == "tap" else 1.0
        assert result.trace.cursor.max() <= end + 0.05
        assert result.trace.cursor.min() >= -0.01


@pytest.mark.parametrize("name", MATCHES)
def test_halving_a_sweeps_duration_is_felt_between_the_events(feels, name):
    for fast, slow in ((1.0, 2.0), (3.0, 6.0)):
        levels = [feels(name, "sweep", s)[1]["out"].event_free_db for s in (fast, slow)]
        assert levels[0] - levels[1] >= JUST_NOTICEABLE_DB


@pytest.mark.parametrize("name", MATCHES)
def test_a_full_tap_unfolds_quickly_and_recoils_slowly(feels, name):
    trace = feels(name, "tap", 1.0)[0].trace
    released = trace.time[trace.engaged > 0.5][-1]
    out = trace.time[np.argmax(trace.cursor >= 0.95)]
    back = trace.time[(trace.time > released) & (trace.cursor <= 0.05)][0] - released
    assert 0.9 <= out <= 2.5
    assert back > out


def test_the_vibration_comes_from_the_torque_alone_but_for_the_output_gains(match, football):
    plain = football.with_changes(
        {"tactor.slow_gain_exponent": 0.0, "tactor.recoil_gain_exponent": 0.0}
    )
    result = ov.render(match, plain, ov.sweep(2.0))
    assert np.array_equal(result.engine.tactor_of(result.trace.torque), result.samples[:, 1])


def test_a_match_without_goals_reaches_no_goals_level(timeline_named, football, feels):
    timeline = timeline_named("bundled")
    dull = replace(
        timeline, events=tuple(event for event in timeline.events if event.kind not in GOALS)
    )
    for seconds in SWEEPS:
        result = ov.render(dull, football, ov.sweep(seconds))
        surface = result.engine.surface
        _, found, goals, _ = feels("bundled", "sweep", seconds)
        for stroke in strokes(result.trace.engaged, result.trace.cursor):
            feel = stroke_feel(
                stroke, surface, result.trace, result.samples[:, 1], result.sample_rate
            )
            goal_level = np.median(found[stroke.name].event_db[goals])
            assert np.nanmax(feel.event_db) <= goal_level - JUST_NOTICEABLE_DB


@pytest.mark.parametrize("rate", [22_050, 44_100, 96_000, 192_000])
def test_every_sample_rate_feels_the_same(match, football, rate):
    for gesture in (ov.sweep(2.0), ov.tap(1.0, 0.8)):
        here = ov.render(match, football, gesture, sample_rate=rate, tail=6.0)
        there = ov.render(match, football, gesture, sample_rate=48_000, tail=6.0)
        assert np.array_equal(here.strikes.event, there.strikes.event)
        assert np.abs(here.strikes.time_s - there.strikes.time_s).max() <= 0.5e-3
        feels = []
        for result in (here, there):
            feels.append(
                [
                    stroke_feel(
                        stroke,
                        result.engine.surface,
                        result.trace,
                        result.samples[:, 1],
                        result.sample_rate,
                        hop_s=1e-4,  # so fine that it matters little where a span ends
                    )
                    for stroke in strokes(result.trace.engaged, result.trace.cursor)
                ]
            )
        for one, other in zip(*feels, strict=True):
            assert one.event_free_db == pytest.approx(other.event_free_db, abs=0.5)
            assert np.nanmax(np.abs(one.event_db - other.event_db)) <= 0.5
