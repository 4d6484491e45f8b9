"""What the heart and crowd presets feel like: the largest events stand out of all the rest."""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.data.analysis.rhythm import Beats, beat_events, heart_rate
from overview_dsp.measure.perceived_level import stroke_feel, strokes

SWEEPS = (2.0, 3.0, 4.0, 6.0)
STANDS_OUT_DB = 6.0


@pytest.fixture(scope="module")
def heart():
    return ov.load_preset("heart")


def made_up_heart(seconds=900.0, seed=3):
    """A heart that quickens and calms, with early beats and two missed ones."""
    random = np.random.default_rng(seed)
    times, at = [], 0.5
    while at < seconds - 1.0:
        times.append(at)
        bpm = 70.0 + 25.0 * np.exp(-(((at - 400.0) / 120.0) ** 2))
        at += 60.0 / bpm * (1.0 + 0.02 * random.normal())
    found = np.array(times)
    for early in random.choice(np.arange(20, len(found) - 20), 12, replace=False):
        found[early] -= 0.35 * (found[early] - found[early - 1])
    found = np.delete(found, [300, 700])
    beats = Beats(found, ("beat",) * len(found), ("",) * len(found), annotated=False)
    events, _ = beat_events(beats, ())
    return ov.Timeline(
        title="made up",
        duration_s=seconds,
        events=tuple(events),
        intensity=heart_rate(found, ()),
    )


@pytest.fixture(scope="module", params=["made up", "record 100"])
def record(request):
    if request.param == "made up":
        return made_up_heart()
    pytest.importorskip("wfdb", reason="needs the extra [ecg]")
    return ov.load_timeline(request.getfixturevalue("data_folder") / "ecg" / "100.hea")


def feel(timeline, preset, gesture):
    result = ov.render(timeline, preset, gesture)
    surface = result.engine.surface
    out, *_ = strokes(result.trace.engaged, result.trace.cursor)
    return surface, stroke_feel(
        out, surface, result.trace, result.samples[:, 1], result.sample_rate
    )


def largest(timeline, surface, count):
    """The rows of the surface's table with the heaviest events, those that stand out alone."""
    weights = np.array([timeline.events[event].weight for event in surface.event])
    return np.argsort(-weights, kind="stable")[:count]


@pytest.mark.parametrize("seconds", SWEEPS)
def test_the_three_largest_events_of_a_heart_stand_out(record, heart, seconds):
    surface, found = feel(record, heart, ov.sweep(seconds))
    loudest = found.event_db[largest(record, surface, 3)]
    assert np.isfinite(loudest).all()
    assert np.isfinite(found.event_free_db)
    assert loudest.min() - found.event_free_db >= STANDS_OUT_DB


def test_steady_beats_come_up_one_by_one_when_a_window_spreads_them(record, heart):
    whole = ov.build_surface(record, heart)
    assert whole.omitted_events["beat"] == record.kinds()["beat"]
    minute = record.window(300.0, 360.0)
    spread = ov.build_surface(minute, heart)
    assert "beat" not in spread.omitted_events
    assert len(spread.position) == len(minute.events)
    surface, found = feel(minute, heart, ov.sweep(6.0))
    beats = np.array([minute.events[event].kind == "beat" for event in surface.event])
    assert np.median(found.event_db[beats]) - found.event_free_db >= 2.5


def test_a_cheer_stands_out_of_the_crowd(heart):
    random = np.random.default_rng(1)
    time = np.arange(0.0, 600.0, 0.5)
    loudness = -30.0 + random.normal(0.0, 0.7, len(time))
    events = []
    for at, lu in ((90.0, 9.0), (240.0, 14.0), (410.0, 11.0), (500.0, 7.0)):
        loudness += lu * np.exp(-(((time - at) / 5.0) ** 2))
        events.append(ov.Event(at, "cheer", "", lu / 10.0))
    timeline = ov.Timeline(
        title="crowd",
        duration_s=600.0,
        events=tuple(events),
        intensity=ov.Intensity(time, loudness, "LUFS"),
    )
    for seconds in SWEEPS:
        surface, found = feel(timeline, ov.load_preset("crowd"), ov.sweep(seconds))
        loudest = found.event_db[largest(timeline, surface, 3)]
        assert loudest.min() - found.event_free_db >= STANDS_OUT_DB
