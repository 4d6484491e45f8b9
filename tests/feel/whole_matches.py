"""What a hand gets of whole matches, stroke by stroke: for tests and `tools/measure_feel.py`."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import overview_dsp as ov
from overview_dsp.measure.event_table import FeltEvents, felt_events

RATE = 16_000
"""The disk and its vibration are the same at any rate."""

GOALS = ("goal", "own_goal")
CARDS = ("yellow_card", "red_card")
CLOSE_S = 120.0


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
) -> list[list[FeltEvents]]:
    """The strokes of a gesture over each match: out and back."""
    tables = felt_events(preset, matches, {"hand": hand}, RATE)
    return [[one for one in tables if one.timeline is match] for match in matches]


def lags_s(part: FeltEvents) -> NDArray[np.float64]:
    """How far ear and finger are apart at each event of which both get something."""
    return part.click_lag_ms[np.isfinite(part.click_lag_ms)] / 1e3


def close_goals_felt(part: FeltEvents) -> list[bool]:
    """Of each goal that follows another within two minutes: are there two knocks?"""
    goals = np.flatnonzero(np.isin(part.kind, GOALS))
    found = []
    for one, other in itertools.pairwise(goals):
        if part.time_s[other] - part.time_s[one] < CLOSE_S:
            near = [
                (part.pulse_s >= part.first_s[i] - 0.015) & (part.pulse_s <= part.last_s[i] + 0.040)
                for i in (one, other)
            ]
            found.append(bool((near[0] | near[1]).sum() >= 2))
    return found


def peaks_under_goals(parts: Sequence[FeltEvents]) -> list[float]:
    """How far the highest peak of each match without goals is under the others' median goal, dB."""
    goals = np.concatenate([part.level_db[np.isin(part.kind, GOALS)] for part in parts])
    return [
        float(np.nanmedian(goals) - np.nanmax(part.level_db))
        for part in parts
        if not np.isin(part.kind, GOALS).any()
    ]


def moments(part: FeltEvents) -> int:
    """How many moments there are to be felt: a foul and its card share theirs."""
    return len(np.unique(part.time_s // 2.0))
