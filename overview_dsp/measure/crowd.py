"""Each event measured where it lies, in its crowd: on real timelines, at every speed.

A feel report on a made-up timeline says what a kind is like by itself. In a match a foul lies
beside a card, a goal throws the disk over what follows it. Here every event of every timeline is
measured in each stroke:

- *level*: highest RMS over 10 ms while the disk is on it, as in `measure.report`;
- *missed*: the disk never met it; *masked*: it is less than a step above what is no event;
- *lost*: it strikes within 30 ms of one with more friction, which is felt in its place;
- *lag*: from its click to its knock (the highest of the vibration on it), ms.

Kinds are in an order of importance, the target's or that of their friction; it is kept where each
kind's median is a step above the next one's.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import Preset
from overview_dsp.kernels.derive import ARRIVAL_S
from overview_dsp.measure.feel import CrowdKind, CrowdReport, CrowdStroke
from overview_dsp.measure.felt import GESTURES, MERGED_S, STEP_DB
from overview_dsp.measure.felt_events import FeltEvents, felt_events
from overview_dsp.measure.report import require_gestures
from overview_dsp.offline.rendering.many import RenderJob, render_many
from overview_dsp.offline.rendering.schedule import Tail
from overview_dsp.signal.actuators.sensitivity import pacinian_db

LOW, HIGH = 10.0, 90.0
"""The spread of a kind's levels, percentiles."""


@dataclass(frozen=True, eq=False)
class _Events:
    """The events of one stroke over one timeline, row by row."""

    kind: NDArray[np.str_]
    level_db: NDArray[np.float64]
    free_db: float
    release: NDArray[np.float64]
    lag_ms: NDArray[np.float64]
    lost_to: NDArray[np.str_]  # the kind of the event that is felt in its place, or ""

    @property
    def masked(self) -> NDArray[np.bool_]:
        """Which are less than a step above what is no event."""
        return np.asarray(self.level_db < self.free_db + STEP_DB)


def crowd_report(
    preset: Preset,
    timelines: Sequence[Timeline],
    gestures: Mapping[str, Gesture] = GESTURES,
    target: Sequence[str] = (),
    sample_rate: float = 16_000,
    recoils: bool = True,
    progress: Callable[[float], None] = lambda part: None,
) -> CrowdReport:
    """Measure each event of real timelines where it lies.

    Parameters
    ----------
    preset : Preset
        What is to be felt.
    timelines : sequence of Timeline
        With events; what is said of a kind is said over all of them.
    gestures : mapping of str to Gesture
        By name; slow, medium and fast sweeps and a tap if left out.
    target : sequence of str
        Kinds, the most important first; the others follow by their friction.
    sample_rate : float
        Hz. The disk and its vibration are the same at any.
    recoils : bool
        Whether the hand lets go, and the way back is measured too.
    progress : callable
        Called with the part done, 0 to 1.

    Returns
    -------
    CrowdReport
        Per stroke and kind: medians, spreads, what is missed, masked and lost, and the order.

    Raises
    ------
    InputError
        What `render` refuses.

    Examples
    --------
    >>> report = ov.measure.crowd_report(football, [match], {"fast": ov.sweep(1.0)})
    >>> all(kind.missed == 0 for kind in report.strokes[0].kinds)
    True
    """
    require_gestures(gestures)
    timelines = validation.instances(timelines, Timeline, "timelines", "ov.load_timeline gives one")
    validation.instance(preset, Preset, "preset", "ov.load_preset gives one")
    sample_rate = validation.positive(sample_rate, "sample_rate")
    weight = pacinian_db(preset.number("tactor.frequency_hz"))
    found: dict[str, list[_Events]] = {}
    for done, (name, gesture) in enumerate(gestures.items()):
        jobs = [RenderJob(timeline, preset, gesture) for timeline in timelines]
        tail: Tail = "rest" if recoils else ARRIVAL_S
        for k, result in enumerate(render_many(jobs, sample_rate, tail=tail, trace=True)):
            for table in felt_events(result):
                way = table.stroke.name
                if way == "out" or recoils:
                    there = found.setdefault(name if way == "out" else f"{name} {way}", [])
                    there.append(_measured(table, weight))
            progress((done + (k + 1) / len(timelines)) / len(gestures))
    order = _order(target, [one for events in found.values() for one in events])
    return CrowdReport(
        preset.name,
        tuple(timeline.title for timeline in timelines),
        tuple(_stroke(name, events, order) for name, events in found.items()),
    )


def _measured(table: FeltEvents, weight: float) -> _Events:
    return _Events(
        table.kind,
        table.level_db + weight,
        table.free_db + weight,
        table.release,
        table.click_lag_ms,
        _lost(table.click_s, table.release, table.kind),
    )


def _lost(
    struck: NDArray[np.float64], release: NDArray[np.float64], names: NDArray[np.str_]
) -> NDArray[np.str_]:
    """For each event, the kind of the strongest one within 30 ms with more friction, or ""."""
    found = np.full(len(struck), "", dtype=names.dtype if len(names) else "U1")
    order = np.argsort(struck)
    order = order[np.isfinite(struck[order])]
    times = struck[order]
    first = np.searchsorted(times, times - MERGED_S, side="right")
    last = np.searchsorted(times, times + MERGED_S)
    for k, row in enumerate(order):
        near = order[first[k] : last[k]]
        other = near[np.argmax(release[near])]
        if release[other] > release[row]:
            found[row] = names[other]
    return found


def _order(target: Sequence[str], events: Sequence[_Events]) -> list[str]:
    """Kinds by importance: the target's, then by the friction that lets go."""
    release: dict[str, list[float]] = {}
    for one in events:
        for kind, value in zip(one.kind.tolist(), one.release.tolist(), strict=True):
            release.setdefault(kind, []).append(value)
    rest = sorted(release, key=lambda kind: -float(np.median(release[kind])))
    return [*target, *(kind for kind in rest if kind not in target)]


def _stroke(name: str, events: Sequence[_Events], order: Sequence[str]) -> CrowdStroke:
    kind, level, lag, lost_to, masked = (
        np.concatenate([getattr(one, column) for one in events])
        for column in ("kind", "level_db", "lag_ms", "lost_to", "masked")
    )
    kinds = []
    for wanted in order:
        rows = kind == wanted
        met = level[rows][np.isfinite(level[rows])]
        low, middle, high = np.percentile(met, [LOW, 50.0, HIGH]) if len(met) else [math.nan] * 3
        lags = lag[rows][np.isfinite(lag[rows])]
        if rows.any():
            kinds.append(
                CrowdKind(
                    wanted,
                    int(rows.sum()),
                    int(rows.sum()) - len(met),
                    int(masked[rows].sum()),
                    int((lost_to[rows] != "").sum()),
                    float(middle),
                    float(low),
                    float(high),
                    float(np.median(lags)) if len(lags) else math.nan,
                )
            )
    gaps = tuple(
        (one.kind, other.kind, (one.level_db - other.level_db) / STEP_DB)
        for one, other in itertools.pairwise(kinds)
    )
    pairs = Counter((a, b) for a, b in zip(kind.tolist(), lost_to.tolist(), strict=True) if b)
    lost = tuple((a, b, n) for (a, b), n in pairs.most_common())
    free = float(np.median([one.free_db for one in events]))
    return CrowdStroke(name, free, tuple(kinds), gaps, lost)
