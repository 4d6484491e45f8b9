"""Measure which of six presets a finger can tell apart: confusions of an observer by touch alone.

The observer feels one stroke. It gets the vibration's level, matched to one root mean square, and
the hand's steady way, nothing of the sound or of the data. It has learned the presets on some data
sets and is asked about others (two halves by data set, both ways). Every timeline is rendered with
all six presets.

Its features have the noise of human judgement, independent in each: 1.6 dB in levels, 18 % in
durations, 30 % in the strength of modulations. Pulses within 30 ms are one. With
independent noise it makes fewer errors than people do: the figures compare presets and do not
predict people.

Data sets: random series, weather, hearts and crowds, and those in OVERVIEW_TEST_DATA (windows of
shares, weather, electrocardiograms, a pulse wave, crowds), where that is a folder of them.

python tools/measure_confusions.py [--preset NAME=FILE ...] [--seed N] [--write]

--write puts the tables into docs/explanation/observer.md, between its markers.
"""

from __future__ import annotations

import argparse
import os
import warnings
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import overview_dsp as ov
from overview_dsp.arrays import FloatArray
from overview_dsp.kernels.layout import TACTOR
from overview_dsp.measure.observer.forest import fit_forest
from overview_dsp.measure.perceived_level import strokes
from overview_dsp.measure.perception import TOUCH_FLOOR_DB, levels, touch_pulses
from overview_dsp.offline.rendering.many import RenderJob, render_many
from overview_dsp.units import FELT_WINDOW_S

NAMES = ("plain", "series", "stocks", "weather", "heart", "crowd")
PAGE = Path(__file__).parent.parent / "docs" / "explanation" / "observer.md"
BEGIN, END = "<!-- confusions: begin -->", "<!-- confusions: end -->"
GESTURES = {"sweep of 4 s": ov.sweep(4.0), "arm of 2 s": ov.arm(2.0)}
RATE = 16_000.0
BANDS_HZ = ((1.5, 3.0), (3.0, 5.0), (5.0, 8.0), (8.0, 12.0), (12.0, 18.0), (18.0, 30.0))
LEVEL_DB, DURATION, MODULATION = 1.6, 0.18, 0.30
COPIES, DRAWS = 8, 12  # noisy copies of each stroke, to learn from and to be asked about


def random_sets(seed: int) -> Iterator[tuple[str, str, ov.Timeline]]:
    """Yield kind, data set and timeline of generated data; each timeline is a set of its own."""
    made = {
        "share": ov.measure.random_share,
        "weather": ov.measure.random_weather,
        "heart": ov.measure.random_heart,
        "crowd": ov.measure.random_crowd,
    }
    for kind, generate in made.items():
        for number in range(12):
            yield kind, f"random {kind} {number}", generate(seed + number)


def windows(timeline: ov.Timeline, lengths_s: tuple[float, ...], count: int) -> list[ov.Timeline]:
    """Return windows of several lengths, evenly spread over a timeline."""
    found = []
    for length in lengths_s:
        length = min(length, timeline.duration_s)
        starts = np.linspace(0.0, timeline.duration_s - length, count).tolist()
        found += [timeline.window(start, start + length) for start in starts]
    return found


def real_sets(folder: Path) -> Iterator[tuple[str, str, ov.Timeline]]:
    """Yield kind, data set and timeline of windows of the real files in a folder."""
    day, year = 86_400.0, 365.25 * 86_400.0
    shares, hours = {"value": "close"}, {"value": "temperature"}
    files: list[tuple[str, str, tuple[float, float], dict[str, object]]] = [
        ("share", "stocks/bokeh_AAPL.csv", (year, 3 * year), {"value": "Close"}),
        ("share", "stocks/bokeh_IBM.csv", (year, 3 * year), {"value": "Close"}),
        ("share", "stocks/sp500-2000.csv", (year, 3 * year), shares),
        ("weather", "weather/seattle-weather.csv", (180 * day, year), {"value": "temp_max"}),
        ("weather", "weather/seattle-weather.csv", (180 * day, year), {"value": "wind"}),
        ("weather", "weather/seattle-weather-hourly-normals.csv", (7 * day, 90 * day), hours),
        ("heart", "ecg/100.hea", (60.0, 600.0), {}),
        ("heart", "ecg/e0103.csv", (20.0, 60.0), {"rate": 250.0}),
        ("heart", "ecg/118e24.csv", (20.0, 60.0), {"rate": 360.0}),
        ("heart", "ecg/heartpy_data_ppg_100hz.csv", (20.0, 60.0), {"rate": 100.0}),
        ("crowd", "crowd/gpf_crowd01.wav", (10.0, 60.0), {}),
        ("crowd", "crowd/mdn_concert-crowd.ogg", (10.0, 60.0), {}),
    ]
    for kind, name, lengths, options in files:
        timeline = ov.load_timeline(folder / name, **options)  # type: ignore[arg-type]
        for part in windows(timeline, lengths, 4):
            yield kind, f"{name} {options.get('value', '')}", part


def features_of(level: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return features of a stroke's level (dB, one per ms) and the standard deviations of noise."""
    level = level - 10.0 * np.log10(np.mean(10.0 ** (level / 10.0)))
    values: list[float] = []
    noise: list[float] = []

    def add(more: FloatArray, deviation: float) -> None:
        values.extend(np.asarray(more, dtype=float).tolist())
        noise.extend([deviation] * len(more))

    pieces = np.array_split(level, max(1, len(level) // 250))
    depth = np.array([np.ptp(np.percentile(one, (10, 90))) for one in pieces])
    middle = np.array([np.median(one) for one in pieces])
    add(np.percentile(level, (5, 25, 50, 75, 95)), LEVEL_DB)
    add(np.percentile(depth, (10, 50, 90)), LEVEL_DB)
    high = middle >= np.median(middle)
    add(np.array([np.median(depth[high]), np.median(depth[~high])]), LEVEL_DB)

    smooth = np.convolve(np.pad(level, 200, mode="edge"), np.full(401, 1 / 401), "valid")
    fast = np.maximum(level, np.median(level) - 20.0) - smooth
    power = np.abs(np.fft.rfft(fast * np.hanning(len(fast)))) ** 2 / len(fast) ** 2
    hz = np.fft.rfftfreq(len(fast), 0.001)
    bands = [power[(hz >= low) & (hz < high_hz)].sum() for low, high_hz in BANDS_HZ]
    add(0.5 * np.log(np.array(bands) + 1e-4), MODULATION)

    norm = np.correlate(fast, fast, "full")[len(fast) - 1 :]
    norm = norm[30:700] / max(norm[0], 1e-9)
    add(np.array([norm.max()]), 0.15)
    add(np.log([30.0 + norm.argmax()]), DURATION)

    at = touch_pulses(level + TOUCH_FLOOR_DB + 40.0)
    gaps = np.diff(at) if len(at) > 2 else np.array([1000.0, 1000.0])
    low, mid, top = np.percentile(gaps, (25, 50, 75))
    add(np.log([mid, top / low + 0.2, len(level) / (len(at) + 1.0)]), DURATION)
    if not len(at):
        at = np.array([int(level.argmax())])
    near = level[np.clip(at[:, None] + np.arange(-120, 121), 0, len(level) - 1)]
    stands = level[at] - near.min(axis=1)
    add(np.percentile(stands, (25, 50, 75)), LEVEL_DB)
    lasts = (near > level[at][:, None] - 3.0).sum(axis=1)
    add(np.log(np.percentile(lasts, (25, 50, 75)) + 5.0), DURATION)
    before = np.diff(near[:, 60:121:5], axis=1).max(axis=1)
    after = -np.diff(near[:, 120:181:5], axis=1).min(axis=1)
    add(np.log([np.median(before) + 0.3, np.median(after) + 0.3]), MODULATION)
    pairs = gaps[:-1] / (gaps[:-1] + gaps[1:]) if len(gaps) > 1 else np.array([0.5])
    add(np.array([np.median(np.abs(pairs - 0.5))]), 0.09)
    return np.array(values), np.array(noise)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--preset", action="append", default=[], metavar="NAME=FILE")
    parser.add_argument("--seed", type=int, default=1000, help="seed of the random data")
    parser.add_argument("--write", action="store_true", help=f"write into {PAGE.name}")
    options = parser.parse_args()
    files = dict(one.split("=", 1) for one in options.preset)
    presets = {name: ov.load_preset(files.get(name, name)) for name in NAMES}
    data = os.environ.get("OVERVIEW_TEST_DATA")
    sets = list(random_sets(options.seed)) + (list(real_sets(Path(data))) if data else [])
    warnings.filterwarnings("ignore", "preset .* has no |.* too narrow for", ov.OverviewWarning)
    lines: list[str] = []
    for title, gesture in GESTURES.items():
        jobs = [RenderJob(one, presets[name], gesture) for _, _, one in sets for name in NAMES]
        rows, noise = [], np.zeros(0)
        for result in render_many(jobs, RATE, tail=0.2, trace=True):
            out = strokes(result.trace.touching, result.trace.cursor)[0]
            vibration = result.samples[out.start : out.stop, TACTOR]
            row, noise = features_of(levels(vibration, RATE, FELT_WINDOW_S, -90.0))
            rows.append(row)
        lines += tables(title, sets, answers(sets, np.array(rows), noise))
    print("\n".join(lines))
    if options.write:
        before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
        text = f"{before}{BEGIN}\n\n" + "\n".join(lines) + f"\n{END}{rest.split(END)[1]}"
        PAGE.write_text(text, encoding="utf-8", newline="\n")


def answers(
    sets: list[tuple[str, str, ov.Timeline]], rows: FloatArray, noise: FloatArray
) -> NDArray[np.int64]:
    """Return the observer's answers: int64 (draws, timelines, presets)."""
    rng = np.random.default_rng(0)
    truth = np.tile(np.arange(len(NAMES)), len(sets))
    folds: dict[str, int] = {}
    counted: defaultdict[str, int] = defaultdict(int)
    for kind, name, _ in sets:
        if name not in folds:
            folds[name] = counted[kind] % 2
            counted[kind] += 1
    fold = np.repeat([folds[name] for _, name, _ in sets], len(NAMES))
    named = np.zeros((DRAWS, len(rows)), dtype=np.int64)
    for half in (0, 1):
        learned, asked = np.flatnonzero(fold != half), np.flatnonzero(fold == half)
        copies = np.tile(rows[learned], (COPIES, 1))
        copies += noise * rng.normal(size=copies.shape)
        forest = fit_forest(copies, np.tile(truth[learned], COPIES), np.ones(len(copies)), rng)
        for draw in range(DRAWS):
            noisy = rows[asked] + noise * rng.normal(size=(len(asked), len(noise)))
            named[draw, asked] = forest.predict(noisy)
    return named.reshape(DRAWS, len(sets), len(NAMES))


def tables(
    title: str, sets: list[tuple[str, str, ov.Timeline]], named: NDArray[np.int64]
) -> Iterator[str]:
    """Yield Markdown: recall of each preset by group of data, then the confusions."""
    right = (named == np.arange(len(NAMES))).mean(axis=0)
    random = np.array([name.startswith("random") for _, name, _ in sets])
    kinds = np.array([kind for kind, _, _ in sets])
    mixed = random & (kinds == "crowd")
    yield f"| {title} | {' | '.join(NAMES)} | mean without weather |"
    yield "|---" * (len(NAMES) + 2) + "|"
    groups = {
        "real": ~random,
        "random, without crowds": random & ~mixed,
        "random crowds": mixed,
    }
    for name, rows in groups.items():
        if rows.any():
            recall = right[rows].mean(axis=0)
            mean = recall[[NAMES.index(one) for one in NAMES if one != "weather"]].mean()
            cells = " | ".join(f"{one:.2f}" for one in recall)
            yield f"| {name} ({rows.sum()}) | {cells} | {mean:.2f} |"
    for i, name in enumerate(NAMES):
        shares = [(named[:, :, i] == j).mean() for j in range(len(NAMES))]
        yield f"| *{name}* taken for | {' | '.join(f'{one:.2f}' for one in shares)} | |"
    yield ""


if __name__ == "__main__":
    main()
