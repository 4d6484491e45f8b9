"""What the series preset feels like: a share year, stroke by stroke (as `test_feel`)."""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.data.timeline import Intensity
from overview_dsp.measure.perceived_level import stroke_feel, strokes
from overview_dsp.units import JUST_NOTICEABLE_DB

SWEEPS = (2.0, 3.0, 4.0, 6.0)
LARGEST = ("highest", "lowest", "largest_rise", "largest_fall")
RANKS = (LARGEST, ("record_high", "record_low"), ("peak", "trough"), ("month", "week"))
"""From the firmest to ticks."""

EDGE = 0.02
YEARS = ("made up", "sp500 2008", "sp500 2019", "AAPL 2012")


def made_up():
    """A year of trading days: a trend, a crash, a recovery."""
    random = np.random.default_rng(5)
    steps = random.normal(0.0006, 0.011, 252)
    steps[[80, 81, 160]] = -0.07, 0.05, -0.045
    price = 100.0 * np.exp(np.cumsum(steps))
    days = np.busday_offset("2019-01-02", np.arange(252), roll="forward")
    return "".join(f"{day},{value:.2f}\n" for day, value in zip(days, price, strict=True))


@pytest.fixture(scope="module")
def share(request, tmp_path_factory):
    @cache
    def load(name):
        path = tmp_path_factory.mktemp("share") / "year.csv"
        if name == "made up":
            rows = made_up()
        else:
            file, year = name.split()
            file = {"sp500": "sp500-2000.csv", "AAPL": "bokeh_AAPL.csv"}[file]
            folder = request.getfixturevalue("data_folder") / "stocks"
            header, *lines = (folder / file).read_text().splitlines()
            names = [column.lower() for column in header.split(",")]
            day, close = names.index("date"), names.index("close")
            fields = [line.split(",") for line in lines]
            rows = "".join(f"{f[day]},{f[close]}\n" for f in fields if f[day].startswith(year))
        path.write_text("date,close\n" + rows)
        return ov.load_timeline(path)

    return load


@pytest.fixture(scope="module")
def feels(share):
    preset = ov.load_preset("series")

    @cache
    def measure(name, seconds):
        timeline = share(name)
        result = ov.render(timeline, preset, ov.sweep(seconds))
        surface = result.engine.surface
        kinds = np.array([timeline.events[event].kind for event in surface.event])
        found = {
            stroke.name: stroke_feel(
                stroke, surface, result.trace, result.samples[:, 1], result.sample_rate
            )
            for stroke in strokes(result.trace.engaged, result.trace.cursor)
        }
        return result, found, kinds

    return measure


@pytest.mark.parametrize("name", YEARS)
def test_at_least_a_third_of_a_share_year_is_free_of_events(share, name):
    surface = ov.build_surface(share(name), ov.load_preset("series"))
    assert 1.0 - surface.in_span(np.linspace(0.0, 1.0, 100_001)).mean() >= 0.3


@pytest.mark.parametrize("stroke", ["out", "recoil"])
@pytest.mark.parametrize("seconds", SWEEPS)
@pytest.mark.parametrize("name", YEARS)
def test_extremes_and_largest_moves_stand_out(feels, name, seconds, stroke):
    result, found, kinds = feels(name, seconds)
    feel = found[stroke]
    # where a hand sets out or arrives, nothing is wound up
    place = result.engine.surface.position
    largest = np.isin(kinds, LARGEST) & (place > EDGE) & (place < 1.0 - EDGE)
    assert largest.sum() >= 6
    assert np.isfinite(feel.event_db[largest]).all(), "one was not reached"
    assert feel.event_db[largest].min() - feel.event_free_db >= 6.0


@pytest.mark.parametrize("seconds", SWEEPS)
def test_the_ranks_of_events_are_felt_a_step_apart(seconds):
    kinds = [kind for rank in RANKS for kind in rank] * 3
    timeline = ov.Timeline(
        title="every kind by itself",
        duration_s=len(kinds) + 1.0,
        events=tuple(ov.Event(i + 1.0, kind) for i, kind in enumerate(kinds)),
        intensity=Intensity(np.zeros(1), np.full(1, 0.5)),
    )
    result = ov.render(timeline, ov.load_preset("series"), ov.sweep(seconds))
    surface = result.engine.surface
    stroke = strokes(result.trace.engaged, result.trace.cursor)[0]
    feel = stroke_feel(stroke, surface, result.trace, result.samples[:, 1], result.sample_rate)
    felt = np.array([timeline.events[event].kind for event in surface.event])
    levels = [np.median(feel.event_db[np.isin(felt, rank)]) for rank in RANKS]
    for higher, lower in itertools.pairwise([*levels, feel.event_free_db]):
        assert higher - lower >= JUST_NOTICEABLE_DB


@pytest.mark.parametrize("name", YEARS)
def test_the_level_is_felt_between_the_events(share, name):
    timeline = share(name)
    preset = ov.load_preset("series")
    surface = ov.build_surface(timeline, preset)
    period = preset.number("surface.pattern_period_percent") / 100.0
    for phase in (0.0, 0.25, 0.5, 0.75):  # the level is compared at one phase of the pattern
        centres = (np.arange(1.0 / period - phase) + phase) * period
        cursor = (centres[:, None] + np.linspace(-0.02, 0.02, 9) * period).ravel()
        free = np.abs(cursor[:, None] - surface.position).min(axis=1) > 0.007
        cursor = cursor[free & (cursor >= 0.0) & (cursor <= 1.0)]
        friction = surface.friction_at(cursor * np.pi)
        level = timeline.normalised_intensity_at(cursor * timeline.duration_s)
        assert np.corrcoef(np.log(friction), level)[0, 1] >= 0.99
        assert friction.max() / friction.min() >= 4.0
