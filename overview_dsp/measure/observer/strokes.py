"""Rendered strokes of an observer, with their features and the events that the disk passes.

There is one model per stroke, since users know how fast they move, and whether a movement is a
sweep, an arm's movement, a tap or a recoil. Random movements of mixed pace, with pauses and short
returns, share one model, which has the pace as a feature (`features.PACE`).

The trace says which event each onset belongs to. The disk is *on* an event from entering its span
until it leaves it. An onset belongs to an event from `BEFORE_MS` before that time to `AFTER_MS`
after it. Of several events, it belongs to the one whose own profile releases the most friction.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture, arm, sweep, tap
from overview_dsp.design.gestures.scripts import CONTROL_RATE
from overview_dsp.design.presets.model import Preset
from overview_dsp.measure.observer.features import Modality, StrokeFeatures, stroke_features
from overview_dsp.measure.perceived_level import passages, strokes
from overview_dsp.measure.perception import AFTER_MS, BEFORE_MS, TRAILING_S
from overview_dsp.offline.rendering.many import RenderedJob, RenderJob, render_many
from overview_dsp.offline.rendering.schedule import Tail
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.signal.surface.model import Surface
from overview_dsp.units import HALF_TURN

TURN_DISTANCE = 0.01
"""Distance in the other direction at which a disk has turned back, as a share of the timeline."""

TURN_CHECK_S = 0.004  # time between the positions that are checked for a turn, s


@dataclass(frozen=True, eq=False)
class PassedEvents:
    """Events of a stroke, one row for each time that the disk passes one.

    Events that the input disk passes and the disk never reaches are rows with infinite times.

    `kind`: index into the surface's `kind_names`.
    `enters_ms`, `leaves_ms`: times from the stroke's start.
    `strength`: friction released by the event, N m s/rad.
    """

    kind: IntArray
    enters_ms: FloatArray
    leaves_ms: FloatArray
    strength: FloatArray

    def __len__(self) -> int:
        return len(self.kind)


def passed_events(
    surface: Surface, cursor: FloatArray, sample_rate: float, furthest: float = -math.inf
) -> PassedEvents:
    """Find the events that a stroke passes, and those that it misses.

    `cursor` is that of the stroke. The input disk passes the events that start before its
    `furthest` position.
    """
    bounds = _turns(cursor, max(1, int(TURN_CHECK_S * sample_rate)))
    parts = []
    for start, stop in itertools.pairwise(bounds):
        event, first, last = passages(surface, cursor[start:stop])
        parts.append((event, first + start, last + start))
    event, *times = (np.concatenate(column) for column in zip(*parts, strict=True))
    frames = np.stack(times).astype(np.float64)
    begins = surface.span[:, 0]
    missed = np.setdiff1d(np.flatnonzero((begins > -math.inf) & (begins <= furthest)), event)
    event = np.append(event, missed)
    frames = np.hstack([frames, np.full((2, len(missed)), math.inf)])
    enters_ms, leaves_ms = frames * (1000.0 / sample_rate)
    return PassedEvents(surface.kind[event], enters_ms, leaves_ms, surface.release[event])


def rows_of_onsets(at_ms: IntArray, passed: PassedEvents) -> IntArray:
    """Return the row of `passed` that each onset belongs to; -1 for none."""
    if not len(passed):
        return np.full(len(at_ms), -1)
    at = at_ms[:, None]
    near = (passed.enters_ms - BEFORE_MS <= at) & (at <= passed.leaves_ms + AFTER_MS)
    strength = np.where(near, passed.strength, -1.0)
    # the last of equal ones: an event may be passed twice
    row = len(passed) - 1 - strength[:, ::-1].argmax(axis=1)
    return np.where(near.any(axis=1), row, -1)


def _turns(cursor: FloatArray, step: int) -> list[int]:
    """Return the frames at which the disk turns back, from 0 to the number of frames."""
    coarse = cursor[::step]
    bounds, extreme, direction = [0], 0, 0
    for i, position in enumerate(coarse.tolist()):
        ahead = position - coarse[extreme]
        if direction == 0:
            if abs(ahead) > TURN_DISTANCE:
                direction, extreme = (1 if ahead > 0.0 else -1), i
        elif ahead * direction >= 0.0:
            extreme = i
        elif -ahead * direction > TURN_DISTANCE:
            bounds.append(extreme * step)
            direction, extreme = -direction, i
    return [*dict.fromkeys(bounds), len(cursor)]


Movement = Literal["all", "steady", "arm", "mixed"]
MOVEMENTS: tuple[Movement, ...] = ("all", "steady", "arm", "mixed")
RECOIL_OF = "2 s"  # sweep whose recoil is observed; the recoils of all sweeps are similar

STEADY: Mapping[str, Gesture] = {
    **{f"{seconds} s": sweep(seconds) for seconds in (1, 2, 4, 6, 15, 30)},
    "tap": tap(1.0, 3.0),
}
"""Steady movements. The tap is held until a slow disk has arrived."""

ARMS: Mapping[str, Gesture] = {f"arm {seconds} s": arm(seconds) for seconds in (1, 2, 4, 6)}
"""Movements of an arm; the disk arrives after their release."""

GESTURES: Mapping[Movement, Mapping[str, Gesture]] = {
    "all": {**STEADY, **ARMS},
    "steady": STEADY,
    "arm": ARMS,
}

ARRIVAL_S = 3.0  # time rendered after a release, s, in which the disk arrives

RECOIL, MIXED = "recoil", "mixed"

TOUCH_RATE, SOUND_RATE = 16_000.0, 48_000.0
"""Sample rates, Hz. The vibration is the same at both; clicks need the higher one."""

_SLOWEST = 0.02  # lowest pace, in timelines per second; a slower input rests
_PACE_OVER_S = 0.05  # time over which the pace is taken, s


@dataclass(frozen=True, eq=False)
class ObservedStroke:
    """One stroke over one timeline.

    `name`: `1 s` to `30 s`, `recoil`, `tap`, `arm 1 s` to `arm 6 s`, `mixed`.
    `owner`: the row of `events` that each onset belongs to, or -1.
    """

    name: str
    features: dict[Modality, StrokeFeatures]
    owner: dict[Modality, IntArray]
    events: PassedEvents


def stroke_names(movement: Movement) -> tuple[str, ...]:
    """Return the names of a movement's strokes, in the order of a report."""
    if movement == "mixed":
        return (MIXED,)
    names = list(GESTURES[movement])
    if RECOIL_OF in names:
        names.insert(names.index("tap"), RECOIL)
    return tuple(names)


def rendered_strokes(
    preset: Preset,
    timelines: Sequence[Timeline],
    movement: Movement,
    modalities: Sequence[Modality],
    seed: int,
    progress: Callable[[int], None],
    sample_rate: float | None = None,
) -> dict[str, list[ObservedStroke]]:
    """Render every stroke over every timeline on all cores; return them by name.

    `movement`: `mixed` renders one movement of mixed pace for each timeline i, of seed `seed + i`.
    `progress`: called after each render with the number of renders (1).
    `sample_rate`: Hz; None: the lowest rate that the modalities need.
    """
    if sample_rate is None:
        sample_rate = TOUCH_RATE if tuple(modalities) == ("touch",) else SOUND_RATE
    found: dict[str, list[ObservedStroke]] = {name: [] for name in stroke_names(movement)}
    for name in (MIXED,) if movement == "mixed" else GESTURES[movement]:
        jobs = [
            RenderJob(
                each,
                preset,
                random_movement(seed + i) if name == MIXED else GESTURES[movement][name],
            )
            for i, each in enumerate(timelines)
        ]
        tail: Tail = "rest" if name == RECOIL_OF else ARRIVAL_S
        for result in render_many(jobs, sample_rate, tail=tail, trace=True):
            for stroke in _observed_strokes(name, result, modalities):
                found[stroke.name].append(stroke)
            progress(1)
    return found


def _observed_strokes(
    name: str, result: RenderedJob[Trace], modalities: Sequence[Modality]
) -> Iterator[ObservedStroke]:
    rate = result.sample_rate
    for stroke in strokes(result.trace.engaged, result.trace.cursor):
        outward = stroke.name == "out"
        if not outward and name != RECOIL_OF:
            continue
        frames = slice(stroke.start, stroke.stop)
        furthest = float(result.job.gesture.theta2.max()) / HALF_TURN if outward else -math.inf
        passed = passed_events(result.surface, result.trace.cursor[frames], rate, furthest)
        if outward:
            frames = slice(stroke.start, stroke.stop + round(TRAILING_S * rate))
        pace = log_pace(result.job.gesture) if name == MIXED else None
        found = stroke_features(result.samples[frames], rate, modalities, pace)
        yield ObservedStroke(
            name if outward else RECOIL,
            found,
            {modality: rows_of_onsets(one.at_ms, passed) for modality, one in found.items()},
            passed,
        )


def log_pace(gesture: Gesture) -> FloatArray:
    """Return the logarithm of the pace at each millisecond, in timelines per second."""
    at = np.arange(0.0, gesture.duration_s, 0.001)
    position = np.interp(
        np.stack([at, at + _PACE_OVER_S]) - _PACE_OVER_S / 2.0, gesture.time_s, gesture.theta2
    )
    pace = np.abs(position[1] - position[0]) / _PACE_OVER_S / HALF_TURN
    return np.asarray(np.log(np.maximum(pace, _SLOWEST)))


SWEEP_S = (1.5, 6.0)  # duration of a steady movement of the mean pace, s; its logarithm is uniform
PACE_CHANGE = 0.6  # standard deviation of the logarithm of the pace of a segment
SEGMENT_S = (0.25, 0.9)  # range of the duration of a segment of equal pace, s
PAUSE_SHARE, PAUSE_S = 0.15, (0.15, 0.8)
RETURN_SHARE, RETURN_BY = 0.12, (0.03, 0.15)
"""Shares of segments that pause or return; distance of a return as a share of the timeline."""

SMOOTHED_S = 0.2  # length of the Hann window that smooths the pace, s


def random_movement(seed: int) -> Gesture:
    """Make a random movement of mixed pace over the whole timeline.

    It touches at the start, changes its pace at random, pauses, returns by up to 15 % of the
    timeline, and releases at the end.

    Parameters
    ----------
    seed : int
        Random seed; the same seed gives the same movement.

    Returns
    -------
    Gesture
        Gesture with 200 control events per second.

    Examples
    --------
    >>> movement = ov.measure.random_movement(2)
    >>> movement.theta2[0], bool(movement.theta2[-1] == np.pi)
    (np.float64(0.0), True)
    """
    rng = validation.random(seed)
    mean_pace = 1.0 / math.exp(rng.uniform(*np.log(SWEEP_S)))
    smoothing = np.hanning(round(SMOOTHED_S * CONTROL_RATE) + 2)[1:-1]
    paces: list[FloatArray] = []
    position = 0.0
    while position < 1.0:
        pace = mean_pace * math.exp(rng.normal(0.0, PACE_CHANGE))
        seconds = rng.uniform(*SEGMENT_S)
        chance = rng.random()
        if chance < PAUSE_SHARE:
            pace, seconds = 0.0, rng.uniform(*PAUSE_S)
        elif chance < PAUSE_SHARE + RETURN_SHARE:
            seconds = min(rng.uniform(*RETURN_BY), 0.8 * position) / pace
            pace = -pace
        steps = round(seconds * CONTROL_RATE)
        paces.append(np.full(steps, pace))
        position += pace * steps / CONTROL_RATE
    smoothed = np.convolve(np.concatenate(paces), smoothing / smoothing.sum())
    positions = np.maximum(np.concatenate([[0.0], np.cumsum(smoothed) / CONTROL_RATE]), 0.0)
    end = int(np.argmax(positions >= 1.0 - 1e-9))
    positions = np.append(positions[:end], [1.0, 1.0])
    time_s = np.append(np.arange(end + 1), end) / CONTROL_RATE
    touching = np.ones(end + 2, dtype=bool)
    touching[-1] = False
    return Gesture(time_s, positions * HALF_TURN, touching, float(time_s[-1]))
