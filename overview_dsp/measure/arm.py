"""Report of a preset under the movements of a human arm, compared with steady sweeps.

An arm speeds up, slows down, releases early and scrubs (`ov.arm`, `ov.flick`, `ov.scrub`). The
report lists the lag of the disk, the events that it never reaches, and whether the strongest kinds
are felt. It also lists where the disk turns back after a tap, whether it follows scrubbing, and the
felt range of the intensity curve.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from overview_dsp.arrays import BoolArray, FloatArray
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture, arm, flick, scrub, sweep, tap
from overview_dsp.design.gestures.scripts import APPROACH_REST_S, APPROACH_S
from overview_dsp.design.presets.model import Preset
from overview_dsp.measure import perception
from overview_dsp.measure.event_table import FLOOR_DB, FeltEvents, felt_events
from overview_dsp.measure.observer.scoring import GROUPS, MINOR
from overview_dsp.measure.report_base import Report, cell
from overview_dsp.offline.rendering.many import RenderedJob, RenderJob, render_many
from overview_dsp.offline.rendering.trace import Trace
from overview_dsp.public import counted, short
from overview_dsp.units import FELT_WINDOW_S

RATE = 16_000.0  # sample rate, Hz. The disk and its vibration do not depend on it.
TAIL_S = 3.0  # time rendered after the release, s, in which the disk arrives

STROKES: Mapping[str, Gesture] = {
    **{f"sweep {s} s": sweep(s) for s in (1, 2, 4, 6)},
    **{f"arm {s} s": arm(s) for s in (1, 2, 4, 6)},
    "flick 0.15 s": flick(0.15),
}
TAPS = (0.1, 0.25, 0.5, 0.75, 0.97)
TAP_S = 1.5
SCRUB_WIDTH, SCRUB_HZ = 0.02, (1.0, 2.0)
SCRUB_DB = -35.0  # lowest level of a pulse in scrubbing, dBFS: a typical foul in a sweep of 4 s
CURVE = "the curve"
CARD_MARGIN_DB, CARD_AFTER_S = 2.5, 600.0
_EDGE = 0.02  # share of the timeline at each end that the felt range leaves out

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class ArmStroke:
    """One gesture over all timelines.

    Attributes
    ----------
    name : str
        Name of the gesture, such as `arm 2 s`.
    events, missed : int
        Events that the finger passes; those that the disk never reaches.
    main, main_missed, main_felt : int
        Such events of the strongest kinds; those of them with a detected pulse that is stronger
        than all distant events of the weakest kind.
    lag_ms, lag_percent : tuple of float
        Median, 95th percentile and worst lag of the events that are reached, in ms and in per cent
        of the timeline.
    spread_db : float
        Strongest minus weakest event of the strongest kind in one timeline, dB; the worst.
    cards, cards_close : int
        Cards up to ten minutes after a goal; those less than 2.5 dB weaker.

    Examples
    --------
    >>> report = ov.measure.arm_report(football, [match], {"arm 2 s": ov.arm(2.0)})
    >>> report.strokes[0].name, report.strokes[0].main
    ('arm 2 s', 6)
    """

    name: str
    events: int
    missed: int
    main: int
    main_missed: int
    main_felt: int
    lag_ms: Triple
    lag_percent: Triple
    spread_db: float
    cards: int
    cards_close: int

    def __repr__(self) -> str:
        return f"<ArmStroke {short(self.name)}: {self.missed} of {self.events} events missed>"


@dataclass(frozen=True)
class ArmReport(Report):
    """Report of a preset under the movements of a human arm.

    Attributes
    ----------
    preset : str
        Name of the preset.
    timelines : int
        Number of timelines.
    main : tuple of str
        The strongest kinds.
    strokes : tuple of ArmStroke
        One per gesture.
    taps : tuple of (float, float)
        Target position of a tap of 1.5 s, and the position furthest from it where the disk turned
        back.
    scrubs : tuple of (float, int, int, int)
        Frequency in Hz; how often the finger crossed an event of the strongest kinds, how often the
        disk followed, and how often that was felt too.
    curve_db : tuple of (float, float)
        Felt range of the intensity curve in a sweep of 4 s, dB: lowest and median timeline; NaN
        without a curve.

    See Also
    --------
    arm_report : Makes a report.

    Examples
    --------
    >>> report = ov.measure.arm_report(football, [match], {"arm 2 s": ov.arm(2.0)})
    >>> report.main
    ('goal', 'own_goal')
    """

    preset: str
    timelines: int
    main: tuple[str, ...]
    strokes: tuple[ArmStroke, ...]
    taps: tuple[tuple[float, float], ...]
    scrubs: tuple[tuple[float, int, int, int], ...]
    curve_db: tuple[float, float]

    def _plain(self) -> dict[str, Any]:
        data = super()._plain()
        for stroke in data["strokes"]:
            for lag in ("lag_ms", "lag_percent"):
                stroke[lag] = dict(zip(("median", "p95", "worst"), stroke[lag], strict=True))
        for name, keys in (
            ("taps", ("target", "turns_back_at")),
            ("scrubs", ("hz", "crossings", "followed", "felt")),
        ):
            data[name] = [dict(zip(keys, row, strict=True)) for row in data[name]]
        data["curve_db"] = dict(zip(("lowest", "median"), data["curve_db"], strict=True))
        return data

    def _lines(self) -> Iterator[str]:
        timelines = counted(self.timelines, "timeline")
        yield f"{self.preset}, movements of an arm and sweeps: {timelines}"
        yield (
            f"{'':<14}{'lag, ms':>15}{'lag, %':>15}{'missed':>12}{'main missed':>13}{'felt':>10}"
            f"{'spread, dB':>12}{'cards close':>13}"
        )
        for one in self.strokes:
            ms = "/".join(cell(value, 0, 0) for value in one.lag_ms)
            percent = "/".join(cell(value, 0, 1) for value in one.lag_percent)
            missed = f"{one.missed} of {one.events}"
            yield (
                f"{one.name:<14}{ms:>15}{percent:>15}{missed:>12}"
                f"{f'{one.main_missed} of {one.main}':>13}{f'{one.main_felt} of {one.main}':>10}"
                f"{cell(one.spread_db, 12)}{f'{one.cards_close} of {one.cards}':>13}"
            )
        yield f"lag: median/95 %/worst of the events reached; main: {', '.join(self.main)}"
        for hz, crossings, followed, felt in self.scrubs:
            yield f"scrub {hz:g} Hz: {followed} of {crossings} crossings followed, {felt} felt"
        turns = ", ".join(f"{turn:.3f} for {target:g}" for target, turn in self.taps)
        if turns:
            yield f"a tap of {TAP_S:g} s turns back at {turns}"
        low, median = self.curve_db
        if median == median:  # not NaN
            yield f"curve felt in a sweep of 4 s: {median:.1f} dB (median), {low:.1f} dB (lowest)"

    def _warning_lines(self) -> Iterator[str]:
        for one in self.strokes:
            if one.missed:
                among = f", {one.main_missed} of the strongest kinds" if one.main_missed else ""
                yield f"{one.name} never reaches {one.missed} of {one.events} events{among}"
        for hz, crossings, _, felt in self.scrubs:
            if felt < crossings:
                yield f"scrubbing at {hz:g} Hz: {felt} of {crossings} crossings are felt"

    def __repr__(self) -> str:
        return f"<ArmReport: {short(self.preset)}, {counted(len(self.strokes), 'stroke')}>"


def arm_report(
    preset: Preset,
    timelines: Sequence[Timeline],
    gestures: Mapping[str, Gesture] = STROKES,
    progress: Callable[[float], None] = lambda part: None,
) -> ArmReport:
    """Measure a preset under the movements of a human arm, compared with steady sweeps.

    Parameters
    ----------
    preset : Preset
        Preset that is measured.
    timelines : sequence of Timeline
        Timelines with events.
    gestures : mapping of str to Gesture
        Gestures by name; default: sweeps and arms of 1 to 6 s and a flick.
    progress : callable
        Called with the completed share, 0 to 1.

    Returns
    -------
    ArmReport
        Lag, missed events, the strongest kinds, taps, scrubbing, the felt range of the curve.

    Raises
    ------
    InputError
        No timelines, or an error of `render`.

    Examples
    --------
    >>> report = ov.measure.arm_report(football, [match], {"sweep 2 s": ov.sweep(2.0)})
    >>> report.strokes[0].missed
    0
    """
    taps = {f"tap {target:g}": tap(target, TAP_S) for target in TAPS}
    all_gestures = {**gestures, **taps, CURVE: sweep(4.0)}
    parts = len(all_gestures) + len(SCRUB_HZ)
    tables = outward(
        preset, timelines, all_gestures, lambda part: progress(part * len(all_gestures) / parts)
    )
    main, weakest = main_kinds(preset, timelines)
    scrubs = []
    for done, hz in enumerate(SCRUB_HZ, 1):
        found = list(itertools.chain.from_iterable(scrubbed(preset, timelines, main, hz)))
        followed, felt = (sum(crossing[i] for crossing in found) for i in (0, 1))
        scrubs.append((hz, len(found), followed, felt))
        progress((len(all_gestures) + done) / parts)
    ranges = [felt_range_db(one) for one in tables[CURVE] if one.timeline.intensity is not None]
    known = [value for value in ranges if np.isfinite(value)] or [np.nan]
    return ArmReport(
        preset.name,
        len(timelines),
        main,
        tuple(_stroke(name, tables[name], main, weakest) for name in gestures),
        tuple(
            (target, max((one.turn for one in tables[name]), key=lambda turn: abs(turn - target)))
            for name, target in zip(taps, TAPS, strict=True)
        ),
        tuple(scrubs),
        (float(min(known)), float(np.median(known))),
    )


def main_kinds(preset: Preset, timelines: Iterable[Timeline]) -> tuple[tuple[str, ...], str]:
    """Return the strongest kinds of the timelines' events, and the weakest kind."""
    present = {event.kind for timeline in timelines for event in timeline.events}
    height = {
        kind: preset.kinds.get(kind, preset.kinds["default"]).height for kind in sorted(present)
    }
    if not height:
        return (), ""
    strongest, weakest = max(height, key=height.__getitem__), min(height, key=height.__getitem__)
    group = GROUPS.get(strongest, MINOR)
    others = (kind for kind in height if kind != strongest and GROUPS.get(kind) == group)
    return (strongest, *others), weakest


def outward(
    preset: Preset,
    timelines: Sequence[Timeline],
    gestures: Mapping[str, Gesture],
    progress: Callable[[float], None] = lambda part: None,
) -> dict[str, list[FeltEvents]]:
    """Return the events of each gesture's outward stroke over each timeline."""
    tables = felt_events(preset, timelines, gestures, RATE, TAIL_S, progress)
    out = [one for one in tables if one.stroke.name == "out"]
    return {name: [one for one in out if one.name == name] for name in gestures}


def percentiles(values: FloatArray) -> Triple:
    """Return median, 95th percentile and maximum of the finite values; NaN without any."""
    known = values[np.isfinite(values)]
    median, most, worst = np.percentile(known if len(known) else np.nan, [50.0, 95.0, 100.0])
    return float(median), float(most), float(worst)


def _stroke(
    name: str, tables: Sequence[FeltEvents], main: tuple[str, ...], weakest: str
) -> ArmStroke:
    cards = [over for one in tables for over in cards_over_goals(one)]
    passed = [one.of() for one in tables]
    strongest = [one.of(*main) & bool(main) for one in tables]
    return ArmStroke(
        name,
        _count(passed),
        _count(rows & ~one.reached for one, rows in zip(tables, passed, strict=True)),
        _count(strongest),
        _count(rows & ~one.reached for one, rows in zip(tables, strongest, strict=True)),
        _count(felt_above(one, rows, weakest) for one, rows in zip(tables, strongest, strict=True)),
        percentiles(np.concatenate([one.lag_ms[one.of()] for one in tables])),
        percentiles(np.concatenate([one.lag_percent[one.of()] for one in tables])),
        max((spread_db(one, main[0]) for one in tables), default=0.0) if main else 0.0,
        len(cards),
        sum(over > -CARD_MARGIN_DB for over in cards),
    )


def _count(parts: Iterable[BoolArray]) -> int:
    return sum(int(rows.sum()) for rows in parts)


def felt_above(one: FeltEvents, rows: BoolArray, weakest: str) -> BoolArray:
    """Return which rows are detected and stronger than every distant event of the weakest kind."""
    reached = one.reached & rows
    gap_s = perception.MIN_PULSE_GAP_MS / 1e3
    first_s, last_s = one.first_s[reached], one.last_s[reached]
    highest_db = -np.inf  # of the distant events of the weakest kind
    for row in np.flatnonzero(one.of(weakest) & one.reached & ~rows).tolist():
        near = (one.first_s[row] < last_s + gap_s) & (first_s < one.last_s[row] + gap_s)
        if not near.any():
            highest_db = max(highest_db, float(one.level_db[row]))
    level_db = np.nan_to_num(one.level_db, nan=-np.inf)
    return np.asarray(reached & one.detected & (level_db > highest_db))


def spread_db(one: FeltEvents, kind: str, last: float = 1.0) -> float:
    """Return strongest minus weakest event of a kind up to a position, dB; 0 without two."""
    known = one.level_db[one.of(kind) & one.reached & (one.position <= last)]
    return float(np.ptp(known)) if len(known) > 1 else 0.0


def cards_over_goals(one: FeltEvents) -> list[float]:
    """Return the level of each card over that of a goal up to ten minutes before it, dB."""
    group = np.array([GROUPS.get(kind, MINOR) for kind in one.kind.tolist()], dtype=str)
    met = one.passed & one.reached
    return [
        float(one.level_db[card] - one.level_db[goal])
        for goal in np.flatnonzero(met & (group == "goal"))
        for card in np.flatnonzero(met & (group == "card"))
        if 0.0 < one.time_s[card] - one.time_s[goal] < CARD_AFTER_S
    ]


def felt_range_db(one: FeltEvents) -> float:
    """Return the level in the upper fifth of the curve minus that in the lower fifth, dB.

    Levels are medians between the events. There a position is mapped to its time linearly, which
    is true of every angle map.
    """
    order = np.argsort(one.time_s, kind="stable")
    places = np.concatenate([[0.0], one.position[order], [1.0]])
    times = np.concatenate([[0.0], one.time_s[order], [one.timeline.duration_s]])

    def curve_at(position: FloatArray) -> FloatArray:
        return one.timeline.normalised_intensity_at(np.interp(position, places, times))

    course = np.maximum.accumulate(one.course)
    free = (course > _EDGE) & (course < 1.0 - _EDGE)
    at_ms = np.arange(len(course)) + 1e3 * one.stroke.start / one.sample_rate
    for first, last in zip(1e3 * one.first_s, 1e3 * one.last_s, strict=True):
        if np.isfinite(first):
            free &= (at_ms < first - 10) | (at_ms > last + perception.AFTER_MS)
    low, high = np.nanpercentile(curve_at(np.linspace(_EDGE, 1.0 - _EDGE, 1000)), [20.0, 80.0])
    curve, level = curve_at(course)[free], one.level[: len(course)][free]
    if not (curve >= high).any() or not (curve <= low).any():
        return float("nan")
    return float(np.median(level[curve >= high]) - np.median(level[curve <= low]))


def scrubbed(
    preset: Preset, timelines: Iterable[Timeline], main: tuple[str, ...], hz: float
) -> Iterator[list[tuple[bool, bool]]]:
    """Yield for each event of these kinds whether its crossings are followed, and felt."""
    from overview_dsp.signal.surface.build import build_surface

    jobs, rows = [], []
    for timeline in timelines:
        surface = build_surface(timeline, preset)
        for row, event in enumerate(surface.event.tolist()):
            if timeline.events[event].kind in main:
                gesture = scrub(float(surface.position[row]), SCRUB_WIDTH, hz)
                jobs.append(RenderJob(timeline, preset, gesture))
                rows.append(row)
    for done, row in zip(render_many(jobs, RATE, tail=0.5, trace=True), rows, strict=True):
        yield crossings(done, row, hz)


def crossings(done: RenderedJob[Trace], row: int, hz: float) -> list[tuple[bool, bool]]:
    """Return for each crossing of an event in scrubbing whether it is followed, and felt.

    The finger crosses in the middle of each half period. The disk follows if it crosses before the
    finger crosses again. It is felt if a pulse of the event of -35 dBFS or more occurs in between.
    """
    per_ms = done.sample_rate / 1e3
    course = done.trace.cursor
    cursor = course[np.arange(0.0, len(course), per_ms).astype(np.int64)]
    level = perception.levels(done.samples[:, 1], done.sample_rate, FELT_WINDOW_S, FLOOR_DB)
    start, end = done.surface.span[row]
    # in milliseconds, of all samples: a disk may pass a narrow event in less than one
    on = np.unique(np.flatnonzero((course >= start) & (course <= end)) // per_ms)
    pulses = perception.touch_pulses(level)
    pulses = pulses[level[pulses] >= SCRUB_DB]
    # the disk is on the event from 40 ms before a pulse to 15 ms after it
    next_on = np.append(on, np.inf)[np.searchsorted(on, pulses - perception.AFTER_MS)]
    pulses = pulses[next_on <= pulses + perception.BEFORE_MS]
    begin_s = APPROACH_S + APPROACH_REST_S
    found = []
    for crossing_s in np.arange(0.25, hz * (done.job.gesture.duration_s - begin_s) - 0.5, 0.5) / hz:
        first = int(1e3 * (begin_s + crossing_s))
        until = first + int(500.0 / hz)
        beyond = cursor[first:until] > done.surface.position[row]
        followed = bool(beyond.any() and not beyond.all())
        felt = ((pulses >= first) & (pulses < until)).any()
        found.append((followed, followed and bool(felt)))
    return found
