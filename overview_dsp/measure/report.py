"""What a person gets of each kind of event, gesture by gesture, and what can't be distinguished.

Measured on the tactor and click channels of renders, as a finger and an ear take them:

- *level*: highest RMS over 10 ms while the disk is on the event, dB of full scale, weighted by the
  skin's sensitivity at the carrier's frequency (`pacinian_db`);
- *contrast*: level above the median of all that is no event;
- *sharpness*: steepest rise of the torque, N m/s;
- *duration*: how long the level stays within 6 dB of its highest, ms (of what stands out by less
  than 12 dB: in the upper half of its contrast);
- *click*: highest RMS over 10 ms of the click, dB of full scale.

Steps: 2.3 dB of level (Israr and Tan 2006: 2.2 to 2.5 dB); a quarter of duration (0.2 to 0.25 is
what touch needs for frequency, the same authors); a factor of two in sharpness (our own rule: no
study gives one for such pulses). Pulses within 30 ms are felt as one. An event less than a step
above the rest is masked.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError, shown
from overview_dsp.kernels.derive import ARRIVAL_S
from overview_dsp.measure.comparing import alike_pairs
from overview_dsp.measure.feel import FeelReport, KindFeel, StrokeReport
from overview_dsp.measure.felt import (
    FALL_DB,
    GESTURES,
    KNOCK_HOP_S,
    MERGED_S,
    STEP_DB,
    Stroke,
    knocks,
    stroke_feel,
    strokes,
    window_db,
)
from overview_dsp.offline.rendering.offline import Result, render
from overview_dsp.offline.rendering.schedule import Tail
from overview_dsp.signal.actuators.sensitivity import pacinian_db
from overview_dsp.units import FELT_WINDOW_S

__all__ = ["GESTURES", "STEP_DB", "FeelReport", "KindFeel", "StrokeReport", "feel_report"]

ARRIVED = 0.005
"""So near to its end, as a part of the timeline, a stroke is over."""

_CLICK_BEFORE_S, _CLICK_AFTER_S = 0.005, 0.060


def feel_report(
    preset: Preset,
    timeline: Timeline | Sequence[Timeline],
    gestures: Mapping[str, Gesture] = GESTURES,
    sample_rate: float = 48_000,
    recoils: bool = True,
) -> FeelReport:
    """Measure how a preset feels on a timeline.

    Parameters
    ----------
    preset : Preset
        What is to be felt.
    timeline : Timeline or sequence of Timeline
        With events. Of several, what is felt on all of them.
    gestures : mapping of str to Gesture
        By name, each of one touch; slow, medium and fast sweeps and a tap if left out.
    sample_rate : float
        Hz.
    recoils : bool
        Without them, the hand never lets go: only the way out is measured.

    Returns
    -------
    FeelReport
        Level, contrast, sharpness, duration and click of each kind in each stroke.

    Raises
    ------
    InputError
        As `render`.

    Examples
    --------
    >>> sweeps = {"fast": ov.sweep(1.0)}
    >>> report = ov.measure.feel_report(football, match, sweeps, sample_rate=8000)
    >>> [stroke.name for stroke in report.strokes]
    ['fast', 'fast recoil']
    """
    require_gestures(gestures)
    if not recoils:
        gestures = {name: _held(gesture) for name, gesture in gestures.items()}
    tail: Tail = "rest" if recoils else ARRIVAL_S
    one = [timeline] if isinstance(timeline, Timeline) else timeline
    timelines = validation.instances(one, Timeline, "timelines", "ov.load_timeline gives one")
    if not timelines:
        raise InputError("no timelines; give one or more")
    validation.instance(preset, Preset, "preset", "ov.load_preset gives one")
    reports = [
        _combined(parts)
        for name, gesture in gestures.items()
        for parts in zip(
            *(
                _stroke_reports(name, gesture, each, preset, sample_rate, tail)
                for each in timelines
            ),
            strict=True,
        )
    ]
    return FeelReport(preset.name, timelines[0].title, tuple(reports))


def require_gestures(gestures: object) -> None:
    """InputError unless these are gestures by name."""
    if not isinstance(gestures, Mapping):
        raise InputError(
            f"gestures is {shown(gestures)}; give them by name: {{'fast': ov.sweep(1.0)}}"
        )
    validation.instances(gestures.values(), Gesture, "gestures", "ov.sweep makes one")


def _stroke_reports(
    name: str,
    gesture: Gesture,
    timeline: Timeline,
    preset: Preset,
    sample_rate: float,
    tail: Tail,
) -> list[StrokeReport]:
    """The strokes of a gesture: out, and its recoil."""
    result = render(timeline, preset, gesture, sample_rate, tail=tail)
    trace = result.trace
    return [
        _stroke_report(
            name if stroke.name == "out" else f"{name} {stroke.name}",
            _until_arrived(stroke, trace.cursor),
            result,
        )
        for stroke in strokes(trace.engaged, trace.cursor)
    ]


def _held(gesture: Gesture) -> Gesture:
    """A gesture of one touch, up to where it lets go."""
    held = gesture.touching
    lift = float(gesture.time_s[~held][0])
    return Gesture(gesture.time_s[held], gesture.theta2[held], gesture.touching[held], lift)


def _combined(parts: Sequence[StrokeReport]) -> StrokeReport:
    """One stroke over several timelines with different kinds."""
    if len(parts) == 1:
        return parts[0]
    kinds = tuple(kind for part in parts for kind in part.kinds)
    level, sharpness, density, free = (
        float(np.median([getattr(part, name) for part in parts]))
        for name in ("level_db", "sharpness", "density_hz", "event_free_db")
    )
    return StrokeReport(parts[0].name, free, level, sharpness, density, kinds, alike_pairs(kinds))


def _until_arrived(stroke: Stroke, cursor: NDArray[np.float64]) -> Stroke:
    """The stroke up to where the disk is at its end: held there, nothing is felt."""
    way = cursor[stroke.start : stroke.stop]
    away = np.flatnonzero(np.abs(way - way[-1]) > ARRIVED)
    stop = stroke.start + int(away[-1]) + 2 if len(away) else stroke.stop
    return Stroke(stroke.name, stroke.start, min(stop, stroke.stop))


def _stroke_report(name: str, stroke: Stroke, result: Result) -> StrokeReport:
    trace, surface = result.trace, result.engine.surface
    felt = stroke_feel(stroke, surface, trace, result.samples[:, 1], result.sample_rate)
    weight = pacinian_db(result.engine.preset.number("tactor.frequency_hz"))
    struck = _strikes_in(stroke, result)
    names = np.array(surface.kind_names)[surface.kind]
    durations = _durations(stroke, result, felt.event_free_db)
    clicks = _clicks(struck, result)
    near = _merged(struck)
    found = []
    for kind in dict.fromkeys(names.tolist()):
        rows = np.flatnonzero(names == kind)
        rows = rows[np.isfinite(felt.event_db[rows])]
        level = felt.event_db[rows]
        events = surface.event[rows]
        click = np.array([clicks.get(int(event), math.nan) for event in events])
        found.append(
            KindFeel(
                kind,
                len(rows),
                _median(level) + weight,
                _median(level) - felt.event_free_db,
                _median(felt.rise[rows]),
                _median(durations[rows]),
                _median(click),
                int(np.count_nonzero(level - felt.event_free_db < STEP_DB)),
                sum(int(event) in near for event in events),
            )
        )
    return StrokeReport(
        name,
        felt.event_free_db + weight,
        *_character(stroke, result, weight),
        tuple(found),
        alike_pairs(found),
    )


def _character(stroke: Stroke, result: Result, weight: float) -> tuple[float, float, float]:
    """Level (dB), sharpness (N m/s) and density (a second) of all that is felt in a stroke."""
    trace, rate = result.trace, result.sample_rate
    level = window_db(result.samples[stroke.start : stroke.stop, 1], rate, KNOCK_HOP_S)[1]
    if not len(level):
        return math.nan, math.nan, 0.0
    peaks = knocks(level)
    slope = np.abs(np.diff(np.abs(trace.torque[stroke.start : stroke.stop]))) * rate
    edges = np.arange(0, max(1, len(slope) - 1), max(1, round(0.1 * rate)))
    steepest = np.maximum.reduceat(slope, edges) if len(slope) else np.zeros(1)
    seconds = (stroke.stop - stroke.start) / rate
    return float(np.median(level)) + weight, float(np.median(steepest)), len(peaks) / seconds


def _median(values: NDArray[np.float64]) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else math.nan


def _strikes_in(stroke: Stroke, result: Result) -> list[tuple[float, int]]:
    rate = result.sample_rate
    strikes = result.strikes.of_events()
    return [
        (float(at), int(event))
        for at, event in zip(strikes.time_s, strikes.event, strict=True)
        if stroke.start <= at * rate < stroke.stop
    ]


def _merged(struck: list[tuple[float, int]]) -> set[int]:
    """Events that strike so soon before or after another one that both are felt as one."""
    found: set[int] = set()
    for (at, event), (then, other) in itertools.pairwise(struck):
        if then - at < MERGED_S and event != other:
            found |= {event, other}
    return found


def _clicks(struck: list[tuple[float, int]], result: Result) -> dict[int, float]:
    rate = result.sample_rate
    found: dict[int, float] = {}
    for at, event in struck:
        first = max(0, round((at - _CLICK_BEFORE_S) * rate))
        samples = result.samples[first : round((at + _CLICK_AFTER_S) * rate), 0]
        level = window_db(samples, rate, 0.001)[1]
        if len(level):
            found[event] = float(level.max())
    return found


def _durations(stroke: Stroke, result: Result, free_db: float) -> NDArray[np.float64]:
    """How long each event's level stays near its highest, ms; a row a surface's event."""
    trace, surface = result.trace, result.engine.surface
    cursor = trace.cursor[stroke.start : stroke.stop]
    hop = FELT_WINDOW_S / 10.0
    starts, level = window_db(
        result.samples[stroke.start : stroke.stop, 1], result.sample_rate, hop
    )
    middle = np.minimum((starts + 0.5 * FELT_WINDOW_S * result.sample_rate), len(cursor) - 1)
    place = cursor[middle.astype(np.int64)]
    found = np.full(len(surface.position), np.nan)
    for i, (first, last) in enumerate(surface.span):
        inside = np.flatnonzero((place >= first) & (place <= last))
        if not len(inside):
            continue
        peak = inside[np.argmax(level[inside])]
        low = high = int(peak)
        contrast = level[peak] - free_db
        least = level[peak] - (min(FALL_DB, 0.5 * contrast) if contrast > 0.0 else FALL_DB)
        while low > 0 and level[low - 1] >= least:
            low -= 1
        while high + 1 < len(level) and level[high + 1] >= least:
            high += 1
        found[i] = (high - low + 1) * hop * 1000.0
    return found
