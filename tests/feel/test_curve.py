"""What a finger gets of the curve itself: its range, its steps, its shape, above no events or many.

The observer of a curve knows that the hand moves steadily, and nothing of the data. It has the
felt level in sixteen windows of the stroke out, each with the noise of human judgement (a step is
2.3 dB, its standard deviation 1.6 dB), and has felt other curves before.
"""

from __future__ import annotations

import numpy as np
import pytest

import overview_dsp as ov
from overview_dsp.measure.felt import JUST_NOTICEABLE_DB, strokes, window_db

CURVED = ("series", "stocks", "weather", "heart", "crowd", "plain")
SERIES = ("series", "stocks", "weather")
"""Those whose shapes are told apart, each on curves with events."""

RATE = 4_000
"""The disk and its vibration are the same at any rate."""

LOUDNESS_STEP_DB = 1.0
"""One step of level to the ear."""

JUDGEMENT_DB = 1.6
WINDOWS = 16
BETWEEN_EVENTS = 15
"""Percentile of a window's levels: events stand out of it, and are few."""

SHAPES = ("rising", "falling", "flat", "valley", "hill")
TOLD = {2.0: 0.90, 4.0: 0.95, 8.0: 0.95}
LEARNT, MET, DRAWS = 20, 12, 5
"""Curves of each shape that the observer has felt before and that it is asked about."""


def curve_of(levels):
    at = np.linspace(0.0, 100.0, len(levels))
    return ov.Timeline("a curve", 100.0, (), ov.Intensity(at, np.asarray(levels, float)))


RAMPS = {"rising": np.array([0.0, 1.0]), "falling": np.array([1.0, 0.0])}


def out_stroke(samples, trace, rate):
    """Levels every 2 ms (dB) of the stroke out, and where the disk is then."""
    stroke = strokes(trace.touching, trace.cursor)[0]
    starts, level = window_db(samples[stroke.start : stroke.stop, 1], rate, 0.002)
    middle = stroke.start + (starts + 0.005 * rate).astype(int)
    return level, trace.cursor[np.minimum(middle, stroke.stop - 1)]


@pytest.mark.parametrize("course", RAMPS)
@pytest.mark.parametrize("name", CURVED)
def test_a_curve_spans_four_steps_of_equal_size(name, course):
    result = ov.render(curve_of(RAMPS[course]), ov.load_preset(name), ov.sweep(4.0), RATE)
    level, cursor = out_stroke(result.samples, result.trace, RATE)
    data = cursor if course == "rising" else 1.0 - cursor
    # a median over so much that ribs of the surface itself don't matter
    at = [np.median(level[np.abs(data - x) < 0.02]) for x in (0.1, 0.3, 0.5, 0.7, 0.9)]
    steps = np.diff(at)
    assert steps.sum() >= 9.0
    assert steps.max() - steps.min() <= JUST_NOTICEABLE_DB / 2.0


@pytest.mark.parametrize("name", CURVED)
def test_a_disk_on_a_low_curve_does_not_ring(name):
    preset = ov.load_preset(name)
    for levels in ([0.0, 0.0], *RAMPS.values()):
        for gesture in (ov.sweep(1.0), ov.sweep(4.0), ov.tap(1.0, 3.0), ov.tap(0.5, 3.0)):
            trace = ov.render(curve_of(levels), preset, gesture, RATE).trace
            assert trace.cursor.max() <= trace.theta2.max() / np.pi + 0.05
            assert trace.cursor.min() >= -0.01


@pytest.mark.filterwarnings("ignore:preset .* has no:overview_dsp.OverviewWarning")
@pytest.mark.parametrize("data", ["made-up-share", "world-cup-final-2018"])
@pytest.mark.parametrize("name", CURVED)
def test_a_full_tap_unfolds_so_that_it_can_be_read_and_recoils_more_slowly(name, data):
    result = ov.render(ov.load_timeline(data), ov.load_preset(name), ov.tap(1.0, 4.0), 16_000)
    trace = result.trace
    released = trace.time[trace.touching > 0.5][-1]
    out = trace.time[np.argmax(trace.cursor >= 0.95)]
    back = trace.time[(trace.time > released) & (trace.cursor <= 0.05)][0] - released
    assert 0.9 <= out <= 2.5
    assert back > out


def heard(samples, trace, rate, part):
    """RMS of the click channel (dB) while the disk is out and within a part of the surface."""
    stroke = strokes(trace.touching, trace.cursor)[0]
    cursor = trace.cursor[stroke.start : stroke.stop]
    there = (cursor > part[0]) & (cursor < part[1])
    return 10.0 * np.log10(np.mean(samples[stroke.start : stroke.stop, 0][there] ** 2) + 1e-20)


@pytest.mark.parametrize("name", CURVED)
def test_the_grain_carries_the_curve_to_the_ear_and_is_silent_at_rest(name):
    preset = ov.load_preset(name).with_values(surface__material="none")
    rate = 48_000
    result = ov.render(curve_of(RAMPS["rising"]), preset, ov.sweep(4.0) + ov.pause(0.1), rate)
    parts = (0.05, 0.15), (0.85, 0.95)
    low, high = (heard(result.samples, result.trace, rate, part) for part in parts)
    assert -50.0 <= high <= -32.0
    assert high - low >= 5.0 * LOUDNESS_STEP_DB
    spectrum = np.abs(np.fft.rfft(result.samples[: 4 * rate, 0])) ** 2
    above = np.fft.rfftfreq(4 * rate, 1.0 / rate) > 500.0
    assert spectrum[above].sum() >= 0.5 * spectrum.sum()
    assert not result.samples[-480:, 0].any()


# --- shapes, from the envelope alone --------------------------------------------------------------


def shape(name, random, count=240):
    """A curve of one of the shapes, in trading days, with noise of 15 % of its span."""
    x = np.linspace(0.0, 1.0, count)
    valley = np.abs(2.0 * x - 1.0)
    of = {"rising": x, "falling": 1.0 - x, "flat": 0.5 + 0.0 * x, "valley": valley}
    return of.get(name, 1.0 - valley) + 0.15 * random.normal(size=count)


def share_year(random, count=252):
    """A year of closing prices whose moves come in bursts."""
    volatility = np.exp(np.cumsum(random.normal(0.0, 0.08, count)))
    volatility *= random.uniform(0.006, 0.025) / volatility.mean()
    steps = random.normal(random.normal(0.0, 0.001), volatility)
    jumps = random.choice(count, 4, replace=False)
    steps[jumps] += random.choice([-1.0, 1.0], 4) * random.uniform(3.0, 6.0, 4) * volatility[jumps]
    return 100.0 * np.exp(np.cumsum(steps))


@pytest.fixture(scope="module")
def loaded(tmp_path_factory):
    path = tmp_path_factory.mktemp("curves") / "year.csv"

    def load(prices):
        days = np.busday_offset("2015-01-02", np.arange(len(prices)), roll="forward")
        rows = (f"{day},{price:.4f}\n" for day, price in zip(days, prices, strict=True))
        path.write_text("date,close\n" + "".join(rows))
        return ov.load_timeline(path)

    return load


def envelopes(timelines, preset, seconds):
    """Level (dB) in each window of each timeline's sweep, float64 (timelines, WINDOWS)."""
    jobs = [ov.RenderJob(timeline, preset, ov.sweep(seconds)) for timeline in timelines]
    rows = []
    for done in ov.render_many(jobs, RATE, trace=True, tail="none"):
        level, _ = out_stroke(done.samples, done.trace, RATE)
        parts = np.array_split(np.maximum(level, -60.0), WINDOWS)
        rows.append([np.percentile(part, BETWEEN_EVENTS) for part in parts])
    return np.array(rows)


def judged(levels, random):
    """Each row `DRAWS` times, as a person has it."""
    rows = np.repeat(levels, DRAWS, axis=0)
    return rows + JUDGEMENT_DB * random.normal(size=rows.shape)


def nearest_mean(learnt, labels):
    """The observer of kinds: the nearest of their means, by their common covariance."""
    means = np.array([learnt[labels == label].mean(axis=0) for label in np.unique(labels)])
    inverse = np.linalg.inv(np.cov((learnt - means[labels]).T))
    bias = 0.5 * np.einsum("ij,jk,ik->i", means, inverse, means)
    return lambda rows: np.argmax(rows @ inverse @ means.T - bias, axis=1)


@pytest.fixture(scope="module")
def shapes(loaded):
    random = np.random.default_rng(2)
    sets = []
    for of_each in (LEARNT, MET):
        labels = np.tile(np.arange(len(SHAPES)), of_each)
        curves = [loaded(100.0 + 10.0 * shape(SHAPES[i], random)) for i in labels]
        sets.append((curves, np.repeat(labels, DRAWS)))
    return sets


@pytest.mark.parametrize("seconds", TOLD)
@pytest.mark.parametrize("name", SERIES)
def test_rising_falling_flat_valley_and_hill_are_told_apart(shapes, name, seconds):
    random = np.random.default_rng(3)
    preset = ov.load_preset(name)
    learnt, met = (
        (judged(envelopes(curves, preset, seconds), random), labels) for curves, labels in shapes
    )
    assert np.mean(nearest_mean(*learnt)(met[0]) == met[1]) >= TOLD[seconds]


def mean_of_thirds(timeline):
    return [part.mean() for part in np.array_split(timeline.normalised_levels(3000), 3)]


@pytest.fixture(scope="module")
def share_years(loaded, data_folder):
    """The bundled year and 44 real ones."""
    found = [ov.load_timeline("made-up-share")]
    for file, column in (
        ("sp500-2000.csv", "close"),
        ("bokeh_AAPL.csv", "adj close"),
        ("bokeh_IBM.csv", "adj close"),
    ):
        header, *lines = (data_folder / "stocks" / file).read_text().splitlines()
        names = header.lower().split(",")
        fields = [line.split(",") for line in lines]
        for year in range(2000, 2020):
            days = [f for f in fields if f[names.index("date")].startswith(str(year))]
            if len(days) > 240:
                found.append(loaded([float(f[names.index(column)]) for f in days]))
    return found


@pytest.mark.parametrize("seconds", [4.0, 8.0])
@pytest.mark.parametrize("name", ["series", "stocks"])
def test_the_highest_and_the_lowest_third_of_a_share_year_are_felt(
    loaded, share_years, name, seconds
):
    random = np.random.default_rng(4)
    made_up = [loaded(share_year(random)) for _ in range(60)]
    preset = ov.load_preset(name)
    learnt = judged(envelopes(made_up, preset, seconds), random)
    thirds = np.repeat([mean_of_thirds(timeline) for timeline in made_up], DRAWS, axis=0)
    ones = np.ones((len(learnt), 1))
    weights = np.linalg.lstsq(np.hstack([learnt, ones]), thirds, rcond=None)[0]
    met = judged(envelopes(share_years, preset, seconds), random)
    said = np.hstack([met, np.ones((len(met), 1))]) @ weights
    truth = np.repeat([mean_of_thirds(timeline) for timeline in share_years], DRAWS, axis=0)
    right = [
        said.argmax(axis=1) == truth.argmax(axis=1),
        said.argmin(axis=1) == truth.argmin(axis=1),
    ]
    assert np.mean(right) >= 0.88
