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
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.actuators.sensitivity import pacinian_db
from overview_dsp.gestures import Gesture, sweep, tap
from overview_dsp.measure.apart import HOP_S, knocks
from overview_dsp.measure.felt import WINDOW_S, Stroke, stroke_feel, strokes, window_db
from overview_dsp.presets.model import Preset
from overview_dsp.public.reprs import counted, short
from overview_dsp.rendering.offline import Result, render
from overview_dsp.rendering.schedule import Tail
from overview_dsp.timeline import Timeline

STEP_DB = 2.3
STEP_DURATION = 1.25
STEP_SHARPNESS = 2.0
MERGED_S = 0.030
FALL_DB = 6.0

ARRIVED = 0.005
"""So near to its end, as a part of the timeline, a stroke is over."""

GESTURES: Mapping[str, Gesture] = {
    "slow": sweep(6.0),
    "medium": sweep(3.0),
    "fast": sweep(1.0),
    "tap": tap(1.0, 3.0),
}
"""Slow, medium and fast sweeps over all of the timeline, and a tap at its end."""

_CLICK_BEFORE_S, _CLICK_AFTER_S = 0.005, 0.060


@dataclass(frozen=True)
class KindFeel:
    """One kind of event in one stroke: medians over its events; NaN where none was felt.

    Attributes
    ----------
    kind : str
        Its name.
    events : int
        How many were felt.
    level_db : float
        Highest RMS over 10 ms on the event, dB of full scale, weighted by the skin's sensitivity.
    contrast_db : float
        Above the median of all that is no event, dB.
    sharpness : float
        Steepest rise of the torque, N m/s.
    duration_ms : float
        How long the level stays near its highest, ms.
    click_db : float
        Highest RMS over 10 ms of the click, dB of full scale.
    masked, merged : int
        Events less than a step above the rest, and within 30 ms of another one.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    >>> sweeps = {"fast": ov.sweep(1.0)}
    >>> report = ov.measure.feel_report(football, match, sweeps, sample_rate=8000)
    >>> report.strokes[0].kinds[0].kind
    'period'
    """

    kind: str
    events: int
    level_db: float
    contrast_db: float
    sharpness: float
    duration_ms: float
    click_db: float
    masked: int
    merged: int

    def __repr__(self) -> str:
        return (
            f"<KindFeel {short(self.kind)}: {counted(self.events, 'event')}, "
            f"{self.level_db:.1f} dB, {self.contrast_db:.1f} dB above the rest, "
            f"{self.duration_ms:.0f} ms>"
        )


@dataclass(frozen=True)
class StrokeReport:
    """One stroke of one gesture.

    Attributes
    ----------
    name : str
        `slow`, `slow recoil`, ..., `tap`, `tap recoil`.
    event_free_db : float
        Weighted median level outside all events, dB of full scale.
    level_db : float
        Weighted median level of all of it, dB of full scale.
    sharpness : float
        Steepest rise of the torque in the median tenth of a second, N m/s.
    density_hz : float
        Pulses that are felt apart, a second: peaks a step above their surroundings, 30 ms apart.
    kinds : tuple of KindFeel
        In the order of the surface.
    alike : tuple of (str, str, float)
        Pairs of kinds less than a step apart in level, sharpness and duration, and how far they
        are.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    >>> sweeps = {"fast": ov.sweep(1.0)}
    >>> report = ov.measure.feel_report(football, match, sweeps, sample_rate=8000)
    >>> report.strokes[0].name
    'fast'
    """

    name: str
    event_free_db: float
    level_db: float
    sharpness: float
    density_hz: float
    kinds: tuple[KindFeel, ...]
    alike: tuple[tuple[str, str, float], ...]

    def __repr__(self) -> str:
        return (
            f"<StrokeReport {short(self.name)}: {self.level_db:.1f} dB, "
            f"{counted(len(self.kinds), 'kind')}, {counted(len(self.alike), 'pair')} alike>"
        )


@dataclass(frozen=True)
class FeelReport:
    """How a preset feels on a timeline.

    Attributes
    ----------
    preset, timeline : str
        The preset's name and the timeline's title.
    strokes : tuple of StrokeReport
        Each gesture's way out, and its recoil.

    See Also
    --------
    feel_report : Makes one.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    >>> sweeps = {"fast": ov.sweep(1.0)}
    >>> report = ov.measure.feel_report(football, match, sweeps, sample_rate=8000)
    >>> report.preset
    'football'
    """

    preset: str
    timeline: str
    strokes: tuple[StrokeReport, ...]

    def stroke(self, name: str) -> StrokeReport:
        """Find a stroke by its name.

        Parameters
        ----------
        name : str
            `fast`, `fast recoil`, say.

        Returns
        -------
        StrokeReport
            That one.

        Raises
        ------
        StopIteration
            There is none.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> sweeps = {"fast": ov.sweep(1.0)}
        >>> report = ov.measure.feel_report(football, match, sweeps, sample_rate=8000)
        >>> report.stroke("fast recoil").name
        'fast recoil'
        """
        return next(stroke for stroke in self.strokes if stroke.name == name)

    def to_json(self) -> dict[str, Any]:
        """Make plain data of it; what was not felt is None.

        Returns
        -------
        dict
            Of texts, numbers and lists, for JSON.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> sweeps = {"fast": ov.sweep(1.0)}
        >>> report = ov.measure.feel_report(football, match, sweeps, sample_rate=8000)
        >>> sorted(report.to_json())
        ['preset', 'strokes', 'timeline']
        """
        return {
            "preset": self.preset,
            "timeline": self.timeline,
            "strokes": [
                {
                    "name": stroke.name,
                    "event_free_db": _rounded(stroke.event_free_db),
                    "level_db": _rounded(stroke.level_db),
                    "sharpness": _rounded(stroke.sharpness),
                    "density_hz": _rounded(stroke.density_hz),
                    "kinds": [
                        {key: _rounded(value) for key, value in vars(kind).items()}
                        for kind in stroke.kinds
                    ],
                    "alike": [[a, b, round(steps, 2)] for a, b, steps in stroke.alike],
                }
                for stroke in self.strokes
            ],
        }

    def table(self) -> str:
        """Write the report as text: a block a stroke.

        Returns
        -------
        str
            Of many lines.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> sweeps = {"fast": ov.sweep(1.0)}
        >>> report = ov.measure.feel_report(football, match, sweeps, sample_rate=8000)
        >>> report.table().splitlines()[0]
        'football on France 4-2 Croatia, World Cup final, Moscow, 15 July 2018'
        """
        lines = [f"{self.preset} on {self.timeline or 'a timeline'}"]
        lines.append(
            f"{'':<28}{'level':>8}{'contrast':>10}{'sharpness':>11}{'lasts':>8}{'click':>8}"
            f"{'masked':>8}{'merged':>8}"
        )
        lines.append(f"{'':<28}{'dB':>8}{'dB':>10}{'N m/s':>11}{'ms':>8}{'dB':>8}")
        for stroke in self.strokes:
            lines.append(f"{stroke.name}: {stroke.event_free_db:.1f} dB between the events")
            lines += [
                f"  {kind.kind[:20]:<20}{kind.events:>5} {_cell(kind.level_db, 8, 1)}"
                f"{_cell(kind.contrast_db, 10, 1)}{_cell(kind.sharpness, 11, 3)}"
                f"{_cell(kind.duration_ms, 8, 0)}{_cell(kind.click_db, 8, 1)}"
                f"{kind.masked:>8}{kind.merged:>8}"
                for kind in stroke.kinds
            ]
        return "\n".join(lines)

    def warnings(self) -> list[str]:
        """List what a person would miss.

        Returns
        -------
        list of str
            Each a line that says what to change.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
        >>> sweeps = {"fast": ov.sweep(1.0)}
        >>> report = ov.measure.feel_report(football, match, sweeps, sample_rate=8000)
        >>> all(isinstance(line, str) for line in report.warnings())
        True
        """
        lines: list[str] = []
        for name in dict.fromkeys(kind.kind for stroke in self.strokes for kind in stroke.kinds):
            masked = [
                stroke.name
                for stroke in self.strokes
                for kind in stroke.kinds
                if kind.kind == name and 2 * kind.masked > kind.events
            ]
            if masked:
                lines.append(
                    f"{name} is hardly felt in {_listed(masked)}: raise kinds.{name}.height, or "
                    "lower surface.ambience"
                )
        pairs: dict[tuple[str, str], list[str]] = {}
        for stroke in self.strokes:
            for first, second, _ in stroke.alike:
                pairs.setdefault((first, second), []).append(stroke.name)
        for (first, second), where in pairs.items():
            lines.append(
                f"{first} and {second} feel alike in {_listed(where)}: move their heights or "
                "widths apart by a third"
            )
        merged = {stroke.name: sum(kind.merged for kind in stroke.kinds) for stroke in self.strokes}
        for name, count in merged.items():
            if count:
                lines.append(
                    f"{count} events come within {1000.0 * MERGED_S:.0f} ms of another in {name} "
                    "and are felt as one with it: zoom in, or move more slowly"
                )
        return lines

    def __repr__(self) -> str:
        return (
            f"<FeelReport: {short(self.preset)} on {short(self.timeline)}, "
            f"{counted(len(self.strokes), 'stroke')}>"
        )


def _cell(value: float, width: int, digits: int) -> str:
    if not math.isfinite(value):
        return f"{'-':>{width}}"
    text = f"{value:.{digits}f}" if abs(value) < 1e4 else f"{value:.3g}"
    return f"{text:>{width}}"


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) < 8 else "every stroke"


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return round(value, 4) if math.isfinite(value) else None
    return value


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
    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    >>> sweeps = {"fast": ov.sweep(1.0)}
    >>> report = ov.measure.feel_report(football, match, sweeps, sample_rate=8000)
    >>> [stroke.name for stroke in report.strokes]
    ['fast', 'fast recoil']
    """
    if not recoils:
        gestures = {name: _held(gesture) for name, gesture in gestures.items()}
    tail: Tail = "rest" if recoils else "none"
    timelines = [timeline] if isinstance(timeline, Timeline) else list(timeline)
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
        for stroke in strokes(trace.touching, trace.cursor)
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
    return StrokeReport(parts[0].name, free, level, sharpness, density, kinds, _alike(kinds))


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
        _alike(found),
    )


def _alike(kinds: Sequence[KindFeel]) -> tuple[tuple[str, str, float], ...]:
    return tuple(
        (first.kind, second.kind, apart)
        for first, second in itertools.combinations(kinds, 2)
        if first.events and second.events and (apart := steps_apart(first, second)) < 1.0
    )


def _character(stroke: Stroke, result: Result, weight: float) -> tuple[float, float, float]:
    """Level (dB), sharpness (N m/s) and density (a second) of all that is felt in a stroke."""
    trace, rate = result.trace, result.sample_rate
    level = window_db(result.samples[stroke.start : stroke.stop, 1], rate, HOP_S)[1]
    if not len(level):
        return math.nan, math.nan, 0.0
    peaks = knocks(level)
    slope = np.abs(np.diff(np.abs(trace.torque[stroke.start : stroke.stop]))) * rate
    edges = np.arange(0, max(1, len(slope) - 1), max(1, round(0.1 * rate)))
    steepest = np.maximum.reduceat(slope, edges) if len(slope) else np.zeros(1)
    seconds = (stroke.stop - stroke.start) / rate
    return float(np.median(level)) + weight, float(np.median(steepest)), len(peaks) / seconds


def character_steps(first: FeelReport, second: FeelReport) -> float:
    """Count the just noticeable steps between two presets on one timeline.

    In what they differ most in: the medians of the steps in level, in sharpness and in density
    over all strokes; the recoils, which are much the same after any gesture, count as one.

    Parameters
    ----------
    first, second : FeelReport
        Of the same gestures.

    Returns
    -------
    float
        Steps.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    >>> sweeps = {"fast": ov.sweep(1.0)}
    >>> report = ov.measure.feel_report(football, match, sweeps, sample_rate=8000)
    >>> ov.measure.character_steps(report, report)
    0.0
    """
    differences = np.array(
        [
            _character_differences(one, other)
            for one, other in zip(first.strokes, second.strokes, strict=True)
        ]
    )
    recoils = np.array([stroke.name.endswith("recoil") for stroke in first.strokes])
    each = [*differences[~recoils], np.nanmedian(differences[recoils], axis=0)]
    return float(np.nanmax(np.nanmedian(each, axis=0)))


def _character_differences(one: StrokeReport, other: StrokeReport) -> tuple[float, float, float]:
    return (
        abs(one.level_db - other.level_db) / STEP_DB,
        _ratio_steps(one.sharpness, other.sharpness, STEP_SHARPNESS),
        # a pulse a second is the least that is called a rhythm
        _ratio_steps(one.density_hz + 1.0, other.density_hz + 1.0, STEP_DURATION),
    )


def steps_apart(first: KindFeel, second: KindFeel) -> float:
    """Count the just noticeable steps between two kinds, in what they differ most in.

    Parameters
    ----------
    first, second : KindFeel
        Of one stroke.

    Returns
    -------
    float
        Steps of level, of sharpness or of duration.

    Examples
    --------
    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
    >>> sweeps = {"fast": ov.sweep(1.0)}
    >>> report = ov.measure.feel_report(football, match, sweeps, sample_rate=8000)
    >>> kind = report.strokes[0].kinds[0]
    >>> ov.measure.steps_apart(kind, kind)
    0.0
    """
    steps = [
        abs(first.level_db - second.level_db) / STEP_DB,
        _ratio_steps(first.sharpness, second.sharpness, STEP_SHARPNESS),
        _ratio_steps(first.duration_ms, second.duration_ms, STEP_DURATION),
    ]
    return max((step for step in steps if math.isfinite(step)), default=0.0)


def _ratio_steps(first: float, second: float, step: float) -> float:
    if not (first > 0.0 and second > 0.0):
        return math.nan
    return abs(math.log(first / second)) / math.log(step)


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
    hop = WINDOW_S / 10.0
    starts, level = window_db(
        result.samples[stroke.start : stroke.stop, 1], result.sample_rate, hop
    )
    middle = np.minimum((starts + 0.5 * WINDOW_S * result.sample_rate), len(cursor) - 1)
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
