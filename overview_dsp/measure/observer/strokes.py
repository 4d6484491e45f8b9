"""The strokes that an observer is asked about: rendered, cut, and what is noticed in each.

One model per stroke: who moves knows how fast, and whether it is an arm's movement, a tap or a
recoil. Hands of mixed pace share one model, which is told the pace of the hand (`noticed.PACE`).

Which event each onset belongs to: an observer's teacher and examiner knows it, by the trace.

The disk is *on* an event from where it enters its span until it leaves it. An onset belongs to an
event if it comes from `BEFORE_MS` before that to `AFTER_MS` after it; of several, to the one whose
own profile lets go the most friction (not the friction that surrounds it: a foul beside a goal
would take the goal's).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture, arm, sweep, tap
from overview_dsp.design.presets.model import Preset
from overview_dsp.measure.felt import passages, strokes
from overview_dsp.measure.observer.noticed import Modality, Noticed, notice
from overview_dsp.measure.random_hands import random_hand
from overview_dsp.offline.rendering.many import RenderedJob, RenderJob, render_many
from overview_dsp.offline.rendering.schedule import Tail
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.signal.surface.model import Surface
from overview_dsp.units import HALF_TURN

BEFORE_MS, AFTER_MS = 15.0, 40.0

TURN = 0.01
"""A disk turns back where it goes so far the other way, as a part of the timeline."""

LOOK_S = 0.004
"""How often it is looked at for that."""


@dataclass(frozen=True, eq=False)
class Met:
    """Events of a stroke, once for each time that the disk passes them; row by row.

    Events that the input disk passes and the disk never meets are rows too, with infinite times.

    Attributes
    ----------
    kind : int64 (events,)
        Index into the surface's `kind_names`.
    enters_ms, leaves_ms : float64 (events,)
        From the stroke's start.
    strength : float64 (events,)
        Friction that lets go, N m s/rad.
    """

    kind: NDArray[np.int64]
    enters_ms: NDArray[np.float64]
    leaves_ms: NDArray[np.float64]
    strength: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.kind)


def met(
    surface: Surface, cursor: NDArray[np.float64], sample_rate: float, furthest: float = -math.inf
) -> Met:
    """Find the events that a stroke meets, and those that it misses.

    Parameters
    ----------
    surface : Surface
    cursor : float64 (frames,)
        Of the stroke.
    sample_rate : float
        Hz.
    furthest : float
        Furthest position of the input disk: it passes all events that start before.
    """
    bounds = _turns(cursor, max(1, int(LOOK_S * sample_rate)))
    events, enters, leaves = [], [], []
    for start, stop in itertools.pairwise(bounds):
        event, first, last = passages(surface, cursor[start:stop])
        events.append(event)
        enters.append(first + start)
        leaves.append(last + start)
    event = np.concatenate(events)
    frames = np.stack([np.concatenate(enters), np.concatenate(leaves)]).astype(np.float64)
    begins = surface.span[:, 0]
    missed = np.setdiff1d(np.flatnonzero((begins > -math.inf) & (begins <= furthest)), event)
    event = np.append(event, missed)
    frames = np.hstack([frames, np.full((2, len(missed)), math.inf)])
    enters_ms, leaves_ms = frames * (1000.0 / sample_rate)
    return Met(
        surface.kind[event],
        enters_ms,
        leaves_ms,
        surface.release[event],
    )


def owners(at_ms: NDArray[np.int64], there: Met) -> NDArray[np.int64]:
    """The row of `there` that each onset belongs to; -1 for none."""
    if not len(there):
        return np.full(len(at_ms), -1)
    at = at_ms[:, None]
    near = (there.enters_ms - BEFORE_MS <= at) & (at <= there.leaves_ms + AFTER_MS)
    strength = np.where(near, there.strength, -1.0)
    # of equal ones the last, as of an event passed twice
    row = len(there) - 1 - strength[:, ::-1].argmax(axis=1)
    return np.where(near.any(axis=1), row, -1)


def _turns(cursor: NDArray[np.float64], step: int) -> list[int]:
    """Frames at which the disk turns back, with the first and the one behind the last."""
    coarse = cursor[::step]
    bounds, extreme, way = [0], 0, 0
    for i, place in enumerate(coarse.tolist()):
        ahead = place - coarse[extreme]
        if way == 0:
            if abs(ahead) > TURN:
                way, extreme = (1 if ahead > 0.0 else -1), i
        elif ahead * way >= 0.0:
            extreme = i
        elif -ahead * way > TURN:
            bounds.append(extreme * step)
            way, extreme = -way, i
    return [*dict.fromkeys(bounds), len(cursor)]


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
) -> dict[str, list[StrokeMet]]:
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
    dict of str to list of StrokeMet
        By the stroke's name, those over each timeline.
    """
    if sample_rate is None:
        sample_rate = TOUCH_RATE if tuple(modalities) == ("touch",) else SOUND_RATE
    found: dict[str, list[StrokeMet]] = {name: [] for name in stroke_names(hands)}
    for name in (MIXED,) if hands == "mixed" else GESTURES[hands]:
        jobs = [
            RenderJob(
                each, preset, random_hand(seed + i) if name == MIXED else GESTURES[hands][name]
            )
            for i, each in enumerate(timelines)
        ]
        tail: Tail = "rest" if name == RECOIL_OF else ARRIVAL_S
        for result in render_many(jobs, sample_rate, tail=tail, trace=True):
            for stroke in _cut(name, result, modalities):
                found[stroke.name].append(stroke)
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
