"""Report of an observer as tables, warnings and plain data."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from overview_dsp.measure.observer.features import Modality
from overview_dsp.measure.observer.scoring import NOTHING, ObserverScores
from overview_dsp.measure.report_base import Report
from overview_dsp.public import counted, plural, short

LEAST_SHARE = 1.0 / 12.5  # smallest share of confusions that is a warning: about 1 in 12
LEAST_EVENTS = 12  # fewest events for a warning


@dataclass(frozen=True)
class StrokeScores:
    """Scores of one stroke by one modality.

    Attributes
    ----------
    kinds : ObserverScores
        Scores of the preset's kinds.
    groups : ObserverScores
        Scores of groups of kinds (goal, card, minor); equal to `kinds` without groups.

    Examples
    --------
    >>> report = ov.measure.observe(
    ...     football, modalities=["touch"], movement="mixed", learned=2, held_out=1
    ... )
    >>> report.sets[0].strokes["mixed"]["touch"].groups.kinds
    ('minor', 'goal', 'card')
    """

    kinds: ObserverScores
    groups: ObserverScores


@dataclass(frozen=True)
class SetScores:
    """Scores of one set of timelines.

    Attributes
    ----------
    name : str
        `random timelines` or `timelines given`.
    timelines : int
        Number of timelines.
    strokes : mapping of str to mapping of str to StrokeScores
        By stroke (`1 s`, ..., `recoil`, `tap`, `arm 1 s`, ..., or `mixed`), then by modality.

    Examples
    --------
    >>> report = ov.measure.observe(
    ...     football, modalities=["touch"], movement="mixed", learned=2, held_out=1
    ... )
    >>> report.sets[0].timelines
    1
    """

    name: str
    timelines: int
    strokes: Mapping[str, Mapping[Modality, StrokeScores]]

    def __repr__(self) -> str:
        return f"<SetScores: {self.name} ({self.timelines}), {', '.join(self.strokes)}>"


@dataclass(frozen=True)
class ObserverReport(Report):
    """Report of the kinds of events that can be distinguished.

    Its table has recall and precision of each kind, then each confusion matrix, in per cent. Its
    warnings list the confusions of at least 1 in 12 events, for groups of at least twelve events.

    Attributes
    ----------
    preset : str
        Name of the preset.
    movement : str
        `all`, `steady`, `arm` or `mixed`.
    learned : int
        Number of random timelines of the training.
    sets : tuple of SetScores
        Scores by set of timelines.

    See Also
    --------
    observe : Makes a report.

    Examples
    --------
    >>> report = ov.measure.observe(
    ...     football, modalities=["touch"], movement="mixed", learned=2, held_out=1
    ... )
    >>> report
    <ObserverReport: 'football', mixed movement, 1 set>
    """

    preset: str
    movement: str
    learned: int
    sets: tuple[SetScores, ...]

    def _plain(self) -> dict[str, Any]:
        sets = []
        for one in self.sets:
            strokes = [
                {
                    "name": stroke,
                    "modality": modality,
                    "groups": scores.groups.to_json(),
                    **scores.kinds.to_json(),
                }
                for stroke, by_modality in one.strokes.items()
                for modality, scores in by_modality.items()
            ]
            sets.append({**vars(one), "strokes": strokes})
        return {**vars(self), "sets": sets}

    def _lines(self) -> Iterator[str]:
        yield (
            f"{self.preset}, {self.movement} movement, an observer that learned from "
            f"{self.learned} random timelines"
        )
        for one in self.sets:
            for modality in next(iter(one.strokes.values())):
                by_stroke = {name: found[modality] for name, found in one.strokes.items()}
                yield ""
                yield f"{one.name} ({one.timelines}), {modality}: recall / precision, %"
                yield from _recalls(by_stroke)
                for stroke, scores in by_stroke.items():
                    yield f"{modality}, {stroke}: answers to each kind, %"
                    yield from _confusion(scores.kinds)

    def _warning_lines(self) -> Iterator[str]:
        for one in self.sets:
            for modality in next(iter(one.strokes.values())):
                yield from _warnings_of(one, modality)

    def __repr__(self) -> str:
        sets = counted(len(self.sets), "set")
        return f"<ObserverReport: {short(self.preset)}, {self.movement} movement, {sets}>"


def _recalls(strokes: Mapping[str, StrokeScores]) -> Iterator[str]:
    """Yield one line per kind or group, with one column per stroke."""
    yield f"{'':<22}{'events':>8}" + "".join(f"{name:>12}" for name in strokes)
    scores = list(strokes.values())
    for title in ("kinds", "groups"):
        tables: list[ObserverScores] = [getattr(one, title) for one in scores]
        if title == "groups" and tables[0].kinds == scores[0].kinds.kinds:
            continue
        for row, kind in enumerate(tables[0].kinds):
            events = max(int(table.events[row]) // table.draws for table in tables)
            if events or any(table.reports[row] for table in tables):
                pairs = ((table.recall[row], table.precision[row]) for table in tables)
                cells = (f"{' / '.join(map(_percent, pair)):>12}" for pair in pairs)
                yield f"  {kind[:20]:<20}{events:>8}{''.join(cells)}"
        means = "".join(f"{_percent(table.balanced):>12}" for table in tables)
        yield f"  {'balanced, ' + title:<28}{means}"


def _confusion(scores: ObserverScores) -> Iterator[str]:
    """Yield the answers to each kind, in per cent of its events."""
    names = [*scores.kinds, NOTHING]
    rows = np.flatnonzero(scores.events).tolist()
    columns = np.flatnonzero(scores.confusion[:-1].sum(axis=0)).tolist()
    yield f"  {'':<20}" + "".join(f"{names[column][:9]:>10}" for column in columns)
    for row in rows:
        counts = scores.confusion[row]
        parts = [100.0 * counts[column] / counts.sum() for column in columns]
        yield f"  {names[row][:20]:<20}" + "".join(f"{part:>10.0f}" for part in parts)


def _confusions(scores: ObserverScores) -> Iterator[tuple[str, str, float]]:
    """Yield the confusions of each kind that are not rare."""
    names = [*scores.kinds, NOTHING]
    for row, kind in enumerate(scores.kinds):
        events = int(scores.events[row])
        if events < LEAST_EVENTS * scores.draws:
            continue
        for column, taken in enumerate(names):
            share = float(scores.confusion[row, column]) / events
            if column != row and share >= LEAST_SHARE:
                yield kind, taken, share


_RATIOS = [*((1, of) for of in range(12, 1, -1)), (2, 3), (3, 4), (9, 10)]
"""Simple ratios by which shares are written."""


def _warnings_of(one: SetScores, modality: Modality) -> Iterator[str]:
    """Yield a line for each confusion of a set by a modality, with its strokes."""
    found: dict[tuple[str, str], list[str]] = {}
    for stroke, by_modality in one.strokes.items():
        for kind, taken, share in _confusions(by_modality[modality].groups):
            some, of = min(_RATIOS, key=lambda ratio: abs(math.log(ratio[0] / ratio[1] / share)))
            if (kind, taken) not in found:
                name, verb = (kind, "is") if some == 1 else (plural(kind), "are")
                article = "an" if taken[:1] in "aeiou" else "a"
                fate = "unnoticed" if taken == NOTHING else f"taken for {article} {taken}"
                text = f"{some} {name} in {of} {verb} {fate}".replace("_", " ")
            else:
                text = f"{some} in {of}"
            found.setdefault((kind, taken), []).append(f"{text} {_where(stroke)}")
    for texts in found.values():
        yield f"{', '.join(texts)} (by {modality}, {one.name})"


def _where(stroke: str) -> str:
    if stroke in ("recoil", "tap"):
        return f"in the {stroke}"
    if stroke.startswith("arm "):
        return f"by an arm in {stroke.removeprefix('arm ')}"
    return "in mixed movement" if stroke == "mixed" else f"at {stroke}"


def _percent(value: float) -> str:
    return f"{100.0 * value:.0f}" if np.isfinite(value) else "-"
