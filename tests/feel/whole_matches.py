"""What a hand gets of whole matches, stroke by stroke: for tests and `tools/measure_feel.py`."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import overview_dsp as ov
from overview_dsp.measure.apart import HOP_S, knocks
from overview_dsp.measure.felt import passages, stroke_feel, strokes, window_db

RATE = 16_000
"""The disk and its vibration are the same at any rate."""

GOALS = ("goal", "own_goal")
CARDS = ("yellow_card", "red_card")
SOON_S = 600.0
CLOSE_S = 120.0


class Stroke(NamedTuple):
    """One way of a gesture over a match; a row an event of the surface."""

    name: str
    time_s: NDArray[np.float64]  # of the timeline
    kind: NDArray[np.str_]
    level_db: NDArray[np.float64]  # NaN where it wasn't met
    knock_s: NDArray[np.float64]  # when the envelope is highest on it; NaN
    click_s: NDArray[np.float64]  # when it is struck; NaN
    knocks_s: NDArray[np.float64]  # all that are felt apart in the stroke
    first_s: NDArray[np.float64]  # when the disk is on it; NaN
    last_s: NDArray[np.float64]
    free_db: float  # median level between events
    length_s: float  # until the disk is past 95 % of its way


def real_files(data: Path) -> list[Path]:
    """Matches among other people's data."""
    folder = data / "football"
    return [
        *(folder / "statsbomb" / f"{name}.json" for name in (15986, 22936, 69321)),
        folder / "metrica" / "Sample_Game_1_RawEventsData.csv",
        folder / "wyscout" / "wyscout_v2_match_2499773.json",
    ]


def real_matches(data: Path) -> list[ov.Timeline]:
    """The bundled match and those of other people's data."""
    return [
        ov.load_timeline("world-cup-final-2018"),
        *(ov.load_timeline(file) for file in real_files(data)),
    ]


def random_matches(count: int) -> list[ov.Timeline]:
    """Random matches, and one more without its goals."""
    lively = ov.measure.random_match(699)
    dull = replace(lively, events=tuple(e for e in lively.events if e.kind not in GOALS))
    return [*(ov.measure.random_match(700 + seed) for seed in range(count)), dull]


def close_matches(count: int) -> list[ov.Timeline]:
    """Random matches with goals less than two minutes apart."""
    found: list[ov.Timeline] = []
    seed = 700
    while len(found) < count:
        match = ov.measure.random_match(seed)
        goals = sorted(event.time_s for event in match.events if event.kind in GOALS)
        if any(late - early < CLOSE_S for early, late in itertools.pairwise(goals)):
            found.append(match)
        seed += 1
    return found


def felt_strokes(
    matches: Sequence[ov.Timeline], preset: ov.Preset, hand: ov.Gesture
) -> list[list[Stroke]]:
    """The strokes of a gesture over each match: out and back."""
    jobs = ov.render_jobs(matches, [preset], [hand])
    return [list(_strokes(done)) for done in ov.render_many(jobs, RATE, trace=True)]


def _strokes(done: ov.RenderedJob[ov.Trace]) -> Iterator[Stroke]:
    trace, surface, timeline = done.trace, done.surface, done.job.timeline
    kinds = np.array([timeline.events[event].kind for event in surface.event])
    times = np.array([timeline.events[event].time_s for event in surface.event])
    at = {event: row for row, event in enumerate(surface.event)}
    for stroke in strokes(trace.touching, trace.cursor):
        part = slice(stroke.start, stroke.stop)
        feel = stroke_feel(stroke, surface, trace, done.samples[:, 1], RATE)
        rows = np.full((4, len(kinds)), np.nan)
        envelope, cursor = trace.envelope[part], trace.cursor[part]
        for row, first, last in zip(*passages(surface, cursor), strict=True):
            begin = max(0, first - RATE // 200)
            end = max(last, first + 3 * RATE // 100) + RATE // 200
            knock = begin + int(np.argmax(envelope[begin:end]))
            rows[:, row] = knock, np.nan, first, last
        rows += stroke.start
        for time, event in zip(done.strikes.time_s, done.strikes.event, strict=True):
            if event >= 0 and stroke.start <= time * RATE < stroke.stop:
                rows[1, at[event]] = time * RATE
        starts, level = window_db(done.samples[part, 1], RATE, HOP_S)
        apart = (starts[knocks(level)] + 0.005 * RATE + stroke.start) / RATE
        knock, click, first, last = rows / RATE
        way = cursor if stroke.name == "out" else 1.0 - cursor
        yield Stroke(
            stroke.name,
            times,
            kinds,
            feel.event_db,
            knock,
            click,
            apart,
            first,
            last,
            feel.event_free_db,
            float(np.argmax(way >= 0.95)) / RATE,
        )


def lags_s(part: Stroke) -> NDArray[np.float64]:
    """How far ear and finger are apart at each event of which both get something."""
    lag = np.abs(part.click_s - part.knock_s)
    return np.asarray(lag[np.isfinite(lag)])


def cards_over_goals(part: Stroke) -> list[float]:
    """Level of each card over that of a goal that it follows within ten minutes of play, dB."""
    return [
        float(part.level_db[card] - part.level_db[goal])
        for goal in np.flatnonzero(np.isin(part.kind, GOALS))
        for card in np.flatnonzero(np.isin(part.kind, CARDS))
        if 0.0 < part.time_s[card] - part.time_s[goal] <= SOON_S
    ]


def spread_of_goals(part: Stroke) -> float:
    """How far the strongest goal is above the weakest, dB; 0 without two."""
    goals = part.level_db[part.kind == "goal"]
    return float(np.ptp(goals)) if len(goals) else 0.0


def close_goals_felt(part: Stroke) -> list[bool]:
    """Of each goal that follows another within two minutes: are there two knocks?"""
    goals = np.flatnonzero(np.isin(part.kind, GOALS))
    found = []
    for one, other in itertools.pairwise(goals):
        if part.time_s[other] - part.time_s[one] < CLOSE_S:
            near = [
                (part.knocks_s >= part.first_s[i] - 0.015)
                & (part.knocks_s <= part.last_s[i] + 0.040)
                for i in (one, other)
            ]
            found.append(bool((near[0] | near[1]).sum() >= 2))
    return found


def peaks_under_goals(parts: Sequence[Stroke]) -> list[float]:
    """How far the highest peak of each match without goals is under the others' median goal, dB."""
    goals = np.concatenate([part.level_db[np.isin(part.kind, GOALS)] for part in parts])
    return [
        float(np.nanmedian(goals) - np.nanmax(part.level_db))
        for part in parts
        if not np.isin(part.kind, GOALS).any()
    ]


def moments(part: Stroke) -> int:
    """How many moments there are to be felt: a foul and its card share theirs."""
    return len(np.unique(part.time_s // 2.0))
