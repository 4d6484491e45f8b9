"""The strokes that an observer is asked about: rendered, cut, and what is noticed in each.

One model per stroke: who moves knows how fast, and whether it is an arm's movement, a tap or a
recoil. Hands of mixed pace share one model, which is told the pace of the hand (`noticed.PACE`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture, arm, sweep, tap
from overview_dsp.design.presets.model import Preset
from overview_dsp.measure.felt import strokes
from overview_dsp.measure.observer.noticed import Modality, Noticed, notice
from overview_dsp.measure.observer.passages import Met, met, owners
from overview_dsp.measure.random_hands import random_hand
from overview_dsp.offline.rendering.many import RenderedJob, RenderJob, render_many
from overview_dsp.offline.rendering.schedule import Tail
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.units import HALF_TURN

Hands = Literal["all", "steady", "arm", "mixed"]
HANDS: tuple[Hands, ...] = ("all", "steady", "arm", "mixed")

RECOIL_OF = "2 s"
"""A recoil is much the same after any sweep: this one's is looked at."""

STEADY: Mapping[str, Gesture] = {
    "1 s": sweep(1.0),
    RECOIL_OF: sweep(2.0),
    "4 s": sweep(4.0),
    "6 s": sweep(6.0),
    "15 s": sweep(15.0),
    "30 s": sweep(30.0),
    "tap": tap(1.0, 3.0),
}
"""The tap is held until a slow one has unfolded."""

ARMS: Mapping[str, Gesture] = {f"arm {seconds} s": arm(seconds) for seconds in (1, 2, 4, 6)}
"""An arm's movements: the disk arrives after their release, as after any."""

GESTURES: Mapping[Hands, Mapping[str, Gesture]] = {
    "all": {**STEADY, **ARMS},
    "steady": STEADY,
    "arm": ARMS,
}

ARRIVAL_S = 3.0
"""Rendered after a release: the disk arrives first."""

TRAILING_S = 0.15
"""Output that still belongs to an outward stroke after the disk turns back: its last pulse ends."""

RECOIL, MIXED = "recoil", "mixed"

TOUCH_RATE, SOUND_RATE = 16_000.0, 48_000.0
"""Hz. The disk and its vibration are the same at both; clicks are told apart less well below."""

_SLOWEST = 0.02
"""Timelines a second: a hand slower than this rests."""

_PACE_OVER_S = 0.05


@dataclass(frozen=True, eq=False)
class StrokeMet:
    """One stroke over one timeline.

    Attributes
    ----------
    name : str
        `1 s` to `30 s`, `recoil`, `tap`, `arm 1 s` to `arm 6 s`, `mixed`.
    noticed : dict of Modality to Noticed
    owner : dict of Modality to int64 (onsets,)
        The row of `met` that each onset belongs to, or -1.
    met : Met
    """

    name: str
    noticed: dict[Modality, Noticed]
    owner: dict[Modality, NDArray[np.int64]]
    met: Met


def stroke_names(hands: Hands) -> tuple[str, ...]:
    """The strokes of a sort of hands, in the order of a report."""
    if hands == "mixed":
        return (MIXED,)
    names = list(GESTURES[hands])
    if RECOIL_OF in names:
        names.insert(names.index("tap"), RECOIL)
    return tuple(names)


def rendered_strokes(
    preset: Preset,
    timelines: Sequence[Timeline],
    hands: Hands,
    modalities: Sequence[Modality],
    seed: int,
    progress: Callable[[int], None],
    sample_rate: float | None = None,
) -> list[list[StrokeMet]]:
    """Render every stroke over every timeline, on all cores.

    Parameters
    ----------
    preset, timelines
        What is felt.
    hands
        Which strokes; `mixed` is one of mixed pace for each timeline.
    modalities
        What is noticed by.
    seed
        Of the hands: timeline i gets that of `seed + i`.
    progress
        Called after each render with how many it was (1).
    sample_rate
        Hz; None is what the modalities need.

    Returns
    -------
    list of list of StrokeMet
        Those of each timeline.
    """
    if sample_rate is None:
        sample_rate = TOUCH_RATE if tuple(modalities) == ("touch",) else SOUND_RATE
    found: list[list[StrokeMet]] = [[] for _ in timelines]
    plans: list[tuple[Tail, list[tuple[str, int, Gesture]]]]
    if hands == "mixed":
        plans = [(ARRIVAL_S, [(MIXED, i, random_hand(seed + i)) for i in range(len(timelines))])]
    else:
        chosen = GESTURES[hands]
        every = [(name, i, chosen[name]) for name in chosen for i in range(len(timelines))]
        # only one sweep's recoil is looked at
        plans = [
            (ARRIVAL_S, [one for one in every if one[0] != RECOIL_OF]),
            ("rest", [one for one in every if one[0] == RECOIL_OF]),
        ]
    for tail, plan in plans:
        jobs = [RenderJob(timelines[i], preset, gesture) for _, i, gesture in plan]
        results = render_many(jobs, sample_rate, tail=tail, trace=True)
        for (name, i, _), result in zip(plan, results, strict=True):
            found[i] += _cut(name, result, modalities)
            progress(1)
    return found


def _cut(
    name: str, result: RenderedJob[Trace], modalities: Sequence[Modality]
) -> Iterator[StrokeMet]:
    for stroke in strokes(result.trace.engaged, result.trace.cursor):
        outward = stroke.name == "out"
        if not outward and name != RECOIL_OF:
            continue
        frames = slice(stroke.start, stroke.stop)
        furthest = float(result.job.gesture.theta2.max()) / HALF_TURN if outward else -math.inf
        there = met(result.surface, result.trace.cursor[frames], result.sample_rate, furthest)
        if outward:
            frames = slice(stroke.start, stroke.stop + round(TRAILING_S * result.sample_rate))
        pace = log_pace(result.job.gesture) if name == MIXED else None
        found = notice(result.samples[frames], result.sample_rate, modalities, pace)
        yield StrokeMet(
            name if outward else RECOIL,
            found,
            {modality: owners(one.at_ms, there) for modality, one in found.items()},
            there,
        )


def log_pace(hand: Gesture) -> NDArray[np.float64]:
    """Log of a hand's pace at each millisecond, timelines a second."""
    at = np.arange(0.0, hand.duration_s, 0.001)
    place = np.interp(
        np.stack([at, at + _PACE_OVER_S]) - _PACE_OVER_S / 2.0, hand.time_s, hand.theta2
    )
    pace = np.abs(place[1] - place[0]) / _PACE_OVER_S / HALF_TURN
    return np.asarray(np.log(np.maximum(pace, _SLOWEST)))
