"""What a feel report holds: kinds of events, stroke by stroke.

What a report on real timelines holds: events where they lie, kind by kind.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from overview_dsp.measure.felt import MERGED_S
from overview_dsp.measure.report_base import Report, called, cell
from overview_dsp.public import counted, short


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
    >>> fast = {"fast": ov.sweep(1.0)}
    >>> report = ov.measure.feel_report(football, match, fast, sample_rate=8000)
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
    >>> fast = {"fast": ov.sweep(1.0)}
    >>> report = ov.measure.feel_report(football, match, fast, sample_rate=8000)
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

    def __repr__(self) -> str:
        return (
            f"<StrokeReport {short(self.name)}: {self.level_db:.1f} dB, "
            f"{counted(len(self.kinds), 'kind')}, {counted(len(self.alike), 'pair')} alike>"
        )


@dataclass(frozen=True)
class FeelReport(Report):
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
    >>> fast = {"fast": ov.sweep(1.0)}
    >>> report = ov.measure.feel_report(football, match, fast, sample_rate=8000)
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
        InputError
            There is none.

        Examples
        --------
        >>> fast = {"fast": ov.sweep(1.0)}
        >>> report = ov.measure.feel_report(football, match, fast, sample_rate=8000)
        >>> report.stroke("fast recoil").name
        'fast recoil'
        """
        return called(name, {stroke.name: stroke for stroke in self.strokes}, "stroke")

    def _lines(self) -> Iterator[str]:
        yield f"{self.preset} on {self.timeline or 'a timeline'}"
        yield (
            f"{'':<28}{'level':>8}{'contrast':>10}{'sharpness':>11}{'lasts':>8}{'click':>8}"
            f"{'masked':>8}{'merged':>8}"
        )
        yield f"{'':<28}{'dB':>8}{'dB':>10}{'N m/s':>11}{'ms':>8}{'dB':>8}"
        for stroke in self.strokes:
            yield f"{stroke.name}: {stroke.event_free_db:.1f} dB between the events"
            for kind in stroke.kinds:
                yield (
                    f"  {kind.kind[:20]:<20}{kind.events:>5} {cell(kind.level_db, 8)}"
                    f"{cell(kind.contrast_db, 10)}{cell(kind.sharpness, 11, 3)}"
                    f"{cell(kind.duration_ms, 8, 0)}{cell(kind.click_db, 8)}"
                    f"{kind.masked:>8}{kind.merged:>8}"
                )

    def _faults(self) -> Iterator[str]:
        for name in dict.fromkeys(kind.kind for stroke in self.strokes for kind in stroke.kinds):
            masked = [
                stroke.name
                for stroke in self.strokes
                for kind in stroke.kinds
                if kind.kind == name and 2 * kind.masked > kind.events
            ]
            if masked:
                yield (
                    f"{name} is hardly felt in {_listed(masked)}: raise kinds.{name}.height, or "
                    "lower surface.ambience"
                )
        pairs: dict[tuple[str, str], list[str]] = {}
        for stroke in self.strokes:
            for first, second, _ in stroke.alike:
                pairs.setdefault((first, second), []).append(stroke.name)
        for (first, second), where in pairs.items():
            yield (
                f"{first} and {second} feel alike in {_listed(where)}: move their heights or "
                "widths apart by a third"
            )
        for stroke in self.strokes:
            count = sum(kind.merged for kind in stroke.kinds)
            if count:
                yield (
                    f"{count} events come within {1000.0 * MERGED_S:.0f} ms of another in "
                    f"{stroke.name} and are felt as one with it: zoom in, or move more slowly"
                )

    def __repr__(self) -> str:
        return (
            f"<FeelReport: {short(self.preset)} on {short(self.timeline)}, "
            f"{counted(len(self.strokes), 'stroke')}>"
        )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) < 8 else "every stroke"


@dataclass(frozen=True)
class CrowdKind:
    """A kind of event in a stroke, over all timelines.

    Attributes
    ----------
    kind : str
        Its name.
    events, missed, masked, lost : int
        How many there are; of these never met, less than a step above the rest, and drowned by one
        with more friction within 30 ms.
    level_db, low_db, high_db : float
        Median, and the tenth and ninetieth percentile of the levels of those met, dB of full scale.
    lag_ms : float
        Median distance of click and knock, ms; NaN where none clicked.

    Examples
    --------
    >>> report = ov.measure.crowd_report(football, [match], {"fast": ov.sweep(1.0)})
    >>> goal = report.strokes[0].kind("goal")
    >>> goal.events, goal.missed, goal.low_db <= goal.level_db
    (5, 0, True)
    """

    kind: str
    events: int
    missed: int
    masked: int
    lost: int
    level_db: float
    low_db: float
    high_db: float
    lag_ms: float

    def __repr__(self) -> str:
        return (
            f"<CrowdKind {short(self.kind)}: {counted(self.events, 'event')}, "
            f"{self.level_db:.1f} dB>"
        )


@dataclass(frozen=True)
class CrowdStroke:
    """A stroke over all timelines.

    Attributes
    ----------
    name : str
        `slow`, `slow recoil`, ..., `tap`, `tap recoil`.
    event_free_db : float
        Median level outside all events, dB of full scale.
    kinds : tuple of CrowdKind
        In the order of importance.
    gaps : tuple of (str, str, float)
        Each kind, the next one, and the just noticeable steps from one's median to the other's.
    lost : tuple of (str, str, int)
        A kind, the kind that is felt in its place, and how often.

    Examples
    --------
    >>> report = ov.measure.crowd_report(football, [match], {"fast": ov.sweep(1.0)})
    >>> [stroke.name for stroke in report.strokes]
    ['fast', 'fast recoil']
    """

    name: str
    event_free_db: float
    kinds: tuple[CrowdKind, ...]
    gaps: tuple[tuple[str, str, float], ...]
    lost: tuple[tuple[str, str, int], ...]

    def kind(self, name: str) -> CrowdKind:
        """Find a kind by its name.

        Parameters
        ----------
        name : str
            Of a kind that the timelines have.

        Returns
        -------
        CrowdKind
            That one.

        Raises
        ------
        InputError
            There is none.

        Examples
        --------
        >>> report = ov.measure.crowd_report(football, [match], {"fast": ov.sweep(1.0)})
        >>> report.strokes[0].kind("foul").kind
        'foul'
        """
        return called(name, {one.kind: one for one in self.kinds}, "kind")

    def __repr__(self) -> str:
        return f"<CrowdStroke {short(self.name)}: {counted(len(self.kinds), 'kind')}>"


@dataclass(frozen=True)
class CrowdReport(Report):
    """How the events of real timelines feel where they lie.

    Attributes
    ----------
    preset : str
        Its name.
    timelines : tuple of str
        Their titles.
    strokes : tuple of CrowdStroke
        Each gesture's way out, and its recoil.

    See Also
    --------
    crowd_report : Makes one.

    Examples
    --------
    >>> report = ov.measure.crowd_report(football, [match], {"fast": ov.sweep(1.0)})
    >>> report.preset, len(report.timelines)
    ('football', 1)
    """

    _digits = 3

    preset: str
    timelines: tuple[str, ...]
    strokes: tuple[CrowdStroke, ...]

    def _lines(self) -> Iterator[str]:
        count = counted(len(self.timelines), "timeline")
        yield f"{self.preset}, each event where it lies: {count}"
        yield (
            f"{'':<24}{'events':>7}{'missed':>8}{'masked':>8}{'lost':>6}{'level':>8}"
            f"{'10 to 90 %':>18}{'lag':>6}"
        )
        yield f"{'':<24}{'':>7}{'':>8}{'':>8}{'':>6}{'dB':>8}{'dB':>18}{'ms':>6}"
        for stroke in self.strokes:
            yield f"{stroke.name}: {stroke.event_free_db:.1f} dB between the events"
            for one in stroke.kinds:
                spread = f"{cell(one.low_db, 0)} .. {cell(one.high_db, 0)}"
                yield (
                    f"  {one.kind[:22]:<22}{one.events:>7}{one.missed:>8}{one.masked:>8}"
                    f"{one.lost:>6}{cell(one.level_db, 8)}{spread:>18}{cell(one.lag_ms, 6, 0)}"
                )
            steps = "; ".join(f"{a} > {b} by {gap:.1f}" for a, b, gap in stroke.gaps)
            if steps:
                yield f"  steps: {steps}"
            if stroke.lost:
                lost = ", ".join(f"{kind} beside {other}: {n}" for kind, other, n in stroke.lost)
                yield f"  lost: {lost}"

    def _faults(self) -> Iterator[str]:
        pairs: dict[tuple[str, str], list[str]] = {}
        for stroke in self.strokes:
            for first, second, steps in stroke.gaps:
                if not steps >= 1.0:  # NaN too
                    pairs.setdefault((first, second), []).append(f"{stroke.name} ({steps:.1f})")
        for (first, second), where in pairs.items():
            yield (
                f"{first} is less than a step above {second} in {', '.join(where)}: move their "
                "heights apart, or overview presets tune"
            )
        for stroke in self.strokes:
            missed = [f"{one.missed} {one.kind}" for one in stroke.kinds if one.missed]
            if missed:
                yield f"never met in {stroke.name}: {', '.join(missed)}"

    def __repr__(self) -> str:
        return (
            f"<CrowdReport: {short(self.preset)} on {counted(len(self.timelines), 'timeline')}, "
            f"{counted(len(self.strokes), 'stroke')}>"
        )
