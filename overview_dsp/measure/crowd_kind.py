"""What a report on real timelines holds: events where they lie, kind by kind."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from overview_dsp.measure.report_base import Report, called, cell
from overview_dsp.public import counted, short


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
    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
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
    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
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
        >>> import overview_dsp as ov
        >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
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
    >>> import overview_dsp as ov
    >>> match, football = ov.load_timeline("world-cup-final-2018"), ov.load_preset("football")
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
