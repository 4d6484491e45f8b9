"""Feel report: level, contrast, sharpness and click of each kind of event, by stroke.

A report groups the rows of `felt_events` by stroke and kind, over all timelines. Levels are
weighted by the skin's sensitivity at the carrier's frequency (`pacinian_db`).

Just noticeable differences (JNDs) are 2.3 dB of level (Israr and Tan 2006: 2.2 to 2.5 dB), a ratio
of 1.25 of duration (from the same authors' 0.2 to 0.25 for frequency) and a factor of two in
sharpness (an assumption: no study measured it for such pulses). Pulses within 30 ms are felt as
one. An event less than one JND above the level between the events is masked.

Kinds may have an order of importance. It holds where the median of each kind is one JND above the
next.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from overview_dsp import validation
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.gestures import Gesture
from overview_dsp.design.presets.model import Preset
from overview_dsp.kernels.derive import ARRIVAL_S
from overview_dsp.measure import perception
from overview_dsp.measure.event_table import HALF_WINDOW_MS, FeltEvents, felt_events
from overview_dsp.measure.perceived_level import GESTURES
from overview_dsp.measure.report_base import Report, cell, entry_named
from overview_dsp.offline.rendering.schedule import Tail
from overview_dsp.public import counted, short
from overview_dsp.signal.actuators.model import pacinian_db

LOW, HIGH = 10.0, 90.0  # percentiles of the spread of a kind's levels


@dataclass(frozen=True)
class KindFeel:
    """One kind of event in one stroke: medians over its events; NaN without any.

    Attributes
    ----------
    kind : str
        Name.
    events, missed : int
        Number of events, and number of those that the disk never reached.
    level_db, low_db, high_db : float
        Highest RMS over 10 ms on the event, dB of full scale, weighted by the skin's sensitivity:
        median, tenth and ninetieth percentile.
    contrast_db : float
        Level above the median level between the events, dB.
    sharpness : float
        Steepest rise of the torque, N m/s.
    duration_ms : float
        Time that the level stays near its highest, ms.
    click_db : float
        Highest RMS over 10 ms of the click, dB of full scale.
    lag_ms : float
        Time between click and felt pulse, ms.
    masked, merged, lost : int
        Events less than one JND above the level between the events; events struck within 30 ms of
        another one; and those of them that are hidden by the friction of the other one.

    Examples
    --------
    >>> report = ov.measure.feel_report(football, match, {"fast": ov.sweep(1.0)}, 8000)
    >>> goal = report.strokes[0].kind("goal")
    >>> goal.events, goal.missed, goal.low_db <= goal.level_db
    (5, 0, True)
    """

    kind: str
    events: int
    missed: int
    level_db: float
    low_db: float
    high_db: float
    contrast_db: float
    sharpness: float
    duration_ms: float
    click_db: float
    lag_ms: float
    masked: int
    merged: int
    lost: int

    @property
    def passed(self) -> int:
        """Number of events that the disk passed."""
        return self.events - self.missed

    def __repr__(self) -> str:
        return (
            f"<KindFeel {short(self.kind)}: {counted(self.events, 'event')}, "
            f"{self.level_db:.1f} dB, {self.contrast_db:.1f} dB of contrast, "
            f"{self.duration_ms:.0f} ms>"
        )


@dataclass(frozen=True)
class StrokeReport:
    """One stroke of one gesture over all timelines.

    Attributes
    ----------
    name : str
        `slow`, `slow recoil`, ..., `tap`, `tap recoil`.
    event_free_db : float
        Weighted median level outside all events, dB of full scale.
    level_db : float
        Weighted median level of the whole stroke, dB of full scale.
    sharpness : float
        Steepest rise of the torque in the median tenth of a second, N m/s.
    density_hz : float
        Pulses per second that are felt separately: at least one JND high, 30 ms from each other.
    kinds : tuple of KindFeel
        Kinds in the order of importance; without one, in the order of the surface.
    indistinct : tuple of (str, str, float)
        Pairs of kinds that differ by less than one JND in level, sharpness and duration, and their
        distance in JNDs.
    gaps : tuple of (str, str, float)
        Each kind, the next one in the order of importance, and the JNDs between their median
        levels.
    lost : tuple of (str, str, int)
        Each kind that is lost, the kind that hides it, and the number of events.

    Examples
    --------
    >>> report = ov.measure.feel_report(football, match, {"fast": ov.sweep(1.0)}, 8000)
    >>> report.strokes[0].name
    'fast'
    """

    name: str
    event_free_db: float
    level_db: float
    sharpness: float
    density_hz: float
    kinds: tuple[KindFeel, ...]
    indistinct: tuple[tuple[str, str, float], ...] = field(metadata={"digits": 2})
    gaps: tuple[tuple[str, str, float], ...]
    lost: tuple[tuple[str, str, int], ...]

    def kind(self, name: str) -> KindFeel:
        """Find a kind by its name.

        Parameters
        ----------
        name : str
            Name of a kind of the timelines.

        Returns
        -------
        KindFeel
            Entry of that name.

        Raises
        ------
        InputError
            There is no such name.

        Examples
        --------
        >>> report = ov.measure.feel_report(football, match, {"fast": ov.sweep(1.0)}, 8000)
        >>> report.strokes[0].kind("foul").kind
        'foul'
        """
        return entry_named(name, {one.kind: one for one in self.kinds}, "kind")

    def __repr__(self) -> str:
        return (
            f"<StrokeReport {short(self.name)}: {self.level_db:.1f} dB, "
            f"{counted(len(self.kinds), 'kind')}, "
            f"{counted(len(self.indistinct), 'indistinct pair')}>"
        )


def _spread(kind: KindFeel, width: int) -> str:
    return f"{f'{cell(kind.low_db, 0, 0)} .. {cell(kind.high_db, 0, 0)}':>{width}}"


_COLUMNS: tuple[tuple[str, str, int, Callable[[KindFeel, int], str]], ...] = (
    ("events", "", 7, lambda kind, width: f"{kind.events:>{width}}"),
    ("missed", "", 8, lambda kind, width: f"{kind.missed:>{width}}"),
    ("masked", "", 8, lambda kind, width: f"{kind.masked:>{width}}"),
    ("merged", "", 8, lambda kind, width: f"{kind.merged:>{width}}"),
    ("lost", "", 6, lambda kind, width: f"{kind.lost:>{width}}"),
    ("level", "dB", 8, lambda kind, width: cell(kind.level_db, width)),
    ("10 to 90 %", "dB", 12, _spread),
    ("contrast", "dB", 10, lambda kind, width: cell(kind.contrast_db, width)),
    ("sharpness", "N m/s", 11, lambda kind, width: cell(kind.sharpness, width, 3)),
    ("lasts", "ms", 7, lambda kind, width: cell(kind.duration_ms, width, 0)),
    ("click", "dB", 8, lambda kind, width: cell(kind.click_db, width)),
    ("lag", "ms", 5, lambda kind, width: cell(kind.lag_ms, width, 0)),
)
"""Columns of the table: heading, unit, width and text."""


@dataclass(frozen=True)
class FeelReport(Report):
    """Measurements of a preset on timelines.

    Attributes
    ----------
    preset : str
        The preset's name.
    timelines : tuple of str
        The timelines' titles.
    strokes : tuple of StrokeReport
        Outward stroke and recoil of each gesture.

    See Also
    --------
    feel_report : Makes a report.

    Examples
    --------
    >>> report = ov.measure.feel_report(football, match, {"fast": ov.sweep(1.0)}, 8000)
    >>> report.preset, len(report.timelines)
    ('football', 1)
    """

    preset: str
    timelines: tuple[str, ...]
    strokes: tuple[StrokeReport, ...]

    def stroke(self, name: str) -> StrokeReport:
        """Find a stroke by its name.

        Parameters
        ----------
        name : str
            Name, such as `fast recoil`.

        Returns
        -------
        StrokeReport
            Entry of that name.

        Raises
        ------
        InputError
            There is no such name.

        Examples
        --------
        >>> report = ov.measure.feel_report(football, match, {"fast": ov.sweep(1.0)}, 8000)
        >>> report.stroke("fast recoil").name
        'fast recoil'
        """
        return entry_named(name, {stroke.name: stroke for stroke in self.strokes}, "stroke")

    def _lines(self) -> Iterator[str]:
        titles = [title or "a timeline" for title in dict.fromkeys(self.timelines)]
        where = titles[0] if len(titles) == 1 else counted(len(titles), "timeline")
        yield f"{self.preset} on {where}"
        yield " " * 22 + "".join(f"{heading:>{width}}" for heading, _, width, _ in _COLUMNS)
        yield " " * 22 + "".join(f"{unit:>{width}}" for _, unit, width, _ in _COLUMNS)
        for stroke in self.strokes:
            yield f"{stroke.name}: {stroke.event_free_db:.1f} dB between the events"
            for kind in stroke.kinds:
                cells = (text(kind, width) for _, _, width, text in _COLUMNS)
                yield f"  {kind.kind[:20]:<20}{''.join(cells)}"
            if stroke.gaps:
                gaps = (f"{a} > {b} by {gap:.1f}" for a, b, gap in stroke.gaps)
                yield f"  JNDs: {'; '.join(gaps)}"
            if stroke.lost:
                lost = (f"{a} beside {b}: {n}" for a, b, n in stroke.lost)
                yield f"  lost: {', '.join(lost)}"

    def _warning_lines(self) -> Iterator[str]:
        masked: dict[str, list[str]] = {}
        indistinct: dict[tuple[str, str], list[str]] = {}
        gaps: dict[tuple[str, str], list[str]] = {}
        for stroke in self.strokes:
            for kind in stroke.kinds:
                if 2 * kind.masked > kind.passed:
                    masked.setdefault(kind.kind, []).append(stroke.name)
            for first, second, _ in stroke.indistinct:
                indistinct.setdefault((first, second), []).append(stroke.name)
            for first, second, steps in stroke.gaps:
                if not steps >= 1.0:  # NaN too
                    gaps.setdefault((first, second), []).append(f"{stroke.name} ({steps:.1f})")
        for name, where in masked.items():
            yield (
                f"{name} is hardly felt in {_listed(where)}: raise kinds.{name}.height, or "
                "lower surface.intensity_gain"
            )
        for (first, second), where in indistinct.items():
            yield (
                f"{first} and {second} feel the same in {_listed(where)}: move their heights or "
                "widths by a third, in opposite directions"
            )
        for (first, second), where in gaps.items():
            yield (
                f"{first} is less than one JND above {second} in {', '.join(where)}: raise "
                f"kinds.{first}.height, or run overview presets tune"
            )
        for stroke in self.strokes:
            if count := sum(kind.merged for kind in stroke.kinds):
                yield (
                    f"{count} events are within {1000.0 * perception.MERGED_S:.0f} ms of another "
                    f"in {stroke.name} and are felt as one with it: zoom in, or move more slowly"
                )
            missed = [f"{one.missed} {one.kind}" for one in stroke.kinds if one.missed]
            if missed:
                yield f"never passed in {stroke.name}: {', '.join(missed)}"

    def __repr__(self) -> str:
        return (
            f"<FeelReport: {short(self.preset)} on {counted(len(self.timelines), 'timeline')}, "
            f"{counted(len(self.strokes), 'stroke')}>"
        )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) < 8 else "every stroke"


def feel_report(
    preset: Preset,
    timelines: Timeline | Sequence[Timeline],
    gestures: Mapping[str, Gesture] = GESTURES,
    sample_rate: float = 48_000,
    recoils: bool = True,
    order: Sequence[str] | None = None,
    progress: Callable[[float], None] = lambda part: None,
) -> FeelReport:
    """Measure level, contrast, sharpness and click of a preset's kinds on timelines.

    Parameters
    ----------
    preset : Preset
        Preset that is measured.
    timelines : Timeline or sequence of Timeline
        Timelines with events; the report is over all of them.
    gestures : mapping of str to Gesture
        Gestures of one touch each, by name; default: slow, medium and fast sweeps and a tap.
    sample_rate : float
        Hz.
    recoils : bool
        Whether recoils are measured too.
    order : sequence of str or None
        Kinds, the most important first; other kinds follow by their friction. Each is expected to
        be one JND above the next. None: no order is expected.
    progress : callable
        Called with the completed share, 0 to 1.

    Returns
    -------
    FeelReport
        Level, contrast, sharpness, duration and click of each kind in each stroke, with the numbers
        of missed, masked, merged and lost events.

    Raises
    ------
    InputError
        No timelines, or an error of `render`.

    Examples
    --------
    >>> report = ov.measure.feel_report(football, match, {"fast": ov.sweep(1.0)}, 8000)
    >>> [stroke.name for stroke in report.strokes]
    ['fast', 'fast recoil']
    """
    several = [timelines] if isinstance(timelines, Timeline) else timelines
    tail: Tail = "rest" if recoils else ARRIVAL_S
    tables = felt_events(preset, several, gestures, sample_rate, tail, progress)
    weight = pacinian_db(preset.number("tactor.frequency_hz"))
    strokes: dict[str, list[FeltEvents]] = {}
    for one in tables:
        if recoils or one.stroke.name == "out":
            strokes.setdefault(one.name, []).append(one)
    kinds = list(dict.fromkeys(kind for one in tables for kind in one.kind.tolist()))
    if order is not None:
        all_kinds, release = _column(tables, "kind"), _column(tables, "release")
        kinds.sort(key=lambda kind: -float(np.median(release[all_kinds == kind])))
        kinds = [*order, *(kind for kind in kinds if kind not in order)]
    return FeelReport(
        preset.name,
        tuple(one.timeline.title for one in next(iter(strokes.values()), [])),
        tuple(
            _stroke(name, parts, kinds, order is not None, weight)
            for name, parts in strokes.items()
        ),
    )


def _column(tables: Iterable[FeltEvents], name: str) -> Any:
    return np.concatenate([getattr(one, name) for one in tables])


def _stroke(
    name: str, tables: Sequence[FeltEvents], names: Sequence[str], ordered: bool, weight: float
) -> StrokeReport:
    column = functools.partial(_column, tables)
    kind, lost_to, level = column("kind"), column("lost_to"), column("level_db")
    kinds = []
    for one in names:
        rows = kind == one
        felt = level[rows & np.isfinite(level)] + weight
        low, high = np.percentile(felt, [LOW, HIGH]).tolist() if len(felt) else [math.nan] * 2
        if rows.any():
            kinds.append(
                KindFeel(
                    kind=one,
                    events=int(rows.sum()),
                    missed=int(rows.sum()) - len(felt),
                    level_db=_median(felt),
                    low_db=low,
                    high_db=high,
                    contrast_db=_median(column("contrast_db")[rows]),
                    sharpness=_median(column("sharpness")[rows]),
                    duration_ms=_median(column("duration_ms")[rows]),
                    click_db=_median(column("click_db")[rows]),
                    lag_ms=_median(column("click_lag_ms")[rows]),
                    masked=int(column("masked")[rows].sum()),
                    merged=int(column("merged")[rows].sum()),
                    lost=int((lost_to[rows] != "").sum()),
                )
            )
    pairs = Counter((a, b) for a, b in zip(kind.tolist(), lost_to.tolist(), strict=True) if b)
    features = [_stroke_features(one) for one in tables]
    level_db, sharpness, density = np.median(features, axis=0).tolist()
    return StrokeReport(
        name,
        _median([one.free_db for one in tables]) + weight,
        level_db + weight,
        sharpness,
        density,
        tuple(kinds),
        tuple(
            (first.kind, second.kind, distance)
            for first, second in itertools.combinations(kinds, 2)
            if first.passed and second.passed and (distance := jnd_distance(first, second)) < 1.0
        ),
        tuple(
            (first.kind, second.kind, (first.level_db - second.level_db) / perception.JND_DB)
            for first, second in itertools.pairwise(kinds)
            if ordered
        ),
        tuple((a, b, n) for (a, b), n in pairs.most_common()),
    )


def _median(values: Any) -> float:
    known = np.asarray(values)[np.isfinite(values)]
    return float(np.median(known)) if len(known) else math.nan


def _stroke_features(one: FeltEvents) -> tuple[float, float, float]:
    """Return level (dB), sharpness (N m/s) and density (per second) of a stroke."""
    end = int(1e3 * one.arrived_s) - HALF_WINDOW_MS
    level = one.level[HALF_WINDOW_MS : end : round(perception.PULSE_HOP_S * 1e3)]
    if not len(level):
        return math.nan, one.slope, 0.0
    return float(np.median(level)), one.slope, len(perception.pulse_indices(level)) / one.arrived_s


def jnd_distance(first: KindFeel, second: KindFeel) -> float:
    """Return the JNDs between two kinds, of the quantity that differs most.

    Parameters
    ----------
    first, second : KindFeel
        Kinds of one stroke.

    Returns
    -------
    float
        JNDs of level, of sharpness or of duration.

    Examples
    --------
    >>> report = ov.measure.feel_report(football, match, {"fast": ov.sweep(1.0)}, 8000)
    >>> kind = report.strokes[0].kinds[0]
    >>> ov.measure.jnd_distance(kind, kind)
    0.0
    """
    for kind in (first, second):
        validation.instance(kind, KindFeel, "a kind", "the strokes of a feel report have them")
    steps = [
        abs(first.level_db - second.level_db) / perception.JND_DB,
        perception.ratio_jnds(first.sharpness, second.sharpness, perception.JND_SHARPNESS),
        perception.ratio_jnds(first.duration_ms, second.duration_ms, perception.JND_DURATION),
    ]
    return max((step for step in steps if math.isfinite(step)), default=0.0)


def character_distance(first: FeelReport, second: FeelReport) -> float:
    """Return the JNDs between two presets on one timeline.

    The result is the largest of the medians over all strokes in level, sharpness and density. All
    recoils count as one stroke, since they are similar after any gesture.

    Parameters
    ----------
    first, second : FeelReport
        Reports of the same gestures.

    Returns
    -------
    float
        Number of JNDs.

    Examples
    --------
    >>> report = ov.measure.feel_report(football, match, {"fast": ov.sweep(1.0)}, 8000)
    >>> ov.measure.character_distance(report, report)
    0.0
    """
    for report in (first, second):
        validation.instance(report, FeelReport, "a report", "ov.measure.feel_report makes one")
    validation.equally_long("the reports' strokes", first.strokes, second.strokes)
    return jnds_over_strokes(
        {
            one.name: (
                abs(one.level_db - other.level_db) / perception.JND_DB,
                perception.ratio_jnds(one.sharpness, other.sharpness, perception.JND_SHARPNESS),
                # one pulse per second is the lowest density that is a rhythm
                perception.ratio_jnds(
                    one.density_hz + 1.0, other.density_hz + 1.0, perception.JND_DURATION
                ),
            )
            for one, other in zip(first.strokes, second.strokes, strict=True)
        }
    )


def jnds_over_strokes(differences: Mapping[str, Any]) -> float:
    """Return the largest median of JNDs over strokes; the recoils count as one stroke."""
    table = {name: np.array(steps) for name, steps in differences.items()}
    each = [steps for name, steps in table.items() if not name.endswith("recoil")]
    recoils = [steps for name, steps in table.items() if name.endswith("recoil")]
    if recoils:
        each.append(_known_median(recoils))
    return float(np.nanmax(np.append(_known_median(each), 0.0)))


def _known_median(rows: Sequence[Any]) -> Any:
    """Return the median of each column with mostly finite values; NaN for the others."""
    table = np.array(rows)
    known = np.isfinite(table).sum(axis=0) > len(rows) / 2
    median = np.full(table.shape[1], np.nan)
    median[known] = np.nanmedian(table[:, known], axis=0)
    return median
