"""What a person gets of each kind of event, stroke by stroke, and what can't be distinguished.

A report groups the rows of `felt_events` by stroke and kind, over all timelines. Levels are
weighted by the skin's sensitivity at the carrier's frequency (`pacinian_db`).

Steps: 2.3 dB of level (Israr and Tan 2006: 2.2 to 2.5 dB); a quarter of duration (0.2 to 0.25 is
what touch needs for frequency, the same authors); a factor of two in sharpness (our own rule: no
study gives one for such pulses). Pulses within 30 ms are felt as one. An event less than a step
above the rest is masked.

Kinds may have an order of importance; it is kept where each kind's median is a step above the next
one's.
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
from overview_dsp.measure.event_table import NEAR_MS, FeltEvents, felt_events
from overview_dsp.measure.perceived_level import (
    GESTURES,
    JND_DURATION,
    JND_SHARPNESS,
    MERGED_S,
    PULSE_HOP_S,
    STEP_DB,
    pulse_indices,
    ratio_jnds,
)
from overview_dsp.measure.report_base import Report, called, cell
from overview_dsp.offline.rendering.schedule import Tail
from overview_dsp.public import counted, short
from overview_dsp.signal.actuators.sensitivity import pacinian_db

LOW, HIGH = 10.0, 90.0
"""The spread of a kind's levels, percentiles."""


@dataclass(frozen=True)
class KindFeel:
    """One kind of event in one stroke: medians over its events; NaN where none was met.

    Attributes
    ----------
    kind : str
        Its name.
    events, missed : int
        How many there are, and how many of these the disk never met.
    level_db, low_db, high_db : float
        Highest RMS over 10 ms on the event, dB of full scale, weighted by the skin's sensitivity:
        median, tenth and ninetieth percentile.
    contrast_db : float
        Above the median of all that is no event, dB.
    sharpness : float
        Steepest rise of the torque, N m/s.
    duration_ms : float
        How long the level stays near its highest, ms.
    click_db : float
        Highest RMS over 10 ms of the click, dB of full scale.
    lag_ms : float
        Distance of click and knock, ms.
    masked, merged, lost : int
        Events less than a step above the rest; struck within 30 ms of another one; and hidden by it
        since it has more friction.

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
        """How many events the disk met."""
        return self.events - self.missed

    def __repr__(self) -> str:
        return (
            f"<KindFeel {short(self.kind)}: {counted(self.events, 'event')}, "
            f"{self.level_db:.1f} dB, {self.contrast_db:.1f} dB above the rest, "
            f"{self.duration_ms:.0f} ms>"
        )


@dataclass(frozen=True)
class StrokeReport:
    """One stroke of one gesture, over all timelines.

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
        In the order of importance; without one, in that of the surface.
    alike : tuple of (str, str, float)
        Pairs of kinds less than a step apart in level, sharpness and duration, and how far they
        are.
    gaps : tuple of (str, str, float)
        Each kind, the next one in the order of importance, and the just noticeable steps from one's
        median level to the other's.
    lost : tuple of (str, str, int)
        A kind, the kind that is felt in its place, and how often.

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
    alike: tuple[tuple[str, str, float], ...] = field(metadata={"digits": 2})
    gaps: tuple[tuple[str, str, float], ...]
    lost: tuple[tuple[str, str, int], ...]

    def kind(self, name: str) -> KindFeel:
        """Find a kind by its name.

        Parameters
        ----------
        name : str
            Of a kind that the timelines have.

        Returns
        -------
        KindFeel
            That one.

        Raises
        ------
        InputError
            There is none.

        Examples
        --------
        >>> report = ov.measure.feel_report(football, match, {"fast": ov.sweep(1.0)}, 8000)
        >>> report.strokes[0].kind("foul").kind
        'foul'
        """
        return called(name, {one.kind: one for one in self.kinds}, "kind")

    def __repr__(self) -> str:
        return (
            f"<StrokeReport {short(self.name)}: {self.level_db:.1f} dB, "
            f"{counted(len(self.kinds), 'kind')}, {counted(len(self.alike), 'pair')} alike>"
        )


_COLUMNS: tuple[tuple[str, str, int, Callable[[KindFeel, int], str]], ...] = (
    ("events", "", 7, lambda kind, width: f"{kind.events:>{width}}"),
    ("missed", "", 8, lambda kind, width: f"{kind.missed:>{width}}"),
    ("masked", "", 8, lambda kind, width: f"{kind.masked:>{width}}"),
    ("merged", "", 8, lambda kind, width: f"{kind.merged:>{width}}"),
    ("lost", "", 6, lambda kind, width: f"{kind.lost:>{width}}"),
    ("level", "dB", 8, lambda kind, width: cell(kind.level_db, width)),
    (
        *("10 to 90 %", "dB", 12),
        lambda kind, width: (
            f"{f'{cell(kind.low_db, 0, 0)} .. {cell(kind.high_db, 0, 0)}':>{width}}"
        ),
    ),
    ("contrast", "dB", 10, lambda kind, width: cell(kind.contrast_db, width)),
    ("sharpness", "N m/s", 11, lambda kind, width: cell(kind.sharpness, width, 3)),
    ("lasts", "ms", 7, lambda kind, width: cell(kind.duration_ms, width, 0)),
    ("click", "dB", 8, lambda kind, width: cell(kind.click_db, width)),
    ("lag", "ms", 5, lambda kind, width: cell(kind.lag_ms, width, 0)),
)
"""Of the table: heading, unit, width and text."""


@dataclass(frozen=True)
class FeelReport(Report):
    """How a preset feels on timelines.

    Attributes
    ----------
    preset : str
        The preset's name.
    timelines : tuple of str
        The timelines' titles.
    strokes : tuple of StrokeReport
        Each gesture's way out, and its recoil.

    See Also
    --------
    feel_report : Makes one.

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
            `fast`, `fast recoil`, say.

        Returns
        -------
        StrokeReport
            That one.

        Raises
        ------
        InputError
            There is none.

        Examples
        --------
        >>> report = ov.measure.feel_report(football, match, {"fast": ov.sweep(1.0)}, 8000)
        >>> report.stroke("fast recoil").name
        'fast recoil'
        """
        return called(name, {stroke.name: stroke for stroke in self.strokes}, "stroke")

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
                yield f"  steps: {'; '.join(gaps)}"
            if stroke.lost:
                lost = (f"{a} beside {b}: {n}" for a, b, n in stroke.lost)
                yield f"  lost: {', '.join(lost)}"

    def _faults(self) -> Iterator[str]:
        masked: dict[str, list[str]] = {}
        alike: dict[tuple[str, str], list[str]] = {}
        gaps: dict[tuple[str, str], list[str]] = {}
        for stroke in self.strokes:
            for kind in stroke.kinds:
                if 2 * kind.masked > kind.passed:
                    masked.setdefault(kind.kind, []).append(stroke.name)
            for first, second, _ in stroke.alike:
                alike.setdefault((first, second), []).append(stroke.name)
            for first, second, steps in stroke.gaps:
                if not steps >= 1.0:  # NaN too
                    gaps.setdefault((first, second), []).append(f"{stroke.name} ({steps:.1f})")
        for name, where in masked.items():
            yield (
                f"{name} is hardly felt in {_listed(where)}: raise kinds.{name}.height, or "
                "lower surface.intensity_gain"
            )
        for (first, second), where in alike.items():
            yield (
                f"{first} and {second} feel alike in {_listed(where)}: move their heights or "
                "widths apart by a third"
            )
        for (first, second), where in gaps.items():
            yield (
                f"{first} is less than a step above {second} in {', '.join(where)}: move their "
                "heights apart, or overview presets tune"
            )
        for stroke in self.strokes:
            if count := sum(kind.merged for kind in stroke.kinds):
                yield (
                    f"{count} events come within {1000.0 * MERGED_S:.0f} ms of another in "
                    f"{stroke.name} and are felt as one with it: zoom in, or move more slowly"
                )
            missed = [f"{one.missed} {one.kind}" for one in stroke.kinds if one.missed]
            if missed:
                yield f"never met in {stroke.name}: {', '.join(missed)}"

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
    """Measure how a preset feels on timelines, each event where it lies.

    Parameters
    ----------
    preset : Preset
        What is to be felt.
    timelines : Timeline or sequence of Timeline
        With events. Of several, what is felt on all of them.
    gestures : mapping of str to Gesture
        By name, each of one touch; slow, medium and fast sweeps and a tap if left out.
    sample_rate : float
        Hz.
    recoils : bool
        Without them, only the way out is measured.
    order : sequence of str or None
        Kinds, the most important first; the others follow by their friction. Each is expected to be
        a step above the next. None: no order is expected.
    progress : callable
        Called with the part done, 0 to 1.

    Returns
    -------
    FeelReport
        Level, contrast, sharpness, duration and click of each kind in each stroke, with what is
        missed, masked, merged and lost.

    Raises
    ------
    InputError
        No timelines; as `render`.

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
        met = level[rows & np.isfinite(level)] + weight
        low, high = np.percentile(met, [LOW, HIGH]).tolist() if len(met) else [math.nan] * 2
        if rows.any():
            kinds.append(
                KindFeel(
                    kind=one,
                    events=int(rows.sum()),
                    missed=int(rows.sum()) - len(met),
                    level_db=_median(met),
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
    level_db, sharpness, density = np.median([_character(one) for one in tables], axis=0).tolist()
    return StrokeReport(
        name,
        _median([one.free_db for one in tables]) + weight,
        level_db + weight,
        sharpness,
        density,
        tuple(kinds),
        tuple(
            (first.kind, second.kind, apart)
            for first, second in itertools.combinations(kinds, 2)
            if first.passed and second.passed and (apart := jnd_distance(first, second)) < 1.0
        ),
        tuple(
            (first.kind, second.kind, (first.level_db - second.level_db) / STEP_DB)
            for first, second in itertools.pairwise(kinds)
            if ordered
        ),
        tuple((a, b, n) for (a, b), n in pairs.most_common()),
    )


def _median(values: Any) -> float:
    known = np.asarray(values)[np.isfinite(values)]
    return float(np.median(known)) if len(known) else math.nan


def _character(one: FeltEvents) -> tuple[float, float, float]:
    """Level (dB), sharpness (N m/s) and density (a second) of all that is felt in a stroke."""
    level = one.level[NEAR_MS : int(1e3 * one.arrived_s) - NEAR_MS : round(PULSE_HOP_S * 1e3)]
    if not len(level):
        return math.nan, one.slope, 0.0
    return float(np.median(level)), one.slope, len(pulse_indices(level)) / one.arrived_s


def jnd_distance(first: KindFeel, second: KindFeel) -> float:
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
    >>> report = ov.measure.feel_report(football, match, {"fast": ov.sweep(1.0)}, 8000)
    >>> kind = report.strokes[0].kinds[0]
    >>> ov.measure.jnd_distance(kind, kind)
    0.0
    """
    for kind in (first, second):
        validation.instance(kind, KindFeel, "a kind", "the strokes of a feel report have them")
    steps = [
        abs(first.level_db - second.level_db) / STEP_DB,
        ratio_jnds(first.sharpness, second.sharpness, JND_SHARPNESS),
        ratio_jnds(first.duration_ms, second.duration_ms, JND_DURATION),
    ]
    return max((step for step in steps if math.isfinite(step)), default=0.0)


def character_distance(first: FeelReport, second: FeelReport) -> float:
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
        How many.

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
                abs(one.level_db - other.level_db) / STEP_DB,
                ratio_jnds(one.sharpness, other.sharpness, JND_SHARPNESS),
                # a pulse a second is the least that is called a rhythm
                ratio_jnds(one.density_hz + 1.0, other.density_hz + 1.0, JND_DURATION),
            )
            for one, other in zip(first.strokes, second.strokes, strict=True)
        }
    )


def jnds_over_strokes(differences: Mapping[str, Any]) -> float:
    """Return the largest median of steps over strokes; the recoils count as one stroke."""
    table = {name: np.array(steps) for name, steps in differences.items()}
    each = [steps for name, steps in table.items() if not name.endswith("recoil")]
    recoils = [steps for name, steps in table.items() if name.endswith("recoil")]
    if recoils:
        each.append(_known_median(recoils))
    return float(np.nanmax(np.append(_known_median(each), 0.0)))


def _known_median(rows: Sequence[Any]) -> Any:
    """Return the median of each column that most rows know; NaN for the others."""
    table = np.array(rows)
    known = np.isfinite(table).sum(axis=0) > len(rows) / 2
    median = np.full(table.shape[1], np.nan)
    median[known] = np.nanmedian(table[:, known], axis=0)
    return median
