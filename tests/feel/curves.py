"""What a finger gets of a curve alone, and an observer of it: for the tests and
`tools/measure_feel.py`.

The observer of a curve knows that the hand moves steadily, and nothing of the data. It has the
felt level in sixteen windows of the stroke out, each with the noise of human judgement (a step is
2.3 dB, its standard deviation 1.6 dB), and has felt other curves before.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import overview_dsp as ov
from overview_dsp.measure.perceived_level import strokes, window_db

RATE = 4_000
"""The disk and its vibration are the same at any rate."""

JUDGEMENT_DB = 1.6
WINDOWS = 16
BETWEEN_EVENTS = 15
"""Percentile of a window's levels: events stand out of it, and are few."""

SHAPES = ("rising", "falling", "flat", "valley", "hill")
DRAWS = 5
RAMPS = {"rising": np.array([0.0, 1.0]), "falling": np.array([1.0, 0.0])}

Floats = NDArray[np.float64]
Loaded = Callable[[Sequence[float] | Floats], ov.Timeline]


def curve_of(levels: Sequence[float] | Floats) -> ov.Timeline:
    """A timeline without events."""
    at = np.linspace(0.0, 100.0, len(levels))
    return ov.Timeline("a curve", 100.0, (), ov.Intensity(at, np.asarray(levels, float)))


def loader(path: Path) -> Loaded:
    """What makes a timeline of prices, by way of a table in a file."""

    def load(prices: Sequence[float] | Floats) -> ov.Timeline:
        days = np.busday_offset("2015-01-02", np.arange(len(prices)), roll="forward")
        rows = (f"{day},{price:.4f}\n" for day, price in zip(days, prices, strict=True))
        path.write_text("date,close\n" + "".join(rows))
        return ov.load_timeline(path)

    return load


def out_stroke(samples: NDArray[np.float32], trace: ov.Trace, rate: float) -> tuple[Floats, Floats]:
    """Levels every 2 ms (dB) of the stroke out, and where the disk is then."""
    stroke = strokes(trace.touching, trace.cursor)[0]
    starts, level = window_db(samples[stroke.start : stroke.stop, 1], rate, 0.002)
    middle = stroke.start + (starts + 0.005 * rate).astype(int)
    return level, trace.cursor[np.minimum(middle, stroke.stop - 1)]


def steps_of(preset: ov.Preset, course: str, seconds: float = 4.0) -> Floats:
    """How much the felt level rises over each fifth of a ramp's data, dB, from .1 to .9."""
    result = ov.render(curve_of(RAMPS[course]), preset, ov.sweep(seconds), RATE)
    level, cursor = out_stroke(result.samples, result.trace, RATE)
    data = cursor if course == "rising" else 1.0 - cursor
    half = 0.5 * whole_periods(preset, 0.16)
    at = [level[np.abs(data - x) < half].mean() for x in (0.1, 0.3, 0.5, 0.7, 0.9)]
    return np.diff(at)


def whole_periods(preset: ov.Preset, width: float) -> float:
    """The width of a surface in whole periods of the preset's pattern."""
    if preset.values["surface.pattern"] == "none":
        return width
    period = preset.number("surface.pattern_period_percent") / 100.0
    return max(1, round(width / period)) * period


def grain_db(preset: ov.Preset, seconds: float = 4.0) -> tuple[float, float]:
    """The click channel's level at the bottom and at the top of a rising curve, dB."""
    bare = preset.with_values(surface__material="none")
    rate = 48_000
    result = ov.render(curve_of(RAMPS["rising"]), bare, ov.sweep(seconds), rate)
    low, high = (heard(result.samples, result.trace, part) for part in ((0.05, 0.15), (0.85, 0.95)))
    return low, high


def heard(samples: NDArray[np.float32], trace: ov.Trace, part: tuple[float, float]) -> float:
    """RMS of the click channel (dB) while the disk is out and within a part of the surface."""
    stroke = strokes(trace.touching, trace.cursor)[0]
    cursor = trace.cursor[stroke.start : stroke.stop]
    there = (cursor > part[0]) & (cursor < part[1])
    power = np.mean(samples[stroke.start : stroke.stop, 0][there].astype(np.float64) ** 2)
    return float(10.0 * np.log10(power + 1e-20))


# --- shapes, from the envelope alone --------------------------------------------------------------


def shape(name: str, random: np.random.Generator, count: int = 240) -> Floats:
    """A curve of one of the shapes, in trading days, with noise of 15 % of its span."""
    x = np.linspace(0.0, 1.0, count)
    valley = np.abs(2.0 * x - 1.0)
    of = {"rising": x, "falling": 1.0 - x, "flat": 0.5 + 0.0 * x, "valley": valley}
    return np.asarray(of.get(name, 1.0 - valley) + 0.15 * random.normal(size=count))


def share_year(random: np.random.Generator, count: int = 252) -> Floats:
    """A year of closing prices whose moves come in bursts."""
    volatility = np.exp(np.cumsum(random.normal(0.0, 0.08, count)))
    volatility *= random.uniform(0.006, 0.025) / volatility.mean()
    steps = random.normal(random.normal(0.0, 0.001), volatility)
    jumps = random.choice(count, 4, replace=False)
    steps[jumps] += random.choice([-1.0, 1.0], 4) * random.uniform(3.0, 6.0, 4) * volatility[jumps]
    return np.asarray(100.0 * np.exp(np.cumsum(steps)))


def real_share_years(data: Path, loaded: Loaded) -> list[ov.Timeline]:
    """The bundled year and those of other people's data."""
    found = [ov.load_timeline("made-up-share")]
    for file, column in (
        ("sp500-2000.csv", "close"),
        ("bokeh_AAPL.csv", "adj close"),
        ("bokeh_IBM.csv", "adj close"),
    ):
        header, *lines = (data / "stocks" / file).read_text().splitlines()
        names = header.lower().split(",")
        fields = [line.split(",") for line in lines]
        for year in range(2000, 2020):
            days = [f for f in fields if f[names.index("date")].startswith(str(year))]
            if len(days) > 240:
                found.append(loaded([float(f[names.index(column)]) for f in days]))
    return found


def envelopes(timelines: Sequence[ov.Timeline], preset: ov.Preset, seconds: float) -> Floats:
    """Level (dB) in each window of each timeline's sweep, float64 (timelines, WINDOWS)."""
    jobs = [ov.RenderJob(timeline, preset, ov.sweep(seconds)) for timeline in timelines]
    rows = []
    for done in ov.render_many(jobs, RATE, trace=True, tail="none"):
        level, _ = out_stroke(done.samples, done.trace, RATE)
        parts = np.array_split(np.maximum(level, -60.0), WINDOWS)
        rows.append([np.percentile(part, BETWEEN_EVENTS) for part in parts])
    return np.array(rows)


def judged(levels: Floats, random: np.random.Generator) -> Floats:
    """Each row `DRAWS` times, as a person has it."""
    rows = np.repeat(levels, DRAWS, axis=0)
    return np.asarray(rows + JUDGEMENT_DB * random.normal(size=rows.shape))


def nearest_mean(
    learnt: Floats, labels: NDArray[np.int64]
) -> Callable[[Floats], NDArray[np.int64]]:
    """The observer of kinds: the nearest of their means, by their common covariance."""
    means = np.array([learnt[labels == label].mean(axis=0) for label in np.unique(labels)])
    inverse = np.linalg.inv(np.cov((learnt - means[labels]).T))
    bias = 0.5 * np.einsum("ij,jk,ik->i", means, inverse, means)
    return lambda rows: np.asarray(np.argmax(rows @ inverse @ means.T - bias, axis=1))


def shape_lessons(loaded: Loaded) -> tuple[list[list[ov.Timeline]], NDArray[np.int64]]:
    """Curves to learn from and curves to be asked about, and which shape each of either has."""
    random = np.random.default_rng(2)
    labels = np.tile(np.arange(len(SHAPES)), 20)
    made = [[loaded(100.0 + 10.0 * shape(SHAPES[i], random)) for i in labels] for _ in "12"]
    return made, labels


def shapes_told(
    lessons: tuple[list[list[ov.Timeline]], NDArray[np.int64]], preset: ov.Preset, seconds: float
) -> NDArray[np.bool_]:
    """Of each noisy curve: is its shape told?"""
    (first, second), labels = lessons
    random = np.random.default_rng(3)
    learnt, met = (judged(envelopes(part, preset, seconds), random) for part in (first, second))
    labels = np.repeat(labels, DRAWS)
    return np.asarray(nearest_mean(learnt, labels)(met) == labels)


def mean_of_thirds(timeline: ov.Timeline) -> list[float]:
    return [float(part.mean()) for part in np.array_split(timeline.normalised_levels(3000), 3)]


def thirds_told(
    loaded: Loaded, years: Sequence[ov.Timeline], preset: ov.Preset, seconds: float
) -> NDArray[np.bool_]:
    """Of each noisy share year: is its highest third told, and its lowest; bool (2, years)."""
    random = np.random.default_rng(4)
    return _told([loaded(share_year(random)) for _ in range(60)], years, preset, seconds, random)


def third_of_windows(
    learnt: Sequence[ov.Timeline],
    asked: Sequence[ov.Timeline],
    preset: ov.Preset,
    seconds: float,
) -> NDArray[np.bool_]:
    """The same of windows, whose observer has felt other windows."""
    return _told(learnt, asked, preset, seconds, np.random.default_rng(4))


def _told(
    made_up: Sequence[ov.Timeline],
    years: Sequence[ov.Timeline],
    preset: ov.Preset,
    seconds: float,
    random: np.random.Generator,
) -> NDArray[np.bool_]:
    learnt = judged(envelopes(made_up, preset, seconds), random)
    thirds = np.repeat([mean_of_thirds(timeline) for timeline in made_up], DRAWS, axis=0)
    ones = np.ones((len(learnt), 1))
    weights = np.linalg.lstsq(np.hstack([learnt, ones]), thirds, rcond=None)[0]
    met = judged(envelopes(years, preset, seconds), random)
    said = np.hstack([met, np.ones((len(met), 1))]) @ weights
    truth = np.repeat([mean_of_thirds(timeline) for timeline in years], DRAWS, axis=0)
    return np.stack(
        [
            said.argmax(axis=1) == truth.argmax(axis=1),
            said.argmin(axis=1) == truth.argmin(axis=1),
        ]
    )


# --- share years as windows of longer files -------------------------------------------------------


def made_up_prices(files: int) -> list[list[str]]:
    """Rows of tables of five share years each."""
    tables = []
    for seed in range(files):
        random = np.random.default_rng(seed)
        prices = np.array([100.0])
        for _ in range(5):
            year = share_year(random)
            prices = np.concatenate((prices, year / year[0] * prices[-1]))
        days = np.busday_offset("2010-01-04", np.arange(len(prices)), roll="forward")
        tables.append([f"{d},{p:.4f}\n" for d, p in zip(days, prices, strict=True)])
    return tables


def real_prices(data: Path) -> list[list[str]]:
    """Rows of other people's tables."""
    tables = []
    for file, column in (
        ("sp500-2000.csv", "close"),
        ("bokeh_AAPL.csv", "adj close"),
        ("bokeh_IBM.csv", "adj close"),
    ):
        header, *lines = (data / "stocks" / file).read_text().splitlines()
        names = header.lower().split(",")
        day, price = names.index("date"), names.index(column)
        fields = [line.split(",") for line in lines]
        tables.append([f"{row[day]},{row[price]}\n" for row in fields])
    return tables


def years_of_files(tables: Sequence[Sequence[str]], folder: Path) -> list[ov.Timeline]:
    """The whole calendar years of tables, as windows of the timelines that they make."""
    found = []
    for rows in tables:
        path = folder / "years.csv"
        path.write_text("date,close\n" + "".join(rows))
        whole = ov.load_timeline(path)
        assert whole.start is not None
        first = whole.start.replace(tzinfo=None)
        for year in range(first.year, first.year + 30):
            edges = [(datetime(n, 1, 1) - first).total_seconds() for n in (year, year + 1)]
            if edges[0] >= 0.0 and edges[1] <= whole.duration_s:
                found.append(whole.window(*edges))
    return found
